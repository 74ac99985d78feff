"""Accelerations of any MJCF robot from MuJoCo's numbers, projected on its equalities' null space.

Mass matrix, bias, passive forces, Jacobians and their rates are MuJoCo's; the rest is NumPy.
Nothing is taken from the robot under test but the names of its joints and their places.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import yaml

from psp3.description.parts import MJCF_ROBOTS, ROBOT_FILES
from tests.helpers import Array
from tests.mujoco_projection import text_with_frames

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

RANK = 1e-9
"""Share of the largest singular value of the equalities up to which one counts as zero; rounding
leaves 1e-15, and these robots are far from singular poses.
"""


HINGE = 0.05
"""Distance of the two points by which a hinge is closed [m]."""


def shipped(name: str) -> Any:
    """Return MuJoCo's own model of a shipped robot, from its file.

    Of a URDF with the loops of its loop file: sites at the frames that coincide, of a hinge at two
    points of its axis.
    """
    if name in MJCF_ROBOTS:
        return mujoco.MjModel.from_xml_path(str(ROBOT_FILES / f"{name}.xml"))
    spec = mujoco.MjSpec.from_string(text_with_frames(name))
    loops = yaml.safe_load((ROBOT_FILES / f"{name}.yaml").read_text(encoding="utf-8"))
    for pair, kind in zip(loops["closed_loop"], loops["type"], strict=True):
        for height in {"3d": (0.0,), "hinge": (0.0, HINGE)}[kind]:
            names = [f"{frame} {height}" for frame in pair]
            for frame, site in zip(pair, names, strict=True):
                spec.body(frame).add_site(name=site, pos=[0.0, 0.0, height])
            spec.add_equality(
                type=mujoco.mjtEq.mjEQ_CONNECT,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                name1=names[0],
                name2=names[1],
            )
    return spec.compile()


class NullSpace:
    """An MJCF robot in MuJoCo, in the velocities of its Pinocchio model."""

    def __init__(self, text: Any, pinocchio_model: pin.Model, rank: float = RANK) -> None:
        self.model = mujoco.MjModel.from_xml_string(text) if isinstance(text, str) else text
        self.data, self.tree, self.rank = mujoco.MjData(self.model), pinocchio_model, rank

    def _set(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Set the state; return the matrix from Pinocchio's velocities, and its rate times v."""
        m, d = self.model, self.data
        matrix, rate = np.zeros((m.nv, m.nv)), np.zeros(m.nv)
        for k in range(m.njnt):
            index = self.tree.getJointId(m.joint(k).name)
            joint, at, own = self.tree.joints[index], m.jnt_qposadr[k], m.jnt_dofadr[k]
            x = q[joint.idx_q : joint.idx_q + joint.nq]
            turn = np.eye(joint.nv)
            if joint.nq == 7:
                place = self.tree.jointPlacements[index] * pin.XYZQUATToSE3(x)
                d.qpos[at : at + 3] = place.translation
                quaternion = pin.Quaternion(place.rotation)
                d.qpos[at + 3 : at + 7] = [quaternion.w, quaternion.x, quaternion.y, quaternion.z]
                # MuJoCo's linear velocity is in axes of the world, Pinocchio's in the body's.
                turn[:3, :3] = place.rotation
                linear, angular = np.split(v[joint.idx_v : joint.idx_v + 6], 2)
                rate[own : own + 3] = place.rotation @ np.cross(angular, linear)
            elif joint.nq == 4:
                d.qpos[at : at + 4] = x[[3, 0, 1, 2]]
            else:
                d.qpos[at] = x[0] + m.qpos0[at]
            matrix[own : own + joint.nv, joint.idx_v : joint.idx_v + joint.nv] = turn
        d.qvel[:] = matrix @ v
        return matrix, rate

    def _rows(self) -> tuple[Array, Array, Array]:
        """Return Jacobian, its rate times the velocity, and the gaps, of all active equalities."""
        m, d = self.model, self.data
        rows, rates, gaps = [], [], []
        for e in range(m.neq):
            one, two, numbers = m.eq_obj1id[e], m.eq_obj2id[e], m.eq_data[e]
            if m.eq_type[e] == mujoco.mjtEq.mjEQ_JOINT:
                row, at, first = np.zeros(m.nv), m.jnt_qposadr, m.jnt_dofadr
                polynomial = np.polynomial.Polynomial(numbers[:5])
                row[first[one]] = 1.0
                x = d.qpos[at[two]] - m.qpos0[at[two]] if two >= 0 else 0.0
                y = d.qpos[at[one]] - m.qpos0[at[one]]
                rate = 0.0
                if two >= 0:
                    row[first[two]] = -polynomial.deriv()(x)
                    rate = -polynomial.deriv(2)(x) * d.qvel[first[two]] ** 2
                rows.append(row[np.newaxis])
                rates.append(np.array([rate]))
                gaps.append(np.array([y - polynomial(x)]))
                continue
            assert m.eq_type[e] == mujoco.mjtEq.mjEQ_CONNECT
            ends = []
            for side, index in enumerate((one, two)):
                if m.eq_objtype[e] == mujoco.mjtObj.mjOBJ_SITE:
                    body, point = m.site_bodyid[index], d.site_xpos[index].copy()
                else:
                    anchor = numbers[3 * side : 3 * side + 3]
                    body = index
                    point = d.xpos[index] + d.xmat[index].reshape(3, 3) @ anchor
                jacobian, change, unused = (np.zeros((3, m.nv)) for _ in range(3))
                mujoco.mj_jac(m, d, jacobian, unused, point, body)
                mujoco.mj_jacDot(m, d, change, unused, point, body)
                ends.append((jacobian, change @ d.qvel, point))
            for sort, out in enumerate((rows, rates, gaps)):
                out.append(ends[1][sort] - ends[0][sort])
        if not rows:
            return np.zeros((0, m.nv)), np.zeros(0), np.zeros(0)
        return np.vstack(rows), np.concatenate(rates), np.concatenate(gaps)

    def accelerations(
        self, q: Array, v: Array, forces: Array, held: Array, held_rates: Array
    ) -> tuple[Array, float, float]:
        """Return accelerations in Pinocchio's velocities under joint forces.

        And how far the loops are open, and how fast they open. ``held`` are rows of velocities that
        stay zero, ``held_rates`` their rates times the velocity.
        """
        m, d = self.model, self.data
        matrix, rate = self._set(q, v)
        mujoco.mj_forward(m, d)
        J, b, gaps = self._rows()
        J = np.vstack([J, held @ np.linalg.inv(matrix)])
        # Only of joints whose velocities are the same in both.
        b = np.concatenate([b, held_rates])
        mass = np.zeros((m.nv, m.nv))
        for row, unit in zip(mass, np.eye(m.nv), strict=True):
            mujoco.mj_mulM(m, d, row, unit)
        left = np.linalg.inv(matrix).T @ forces + d.qfrc_passive - d.qfrc_bias
        basis, uniform = np.eye(m.nv), np.zeros(m.nv)
        if len(J):
            _, values, right = np.linalg.svd(J)
            basis = right[np.count_nonzero(values > self.rank * values[0]) :].T
            uniform = -np.linalg.pinv(J, rcond=self.rank) @ b
        a = uniform + basis @ np.linalg.solve(
            basis.T @ mass @ basis, basis.T @ (left - mass @ uniform)
        )
        opening = float(np.abs(J @ d.qvel).max(initial=0.0))
        return np.linalg.solve(matrix, a - rate), float(np.abs(gaps).max(initial=0.0)), opening


def inertial(com: str = ".1 0 .02", mass: float = 1.0, moments: str = ".01 .012 .014") -> str:
    """Return the inertia of a body."""
    return f'<inertial pos="{com}" mass="{mass}" diaginertia="{moments}"/>'


def body(name: str, pos: str, joint: str, inner: str = "", inertia: str | None = None) -> str:
    """Return a body with a joint and what hangs on it."""
    return f'<body name="{name}" pos="{pos}">{joint}{inertia or inertial()}{inner}</body>'


def hinge(name: str, axis: str = "0 0 1", more: str = "") -> str:
    """Return a hinge."""
    return f'<joint name="{name}" axis="{axis}" {more}/>'


def document(world: str, equalities: str, motors: str, tendons: str = "") -> str:
    """Return an MJCF document under an oblique gravity."""
    return (
        '<mujoco><compiler angle="radian"/><option gravity="0 -3 -9"/>'
        f"<worldbody>{world}</worldbody><equality>{equalities}</equality>"
        f"<tendon>{tendons}</tendon><actuator>{motors}</actuator></mujoco>"
    )


def motors(*names: str) -> str:
    """Return motors that drive joints."""
    return "".join(f'<motor joint="{name}"/>' for name in names)


def rod(moments: str = ".01 .012 .014", com: str = ".1 0 .02") -> str:
    """Return a crank about z, a rod between two balls, and a rocker about an oblique axis.

    The rod can spin about its line.
    """
    ball = body(
        "rod", ".15 .1 .05", '<joint type="ball" name="ball"/>', "", inertial(com, 1.0, moments)
    )
    return document(
        body("crank", "0 0 0", hinge("crank"), ball)
        + body("rocker", ".6 0 0", hinge("rocker", "1 0 .3")),
        '<connect body1="rod" body2="rocker" anchor=".4 .25 .2"/>',
        motors("crank"),
    )


def doubled() -> str:
    """Return a four-bar of which one hinge is there twice, so that a link turns freely."""
    two = body("two", "0 0 .05", hinge("pin2"), "", inertial(".2 .05 0"))
    return document(
        body("crank", "0 0 0", hinge("crank"), body("one", ".12 .16 0", hinge("pin1"), two))
        + body("rocker", ".45 0 0", hinge("rocker")),
        '<connect body1="two" body2="rocker" anchor=".4 .14 0"/>',
        motors("crank"),
    )


def five_bar(*driven: str, spring: str = "", more: str = "") -> str:
    """Return a five-bar with given motors, a spring's attributes at p1, and more equalities."""
    return document(
        body("a1", "-.15 0 0", hinge("m1"), body("b1", "-.1 .2 0", hinge("p1", more=spring)))
        + body("a2", ".15 0 0", hinge("m2"), body("b2", ".1 .2 0", hinge("p2"))),
        f'<connect body1="b1" body2="b2" anchor=".25 .3 0"/>{more}',
        motors(*driven),
    )


def gripper() -> str:
    """Return two fingers, each a four-bar with a spring, coupled, and pulled by one tendon."""

    def finger(side: str, y: float) -> str:
        small = inertial("0 .01 .02", 0.1, ".001 .001 .001")
        coupler = body(f"{side}coupler", f"0 {y} .01", hinge(f"{side}coupler", "1 0 0"), "", small)
        follower = body(
            f"{side}follower", f"0 {0.5 * y} .06", hinge(f"{side}follower", "1 0 0"), "", small
        )
        spring = 'stiffness=".5" springref=".3" damping=".01"'
        return body(
            f"{side}driver",
            f"0 {y} 0",
            hinge(f"{side}driver", "1 0 0", 'armature=".002"'),
            coupler,
            inertial("0 .01 0", 0.2, ".001 .002 .001"),
        ) + body(
            f"{side}spring",
            f"0 {0.4 * y} .02",
            hinge(f"{side}spring", "1 0 0", spring),
            follower,
            small,
        )

    return document(
        finger("l_", 0.03) + finger("r_", -0.03),
        '<connect body1="l_coupler" body2="l_follower" anchor="0 -.01 .07"/>'
        '<connect body1="r_coupler" body2="r_follower" anchor="0 .01 .07"/>'
        '<joint joint1="l_driver" joint2="r_driver" polycoef="0 -1 .3 .1 0"/>',
        '<motor tendon="split"/>',
        '<fixed name="split"><joint joint="l_driver" coef=".5"/>'
        '<joint joint="r_driver" coef="-.5"/></fixed>',
    )


def biped(*driven: str) -> str:
    """Return a trunk on a floating base with two legs, each with a four-bar at the knee."""

    def leg(side: str, y: float) -> str:
        shank = body(
            f"{side}shank",
            "0 0 -.3",
            hinge(f"{side}knee", "0 1 0"),
            "",
            inertial("0 .005 -.14", 0.7, ".006 .006 .001"),
        )
        thigh = body(
            f"{side}thigh",
            f"0 {y} -.1",
            hinge(f"{side}hip", "0 1 0"),
            shank,
            inertial(".01 0 -.15", 1.2, ".012 .011 .003"),
        )
        bar = body(
            f"{side}rod",
            ".05 0 0",
            hinge(f"{side}rodpin", "0 1 0"),
            "",
            inertial("0 0 -.15", 0.15, ".002 .002 .0001"),
        )
        crank = body(
            f"{side}crank",
            f".08 {y} -.1",
            hinge(f"{side}motor", "0 1 0"),
            bar,
            inertial(".02 0 0", 0.2, ".0004 .0005 .0003"),
        )
        return thigh + crank

    return document(
        body(
            "trunk",
            "0 0 1",
            '<freejoint name="root"/>',
            leg("l_", 0.1) + leg("r_", -0.1),
            inertial(".02 0 .05", 8.0, ".12 .1 .08"),
        ),
        '<connect body1="l_rod" body2="l_shank" anchor="0 0 -.3"/>'
        '<connect body1="r_rod" body2="r_shank" anchor="0 0 -.3"/>',
        motors(*driven),
    )

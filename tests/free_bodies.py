"""Dynamics of bodies that float freely, held together by joints as constraints.

Newton's and Euler's equations of every body, with its twist in its own frame, and the rows of
velocities that its joints forbid. No tree is chosen and none cut, so what a tree with loops says
can be compared with it. From the robot under test come the places of its links and their twists
alone, and both are checked: they must satisfy every joint.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from tests.helpers import Array, derivative

RANK = 1e-9
"""Share of the largest singular value up to which one counts as zero; rounding leaves 1e-15."""


class Body(NamedTuple):
    """A rigid body; the world is the one of name ``""``."""

    name: str
    inertia: pin.Inertia


class Connection(NamedTuple):
    """A joint between two bodies."""

    name: str
    kind: str
    """``revolute``, ``prismatic``, ``screw``, ``ball``, ``universal`` or ``fixed``."""
    parent: str
    child: str
    in_parent: pin.SE3
    in_child: pin.SE3
    axes: tuple[Array, ...] = ()
    """In the joint's frame in the pose where both of its frames coincide; the parent's first."""
    pitch: float = 0.0
    damping: tuple[float, ...] = ()
    stiffness: tuple[float, ...] = ()
    rest: tuple[float, ...] = ()
    friction: tuple[float, ...] = ()


class Gear(NamedTuple):
    """A coordinate that moves so many times as fast as another one."""

    follows: str
    leads: str
    ratio: float


class FreeBodies:
    """A mechanism of bodies and joints, in the state of a robot under test."""

    def __init__(
        self,
        bodies: list[Body],
        joints: list[Connection],
        gears: list[Gear] = [],  # noqa: B006 - not changed
        gravity: Array | None = None,
    ) -> None:
        self.bodies, self.joints, self.gears = bodies, joints, gears
        self.number = {body.name: k for k, body in enumerate(bodies)}
        self.gravity = np.array([0.0, 0.0, -9.81]) if gravity is None else gravity

    def set(self, robot: Any, q: Array, v: Array) -> None:
        """Take places and twists of all bodies from the links of a robot."""
        model, data = robot.model, robot.model.createData()
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        self.places, self.twists = [], []
        for body in self.bodies:
            frame = model.getFrameId(body.name, pin.FrameType.BODY)
            assert frame < model.nframes, f"there is no link {body.name!r}"
            self.places.append(data.oMf[frame].copy())
            self.twists.append(pin.getFrameVelocity(model, data, frame, pin.ReferenceFrame.LOCAL))

    def _end(self, name: str) -> tuple[pin.SE3, Array, slice | None]:
        if not name:
            return pin.SE3.Identity(), np.zeros(6), None
        k = self.number[name]
        return self.places[k], self.twists[k].vector, slice(6 * k, 6 * k + 6)

    def _relative(self, joint: Connection) -> tuple[pin.SE3, Array, Array, Array]:
        """Return the child's joint frame in the parent's, its twist, that twist's rows and rate.

        All in the axes of the child's joint frame; the rate is what is left without accelerations.
        """
        place_p, twist_p, at_p = self._end(joint.parent)
        place_c, twist_c, at_c = self._end(joint.child)
        apart = (place_p * joint.in_parent).actInv(place_c * joint.in_child)
        rows = np.zeros((6, 6 * len(self.bodies)))
        to_child = joint.in_child.toActionMatrixInverse()
        to_parent = apart.toActionMatrixInverse() @ joint.in_parent.toActionMatrixInverse()
        if at_c is not None:
            rows[:, at_c] += to_child
        if at_p is not None:
            rows[:, at_p] -= to_parent
        seen = to_parent @ twist_p
        twist = to_child @ twist_c - seen
        rate = pin.Motion(twist).cross(pin.Motion(seen)).vector
        return apart, twist, rows, rate

    def rows(self) -> tuple[Array, Array, Array]:
        """Return the rows of all joints, their rates times the twists, and their gaps."""
        rows, rates, gaps = [], [], []
        for joint in self.joints:
            apart, twist, motion, rate = self._relative(joint)
            place, turn, kind = apart.translation, apart.rotation, joint.kind
            if kind == "universal":
                one, two = turn.T @ joint.axes[0], joint.axes[1]
                normal, change = np.cross(one, two), np.cross(-np.cross(twist[3:], one), two)
                rows += [motion[:3], normal[None] @ motion[3:]]
                rates += [rate[:3], [change @ twist[3:] + normal @ rate[3:]]]
                gaps += [place, [one @ two - joint.axes[0] @ joint.axes[1]]]
                continue
            kept = np.eye(6)
            if kind == "ball":
                kept = kept[:3]
                gaps.append(place)
            elif kind != "fixed":
                axis = joint.axes[0]
                free = np.concatenate([np.zeros(3), axis])
                gap = [*(place - joint.pitch * _angle(turn, axis) * axis), *(turn @ axis - axis)]
                if kind == "prismatic":
                    free = np.concatenate([axis, np.zeros(3)])
                    gap = [*(place - (axis @ place) * axis), *pin.log3(turn)]
                elif kind == "screw":
                    free = np.concatenate([joint.pitch * axis, axis])
                kept = np.linalg.svd(free[None])[2][1:]
                gaps.append(gap)
            else:
                gaps.append(pin.log6(apart).vector)
            rows.append(kept @ motion)
            rates.append(kept @ rate)
        for gear in self.gears:
            (two, turned), (one, turning) = self.speeds(gear.follows), self.speeds(gear.leads)
            rows.append(two[:1] - gear.ratio * one[:1])
            rates.append(turned[:1] - gear.ratio * turning[:1])
        return np.vstack(rows), np.concatenate(rates), np.concatenate([np.ravel(g) for g in gaps])

    def speeds(self, name: str) -> tuple[Array, Array]:
        """Return the rows of a joint's speeds, and their rates times the twists."""
        joint = next(joint for joint in self.joints if joint.name == name)
        apart, twist, motion, rate = self._relative(joint)
        if joint.kind == "universal":
            one, two = apart.rotation.T @ joint.axes[0], joint.axes[1]
            both = np.linalg.pinv(np.column_stack([one, two]))
            first = -np.cross(twist[3:], one) * (both @ twist[3:])[0]
            return both @ motion[3:], both @ (rate[3:] - first)
        part = slice(0, 3) if joint.kind == "prismatic" else slice(3, 6)
        axis = np.atleast_2d(joint.axes[0])
        return axis @ motion[part], axis @ rate[part]

    def base(self, name: str) -> tuple[Array, Array]:
        """Return the rows of a body's twist in its own frame, and their rates."""
        rows = np.zeros((6, 6 * len(self.bodies)))
        rows[:, 6 * self.number[name] : 6 * self.number[name] + 6] = np.eye(6)
        return rows, np.zeros(6)

    def spin(self, robot: Any, one: Any, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the row that holds the spin of a ball, and its rate times the twists.

        Held is the part along its axis of the vector of its quaternion, seen from where it is held.
        """
        joint = robot.model.joints[robot.model.getJointId(one.joint)]

        def part(at: Array) -> Array:
            ball = pin.Quaternion(at[joint.idx_q : joint.idx_q + 4])
            x, y, z, w = (pin.Quaternion(one.spin.quaternion).inverse() * ball).coeffs()
            return 0.5 * (w * one.spin.axis + np.cross(one.spin.axis, [x, y, z]))

        named = next(other for other in self.joints if other.name == one.joint)
        apart, twist, motion, rate = self._relative(named)
        turning = v[joint.idx_v : joint.idx_v + 3]
        turn = np.eye(3)
        if np.abs(twist[3:] - turning).max() > 1e-9:  # the tree has it from the child
            turn = -apart.rotation
        assert np.abs(turn @ twist[3:] - turning).max() < 1e-9
        change = derivative(lambda t: part(pin.integrate(robot.model, q, t * v)), 1e-2)
        row = part(q) @ turn
        return (row @ motion[3:])[None], np.atleast_1d(change @ turning + row @ rate[3:])

    def answer(
        self,
        coordinates: Array,
        rates: Array,
        held: Array | None = None,
        changes: Array | None = None,
    ) -> tuple[Array, Array, float]:
        """Return mass matrix and all other forces along coordinates, and how well they are defined.

        ``coordinates`` are rows of the twists, ``rates`` their rates times the twists; ``held`` and
        ``changes`` those of motions that are held. The forces
        are such that M a + forces = τ. The last number says how much a motion is left undetermined.
        """
        n = len(coordinates)
        rows, change, _ = self.rows()
        if held is not None and changes is not None:
            rows, change = np.vstack([rows, held]), np.concatenate([change, changes])
        every = np.vstack([rows, coordinates])
        inverse = np.linalg.pinv(every, rcond=RANK)
        basis = inverse[:, -n:]
        wrong = float(np.abs(every @ basis - np.eye(len(every))[:, -n:]).max())
        undetermined = every.shape[1] - np.linalg.matrix_rank(every, tol=RANK)
        uniform = -inverse @ np.concatenate([change, rates])
        mass = np.zeros((every.shape[1],) * 2)
        forces = np.zeros(every.shape[1])
        for k, body in enumerate(self.bodies):
            at = slice(6 * k, 6 * k + 6)
            mass[at, at] = body.inertia.matrix()
            falling = pin.Motion(self.places[k].rotation.T @ self.gravity, np.zeros(3))
            forces[at] = body.inertia.vxiv(self.twists[k]).vector - (body.inertia * falling).vector
        twists = np.concatenate([twist.vector for twist in self.twists])
        for joint in self.joints:
            apart, *_ = self._relative(joint)
            if any(joint.damping) and joint.kind == "ball":
                turning = self._relative(joint)[2][3:]
                forces += joint.damping[0] * turning.T @ turning @ twists
            elif any((*joint.damping, *joint.stiffness, *joint.friction)):
                along = self.speeds(joint.name)[0]
                if any(joint.damping):
                    forces += along.T @ (np.array(joint.damping) * (along @ twists))
                if any(joint.friction):
                    forces += along.T @ (np.array(joint.friction) * np.sign(along @ twists))
                if any(joint.stiffness):
                    bent = self._coordinates(joint, apart) - np.array(joint.rest)
                    forces += along.T @ (np.array(joint.stiffness) * bent)
        return (
            basis.T @ mass @ basis,
            basis.T @ (mass @ uniform + forces),
            wrong + undetermined,
        )

    def _coordinates(self, joint: Connection, apart: pin.SE3) -> Array:
        if joint.kind == "prismatic":
            return np.array([joint.axes[0] @ apart.translation])
        if joint.kind == "universal":
            # R = exp(a₁ q₁) exp(a₂ q₂), each angle from what the other leaves alone.
            one, two = joint.axes
            first = _angle_between(two, apart.rotation @ two, one)
            second = -_angle_between(one, apart.rotation.T @ one, two)
            return np.array([first, second])
        return np.array([_angle(apart.rotation, joint.axes[0])])


def _angle(turn: Array, axis: Array) -> float:
    return float(pin.log3(turn) @ axis)


def _angle_between(one: Array, two: Array, axis: Array) -> float:
    """Return the angle by which a turn about an axis takes one vector to the other."""
    flat = [vector - (axis @ vector) * axis for vector in (one, two)]
    return float(np.arctan2(axis @ np.cross(*flat), flat[0] @ flat[1]))


class Comparison(NamedTuple):
    """The largest differences of a robot from the free bodies, each relative to its own size."""

    gap: float
    """How far joints are apart [m or rad]."""
    opening: float
    """How fast they come apart [m/s or rad/s]."""
    mass: float
    forces: float
    forward: float


def compared(
    robot: Any, mechanism: FreeBodies, rng: np.random.Generator, *, reach: float, count: int = 3
) -> Comparison:
    """Compare M, C v + G with all passive forces, and forward dynamics, at poses near home."""
    worst = np.zeros(5)
    model = robot.model
    for _ in range(count):
        step = np.zeros(model.nv)
        step[robot.coordinates_v] = rng.uniform(-reach, reach, len(robot.coordinates_v))
        positions = pin.integrate(model, robot.q0, step)[robot.coordinates_q]
        speeds = rng.uniform(-1.0, 1.0, len(robot.coordinates_v))
        forces = rng.uniform(-1.0, 1.0, len(robot.coordinates_v))
        q = robot.configuration(positions)
        v = robot.velocity(positions, speeds)
        mechanism.set(robot, q, v)
        chosen = _coordinates(robot, mechanism)
        held = [
            mechanism.speeds(one.joint) if one.spin is None else mechanism.spin(robot, one, q, v)
            for one in robot.locked
        ]
        if held:
            still = [np.concatenate([row[k] for row in held]) for k in (0, 1)]
            M, h, unclear = mechanism.answer(*chosen, *still)
        else:
            M, h, unclear = mechanism.answer(*chosen)
        assert unclear < 1e-6, "the coordinates do not determine the motion of the free bodies"
        rows, _, gaps = mechanism.rows()
        twists = np.concatenate([twist.vector for twist in mechanism.twists])
        zero = np.zeros(len(speeds))
        found = robot.mass_matrix(positions)
        bias = robot.inverse_dynamics(positions, speeds, zero)
        worst = np.maximum(
            worst,
            [
                np.abs(gaps).max(initial=0.0),
                np.abs(rows @ twists).max(initial=0.0),
                _relative_error(found, M),
                _relative_error(bias, h, np.abs(M).max()),
                _relative_error(
                    robot.forward_dynamics(positions, speeds, forces),
                    np.linalg.solve(M, forces - h),
                ),
            ],
        )
    return Comparison(*map(float, worst))


def _relative_error(one: Array, two: Array, size: float = 1e-12) -> float:
    """Return the largest difference by the largest entry, or by a size where all entries are small.

    Of forces that is what accelerations of 1 m/s² or rad/s² need.
    """
    return float(np.abs(one - two).max() / max(np.abs(two).max(), size))


def _coordinates(robot: Any, mechanism: FreeBodies) -> tuple[Array, Array]:
    """Return the rows of a robot's coordinates, in its order."""
    rows, rates = [], []
    for name in robot.coordinates:
        joint = robot.model.joints[robot.model.getJointId(name)]
        if joint.nv == 6:
            frames = [
                frame.name
                for frame in robot.model.frames
                if frame.type == pin.FrameType.BODY
                and frame.parentJoint == joint.id
                and np.abs(frame.placement.homogeneous - np.eye(4)).max() < 1e-12
            ]
            found = mechanism.base(frames[0])
        else:
            plain = name.removesuffix("_axis2").removesuffix("_axis")
            index = 1 if name.endswith("_axis2") else 0
            found = mechanism.speeds(plain)
            found = found[0][index : index + 1], found[1][index : index + 1]
        rows.append(found[0])
        rates.append(found[1])
    return np.vstack(rows), np.concatenate(rates)

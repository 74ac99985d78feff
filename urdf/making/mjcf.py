"""Writer of robots as MJCF files, for features that a URDF and a loop file lack.

These are floating bases, balls, springs, couplings and tendons. Everything is given in the pose
with all joints at zero, in world axes, which are then the axes of every body. This is the pose
home, unless another one is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from .solids import MATERIALS, Array, Solid
from .urdf import exact, short

More = Mapping[str, float | tuple[float, float]]
"""Attributes of a joint in MJCF."""


class Joint(NamedTuple):
    """A joint of a body: ``hinge``, ``ball`` or ``free``.

    ``more`` holds attributes of MJCF: a range, the range of the motor's force, a spring.
    """

    name: str
    kind: str = "hinge"
    axis: tuple[float, float, float] = (0.0, 0.0, 0.0)
    more: More = {}  # noqa: RUF012 - never changed


class Assembly:
    """A robot in the pose with all joints at zero: loops, couplings, tendons and motors."""

    def __init__(self, name: str, title: str) -> None:
        self.name, self.title = name, title
        self._places: dict[str, Array] = {"world": np.zeros(3)}
        self._bodies: dict[str, list[str]] = {"world": []}
        self._joints: dict[str, Joint] = {}
        self._children: dict[str, list[str]] = {"world": []}
        self._loops: list[str] = []
        self._couplings: list[str] = []
        self._tendons: list[str] = []
        self._motors: list[str] = []
        self._home: dict[str, float] = {}
        self._materials: set[str] = set()

    def base(self, solids: Sequence[Solid]) -> None:
        """Add the fixed base: it is drawn, and has no mass."""
        self._bodies["world"] += self._geoms(solids, np.zeros(3))

    def body(
        self, name: str, parent: str, place: ArrayLike, joint: Joint, solids: Sequence[Solid]
    ) -> None:
        """Add a body with its joint at a world position; its solids are given in world axes.

        Mass and moments of the solids are written as numbers; geoms are only drawn.
        """
        here = np.asarray(place, dtype=float)
        shift = pin.SE3(np.eye(3), -here)
        inertia = shift.act(sum((one.inertia() for one in solids[1:]), start=solids[0].inertia()))
        # A rounding error is written as zero.
        moments = np.where(
            np.abs(inertia.inertia) > 1e-12 * inertia.inertia.max(), inertia.inertia, 0.0
        )
        center = np.where(np.abs(inertia.lever) > 1e-12, inertia.lever, 0.0)
        full = [moments[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        tag = "freejoint" if joint.kind == "free" else "joint"
        kind = "" if joint.kind in ("free", "hinge") else f' type="{joint.kind}"'
        axis = f' axis="{exact(joint.axis)}"' if joint.kind == "hinge" else ""
        more = "".join(
            f' {key}="{" ".join(f"{v:.6g}" for v in np.atleast_1d(value))}"'
            for key, value in joint.more.items()
        )
        self._places[name] = here
        self._children[parent].append(name)
        self._children[name] = []
        self._joints[name] = joint
        self._bodies[name] = [
            f'<{tag} name="{joint.name}"{kind}{axis}{more}/>',
            (
                f'<inertial pos="{" ".join(f"{v:.12g}" for v in center)}" '
                f'mass="{inertia.mass:.12g}" fullinertia="{" ".join(f"{v:.12g}" for v in full)}"/>'
            ),
            *self._geoms(solids, here),
        ]

    def site(self, name: str, body: str, place: ArrayLike) -> None:
        """Add a frame on a body, at a world position."""
        self._bodies[body].append(
            f'<site name="{name}" pos="{exact(np.asarray(place) - self._places[body])}"/>'
        )

    def connect(self, first: str, second: str, place: ArrayLike) -> None:
        """Join two bodies at the point at a world position."""
        ends = (f"{first}_end", f"{second}_{first}")
        for body, end in zip((first, second), ends, strict=True):
            self.site(end, body, place)
        self._loops.append(
            f'<connect name="{first}-{second}" site1="{ends[0]}" site2="{ends[1]}"/>'
        )

    def couple(self, follows: str, leads: str, polynomial: Sequence[float]) -> None:
        """Couple a joint to another one with a polynomial, the constant first."""
        self._couplings.append(
            f'<joint name="{follows}-{leads}" joint1="{follows}" joint2="{leads}" '
            f'polycoef="{exact(polynomial)}"/>'
        )

    def tendon(self, name: str, levers: Mapping[str, float]) -> None:
        """Add a tendon that pulls joints with levers."""
        self._tendons += [
            f'<fixed name="{name}">',
            *(f'  <joint joint="{joint}" coef="{value:g}"/>' for joint, value in levers.items()),
            "</fixed>",
        ]

    def motor(self, name: str, limit: float, kind: str = "joint") -> None:
        """Add a motor with a force limit to a joint or a tendon."""
        self._motors.append(
            f'<motor name="{name}" {kind}="{name}" ctrlrange="{-limit:g} {limit:g}"/>'
        )

    def home(self, angles: Mapping[str, float]) -> None:
        """Set another pose home than all zeros, by the angles of hinges."""
        self._home = dict(angles)

    def _geoms(self, solids: Sequence[Solid], origin: Array) -> list[str]:
        lines = []
        for solid in solids:
            half = 0.5 * np.array(solid.size)
            sizes: dict[str, ArrayLike] = {
                "box": half,
                "sphere": [solid.size[0]],
                "cylinder": [solid.size[0], half[-1]],
            }
            size = sizes[solid.shape]
            x, y, z, w = pin.Quaternion(solid.placement.rotation).coeffs()
            turned = "" if abs(w) > 1.0 - 1e-12 else f' quat="{short([w, x, y, z])}"'
            lines.append(
                f'<geom type="{solid.shape}" size="{short(size)}" '
                f'pos="{short(solid.placement.translation - origin)}"{turned} '
                f'material="{solid.material}"/>'
            )
            self._materials.add(solid.material)
        return lines

    def _body_lines(self, name: str, depth: int) -> list[str]:
        space = "  " * depth
        lines = [f"{space}{line}" for line in self._bodies[name]]
        for child in self._children[name]:
            place = exact(self._places[child] - self._places[name])
            lines += [
                f'{space}<body name="{child}" pos="{place}">',
                *self._body_lines(child, depth + 1),
                f"{space}</body>",
            ]
        return lines

    def _order(self, name: str) -> list[str]:
        """Return a body and all bodies that it carries, in the order of the file."""
        return [name, *(one for child in self._children[name] for one in self._order(child))]

    def _position(self, body: str) -> Array:
        """Return the coordinates of a body's joint in the pose home."""
        joint, upright = self._joints[body], np.array([1.0, 0.0, 0.0, 0.0])
        if joint.kind == "hinge":
            return np.array([self._home.get(joint.name, 0.0)])
        return upright if joint.kind == "ball" else np.append(self._places[body], upright)

    def texts(self) -> Mapping[str, str]:
        """Return the content of the file by its name."""
        materials = [
            f'<material name="{name}" rgba="{MATERIALS[name][0]}"/>'
            for name in MATERIALS
            if name in self._materials
        ]
        sections = {
            "asset": materials,
            "tendon": self._tendons,
            "equality": [*self._loops, *self._couplings],
            "actuator": self._motors,
        }
        text = [
            (
                f"<!-- {self.title} Written by make_robots.py; README.md says where every number "
                "comes from. -->"
            ),
            f'<mujoco model="{self.name}">',
            '  <compiler angle="radian"/>',
            '  <option timestep="0.001"/>',
            '  <default><geom contype="0" conaffinity="0" density="0"/></default>',
        ]
        for tag, lines in sections.items():
            if tag == "tendon":
                text += ["  <worldbody>", *self._body_lines("world", 2), "  </worldbody>"]
            if lines:
                text += [f"  <{tag}>", *(f"    {line}" for line in lines), f"  </{tag}>"]
        pose = exact(np.concatenate([self._position(name) for name in self._order("world")[1:]]))
        text += ["  <keyframe>", f'    <key name="home" qpos="{pose}"/>', "  </keyframe>"]
        return {f"{self.name}.xml": "\n".join([*text, "</mujoco>", ""])}

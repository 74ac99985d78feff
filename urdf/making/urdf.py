"""Writer of robots as URDF, SRDF and loop files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from .solids import MATERIALS, Solid, at

NO_MASS = (
    "    <inertial>",
    '      <mass value="0"/>',
    '      <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>',
    "    </inertial>",
)
"""Inertia of a massless link, written out because PyBullet gives a link without inertia a
kilogram."""

PASSIVE_SPEED = 100.0
"""Velocity limit of joints without a motor [rad/s, m/s], large enough to mean no limit.
"""


def exact(values: ArrayLike) -> str:
    """Write numbers with enough digits to be read back exactly."""
    return " ".join(
        repr(float(value) + 0.0) for value in np.atleast_1d(np.asarray(values, dtype=float))
    )


def short(values: ArrayLike) -> str:
    """Write numbers to a micrometer, for drawn shapes only."""
    return " ".join(
        f"{value + 0.0:.6g}"
        for value in np.round(np.atleast_1d(np.asarray(values, dtype=float)), 6)
    )


def _origin(placement: pin.SE3, write: Callable[[ArrayLike], str]) -> str:
    return (
        f'<origin xyz="{write(placement.translation)}" '
        f'rpy="{write(pin.rpy.matrixToRpy(placement.rotation))}"/>'
    )


class Robot:
    """A robot to be written to three files.

    It has links, joints, loops, actuated joints and the pose ``home``. Loops are closed at points,
    or by hinges (``kind``). Positions and ``home`` are written with all digits, or with fewer
    ``digits``.
    """

    def __init__(self, name: str, title: str, kind: str = "3d", digits: int | None = None) -> None:
        self.name, self.title, self.kind, self.digits = name, title, kind, digits
        self.elements: list[str] = []
        self.home: dict[str, float] = {}
        self.loops: list[tuple[str, str]] = []
        self.actuated: list[str] = []

    def write(self, values: ArrayLike) -> str:
        """Write numbers with the digits of this robot."""
        if self.digits is None:
            return exact(values)
        # A rounding error is written as zero.
        numbers = np.atleast_1d(np.asarray(values, dtype=float))
        return " ".join(f"{0.0 if abs(v) < 1e-15 else v:.{self.digits}g}" for v in numbers)

    def base(self, solids: Sequence[Solid]) -> None:
        """Add the fixed base: it is drawn, and has no mass."""
        self._link("base", None, solids)

    def body(
        self,
        link: str,
        solids: Sequence[Solid],
        joint: str,
        parent: str,
        placement: pin.SE3,
        axis: str,
        limits: tuple[float, float],
        home: float = 0.0,
        motor: tuple[float, float] | None = None,
    ) -> None:
        """Add a link with its joint.

        The joint is revolute about ``axis``, or prismatic along it if the name starts with
        ``along``.

        ``motor`` holds the limits of effort and velocity of an actuated joint.
        """
        kind = "prismatic" if axis.startswith("along") else "revolute"
        vector = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1", "-y": "0 -1 0", "-z": "0 0 -1"}[
            axis.split()[-1]
        ]
        effort, velocity = motor or (0.0, PASSIVE_SPEED)
        self.elements += [
            f'  <joint name="{joint}" type="{kind}">',
            f'    <parent link="{parent}"/>',
            f'    <child link="{link}"/>',
            f"    {_origin(placement, self.write)}",
            f'    <axis xyz="{vector}"/>',
            (
                f'    <limit lower="{limits[0]:g}" upper="{limits[1]:g}" effort="{effort:g}" '
                f'velocity="{velocity:g}"/>'
            ),
            "  </joint>",
        ]
        inertia = sum((solid.inertia() for solid in solids[1:]), start=solids[0].inertia())
        self._link(link, inertia, solids)
        self.home[joint] = home
        if motor is not None:
            self.actuated.append(joint)

    def frame(
        self,
        name: str,
        parent: str,
        position: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike | None = None,
    ) -> None:
        """Add a frame on a link."""
        self.elements += [
            f'  <link name="{name}">',
            *NO_MASS,
            "  </link>",
            f'  <joint name="{name}_fixed" type="fixed">',
            f'    <parent link="{parent}"/>',
            f'    <child link="{name}"/>',
            f"    {_origin(at(position, rotation), self.write)}",
            "  </joint>",
        ]

    def close(self, first: str, second: str) -> None:
        """Close a loop: the origins of two frames coincide in the assembled robot."""
        self.loops.append((first, second))

    def _link(self, name: str, inertia: pin.Inertia | None, solids: Sequence[Solid]) -> None:
        self.elements.append(f'  <link name="{name}">')
        if inertia is None:
            self.elements += NO_MASS
        else:
            moments = inertia.inertia
            entries = zip(
                ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), moments[np.triu_indices(3)], strict=True
            )
            # A rounding error is written as zero.
            written = " ".join(
                f'{key}="{value if abs(value) > 1e-12 * moments.max() else 0.0:.12g}"'
                for key, value in entries
            )
            center = np.where(np.abs(inertia.lever) > 1e-12, inertia.lever, 0.0)
            self.elements += [
                "    <inertial>",
                f'      <origin xyz="{" ".join(f"{value:.12g}" for value in center)}"/>',
                f'      <mass value="{inertia.mass:.12g}"/>',
                f"      <inertia {written}/>",
                "    </inertial>",
            ]
        for solid in solids:
            tag = {
                "box": f'box size="{short(solid.size)}"',
                "sphere": f'sphere radius="{short(solid.size)}"',
                "cylinder": (
                    f'cylinder radius="{short(solid.size[0])}" length="{short(solid.size[-1])}"'
                ),
            }[solid.shape]
            self.elements.append(
                f"    <visual>{_origin(solid.placement, short)}<geometry><{tag}/></geometry>"
                f'<material name="{solid.material}"/></visual>'
            )
        self.elements.append("  </link>")

    def texts(self) -> Mapping[str, str]:
        """Return the contents of the three files by their names."""
        used = [
            name
            for name in MATERIALS
            if any(f'<material name="{name}"/>' in line for line in self.elements)
        ]
        materials = [
            f'  <material name="{name}"><color rgba="{MATERIALS[name][0]}"/></material>'
            for name in used
        ]
        head = [
            '<?xml version="1.0"?>',
            (
                f"<!-- {self.title} Written by make_robots.py; README.md says where every number "
                "comes from. -->"
            ),
        ]
        urdf = [
            *head,
            f'<robot name="{self.name}">',
            *materials,
            "",
            *self.elements,
            "</robot>",
            "",
        ]
        precision = "1e-12" if self.digits is None else f"{self.digits} digits"
        srdf = [
            '<?xml version="1.0"?>',
            (
                f"<!-- Reference pose of {self.name}.urdf, which closes the loops of "
                f"{self.name}.yaml to {precision}. Written by make_robots.py. -->"
            ),
            f'<robot name="{self.name}">',
            '  <group name="all">',
            *(f'    <joint name="{joint}"/>' for joint in self.home),
            "  </group>",
            '  <group name="actuated">',
            *(f'    <joint name="{joint}"/>' for joint in self.actuated),
            "  </group>",
            '  <group_state name="home" group="all">',
            *(
                f'    <joint name="{joint}" value="{self.write(value)}"/>'
                for joint, value in self.home.items()
            ),
            "  </group_state>",
            "</robot>",
            "",
        ]
        pairs = ",\n              ".join(f"[{first}, {second}]" for first, second in self.loops)
        yaml = [
            (
                f"# The loops of {self.name}.urdf and its actuated joints, in the keys of "
                "toolbox-parallel-robots. Written by make_robots.py."
            ),
            f"closed_loop: [{pairs}]",
            f"type: [{', '.join([self.kind] * len(self.loops))}]",
            f"name_mot: [{', '.join(self.actuated)}]",
            "joint_name: []",
            "joint_type: []",
            "",
        ]
        return {
            f"{self.name}.urdf": "\n".join(urdf),
            f"{self.name}.srdf": "\n".join(srdf),
            f"{self.name}.yaml": "\n".join(yaml),
        }

"""Write the files of five parallel robots, ``<name>.urdf``, ``.srdf`` and ``.yaml``.

Run by ``python urdf/make_robots.py [directory]``.

Every length is here once, and every mass and inertia is computed from the solids that are drawn: a
box, a ball, a rod or a tube of the density of its material. What a frame stands on is drawn but
never moves, so it has no mass. README.md says where the numbers come from.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

HERE = Path(__file__).resolve().parent

MATERIALS = {
    "steel": ("0.78 0.80 0.82 1", 7850.0),
    "screw": ("0.48 0.50 0.53 1", 7850.0),
    "aluminum": ("0.62 0.65 0.68 1", 2700.0),
    "anodized": ("0.20 0.23 0.27 1", 2700.0),
    "accent": ("0.93 0.42 0.10 1", 2700.0),
    "brass": ("0.72 0.56 0.27 1", 8500.0),
    "carbon": ("0.10 0.10 0.11 1", 1600.0),
    "rubber": ("0.14 0.14 0.15 1", 1200.0),
}
"""Color and density [kg/m³] of each material; anodized and accent are aluminum, screw is steel."""

X, Y, Z = np.eye(3)
"""Unit vectors."""

PASSIVE_SPEED = 100.0
"""Limit of the velocity of joints without a motor [rad/s, m/s]: none, in words that a URDF
accepts.
"""


class Solid(NamedTuple):
    """A homogeneous solid: what is drawn, and what weighs.

    ``bore`` is the radius of the hole along a cylinder [m].
    """

    shape: str
    size: tuple[float, ...]
    material: str
    placement: pin.SE3
    bore: float = 0.0

    def inertia(self) -> pin.Inertia:
        """Return the mass, center of mass and moments, in the frame of the link."""
        density = MATERIALS[self.material][1]
        if self.shape == "box":
            body = pin.Inertia.FromBox(density * float(np.prod(self.size)), *self.size)
        elif self.shape == "sphere":
            body = pin.Inertia.FromSphere(
                density * 4.0 / 3.0 * np.pi * self.size[0] ** 3, *self.size
            )
        else:
            outer, length = self.size
            mass = density * np.pi * (outer**2 - self.bore**2) * length
            axial = 0.5 * mass * (outer**2 + self.bore**2)
            transverse = 0.5 * axial + mass * length**2 / 12.0
            body = pin.Inertia(mass, np.zeros(3), np.diag([transverse, transverse, axial]))
        return self.placement.act(body)


def box(
    size: tuple[float, float, float], center: ArrayLike, material: str, turn: float = 0.0
) -> Solid:
    """Return a box, turned about the vertical through its center."""
    return Solid(
        "box", size, material, pin.SE3(pin.utils.rotate("z", turn), np.asarray(center, dtype=float))
    )


def ball(radius: float, center: ArrayLike, material: str) -> Solid:
    """Return a ball."""
    return Solid("sphere", (radius,), material, pin.SE3(np.eye(3), np.asarray(center, dtype=float)))


def rod(start: ArrayLike, end: ArrayLike, radius: float, material: str, bore: float = 0.0) -> Solid:
    """Return a cylinder between two points, or a tube."""
    first, last = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    placement = pin.SE3(_turn_to(last - first), 0.5 * (first + last))
    return Solid(
        "cylinder", (radius, float(np.linalg.norm(last - first))), material, placement, bore
    )


def cross(radius: float, length: float, first: str, second: str) -> list[Solid]:
    """Return the two pins of a universal joint.

    Along the axes ``x``, ``y`` or ``z`` of its two hinges.
    """
    axes = {"x": X, "y": Y, "z": Z}
    return [
        rod(-0.5 * length * axes[axis], 0.5 * length * axes[axis], radius, "steel")
        for axis in (first, second)
    ]


def moved(solids: Iterable[Solid], by: ArrayLike) -> list[Solid]:
    """Return solids given about another origin, which is at ``by`` in the frame of the link."""
    shift = pin.SE3(np.eye(3), np.asarray(by, dtype=float))
    return [solid._replace(placement=shift * solid.placement) for solid in solids]


def around(angle: float, radius: float, height: float = 0.0) -> Array:
    """Return the point at an azimuth and a distance from the vertical axis."""
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def _turn_to(direction: Array) -> Array:
    """Return a rotation that takes z to a direction, with x horizontal."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(Z, z)
    x = x / np.linalg.norm(x) if np.linalg.norm(x) > 1e-12 else X
    return np.column_stack([x, np.cross(z, x), z])


def _exact(values: ArrayLike) -> str:
    """Write numbers so that they are read back bit by bit."""
    return " ".join(
        repr(float(value) + 0.0) for value in np.atleast_1d(np.asarray(values, dtype=float))
    )


def _short(values: ArrayLike) -> str:
    """Write numbers to a micrometer, for what is only drawn."""
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
    """A robot on its way to three files.

    Links, joints, loops, actuated joints and the pose ``home``.
    """

    def __init__(self, name: str, title: str) -> None:
        self.name, self.title = name, title
        self.elements: list[str] = []
        self.home: dict[str, float] = {}
        self.loops: list[tuple[str, str]] = []
        self.actuated: list[str] = []

    def base(self, solids: Sequence[Solid]) -> None:
        """Add what does not move: it is drawn, and has no mass."""
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

        Revolute about ``axis``, or prismatic along it where the axis starts with ``along``.

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
            f"    {_origin(placement, _exact)}",
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

    def frame(self, name: str, parent: str, position: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Add a frame on a link."""
        self.elements += [
            f'  <link name="{name}"/>',
            f'  <joint name="{name}_fixed" type="fixed">',
            f'    <parent link="{parent}"/>',
            f'    <child link="{name}"/>',
            f"    {_origin(pin.SE3(np.eye(3), np.asarray(position, dtype=float)), _exact)}",
            "  </joint>",
        ]

    def close(self, first: str, second: str) -> None:
        """Let the origins of two frames coincide in the assembled robot."""
        self.loops.append((first, second))

    def _link(self, name: str, inertia: pin.Inertia | None, solids: Sequence[Solid]) -> None:
        self.elements.append(f'  <link name="{name}">')
        if inertia is not None:
            moments = inertia.inertia
            entries = zip(
                ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), moments[np.triu_indices(3)], strict=True
            )
            # What rounding leaves of a zero is written as zero.
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
                "box": f'box size="{_short(solid.size)}"',
                "sphere": f'sphere radius="{_short(solid.size)}"',
                "cylinder": (
                    f'cylinder radius="{_short(solid.size[0])}" length="{_short(solid.size[-1])}"'
                ),
            }[solid.shape]
            self.elements.append(
                f"    <visual>{_origin(solid.placement, _short)}<geometry><{tag}/></geometry>"
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
        srdf = [
            '<?xml version="1.0"?>',
            (
                f"<!-- Reference pose of {self.name}.urdf, which closes the loops of "
                f"{self.name}.yaml to 1e-12. Written by make_robots.py. -->"
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
                f'    <joint name="{joint}" value="{_exact(value)}"/>'
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
            f"type: [{', '.join(['3d'] * len(self.loops))}]",
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


def at(position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None) -> pin.SE3:
    """Return a placement; without a rotation the axes stay parallel."""
    return pin.SE3(
        np.eye(3) if rotation is None else np.asarray(rotation), np.asarray(position, dtype=float)
    )


def turn(angle: float) -> Array:
    """Return the rotation about the vertical."""
    return np.asarray(pin.utils.rotate("z", angle))


def beams(radius: float, height: float, azimuths: Iterable[float], width: float) -> list[Solid]:
    """Return beams from the axis outward."""
    return [
        box((radius, width, width), around(azimuth, 0.5 * radius, height), "anodized", azimuth)
        for azimuth in azimuths
    ]


def columns(
    radius: float, top: float, floor: float, azimuths: Iterable[float], width: float
) -> list[Solid]:
    """Return columns at a distance from the axis, each with a foot."""
    solids = []
    for azimuth in azimuths:
        middle, foot = around(azimuth, radius, 0.5 * (top + floor)), around(azimuth, radius, floor)
        solids += [
            box((width, width, top - floor + width), middle, "anodized", azimuth),
            rod(foot - width * Z, foot - 0.5 * width * Z, 1.2 * width, "rubber"),
        ]
    return solids


def five_bar() -> Robot:
    """Return two motors side by side, two cranks, two rods that meet in a point.

    In a vertical plane, seen from the side of y.
    """
    spacing, crank, coupler, swing = 0.2, 0.2, 0.28, 0.6
    robot = Robot("five_bar", "Planar five-bar linkage in the plane y = 0.")
    shafts = {1: 0.5 * spacing * X, 2: -0.5 * spacing * X}
    posts = [box((0.03, 0.03, 0.66), [x, -0.075, -0.29], "anodized") for x in (-0.17, 0.17)]
    motors = [rod(shaft - 0.06 * Y, shaft - 0.15 * Y, 0.032, "rubber") for shaft in shafts.values()]
    bearings = [
        rod(shaft - 0.012 * Y, shaft - 0.05 * Y, 0.022, "steel") for shaft in shafts.values()
    ]
    foot = box((0.46, 0.24, 0.02), [0.0, -0.06, -0.63], "anodized")
    robot.base(
        [box((0.40, 0.03, 0.10), [0.0, -0.05, 0.0], "aluminum"), *posts, foot, *motors, *bearings]
    )
    # At home the robot is symmetric, its point below the middle: each rod leans toward it by this
    # angle.
    lean = np.arcsin((0.5 * spacing + crank * np.sin(swing)) / coupler)
    elbow = -crank * Z
    end = -coupler * Z
    for leg, side in ((1, -1.0), (2, 1.0)):
        # The rods pass in front of the cranks, in layers of their own.
        depth = (0.018 if leg == 1 else 0.028) * Y
        upper = [
            box((0.026, 0.008, crank), 0.5 * elbow, "aluminum"),
            rod(-0.012 * Y, 0.01 * Y, 0.02, "anodized"),
            rod(elbow - 0.008 * Y, elbow + 0.01 * Y, 0.016, "anodized"),
        ]
        lower = [
            box((0.018, 0.006, coupler), depth + 0.5 * end, "carbon"),
            rod(0.01 * Y, depth + 0.005 * Y, 0.012, "steel"),
            rod(end + depth - 0.004 * Y, end + depth + 0.004 * Y, 0.013, "steel"),
        ]
        if leg == 1:
            lower.append(rod(end + 0.01 * Y, end + 0.055 * Y, 0.006, "accent"))
        shoulder, limits = at(shafts[leg]), (-1.5, 1.5)
        robot.body(
            f"leg{leg}_crank",
            upper,
            f"leg{leg}_shoulder",
            "base",
            shoulder,
            "y",
            limits,
            side * swing,
            (20.0, 20.0),
        )
        bend = -side * (lean + swing)
        robot.body(
            f"leg{leg}_rod",
            lower,
            f"leg{leg}_elbow",
            f"leg{leg}_crank",
            at(elbow),
            "y",
            (-2.6, 2.6),
            bend,
        )
    robot.frame("tip", "leg1_rod", end)
    robot.frame("leg2_end", "leg2_rod", end)
    robot.close("tip", "leg2_end")
    return robot


def planar_3rrr() -> Robot:
    """Return a triangle carried by three legs of a crank and a rod each, in a horizontal plane."""
    base, platform, crank, coupler = 0.3, 0.08, 0.16, 0.18
    robot = Robot("planar_3rrr", "Planar 3-RRR robot in the plane z = 0.")
    azimuths = {leg: np.pi / 2.0 + 2.0 * np.pi / 3.0 * (leg - 1) for leg in (1, 2, 3)}
    table = [rod(-0.10 * Z, -0.08 * Z, 0.36, "anodized"), rod(-0.11 * Z, -0.10 * Z, 0.33, "rubber")]
    for azimuth in azimuths.values():
        shaft = around(azimuth, base)
        table += [
            rod(shaft - 0.08 * Z, shaft - 0.025 * Z, 0.034, "rubber"),
            rod(shaft - 0.025 * Z, shaft - 0.008 * Z, 0.02, "steel"),
        ]
    robot.base(table)
    # At home the platform is centered and not turned; the law of cosines in the triangle shaft,
    # elbow, wrist.
    reach = base - platform
    swing = np.arccos((reach**2 + crank**2 - coupler**2) / (2.0 * reach * crank))
    bend = np.pi - np.arccos((crank**2 + coupler**2 - reach**2) / (2.0 * crank * coupler))
    for leg, azimuth in azimuths.items():
        upper = [
            box((crank, 0.024, 0.008), [0.5 * crank, 0.0, 0.0], "aluminum"),
            rod(-0.008 * Z, 0.01 * Z, 0.02, "anodized"),
            rod([crank, 0.0, -0.006], [crank, 0.0, 0.01], 0.015, "anodized"),
        ]
        lower = [
            box((coupler, 0.016, 0.006), [0.5 * coupler, 0.0, 0.016], "carbon"),
            rod(0.01 * Z, 0.022 * Z, 0.012, "steel"),
            rod([coupler, 0.0, 0.012], [coupler, 0.0, 0.022], 0.012, "steel"),
        ]
        # The crank's angle is counted from the direction to the middle.
        placement = at(around(azimuth, base), turn(azimuth + np.pi))
        robot.body(
            f"leg{leg}_crank",
            upper,
            f"leg{leg}_shoulder",
            "base",
            placement,
            "z",
            (-1.0, 2.2),
            swing,
            (10.0, 20.0),
        )
        robot.body(
            f"leg{leg}_rod",
            lower,
            f"leg{leg}_elbow",
            f"leg{leg}_crank",
            at([crank, 0.0, 0.0]),
            "z",
            (-2.7, 2.7),
            -bend,
        )
    corners = {leg: around(azimuth, platform) for leg, azimuth in azimuths.items()}
    plate = [rod(0.022 * Z, 0.034 * Z, 0.03, "anodized"), rod(0.034 * Z, 0.07 * Z, 0.008, "accent")]
    for corner, azimuth in zip(corners.values(), azimuths.values(), strict=True):
        plate += [
            box((platform, 0.022, 0.008), 0.5 * corner + 0.028 * Z, "aluminum", azimuth),
            rod(corner + 0.022 * Z, corner + 0.036 * Z, 0.014, "anodized"),
        ]
    # The platform's axes are the base's at home, where the rod of leg 1 has turned by the azimuth
    # of its frame, the swing and the bend.
    rod_direction = azimuths[1] + np.pi + swing - bend
    robot.body(
        "platform",
        moved(plate, -corners[1]),
        "leg1_wrist",
        "leg1_rod",
        at([coupler, 0.0, 0.0], turn(-rod_direction)),
        "z",
        (-2.7, 2.7),
    )
    robot.frame("tip", "platform", -corners[1])
    for leg in (2, 3):
        robot.frame(f"leg{leg}_end", f"leg{leg}_rod", [coupler, 0.0, 0.0])
        robot.frame(f"platform_corner{leg}", "platform", corners[leg] - corners[1])
        robot.close(f"platform_corner{leg}", f"leg{leg}_end")
    return robot


def delta() -> Robot:
    """Return three arms, each with two parallel rods to a platform that cannot turn."""
    base, arm, rod_length, platform, spacing = 0.12, 0.2, 0.4, 0.05, 0.09
    robot = Robot("delta", "Delta robot: three driven arms, six rods.")
    azimuths = {leg: 2.0 * np.pi / 3.0 * (leg - 1) for leg in (1, 2, 3)}
    # The beams pass above the arms, as far up as these swing.
    stand = beams(0.46, 0.3, azimuths.values(), 0.04) + columns(
        0.46, 0.3, -0.62, azimuths.values(), 0.04
    )
    stand += [rod(0.05 * Z, 0.09 * Z, 0.16, "anodized"), rod(0.09 * Z, 0.3 * Z, 0.06, "anodized")]
    for azimuth in azimuths.values():
        sideways, shoulder = around(azimuth + np.pi / 2.0, 1.0), around(azimuth, base)
        stand += [
            box((0.05, 0.05, 0.06), shoulder + 0.055 * sideways + 0.022 * Z, "aluminum", azimuth),
            rod(shoulder + 0.03 * sideways, shoulder + 0.13 * sideways, 0.026, "rubber"),
        ]
    robot.base(stand)
    # At home the arms are level, and each rod leans inward by this angle.
    lean = np.arcsin((base + arm - platform) / rod_length)
    link = [
        rod([0.02, 0.0, 0.0], [arm, 0.0, 0.0], 0.014, "carbon", 0.012),
        rod(-0.03 * Y, 0.03 * Y, 0.024, "aluminum"),
        rod([arm, -0.5 * spacing, 0.0], [arm, 0.5 * spacing, 0.0], 0.008, "steel"),
    ]
    thin = [
        rod(-0.012 * Z, (0.012 - rod_length) * Z, 0.006, "carbon", 0.004),
        rod(-0.018 * Z, 0.0 * Z, 0.009, "anodized"),
        ball(0.01, -rod_length * Z, "steel"),
    ]
    for leg, azimuth in azimuths.items():
        placement = at(around(azimuth, base), turn(azimuth))
        robot.body(
            f"leg{leg}_arm",
            link,
            f"leg{leg}_shoulder",
            "base",
            placement,
            "y",
            (-1.0, 1.5),
            0.0,
            (30.0, 20.0),
        )
        for number, side in ((1, 1.0), (2, -1.0)):
            name = f"leg{leg}_rod{number}"
            hinge = at([arm, 0.5 * side * spacing, 0.0])
            robot.body(
                f"{name}_cross",
                cross(0.005, 0.024, "y", "x"),
                f"{name}_pitch",
                f"leg{leg}_arm",
                hinge,
                "y",
                (-1.5, 2.6),
                lean,
            )
            robot.body(name, thin, f"{name}_swing", f"{name}_cross", at(), "x", (-1.2, 1.2))
    ends = {
        (leg, number): around(azimuth, platform)
        + 0.5 * side * spacing * around(azimuth + np.pi / 2.0, 1.0)
        for leg, azimuth in azimuths.items()
        for number, side in ((1, 1.0), (2, -1.0))
    }
    plate = [
        rod(-0.012 * Z, 0.0 * Z, 0.045, "anodized"),
        rod(-0.05 * Z, -0.012 * Z, 0.012, "accent"),
        *(rod(ends[leg, 1], ends[leg, 2], 0.007, "steel") for leg in azimuths),
    ]
    # A ball joint at the lower end of the first rod of leg 1 carries the platform. It undoes swing
    # and pitch of the rod, so that its middle angle is always 0, far from where its axes fall
    # together.
    lower = at(-rod_length * Z)
    robot.body(
        "platform_cross1",
        cross(0.004, 0.02, "x", "z"),
        "platform_x",
        "leg1_rod1",
        lower,
        "x",
        (-1.2, 1.2),
    )
    robot.body(
        "platform_cross2",
        cross(0.004, 0.02, "z", "y"),
        "platform_z",
        "platform_cross1",
        at(),
        "z",
        (-1.2, 1.2),
    )
    robot.body(
        "platform",
        moved(plate, -ends[1, 1]),
        "platform_y",
        "platform_cross2",
        at(),
        "y",
        (-2.6, 2.6),
        -lean,
    )
    robot.frame("tip", "platform", -ends[1, 1])
    for (leg, number), end in ends.items():
        if (leg, number) != (1, 1):
            robot.frame(f"leg{leg}_rod{number}_end", f"leg{leg}_rod{number}", -rod_length * Z)
            robot.frame(f"platform_leg{leg}_rod{number}", "platform", end - ends[1, 1])
            robot.close(f"platform_leg{leg}_rod{number}", f"leg{leg}_rod{number}_end")
    return robot


def extensible_leg(
    robot: Robot,
    name: str,
    foot: Array,
    end: Array,
    tube: tuple[float, float],
    piston: tuple[float, float],
    stroke: tuple[float, float],
    motor: tuple[float, float],
) -> None:
    """Add a universal joint at ``foot`` and a slider.

    The slider's coordinate is the distance to the leg's end.

    At home the leg points to ``end`` and its universal joint is straight: the leg's frame has z
    along the leg and x horizontal. ``tube`` and ``piston`` hold radius and length.
    """
    placement = at(foot, _turn_to(end - foot))
    body = [
        rod(0.0 * Z, tube[1] * Z, tube[0], "aluminum", 0.8 * tube[0]),
        rod((tube[1] - 0.03) * Z, (tube[1] + 0.01) * Z, 1.25 * tube[0], "anodized", 0.8 * tube[0]),
        rod(0.03 * Z, 0.15 * Z, 1.25 * tube[0], "anodized", 0.8 * tube[0]),
    ]
    slider = [
        rod(-piston[1] * Z, 0.0 * Z, piston[0], "screw", 0.7 * piston[0]),
        ball(1.5 * piston[0], np.zeros(3), "steel"),
    ]
    length = float(np.linalg.norm(end - foot))
    robot.body(
        f"{name}_cross",
        cross(0.4 * tube[0], 2.6 * tube[0], "x", "y"),
        f"{name}_universal_x",
        "base",
        placement,
        "x",
        (-1.2, 1.2),
    )
    robot.body(f"{name}_tube", body, f"{name}_universal_y", f"{name}_cross", at(), "y", (-1.2, 1.2))
    robot.body(
        f"{name}_rod",
        slider,
        f"{name}_length",
        f"{name}_tube",
        at(),
        "along z",
        stroke,
        length,
        motor,
    )


def gough_stewart() -> Robot:
    """Return six legs of adjustable length between a base and a platform.

    Each is on a universal joint below and a ball above.
    """
    base, platform, height = 0.5, 0.3, 0.7
    robot = Robot("gough_stewart", "Gough-Stewart platform: six legs of adjustable length (6-UPS).")
    near = np.radians(10.0)
    feet = [
        around(2.0 * np.pi / 3.0 * k + sign * near, base)
        for k, sign in ((0, 1), (1, -1), (1, 1), (2, -1), (2, 1), (3, -1))
    ]
    corners = [
        around(np.pi / 3.0 + 2.0 * np.pi / 3.0 * k + sign * near, platform)
        for k, sign in ((0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1))
    ]
    floor = [rod(-0.09 * Z, -0.06 * Z, 0.6, "anodized"), rod(-0.11 * Z, -0.09 * Z, 0.56, "rubber")]
    robot.base(
        [*floor, *(rod(foot - 0.06 * Z, foot - 0.02 * Z, 0.05, "aluminum") for foot in feet)]
    )
    lift = height * Z
    for leg, (foot, corner) in enumerate(zip(feet, corners, strict=True), start=1):
        extensible_leg(
            robot,
            f"leg{leg}",
            foot,
            corner + lift,
            (0.035, 0.5),
            (0.018, 0.55),
            (0.6, 0.95),
            (3000.0, 2.0),
        )
        if leg == 1:
            plate = [
                rod(0.02 * Z, 0.04 * Z, 0.32, "anodized"),
                rod(0.04 * Z, 0.1 * Z, 0.06, "aluminum"),
                rod(0.1 * Z, 0.16 * Z, 0.02, "accent"),
                *(rod(point, point + 0.02 * Z, 0.03, "aluminum") for point in corners),
            ]
            # The ball's axes are the base's at home.
            level = at(rotation=_turn_to(corner + lift - foot).T)
            robot.body(
                "platform_cross1",
                cross(0.012, 0.06, "x", "y"),
                "platform_x",
                "leg1_rod",
                level,
                "x",
                (-1.5, 1.5),
            )
            robot.body(
                "platform_cross2",
                cross(0.012, 0.06, "y", "z"),
                "platform_y",
                "platform_cross1",
                at(),
                "y",
                (-1.5, 1.5),
            )
            robot.body(
                "platform",
                moved(plate, -corner),
                "platform_z",
                "platform_cross2",
                at(),
                "z",
                (-1.5, 1.5),
            )
            robot.frame("tip", "platform", -corner)
        else:
            robot.frame(f"leg{leg}_end", f"leg{leg}_rod")
            robot.frame(f"platform_corner{leg}", "platform", corner - corners[0])
            robot.close(f"platform_corner{leg}", f"leg{leg}_end")
    return robot


def tricept() -> Robot:
    """Return three legs of adjustable length and a tube in the middle.

    The tube slides in a universal joint and carries platform and tool.
    """
    base, platform, depth, tool = 0.4, 0.16, 1.15, 0.25
    robot = Robot(
        "tricept",
        "Tricept: three legs of adjustable length (UPS) around a sliding central tube (UP).",
    )
    azimuths = {leg: 2.0 * np.pi / 3.0 * (leg - 1) for leg in (1, 2, 3)}
    feet = {leg: around(azimuth, base) for leg, azimuth in azimuths.items()}
    # One column out of the tool's reach.
    stand = beams(0.47, 0.11, azimuths.values(), 0.08)
    stand += beams(1.3, 0.11, [azimuths[3]], 0.12) + columns(1.3, 0.11, -1.85, [azimuths[3]], 0.16)
    stand.append(rod(0.07 * Z, 0.15 * Z, 0.17, "anodized"))
    stand += [box((0.03, 0.08, 0.1), [x, 0.0, 0.03], "aluminum") for x in (-0.1, 0.1)]
    # A fork above each leg's universal joint; its hinge lies across the leg's azimuth.
    for azimuth, foot in zip(azimuths.values(), feet.values(), strict=True):
        sideways = around(azimuth + np.pi / 2.0, 0.055)
        stand += [
            box((0.08, 0.02, 0.1), foot + side * sideways + 0.03 * Z, "aluminum", azimuth)
            for side in (-1.0, 1.0)
        ]
    robot.base(stand)
    corners = {leg: around(azimuth, platform) for leg, azimuth in azimuths.items()}
    down = -depth * Z
    for leg in azimuths:
        extensible_leg(
            robot,
            f"leg{leg}",
            feet[leg],
            corners[leg] + down,
            (0.04, 0.8),
            (0.02, 0.85),
            (0.9, 1.55),
            (5000.0, 2.0),
        )
    ring = [rod(-0.05 * Y, 0.05 * Y, 0.02, "steel"), rod(-0.09 * X, 0.09 * X, 0.02, "steel")]
    sleeve = [rod(-0.08 * Z, 0.08 * Z, 0.06, "anodized", 0.045)]
    tube = [
        rod(0.0 * Z, 1.5 * Z, 0.045, "steel", 0.04),
        rod(-0.03 * Z, 0.0 * Z, 0.19, "anodized"),
        rod(-0.17 * Z, -0.03 * Z, 0.05, "aluminum"),
        rod(-tool * Z, -0.17 * Z, 0.012, "accent"),
        *(
            rod(corner - 0.02 * Z, corner + 0.01 * Z, 0.03, "aluminum")
            for corner in corners.values()
        ),
    ]
    robot.body("center_cross", ring, "center_universal_x", "base", at(), "x", (-0.7, 0.7))
    robot.body(
        "center_sleeve", sleeve, "center_universal_y", "center_cross", at(), "y", (-0.7, 0.7)
    )
    # The tube's coordinate is the distance from the universal joint down to the platform.
    robot.body(
        "platform", tube, "center_length", "center_sleeve", at(), "along -z", (0.8, 1.45), depth
    )
    robot.frame("tip", "platform", -tool * Z)
    for leg, corner in corners.items():
        robot.frame(f"leg{leg}_end", f"leg{leg}_rod")
        robot.frame(f"platform_corner{leg}", "platform", corner)
        robot.close(f"platform_corner{leg}", f"leg{leg}_end")
    return robot


ROBOTS = (five_bar, planar_3rrr, delta, gough_stewart, tricept)


def main(directory: str | Path = HERE) -> None:
    """Write all files into a directory."""
    for build in ROBOTS:
        for name, text in build().texts().items():
            (Path(directory) / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Two-finger gripper: five-bar fingers with a spring each, coupled, pulled by one tendon."""

from __future__ import annotations

import numpy as np

from .mjcf import Assembly, Joint, More
from .solids import Array, Solid, Z, box, meet, rod

DRIVER, SPRING = (0.0306, 0.0549), (0.0132, 0.0609)
"""Pins of a finger's two arms on the palm, (y, z) [m]."""

DRIVER_ARM, SPRING_ARM = (0.0315, -0.0041), (0.0370, 0.0440)
"""From these pins to the next ones, with open fingers."""

TIP = (0.0180, -0.0065)
"""On the fingertip, from the spring arm's pin to that of the coupler, with open fingers."""

PAD = 0.0427
"""Distance of an open pad from the middle: 85 mm between the two."""

HALF = 0.4
"""Angle of the drivers in the home pose; the pads touch at 0.8 [rad]."""

TIP_HEIGHT = 0.13
"""Position of the point between the pads, the frame ``tip`` [m]."""

STIFFNESS, REST = 0.05, 2.62
"""Spring of each finger [N m/rad, rad]."""


def gripper() -> Assembly:
    """Return the palm, and two fingers that mirror each other."""
    robot = Assembly(
        "gripper", "Two-finger gripper: coupled five-bars with springs, one tendon motor."
    )
    robot.base(
        [
            rod(-0.012 * Z, 0.0 * Z, 0.0375, "anodized"),
            box((0.056, 0.075, 0.05), 0.025 * Z, "anodized"),
            box((0.012, 0.066, 0.026), 0.058 * Z, "rubber"),
        ]
    )
    robot.site("tip", "world", np.array([0.0, 0.0, TIP_HEIGHT]))
    for name, side in (("right", 1.0), ("left", -1.0)):
        _finger(robot, name, side)
    robot.couple("left_driver", "right_driver", (0.0, 1.0, 0.0, 0.0, 0.0))
    robot.tendon("split", {"right_driver": 0.5, "left_driver": 0.5})
    robot.motor("split", 5.0, "tendon")
    angles = half_closed()
    robot.home(
        {f"{name}_{joint}": at for name in ("right", "left") for joint, at in angles.items()}
    )
    return robot


def half_closed() -> dict[str, float]:
    """Return the angles of a finger with its driver half way and its pad not rotated."""
    open_end = np.add(np.add(SPRING, SPRING_ARM), TIP)
    coupler = open_end - np.add(DRIVER, DRIVER_ARM)
    c, s = np.cos(HALF), np.sin(HALF)
    arm = np.array([c * DRIVER_ARM[0] - s * DRIVER_ARM[1], s * DRIVER_ARM[0] + c * DRIVER_ARM[1]])
    knee = np.add(DRIVER, arm)
    # The fingertip only translates, so its two pins move as one.
    knuckle = meet(np.array(SPRING), np.hypot(*SPRING_ARM), knee - TIP, np.hypot(*coupler), 1.0)
    turned, before = knuckle - SPRING, np.arctan2(SPRING_ARM[1], SPRING_ARM[0])
    spring = np.arctan2(turned[1], turned[0]) - before
    way = knuckle + TIP - knee
    tilt = np.arctan2(way[1], way[0]) - np.arctan2(coupler[1], coupler[0])
    return {
        "driver": HALF,
        "coupler": float(tilt - HALF),
        "spring": float(spring),
        "fingertip": float(-spring),
    }


def _finger(robot: Assembly, name: str, side: float) -> None:
    """Add the four bodies of a finger; a positive angle of the driver closes it."""

    def place(y: float, z: float, x: float = 0.0) -> Array:
        return np.array([x, side * y, z])

    pins = {
        "driver": place(*DRIVER),
        "coupler": place(*np.add(DRIVER, DRIVER_ARM)),
        "spring": place(*SPRING),
        "tip": place(*np.add(SPRING, SPRING_ARM)),
        "end": place(*np.add(np.add(SPRING, SPRING_ARM), TIP)),
    }
    axis = (side, 0.0, 0.0)
    # The bars are in layers: arms outside, coupler and fingertip between them.
    across = np.array([0.004, 0.0, 0.0])

    def bar(first: str, last: str, layer: float, thick: float) -> list[Solid]:
        return [
            rod(
                pins[first] + k * layer * across, pins[last] + k * layer * across, thick, "aluminum"
            )
            for k in (-1.0, 1.0)
        ]

    def pin(at: str, layer: float) -> list[Solid]:
        return [rod(pins[at] - layer * across, pins[at] + layer * across, 0.003, "steel")]

    driven: More = {"range": (0.0, 0.8), "actuatorfrcrange": (-5.0, 5.0), "armature": 0.005}
    robot.body(
        f"{name}_driver",
        "world",
        pins["driver"],
        Joint(f"{name}_driver", axis=axis, more=driven),
        bar("driver", "coupler", 3.0, 0.004) + pin("coupler", 3.0),
    )
    robot.body(
        f"{name}_coupler",
        f"{name}_driver",
        pins["coupler"],
        Joint(f"{name}_coupler", axis=axis, more={"range": (-1.57, 0.5)}),
        bar("coupler", "end", 2.0, 0.003),
    )
    sprung: More = {"range": (-0.3, 0.8), "stiffness": STIFFNESS, "springref": REST}
    robot.body(
        f"{name}_spring_arm",
        "world",
        pins["spring"],
        Joint(f"{name}_spring", axis=axis, more=sprung),
        bar("spring", "tip", 3.0, 0.004) + pin("tip", 3.0),
    )
    z = pins["end"][2]
    robot.body(
        f"{name}_fingertip",
        f"{name}_spring_arm",
        pins["tip"],
        Joint(f"{name}_fingertip", axis=axis, more={"range": (-0.88, 0.88)}),
        [
            *bar("tip", "end", 1.0, 0.004),
            box((0.022, 0.010, 0.050), place(PAD + 0.012, z + 0.030), "aluminum"),
            box((0.022, 0.007, 0.0375), place(PAD + 0.0035, z + 0.032), "rubber"),
        ],
    )
    robot.site(f"{name}_pad", f"{name}_fingertip", place(PAD, z + 0.032))
    robot.connect(f"{name}_coupler", f"{name}_fingertip", pins["end"])

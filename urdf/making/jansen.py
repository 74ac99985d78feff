"""Jansen's leg, the walking linkage of the Strandbeest."""

from __future__ import annotations

import numpy as np

from .solids import Array, Solid, X, Y, at, ball, box, meet, rod
from .urdf import Robot

LENGTHS = {
    "a": 38.0,
    "b": 41.5,
    "c": 39.3,
    "d": 40.1,
    "e": 55.8,
    "f": 39.4,
    "g": 36.7,
    "h": 65.7,
    "i": 49.0,
    "j": 50.0,
    "k": 61.9,
    "l": 7.8,
    "m": 15.0,
}
"""Jansen's thirteen "holy numbers", here in centimeters."""

HOME = 0.3
"""Angle of the crank at home [rad]."""

TUBE, BORE = 0.0095, 0.0078
"""Radii of electrical conduit of 19 mm [m]."""


def points(angle: float) -> dict[str, Array]:
    """Return the pins by name, (x, z) [m], with the crank's shaft at the origin.

    O is the shaft, B the fixed pin, P the crank's end, X and Y are on the upper triangle, Z and W
    on the lower one, and F is the foot.
    """
    a, b, c, d, e, f, g, h, i, j, k, ll, m = (value / 100.0 for value in LENGTHS.values())
    at_pin: dict[str, Array] = {"O": np.zeros(2), "B": np.array([-a, -ll])}
    at_pin["P"] = m * np.array([np.cos(angle), np.sin(angle)])
    at_pin["X"] = meet(at_pin["B"], b, at_pin["P"], j, 1.0)
    at_pin["Y"] = meet(at_pin["B"], d, at_pin["X"], e, 1.0)
    at_pin["Z"] = meet(at_pin["B"], c, at_pin["P"], k, -1.0)
    at_pin["W"] = meet(at_pin["Y"], f, at_pin["Z"], g, -1.0)
    at_pin["F"] = meet(at_pin["W"], h, at_pin["Z"], i, -1.0)
    return at_pin


def jansen() -> Robot:
    """Return a crank, three rods, a rocker and two triangles, in a vertical plane."""
    robot = Robot("jansen", "Jansen's leg in the plane y = 0.")
    pins = {name: np.array([point[0], 0.0, point[1]]) for name, point in points(HOME).items()}
    # Every bar is in a separate layer.
    layers = {"j": 1.0, "k": 2.0, "f": 2.0, "c": 1.0}

    def bar(first: str, second: str, about: str, layer: float = 0.0) -> list[Solid]:
        """Return a tube between two pins, seen from a third one."""
        depth = 0.03 * layer * Y
        start, end = (pins[name] - pins[about] + depth for name in (first, second))
        bolts = [
            rod(point - 1.6 * TUBE * Y - depth, point + 1.6 * TUBE * Y, 0.005, "steel")
            for point in (start, end)
        ]
        return [rod(start, end, TUBE, "pvc", BORE), *bolts]

    base = [
        box((0.55, 0.04, 0.05), 0.5 * pins["B"] - 0.07 * Y, "anodized"),
        rod(-0.10 * Y, -0.19 * Y, 0.045, "rubber"),
        rod(-0.02 * Y, -0.07 * Y, 0.02, "steel"),
        rod(pins["B"] - 0.02 * Y, pins["B"] - 0.07 * Y, 0.02, "steel"),
        *(box((0.04, 0.04, 1.0), [x, -0.07, -0.47], "anodized") for x in (-0.45, 0.07)),
        box((0.75, 0.25, 0.03), [-0.19, -0.07, -0.985], "rubber"),
    ]
    robot.base(base)
    level = at(rotation=np.eye(3))
    crank = float(np.linalg.norm(pins["P"]))
    disk = [
        rod(-0.015 * Y, 0.015 * Y, 0.03, "anodized"),
        rod(0.0 * X, crank * X, 0.012, "accent"),
        rod([crank, -0.01, 0.0], [crank, 0.07, 0.0], 0.008, "steel"),
    ]
    robot.body("crank", disk, "crank_joint", "base", level, "-y", (-20.0, 20.0), HOME, (20.0, 20.0))
    # The crank's x axis points to its end; the bodies that it carries have the base's axes at home.
    at_end = at(crank * X, np.asarray(rotation_about_y(HOME)))
    limits = (-2.0 * np.pi, 2.0 * np.pi)

    def carried(link: str, solids: list[Solid], parent: str, placement: object) -> None:
        robot.body(link, solids, f"{link}_joint", parent, placement, "-y", limits)

    carried("rod_j", bar("P", "X", "P", layers["j"]), "crank", at_end)
    carried("rod_k", bar("P", "Z", "P", layers["k"]), "crank", at_end)
    upper = bar("B", "X", "B") + bar("X", "Y", "B") + bar("Y", "B", "B")
    carried("upper_triangle", upper, "base", at(pins["B"]))
    carried("rod_f", bar("Y", "W", "Y", layers["f"]), "upper_triangle", at(pins["Y"] - pins["B"]))
    carried("rocker_c", bar("B", "Z", "B", layers["c"]), "base", at(pins["B"]))
    lower = bar("Z", "W", "Z") + bar("W", "F", "Z") + bar("F", "Z", "Z")
    foot = pins["F"] - pins["Z"]
    lower.append(ball(0.025, foot, "rubber"))
    carried("lower_triangle", lower, "rocker_c", at(pins["Z"] - pins["B"]))
    robot.frame("tip", "lower_triangle", foot)
    for name, first, second in (
        ("X", ("rod_j", "P"), ("upper_triangle", "B")),
        ("Z", ("rod_k", "P"), ("rocker_c", "B")),
        ("W", ("rod_f", "Y"), ("lower_triangle", "Z")),
    ):
        for link, origin in (first, second):
            robot.frame(f"{link}_{name}", link, pins[name] - pins[origin])
        robot.close(f"{second[0]}_{name}", f"{first[0]}_{name}")
    return robot


def rotation_about_y(angle: float) -> Array:
    """Return the rotation about y that cancels the rotation of a crank about −y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])

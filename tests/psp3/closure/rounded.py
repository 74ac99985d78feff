"""Linkages whose frames are written with few digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from tests.helpers import Array

TURN = pin.rpy.rpyToMatrix(0.3, 0.7, -0.4)
"""The planes of the planar ones are oblique, so that every number is rounded."""

EXACT = 17
"""Digits at which nothing is rounded."""


class Parts(NamedTuple):
    """What a robot is made of."""

    model: pin.Model
    loops: list[Any]
    motors: tuple[str, ...]


def rounded(placement: pin.SE3, digits: int) -> pin.SE3:
    """Return a placement whose quaternion and position are written with so many digits."""
    if digits >= EXACT:
        return placement

    def written(numbers: Array) -> Array:
        return np.array([float(f"{number:.{digits}g}") for number in numbers])

    quaternion = written(pin.Quaternion(placement.rotation).coeffs())
    turn = pin.Quaternion(quaternion / np.linalg.norm(quaternion)).toRotationMatrix()
    return pin.SE3(turn, written(placement.translation))


def built(
    bodies: list[tuple[str, str, pin.SE3]],
    loops: list[tuple[str, str, pin.SE3, str]],
    motors: tuple[str, ...],
    digits: int,
    seed: int = 3,
) -> Parts:
    """Return a linkage of hinges, of which every placement is rounded.

    ``bodies`` have a name, a parent, and the frame of their hinge in the base at q = 0; ``loops``
    two bodies, where they meet, and a kind.
    """
    rng, model = np.random.default_rng(seed), pin.Model()
    places, numbers = {"": pin.SE3.Identity()}, {"": 0}
    for name, parent, place in bodies:
        # As exporters leave it, turned about its own axis by any angle.
        spun = place * pin.SE3(pin.utils.rotate("z", rng.uniform(-1.0, 1.0)), np.zeros(3))
        numbers[name] = model.addJoint(
            numbers[parent],
            pin.JointModelRZ(),
            rounded(places[parent].inverse() * spun, digits),
            name,
        )
        places[name] = spun
        inertia = pin.Inertia(1.0, np.array([0.1, 0.02, 0.03]), np.diag([0.01, 0.012, 0.014]))
        model.appendBodyToJoint(numbers[name], inertia, pin.SE3.Identity())
    made = []
    for one, two, place, kind in loops:
        ends = [
            (numbers[end], rounded(places[end].inverse() * place, digits)) for end in (one, two)
        ]
        contact = pin.ContactType.CONTACT_6D if kind == "6d" else pin.ContactType.CONTACT_3D
        made.append(
            pin.RigidConstraintModel(contact, model, *ends[0], *ends[1], pin.ReferenceFrame.LOCAL)
        )
        made[-1].name = f"{one}-{two or 'base'}"
    return Parts(model, made, motors)


def in_plane(x: float, y: float) -> pin.SE3:
    """Return a hinge at a point of the oblique plane."""
    return pin.SE3(TURN, TURN @ np.array([x, y, 0.0]))


FOUR_BAR = ((0.0, 0.0), (0.12, 0.16), (0.52, 0.3), (0.45, 0.0))


FIVE_BAR = ((0.0, 0.0), (-0.12, 0.21), (0.14, 0.48), (0.3, 0.0), (0.41, 0.23))


def four_bar(digits: int, seed: int = 3, corners: Any = FOUR_BAR) -> Parts:
    """Return a planar four-bar closed at a point: one of three equations is redundant."""
    a, b, c, d = (in_plane(*corner) for corner in corners)
    bodies = [("crank", "", a), ("coupler", "crank", b), ("rocker", "", d)]
    return built(bodies, [("coupler", "rocker", c, "3d")], ("crank",), digits, seed)


def four_bar_6d(digits: int, seed: int = 3) -> Parts:
    """Return a planar four-bar with all its hinges: three of six equations are redundant."""
    a, b, c, d = (in_plane(*corner) for corner in FOUR_BAR)
    bodies = [
        ("crank", "", a),
        ("coupler", "crank", b),
        ("rocker", "coupler", c),
        ("ground", "rocker", d),
    ]
    return built(bodies, [("ground", "", d, "6d")], ("crank",), digits, seed)


def _meeting(a: Array, ra: float, b: Array, rb: float, side: int) -> Array:
    way = b - a
    apart = np.linalg.norm(way)
    x = (ra**2 - rb**2 + apart**2) / (2.0 * apart)
    along = way / apart
    across = np.array([-along[1], along[0]])
    return np.asarray(a + x * along + side * np.sqrt(ra**2 - x**2) * across)


def jansen(digits: int, seed: int = 3) -> Parts:
    """Return one leg of T. Jansen's walking machines: seven hinges, three planar loops."""
    a, b, c, d, e, f, g, j, k, low, m = (
        length / 100.0 for length in (38, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 50, 61.9, 7.8, 15)
    )
    pivot, crank = np.array([-a, -low]), m * np.array([np.cos(0.3), np.sin(0.3)])
    x = _meeting(pivot, b, crank, j, 1)
    z = _meeting(pivot, c, crank, k, -1)
    y = _meeting(pivot, d, x, e, 1)
    w = _meeting(y, f, z, g, -1)
    at = {"o": np.zeros(2), "b": pivot, "p": crank, "x": x, "y": y, "z": z, "w": w}
    places = {name: in_plane(*point) for name, point in at.items()}
    bodies = [
        ("crank", "", places["o"]),
        ("j", "crank", places["p"]),
        ("k", "crank", places["p"]),
        ("tri", "", places["b"]),
        ("f", "tri", places["y"]),
        ("c", "", places["b"]),
        ("low", "c", places["z"]),
    ]
    loops = [
        ("j", "tri", places["x"], "3d"),
        ("k", "c", places["z"], "3d"),
        ("f", "low", places["w"], "3d"),
    ]
    return built(bodies, loops, ("crank",), digits, seed)


def _frame(z: Array) -> Array:
    z = z / np.linalg.norm(z)
    x = np.array([0.3, 0.5, 0.81])
    x = x - z * (z @ x)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def spherical(digits: int, seed: int = 3) -> Parts:
    """Return a spherical 3-RRR: all axes meet in a point, and six of twelve equations repeat."""
    center = np.array([0.1, -0.2, 0.3])
    bodies, ends = [], []
    for leg in range(3):
        parent, turn = "", 2.0 * np.pi * leg / 3.0
        for number, (more, height) in enumerate(((0.0, -0.8), (0.9, 0.1), (0.35, 0.9))):
            axis = np.array([np.cos(turn + more), np.sin(turn + more), height])
            name = f"{leg}{number}"
            bodies.append((name, parent, pin.SE3(_frame(axis), center + 0.2 * axis)))
            parent = name
        ends.append(parent)
    plate = pin.SE3(_frame(np.array([0.2, 0.3, 1.0])), center + np.array([0.0, 0.0, 0.3]))
    loops = [(ends[0], end, plate, "6d") for end in ends[1:]]
    return built(bodies, loops, ("00", "10", "20"), digits, seed)


def bennett(digits: int, seed: int = 3) -> Parts:
    """Return Bennett's linkage: four hinges that move only because of its proportions.

    G. T. Bennett, A new mechanism, Engineering 76, 1903: twists to lengths as sines.
    """
    a, b, alpha, angle = 0.3, 0.5, 0.6, 1.0
    beta = np.arcsin(b / a * np.sin(alpha))
    other = 2.0 * np.arctan(
        np.sin((beta + alpha) / 2.0) / np.sin((beta - alpha) / 2.0) / np.tan(angle / 2.0)
    )
    places = [pin.SE3(TURN, np.array([0.2, 0.1, 0.0]))]
    for turn, length, twist in (
        (angle, a, alpha),
        (other, b, beta),
        (-angle, a, alpha),
        (-other, b, beta),
    ):
        places.append(
            places[-1]
            * pin.SE3(pin.utils.rotate("z", turn), np.zeros(3))
            * pin.SE3(pin.utils.rotate("x", twist), np.array([length, 0.0, 0.0]))
        )
    assert np.abs((places[0].inverse() * places[4]).homogeneous - np.eye(4)).max() < 1e-12
    bodies = [(f"h{i}", f"h{i - 1}" if i else "", places[i]) for i in range(4)]
    return built(bodies, [("h3", "", places[0], "6d")], ("h0",), digits, seed)


def five_bar_by_poses(digits: int, seed: int = 3) -> Parts:
    """Return a five-bar of which the pose of each body is written, as SDF does, and so rounded.

    Where it is closed follows from the poses, so that it closes exactly at home, and there only.
    """
    o, p, meeting, a, b = (rounded(in_plane(*corner), digits) for corner in FIVE_BAR)
    bodies = [("left", "", o), ("far left", "left", p), ("right", "", a), ("far right", "right", b)]
    # The hinges are where the poses say, each turned as little as rounding turns it.
    rng = np.random.default_rng(seed)
    tilted = [
        (name, parent, place * pin.SE3(pin.exp3(rng.normal(0.0, 10.0**-digits, 3)), np.zeros(3)))
        for name, parent, place in bodies
    ]
    loops = [("far left", "far right", meeting, "3d")]
    return built(tilted, loops, ("left", "right"), EXACT, seed)


def flat_triangle(bend: float, beside: bool = True) -> Parts:
    """Return two bars that are stretched but for an angle, between two points of the ground.

    They cannot move. Beside them, if asked for, is a five-bar.
    """
    start, turn, first, second = np.array([1.0, 0.0]), 0.603, 0.126, 0.171
    knee = start + first * np.array([np.cos(turn), np.sin(turn)])
    end = knee + second * np.array([np.cos(turn + bend), np.sin(turn + bend)])
    bodies = [("near", "", in_plane(*start)), ("far", "near", in_plane(*knee))]
    loops = [("far", "", in_plane(*end), "3d")]
    if beside:
        o, p, meeting, a, b = (in_plane(*corner) for corner in FIVE_BAR)
        bodies += [("left", "", o), ("far left", "left", p)]
        bodies += [("right", "", a), ("far right", "right", b)]
        loops.append(("far left", "far right", meeting, "3d"))
    return built(bodies, loops, ("left", "right") if beside else ("near",), EXACT)


def short_lever(lever: float, turntable: bool) -> Parts:
    """Return a plate that slides and turns in the plane, and is closed at two points.

    They are so far apart, on the ground or on a turntable of 1 m. What drives is an arm of its own,
    or the turntable.
    """
    model = pin.Model()
    arm = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "arm")
    x = model.addJoint(0, pin.JointModelPX(), pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0])), "x")
    y = model.addJoint(x, pin.JointModelPY(), pin.SE3.Identity(), "y")
    plate = model.addJoint(y, pin.JointModelRZ(), pin.SE3.Identity(), "plate")
    inertia = pin.Inertia(1.0, np.array([0.1, 0.02, 0.03]), np.diag([0.01, 0.012, 0.014]))
    for joint in (arm, x, y, plate):
        model.addJointFrame(joint)
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
    loops = []
    for across in (0.0, lever):
        point = np.array([0.2, across, 0.0])
        on_plate = pin.SE3(np.eye(3), point)
        on_other = pin.SE3(np.eye(3), point + np.array([1.0, 0.0, 0.0]))
        loops.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                model,
                *(arm if turntable else 0, on_other, plate, on_plate),
                pin.ReferenceFrame.LOCAL,
            )
        )
    return Parts(model, loops, ("arm",))


def small_four_bar(digits: int, seed: int = 3) -> Parts:
    """Return a four-bar of 5 mm beside one of 2 m."""
    bodies, loops = [], []
    for name, size in (("large", 4.0), ("small", 0.01)):
        a, b, c, d = (in_plane(*(size * np.array(corner))) for corner in FOUR_BAR)
        crank, coupler, rocker = (f"{name} {part}" for part in ("crank", "coupler", "rocker"))
        bodies += [(crank, "", a), (coupler, crank, b), (rocker, "", d)]
        loops += [(coupler, rocker, c, "3d")]
    return built(bodies, loops, ("large crank", "small crank"), digits, seed)


LINKAGES: dict[str, tuple[Callable[..., Parts], int, int]] = {
    # builder, degrees of freedom, rank
    "four-bar": (four_bar, 1, 2),
    "four-bar, all hinges": (four_bar_6d, 1, 3),
    "Jansen's leg": (jansen, 1, 6),
    "spherical 3-RRR": (spherical, 3, 6),
    "Bennett": (bennett, 1, 3),
    "five-bar by poses": (five_bar_by_poses, 2, 2),
}

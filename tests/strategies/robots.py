"""Robots as hypothesis makes them up: random trees whose random loops are closed at home.

What can make a robot special is drawn one by one, so that a failing example becomes small: joints
and what carries them, loops, motors. Lengths, axes and inertias come from a seed. Layouts in the
plane and on a grid have parallel axes and loops that say the same thing twice, which robots of
random numbers never have.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from hypothesis import strategies as st

from psp3.multibody.equations import Coupling, Hinge
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array

LAYOUTS = ("any", "grid", "plane")

QUARTERS = tuple(
    pin.utils.rotate("z", 0.5 * np.pi * turn) @ pin.utils.rotate(axis, 0.5 * np.pi * other)
    for turn, axis, other in itertools.product(range(4), "xy", range(4))
)


def _other_axis(axis: Array) -> Array:
    """Return a direction at right angles to an axis."""
    other = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    return np.asarray(other / np.linalg.norm(other))


def _composite(axis: Array) -> Any:
    joint = pin.JointModelComposite()
    joint.addJoint(pin.JointModelRevoluteUnaligned(axis))
    joint.addJoint(pin.JointModelPrismaticUnaligned(_other_axis(axis)))
    return joint


JOINTS: dict[str, Callable[[Array], Any]] = {
    "revolute": pin.JointModelRevoluteUnaligned,
    "slide": pin.JointModelPrismaticUnaligned,
    "z": lambda axis: pin.JointModelRZ(),
    "x": lambda axis: pin.JointModelRX(),
    "slide along y": lambda axis: pin.JointModelPY(),
    "unbounded": lambda axis: pin.JointModelRUBZ(),
    "screw": lambda axis: pin.JointModelHelicalUnaligned(axis, 0.05),
    "ball": lambda axis: pin.JointModelSpherical(),
    "three angles": lambda axis: pin.JointModelSphericalZYX(),
    "universal": lambda axis: pin.JointModelUniversal(axis, _other_axis(axis)),
    "translation": lambda axis: pin.JointModelTranslation(),
    "planar": lambda axis: pin.JointModelPlanar(),
    "composite": _composite,
    "free": lambda axis: pin.JointModelFreeFlyer(),
}
"""Joints of every kind that Pinocchio has, about an axis where they have one."""

IN_THE_PLANE = ("z", "z", "z", "planar", "unbounded", "slide")

CONTACTS = {"3d": pin.ContactType.CONTACT_3D, "6d": pin.ContactType.CONTACT_6D}


class Parts(NamedTuple):
    """What a robot is made of."""

    model: pin.Model
    constraint_models: list[Any]
    equations: list[Any]
    actuated: tuple[str, ...]
    q0: Array
    springs: dict[str, tuple[float, float]]
    free: str

    def robot(self) -> ClosedLoopRobot:
        """Return the robot, or raise what the package raises of one that cannot be."""
        return ClosedLoopRobot(
            self.model,
            self.constraint_models,
            self.actuated,
            self.q0,
            equations=self.equations,
            springs=self.springs,
            free=self.free,
        )

    def __repr__(self) -> str:
        joints = [
            f"{name} on {self.model.names[parent]}: {joint.shortname()}"
            for name, parent, joint in zip(
                self.model.names, self.model.parents, self.model.joints, strict=True
            )
        ][1:]
        loops = [
            f"{one.joint1_id}-{one.joint2_id} {one.type.name}" for one in self.constraint_models
        ]
        return (
            f"Parts({'; '.join(joints)}; loops {loops}; {self.equations}; "
            f"motors {self.actuated}; {self.springs}; free={self.free!r})"
        )


def random_inertia(rng: np.random.Generator) -> pin.Inertia:
    """Return the inertia of a box of up to 0.4 m, somewhere in it."""
    sides, mass = rng.uniform(0.05, 0.4, 3), float(np.exp(rng.uniform(-2.0, 2.0)))
    box = pin.Inertia.FromBox(mass, *sides)
    place = pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.2, 0.2, 3))
    return box.se3Action(place)


def random_placement(rng: np.random.Generator, layout: str) -> pin.SE3:
    """Return where something is on a body: anywhere, on a grid of 0.1 m, or in the plane."""
    if layout == "grid":
        return pin.SE3(QUARTERS[rng.integers(len(QUARTERS))], 0.1 * rng.integers(-2, 3, 3))
    if layout == "plane":
        turn = pin.utils.rotate("z", rng.uniform(-1.0, 1.0))
        return pin.SE3(turn, np.append(rng.uniform(-0.4, 0.4, 2), 0.0))
    return pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.4, 0.4, 3))


def _random_axis(rng: np.random.Generator, layout: str, kind: str) -> Array:
    if layout == "plane":
        return np.eye(3)[0] if kind == "slide" else np.eye(3)[2]
    if layout == "grid":
        return np.eye(3)[rng.integers(3)]
    axis = rng.normal(size=3)
    return np.asarray(axis / np.linalg.norm(axis))


@st.composite
def trees(
    draw: st.DrawFn, kinds: tuple[str, ...], bases: tuple[str, ...], layout: str, most: int
) -> pin.Model:
    """Draw a tree of bodies; a joint that the ground carries can be one of ``bases``, too."""
    model, rng = pin.Model(), np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    model.gravity = pin.Motion(np.array([1.0, -3.0, -9.0]), np.zeros(3))
    count = draw(st.integers(2, most))
    for number in range(count):
        parent = draw(st.integers(0, number))
        kind = draw(st.sampled_from((*kinds, *bases) if parent == 0 else kinds))
        joint = JOINTS[kind](_random_axis(rng, layout, kind))
        index = model.addJoint(parent, joint, random_placement(rng, layout), f"j{number + 1}")
        model.appendBodyToJoint(index, random_inertia(rng), pin.SE3.Identity())
        at_joint = pin.SE3.Identity()
        model.addFrame(pin.Frame(f"b{number + 1}", index, 0, at_joint, pin.FrameType.BODY))
    return model


def simple_joints(model: pin.Model) -> list[str]:
    """Return the joints of one degree of freedom in one coordinate."""
    return [
        str(name)
        for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
        if (joint.nq, joint.nv) == (1, 1)
    ]


def _loop(
    model: pin.Model, data: Any, ends: tuple[int, int], kind: str, place: pin.SE3, turn: float
) -> Any:
    """Return a loop that is closed where ``data`` has the joints."""
    first, second = ends
    world = data.oMi[first] * place
    local = data.oMi[second].actInv(world)
    if kind == "hinge":
        spun = pin.SE3(pin.utils.rotate("z", turn), np.zeros(3))
        return Hinge(f"hinge {first}-{second}", first, place, second, local * spun)
    return pin.RigidConstraintModel(
        CONTACTS[kind], model, first, place, second, local, pin.ReferenceFrame.LOCAL
    )


@st.composite
def robots(
    draw: st.DrawFn,
    kinds: tuple[str, ...] = tuple(JOINTS)[:-1],
    layouts: tuple[str, ...] = LAYOUTS,
    closures: tuple[str, ...] = ("3d", "6d", "hinge"),
    bases: tuple[str, ...] = ("free",),
    most: int = 7,
    couplings: bool = True,
    damping: bool = True,
) -> Parts:
    """Draw a tree with loops, motors, and perhaps a coupling, springs and damping.

    Whether that is a robot is for the package to say: loops may leave nothing that moves.
    """
    layout = draw(st.sampled_from(layouts))
    if layout == "plane":
        kinds, bases = tuple(kind for kind in IN_THE_PLANE if kind in kinds), ()
    model = draw(trees(kinds, bases, layout, most))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    q0 = pin.integrate(model, pin.neutral(model), rng.uniform(-0.8, 0.8, model.nv))
    data = model.createData()
    pin.forwardKinematics(model, data, q0)
    ends = st.lists(st.integers(0, model.njoints - 1), min_size=2, max_size=2, unique=True)
    loops, equations = [], []
    for _ in range(draw(st.integers(0, 2))):
        first, second = draw(ends)
        kind = draw(st.sampled_from(closures))
        place = random_placement(rng, layout)
        loop = _loop(model, data, (first, second), kind, place, rng.uniform(-1.0, 1.0))
        (equations if isinstance(loop, Hinge) else loops).append(loop)
    simple = simple_joints(model)
    if couplings and len(simple) > 2 and draw(st.booleans()):
        y, x = (model.getJointId(name) for name in draw(st.permutations(simple))[:2])
        at_y, at_x = (q0[model.joints[number].idx_q] for number in (y, x))
        bend = draw(st.sampled_from([(1.0,), (-0.5,), (0.7, 0.3), (0.5, 0.0, 0.4)]))
        constant = at_y - sum(c * at_x ** (k + 1) for k, c in enumerate(bend))
        equations.append(Coupling(f"{y} of {x}", y, x, (float(constant), *bend)))
    springs: dict[str, tuple[float, float]] = {}
    motors: list[str] = []
    if simple:
        motors = draw(st.lists(st.sampled_from(simple), min_size=1, unique=True))
        if draw(st.booleans()):
            springs[draw(st.sampled_from(simple))] = (20.0, 0.1)
    if damping and draw(st.booleans()):
        for name in simple:
            model.damping[model.joints[model.getJointId(name)].idx_v] = 0.2
    free = draw(st.sampled_from(["lock", "keep"]))
    return Parts(model, loops, equations, tuple(motors), q0, springs, free)


def moved(parts: Parts, place: pin.SE3) -> Parts:
    """Return the same robot, whose base and gravity are somewhere else."""
    model = pin.Model(parts.model)
    for number in range(1, model.njoints):
        if model.parents[number] == 0:
            model.jointPlacements[number] = place * model.jointPlacements[number]
    model.gravity = pin.Motion(place.rotation @ model.gravity.linear, np.zeros(3))

    def end(number: int, local: pin.SE3) -> pin.SE3:
        return place * local if number == 0 else local

    loops = [
        pin.RigidConstraintModel(
            one.type,
            model,
            one.joint1_id,
            end(one.joint1_id, one.joint1_placement),
            one.joint2_id,
            end(one.joint2_id, one.joint2_placement),
            pin.ReferenceFrame.LOCAL,
        )
        for one in parts.constraint_models
    ]
    equations = [
        one._replace(
            joint1_placement=end(one.joint1_id, one.joint1_placement),
            joint2_placement=end(one.joint2_id, one.joint2_placement),
        )
        if isinstance(one, Hinge)
        else one
        for one in parts.equations
    ]
    return parts._replace(model=model, constraint_models=loops, equations=equations)

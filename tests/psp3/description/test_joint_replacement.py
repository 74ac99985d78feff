"""Joints that stand for others: against trees written out by hand, joint by joint."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from psp3.description.joint_replacement import (
    PER_DEGREE_OF_FREEDOM,
    REPLACEMENTS,
    UNIVERSAL,
    replace_joints,
)
from psp3.errors import InvalidRobotFile
from tests.helpers import Array

ABOUT = {"X": pin.JointModelRX, "Y": pin.JointModelRY, "Z": pin.JointModelRZ}
RNG = np.random.default_rng(7)
*PLACES, LOOK = [pin.SE3(pin.exp3(RNG.normal(size=3)), RNG.normal(size=3)) for _ in range(5)]
BODIES = [
    pin.Inertia(mass, RNG.normal(size=3), np.diag([0.5, 0.7, 0.9]))
    for mass in RNG.uniform(0.5, 2.0, 4)
]


def chain(second: list[tuple[str, Any]], first: Any = None) -> tuple[pin.Model, pin.GeometryModel]:
    """Return a tree of joints j1, j2, j3 in a row and j4 beside j3.

    With a sphere and a frame on each body; j2 is what is asked for.
    """
    model, shapes = pin.Model(), pin.GeometryModel()
    model.name = "chain"
    model.gravity = pin.Motion(np.array([1.0, -3.0, -9.0]), np.zeros(3))
    joints = [
        [("j1", first or pin.JointModelPY())],
        second,
        [("j3", pin.JointModelRX())],
        [("j4", pin.JointModelRevoluteUnaligned(0.6, 0.0, 0.8))],
    ]
    parents, last = [0, 1, 2, 2], [0]
    for number, row in enumerate(joints):
        parent, placement = last[parents[number]], PLACES[number]
        for name, joint in row:
            parent = model.addJoint(parent, joint, placement, name)
            model.addJointFrame(parent)
            placement = pin.SE3.Identity()
        last.append(parent)
        model.appendBodyToJoint(parent, BODIES[number], pin.SE3.Identity())
        frame = model.addBodyFrame(f"body{number + 1}", parent, LOOK, -1)
        shapes.addGeometryObject(
            pin.GeometryObject(f"ball{number + 1}", parent, frame, LOOK, coal.Sphere(0.1))
        )
    for attribute in (*PER_DEGREE_OF_FREEDOM, "lowerPositionLimit", "upperPositionLimit"):
        vector = getattr(model, attribute)
        vector[:] = 10.0 * len(attribute) + np.arange(vector.size)
    return model, shapes


@pytest.fixture
def tree() -> tuple[pin.Model, pin.GeometryModel]:
    return chain([("j2", pin.JointModelRZ())])


def places(model: pin.Model, shapes: pin.GeometryModel, q: Array) -> dict[str, Array]:
    data, placed = model.createData(), shapes.createData()
    pin.framesForwardKinematics(model, data, q)
    pin.updateGeometryPlacements(model, data, shapes, placed, q)
    found = {
        frame.name: place.homogeneous for frame, place in zip(model.frames, data.oMf, strict=True)
    }
    return found | {
        shape.name: place.homogeneous
        for shape, place in zip(shapes.geometryObjects, placed.oMg, strict=True)
    }


def same_motion(
    found: tuple[pin.Model, Any], expected: tuple[pin.Model, Any], rng: np.random.Generator
) -> None:
    """Names of joints, places of all frames and shapes, and forces at random states are the same.

    1e-12 is rounding.

    Without the armature, which chain() numbers through; what becomes of it has its own tests.
    """
    model, other = found[0], expected[0]
    model.armature[:] = other.armature[:] = 0.0
    assert list(model.names) == list(other.names)
    assert [joint.shortname() for joint in model.joints] == [
        joint.shortname() for joint in other.joints
    ]
    for _ in range(5):
        v, a = rng.normal(size=(2, model.nv))
        q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
        ours, theirs = places(*found, q), places(*expected, q)
        assert set(theirs) <= set(ours)
        for name, place in theirs.items():
            assert_allclose(ours[name], place, rtol=0, atol=1e-12, err_msg=name)
        assert_allclose(
            pin.rnea(model, model.createData(), q, v, a),
            pin.rnea(other, other.createData(), q, v, a),
            rtol=1e-12,
            atol=1e-10,
        )


def limits_of(model: pin.Model, name: str) -> dict[str, Array]:
    joint = model.joints[model.getJointId(name)]
    velocities, coordinates = (
        slice(joint.idx_v, joint.idx_v + joint.nv),
        slice(joint.idx_q, joint.idx_q + joint.nq),
    )
    found = {
        attribute: np.array(getattr(model, attribute)[velocities])
        for attribute in PER_DEGREE_OF_FREEDOM
    }
    return found | {
        attribute: np.array(getattr(model, attribute)[coordinates])
        for attribute in ("lowerPositionLimit", "upperPositionLimit")
    }


def test_ball_joint_is_that_of_a_tree_written_with_one(tree: Any) -> None:
    found = replace_joints(*tree, [("j2", "SPHERICAL")], ["j1"], "x.yaml")
    same_motion(found, chain([("j2", pin.JointModelSpherical())]), np.random.default_rng(0))


@pytest.mark.parametrize("kind", UNIVERSAL)
def test_universal_joint_is_two_revolutes_about_axes_of_the_joint_frame(
    tree: Any, kind: str
) -> None:
    """All six pairs of axes; the frame j2 stays and moves with the second revolute."""
    first, second = kind[-2:]
    found = replace_joints(*tree, [("j2", kind)], ["j1"], "x.yaml")
    expected = chain([(f"j2_{first}", ABOUT[first]()), (f"j2_{second}", ABOUT[second]())])
    same_motion(found, expected, np.random.default_rng(1))
    q = pin.integrate(
        found[0], pin.neutral(found[0]), np.random.default_rng(2).normal(size=found[0].nv)
    )
    placed = places(*found, q)
    assert_array_equal(placed["j2"], placed[f"j2_{second}"])


def test_fixed_joint_is_locked_where_its_coordinate_is_zero(tree: Any) -> None:
    """Against the whole tree with j2 held at zero: the forces of the other joints, and places."""
    model, shapes = tree
    found, seen = replace_joints(model, shapes, [("j2", "FIXED")], ["j1"], "x.yaml")
    assert list(found.names)[1:] == ["j1", "j3", "j4"]
    rng = np.random.default_rng(3)
    others = [0, 2, 3]
    q, v, a = np.zeros((3, model.nv))
    q[others], v[others], a[others] = rng.normal(size=(3, 3))
    ours, theirs = places(found, seen, q[others]), places(model, shapes, q)
    for name, place in theirs.items():
        assert_allclose(ours[name], place, rtol=0, atol=1e-12, err_msg=name)
    forces = pin.rnea(model, model.createData(), q, v, a)[others]
    assert_allclose(
        pin.rnea(found, found.createData(), q[others], v[others], a[others]),
        forces,
        rtol=1e-12,
        atol=1e-10,
    )


def test_fixed_joints_behind_a_universal_joint_are_the_ones_named(tree: Any) -> None:
    """A loader that locks joints by their number in the URDF's tree would lock j3 here."""
    model, _ = replace_joints(*tree, [("j2", "UJOINT_XY"), ("j4", "FIXED")], ["j1"], "x.yaml")
    assert list(model.names)[1:] == ["j1", "j2_X", "j2_Y", "j3"]


@pytest.mark.parametrize("kind", REPLACEMENTS)
def test_limits_of_the_other_joints_stay_theirs(tree: Any, kind: str) -> None:
    """Their places in the vectors move. Gravity and names stay too."""
    model, _ = replace_joints(*tree, [("j2", kind)], ["j1"], "x.yaml")
    for name in ("j1", "j3", "j4"):
        for attribute, values in limits_of(tree[0], name).items():
            assert_array_equal(
                limits_of(model, name)[attribute], values, err_msg=f"{name} {attribute}"
            )
    assert_array_equal(model.gravity.vector, tree[0].gravity.vector)
    assert model.name == "chain"


def test_replaced_joints_have_no_position_limits_and_the_others_for_each_degree_of_freedom(
    tree: Any,
) -> None:
    before = limits_of(tree[0], "j2")
    for kind, names, limit in (
        ("SPHERICAL", ["j2"], 1.01),
        ("UJOINT_ZX", ["j2_Z", "j2_X"], np.inf),
    ):
        model, _ = replace_joints(*tree, [("j2", kind)], ["j1"], "x.yaml")
        for name in names:
            after = limits_of(model, name)
            for attribute in PER_DEGREE_OF_FREEDOM:
                assert_array_equal(
                    after[attribute], np.full(after[attribute].size, before[attribute][0])
                )
            assert (after["lowerPositionLimit"] == -limit).all()
            assert (after["upperPositionLimit"] == limit).all()


CONTINUOUS = [
    (pin.JointModelRUBX, pin.JointModelRX),
    (pin.JointModelRUBY, pin.JointModelRY),
    (pin.JointModelRUBZ, pin.JointModelRZ),
]


@pytest.mark.parametrize(("unbounded", "plain"), CONTINUOUS)
def test_an_actuated_joint_of_unlimited_angle_becomes_a_revolute_without_limits(
    unbounded: Callable[[], Any], plain: Callable[[], Any]
) -> None:
    """Pinocchio holds the one as cosine and sine, the other as the angle."""
    found = replace_joints(*chain([("j2", pin.JointModelRZ())], unbounded()), [], ["j1"], "x.yaml")
    same_motion(found, chain([("j2", pin.JointModelRZ())], plain()), np.random.default_rng(4))
    limits = limits_of(found[0], "j1")
    assert limits["lowerPositionLimit"] == -np.inf
    assert limits["upperPositionLimit"] == np.inf


def test_the_axis_of_an_actuated_joint_of_unlimited_angle_may_be_oblique() -> None:
    """From a URDF, the only place where such a joint can be had.

    1e-15 is the axis divided by its length.
    """
    text = (
        "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='continuous'>"
        "<parent link='a'/><child link='b'/><axis xyz='0 3 -4'/></joint></robot>"
    )
    model, _ = replace_joints(pin.buildModelFromXML(text), pin.GeometryModel(), [], ["j"], "x.yaml")
    assert model.joints[1].shortname() == "JointModelRevoluteUnaligned"
    assert_allclose(model.joints[1].extract().axis, [0.0, 0.6, -0.8], rtol=0, atol=1e-15)


def test_an_unactuated_joint_of_unlimited_angle_stays() -> None:
    model, shapes = chain([("j2", pin.JointModelRZ())], pin.JointModelRUBX())
    found = replace_joints(model, shapes, [], ["j2"], "x.yaml")
    assert found[0] is model
    assert found[1] is shapes


def test_a_joint_of_unlimited_angle_can_be_replaced() -> None:
    found = replace_joints(
        *chain([("j2", pin.JointModelRUBZ())]), [("j2", "SPHERICAL")], ["j1"], "x.yaml"
    )
    same_motion(found, chain([("j2", pin.JointModelSpherical())]), np.random.default_rng(5))


def test_the_given_tree_stays_as_it_is(tree: Any) -> None:
    model, shapes = tree[0].copy(), tree[1].copy()
    replace_joints(*tree, [("j2", "UJOINT_XY"), ("j4", "FIXED")], ["j1"], "x.yaml")
    assert tree[0] == model
    assert tree[1] == shapes


@pytest.mark.parametrize(
    ("replaced", "reason"),
    [
        (("j9", "SPHERICAL"), "no joint 'j9'; its joints are j1, j2, j3, j4"),
        (("universe", "FIXED"), "no joint 'universe'"),
        (("j2", "HELICAL"), "'HELICAL' for joint 'j2' is unknown; known are SPHERICAL, UJOINT_XY"),
        (("j2", "UJOINT_XX"), "unknown"),
        (("j1", "SPHERICAL"), "only a revolute joint can become SPHERICAL, and 'j1' is a PY"),
        (("j1", "UJOINT_XY"), "only a revolute joint"),
    ],
)
def test_what_cannot_be_replaced_is_refused(
    tree: Any, replaced: tuple[str, str], reason: str
) -> None:
    with pytest.raises(InvalidRobotFile) as caught:
        replace_joints(*tree, [replaced], ["j4"], "some.yaml")
    assert caught.value.path == Path("some.yaml")
    assert reason in caught.value.reason


@pytest.mark.parametrize("taken", ["j2_X", "j2_Y"])
def test_a_name_that_a_universal_joint_needs_must_be_free(taken: str) -> None:
    model, shapes = chain([("j2", pin.JointModelRZ())])
    model.addJoint(4, pin.JointModelRX(), pin.SE3.Identity(), taken)
    with pytest.raises(
        InvalidRobotFile, match=f"'j2' becomes '{taken}', a name that another joint has"
    ):
        replace_joints(model, shapes, [("j2", "UJOINT_XY")], ["j1"], "x.yaml")

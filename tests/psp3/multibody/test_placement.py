"""Placements, screws and steps of every kind of joint, against Pinocchio."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from psp3.multibody import flatten
from psp3.multibody.flatten import NO_MOTORS, flattened
from psp3.multibody.placement import compose, move
from psp3.multibody.tree import (
    AT_CLOSED,
    AT_CONFIGURATION,
    AT_PLACEMENTS,
    AT_RIGHT,
    AT_SCREWS,
    COORDINATES,
    ELEMENTS,
    MEMBERS,
)
from tests.helpers import Array
from tests.psp3.multibody.flat import Flat, flat_of


def placement(rng: np.random.Generator) -> pin.SE3:
    """Return a random placement."""
    return pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))


def free_tree() -> SimpleNamespace:
    """Return an open tree with every kind of element, each on the one before."""
    model, rng = pin.Model(), np.random.default_rng(31)
    chain = pin.JointModelComposite()
    chain.addJoint(pin.JointModelPX())
    chain.addJoint(pin.JointModelRY(), placement(rng))
    kinds = [
        pin.JointModelFreeFlyer(),
        pin.JointModelRUBZ(),
        pin.JointModelHelicalUnaligned(np.array([0.0, 0.6, 0.8]), 0.3),
        chain,
        pin.JointModelSpherical(),
        pin.JointModelPrismaticUnaligned(np.array([0.6, 0.0, -0.8])),
        pin.JointModelTranslation(),
        pin.JointModelSphericalZYX(),
        pin.JointModelRUBX(),
    ]
    for number, kind in enumerate(kinds):
        model.addJoint(number, kind, placement(rng), f"j{number}")
    return SimpleNamespace(model=model)


@pytest.fixture(scope="module")
def tree() -> tuple[pin.Model, Flat, list[int]]:
    model = free_tree().model
    return model, Flat(flattened(model, [], NO_MOTORS)), flatten._elements(model)[1]


def random_configuration(model: pin.Model, rng: np.random.Generator) -> Array:
    """Return a configuration anywhere, angles of several turns and all."""
    step = rng.uniform(-3.0, 3.0, model.nv)
    return np.asarray(pin.integrate(model, pin.neutral(model), step))


def placements(flat: Flat) -> list[pin.SE3]:
    rows = flat.part(AT_PLACEMENTS, flat.count(ELEMENTS), 12)
    return [pin.SE3(row[:9].reshape(3, 3), row[9:]) for row in rows]


def test_placements_are_pinocchios(tree: tuple[pin.Model, Flat, list[int]]) -> None:
    """1e-13 of positions of some meters: rounding of a chain of nine joints."""
    model, flat, of_joint = tree
    data, rng = model.createData(), np.random.default_rng(32)
    for _ in range(50):
        q = random_configuration(model, rng)
        flat.place(q)
        pin.forwardKinematics(model, data, q)
        ours = placements(flat)
        for joint in range(1, model.njoints):
            expected = flat.seen_from.actInv(data.oMi[joint]).homogeneous
            assert_allclose(ours[of_joint[joint]].homogeneous, expected, rtol=0.0, atol=2e-13)


def test_screws_are_the_columns_of_pinocchios_jacobian_in_the_base(
    tree: tuple[pin.Model, Flat, list[int]],
) -> None:
    """Of the last joint, which all joints carry; 1e-12, rounding times lever arms."""
    model, flat, _ = tree
    data, rng = model.createData(), np.random.default_rng(33)
    for _ in range(50):
        q = random_configuration(model, rng)
        flat.place(q)
        pin.computeJointJacobians(model, data, q)
        world = pin.getJointJacobian(model, data, model.njoints - 1, pin.ReferenceFrame.WORLD)
        expected = flat.seen_from.inverse().action @ world
        assert_allclose(flat.part(AT_SCREWS, model.nv, 6).T, expected, rtol=0.0, atol=1e-12)


def test_placements_of_robots_with_branches(parts: SimpleNamespace, anywhere: Array) -> None:
    flat, data = flat_of(parts), parts.model.createData()
    _, of_joint = flatten._elements(parts.model)
    flat.place(anywhere)
    pin.forwardKinematics(parts.model, data, anywhere)
    ours = placements(flat)
    for joint in range(1, parts.model.njoints):
        expected = flat.seen_from.actInv(data.oMi[joint]).homogeneous
        assert_allclose(ours[of_joint[joint]].homogeneous, expected, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("kind", [pin.JointModelFreeFlyer(), pin.JointModelPlanar()])
def test_nothing_depends_on_where_a_floating_base_is(kind: Any) -> None:
    """Placements and screws of a base far away are those of one at home, bit for bit."""
    model, rng = pin.Model(), np.random.default_rng(35)
    base = model.addJoint(0, kind, placement(rng), "base")
    model.addJoint(base, pin.JointModelRX(), placement(rng), "arm")
    flat, q = Flat(flattened(model, [], NO_MOTORS)), random_configuration(model, rng)
    parts = [(AT_PLACEMENTS, (2, 12)), (AT_SCREWS, (model.nv, 6))]
    flat.place(q)
    at_home = [flat.part(at, *shape).copy() for at, shape in parts]
    q[: 3 if kind.nq == 7 else 2] += 1e6
    flat.place(q)
    assert np.linalg.norm(flat.seen_from.translation) > 1e6
    for (at, shape), expected in zip(parts, at_home, strict=True):
        assert_array_equal(flat.part(at, *shape), expected)


@pytest.mark.parametrize("share", [1.0, 0.3, -0.7])
@pytest.mark.parametrize("size", [1.0, 1e-4, 1e-9])
def test_a_step_is_pinocchios_integration(share: float, size: float) -> None:
    """Joints in the axes of their own; 1e-15 times the size of what is moved, some roundings.

    Of a free flyer Pinocchio turns and slides along a screw, here it slides and turns; the two
    meet in the first order, so it is compared by its parts.
    """
    model, rng = pin.Model(), np.random.default_rng(34)
    for kind in (pin.JointModelRX(), pin.JointModelRUBY(), pin.JointModelSpherical()):
        model.addJoint(0, kind, pin.SE3.Identity(), kind.shortname())
    # With a closure every joint is of a group, and dependent.
    loops = pin.StdVec_RigidConstraintModel()
    for joint in range(1, 4):
        kind = pin.ContactType.CONTACT_6D
        loops.append(pin.RigidConstraintModel(kind, model, joint, pin.SE3.Identity()))
    flat = Flat(flattened(model, loops, NO_MOTORS))
    start = random_configuration(model, rng)
    step = size * rng.normal(size=model.nv)
    flat.part(AT_CLOSED, model.nq)[:] = start
    flat.part(AT_RIGHT, model.nv)[:] = step
    members = flat.count(MEMBERS)
    for group, joint in enumerate(list(model.joints)[1:]):
        move(
            flat.tree,
            flat.memory,
            members - 3 + group,
            members - 2 + group,
            flat.at(AT_CLOSED),
            flat.at(AT_RIGHT) + joint.idx_v,
            joint.idx_v,
            share,
        )
    expected = pin.integrate(model, start, share * step)
    assert_allclose(flat.part(AT_CONFIGURATION, model.nq), expected, rtol=0.0, atol=2e-15)


def test_a_free_flyer_slides_in_its_own_axes_and_then_turns() -> None:
    model, rng = pin.Model(), np.random.default_rng(35)
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "free")
    loops = pin.StdVec_RigidConstraintModel()
    kind = pin.ContactType.CONTACT_6D
    loops.append(pin.RigidConstraintModel(kind, model, 1, pin.SE3.Identity()))
    flat = Flat(flattened(model, loops, NO_MOTORS))
    start, step = random_configuration(model, rng), rng.normal(size=6)
    flat.part(AT_CLOSED, 7)[:] = start
    flat.part(AT_RIGHT, 6)[:] = step
    last = flat.count(MEMBERS)
    move(flat.tree, flat.memory, last - 1, last, flat.at(AT_CLOSED), flat.at(AT_RIGHT), 0, 0.5)
    before = pin.XYZQUATToSE3(start)
    expected = before * pin.SE3(pin.exp3(0.5 * step[3:]), 0.5 * step[:3])
    found = pin.XYZQUATToSE3(flat.part(AT_CONFIGURATION, flat.count(COORDINATES)))
    assert_allclose(found.homogeneous, expected.homogeneous, rtol=0.0, atol=1e-14)


def test_the_product_of_placements() -> None:
    rng, out = np.random.default_rng(36), np.empty(14)
    one, other = placement(rng), placement(rng)
    rows = [np.concatenate([m.rotation.ravel(), m.translation]) for m in (one, other)]
    compose(np.concatenate([[7.0], rows[0]]), 1, rows[1], 0, out, 2)
    expected = one * other
    assert_allclose(out[2:11].reshape(3, 3), expected.rotation, rtol=0.0, atol=1e-15)
    assert_allclose(out[11:], expected.translation, rtol=0.0, atol=1e-15)

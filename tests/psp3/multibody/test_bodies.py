"""Inertias, momenta and forces of bodies, against Pinocchio's spatial algebra."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
from numpy.testing import assert_allclose

from psp3.multibody import flatten
from psp3.multibody.bodies import momentum, weigh, wrench
from psp3.multibody.tree import AT_ACCELERATIONS, AT_INERTIAS, AT_VELOCITIES, ELEMENTS
from tests.helpers import Array
from tests.psp3.multibody.flat import Flat


def inertias_in_the_base(parts: SimpleNamespace, flat: Flat, q: Array) -> dict[int, pin.Inertia]:
    """Return the inertia of each joint's body, moved into the base, by the joint's element.

    Seen from where a floating base is.
    """
    data = parts.model.createData()
    pin.forwardKinematics(parts.model, data, q)
    _, of_joint = flatten._elements(parts.model)
    return {
        of_joint[joint]: flat.seen_from.actInv(data.oMi[joint]).act(parts.model.inertias[joint])
        for joint in range(1, parts.model.njoints)
    }


def test_inertias_are_those_of_bodies_moved_into_the_base(
    parts: SimpleNamespace, flat: Flat, anywhere: Array
) -> None:
    """Mass, mass times center, and moments about the base's origin; 1e-14."""
    flat.place(anywhere)
    weigh(*flat.all)
    rows = flat.part(AT_INERTIAS, flat.count(ELEMENTS), 10)
    for e, inertia in inertias_in_the_base(parts, flat, anywhere).items():
        whole = inertia.matrix()
        assert_allclose(rows[e, 0], inertia.mass, rtol=1e-15)
        assert_allclose(rows[e, 1:4], inertia.mass * inertia.lever, rtol=0.0, atol=1e-14)
        moments = whole[3:, 3:][np.triu_indices(3)]
        assert_allclose(rows[e, 4:], moments, rtol=0.0, atol=1e-14)


def test_momenta_and_forces_are_those_of_spatial_algebra(
    parts: SimpleNamespace, flat: Flat, anywhere: Array
) -> None:
    """I X, and I (A − g) + V ×* I V; 1e-13 of some newtons."""
    flat.place(anywhere)
    weigh(*flat.all)
    rng, count = np.random.default_rng(51), flat.count(ELEMENTS)
    V = flat.part(AT_VELOCITIES, count + 1, 6)
    A = flat.part(AT_ACCELERATIONS, count + 1, 6)
    V[:], A[:] = rng.normal(size=(2, count + 1, 6))
    out = np.empty(len(flat.memory) + 6)
    out[:-6] = flat.memory
    at = len(flat.memory)
    for e, inertia in inertias_in_the_base(parts, flat, anywhere).items():
        velocity, acceleration = pin.Motion(V[e]), pin.Motion(A[e])
        momentum(flat.tree, out, e, flat.at(AT_VELOCITIES) + 6 * e, at)
        assert_allclose(out[at:], (inertia * velocity).vector, rtol=0.0, atol=1e-13)
        wrench(flat.tree, flat.numbers, out, e, at)
        expected = inertia * (acceleration - parts.model.gravity)
        expected += velocity.cross(inertia * velocity)
        assert_allclose(out[at:], expected.vector, rtol=0.0, atol=1e-13)

"""Closure equations of all groups at once, for what looks for a closed configuration."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
from numpy.testing import assert_allclose, assert_array_equal

from psp3.multibody.constraint import closure_equations
from psp3.multibody.flatten import NO_MOTORS, flattened
from psp3.multibody.tree import GROUPS, ROWS, VELOCITIES
from tests.helpers import Array, derivative, four_bar_closed_with_6d
from tests.psp3.multibody.flat import Flat
from tests.psp3.multibody.linkages import rockers


def equations(flat: Flat, q: Array, rows: int) -> tuple[Array, Array]:
    size, velocities = flat.count(ROWS), flat.count(VELOCITIES)
    out = np.empty(size + rows * velocities)
    closure_equations(*flat.all, q, out)
    return out[:size], out[size:].reshape(rows, velocities)


def test_residuals_of_several_groups_and_their_slopes() -> None:
    """Two loops without a motor share the crank; with it as motor they are groups. 1e-9."""
    model, loops, q = rockers(2)
    rng = np.random.default_rng(81)
    q = q + rng.uniform(-0.2, 0.2, model.nq)
    for motors, groups in ((NO_MOTORS, 1), (np.zeros(1, dtype=np.int64), 2)):
        flat = Flat(flattened(model, loops, motors))
        assert flat.count(GROUPS) == groups
        gap, slope = equations(flat, q, flat.count(ROWS))
        expected = np.column_stack(
            [
                derivative(lambda t, u=unit, f=flat: equations(f, q + t * u, 0)[0], 1e-2)
                for unit in np.eye(model.nv)
            ]
        )
        dependent = np.setdiff1d(np.arange(model.nv), motors)
        assert_allclose(slope[:, dependent], expected[:, dependent], rtol=0.0, atol=1e-9)
        # What motors do is left to who drives them.
        assert_array_equal(slope[:, motors], np.zeros((len(gap), len(motors))))
        assert_array_equal(equations(flat, q, 0)[0], gap)


def test_each_loop_has_its_own_rows(parts: SimpleNamespace, anywhere: Array) -> None:
    flat = Flat(flattened(parts.model, parts.constraint_models, NO_MOTORS))
    gap, _ = equations(flat, anywhere, 0)
    assert len(gap) == sum(flat.flat.closure_rows)
    assert (gap != 0.0).all() or np.count_nonzero(gap) >= 2
    closed, _ = equations(flat, parts.q0, 0)
    assert np.abs(closed).max() < 1e-9


def test_the_configuration_is_not_changed() -> None:
    parts = four_bar_closed_with_6d()
    flat = Flat(flattened(parts.model, parts.constraint_models, NO_MOTORS))
    q = np.array(pin.integrate(parts.model, parts.q0, 0.1 * np.ones(parts.model.nv)))
    before = q.copy()
    equations(flat, q, flat.count(ROWS))
    assert_array_equal(q, before)

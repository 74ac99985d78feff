"""Compiled loops give what arrays give: two ways that share no code but the firing of rules."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given

import fuzzy2
from tests.fuzzy2.systems.random_systems import states, systems

CRISP = (fuzzy2.Type1System, fuzzy2.IntervalType2System)


def by_arrays(system: Any, x: Any) -> Any:
    """Return the intervals without compiled loops."""
    with np.errstate(all="ignore"):
        return system._or_default(system._reduced(x))


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@given(system=systems(CRISP))
def test_what_arrays_give(system: Any) -> None:
    assume(system.reducer is not None)
    x = states(system)
    found, right = system.type_reduced(x), by_arrays(system, x)
    fired = system.firing(x)[..., 1]
    # Grades that are nearly no floats lose digits in sums that are not relative to the greatest.
    held = ((fired == 0.0) | (fired > 1e-200)).all(axis=-1)
    found, right = found[held], right[held]
    if not is_continuous(system):
        # Of two points that are equally good rounding chooses one.
        same = np.isclose(found, right, rtol=1e-9, atol=1e-9, equal_nan=True)
        assert same.mean() > 0.8
        return
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(right))
    # Halves of an area that arrays know to 1e-11 of it are 1e-5 wide where sets are cut low.
    allowed = 1e-5 if system.type_reduction == "bisector" else 1e-9
    np.testing.assert_allclose(found, right, rtol=allowed, atol=allowed)


def is_continuous(system: Any) -> bool:
    """Return whether outputs do not jump where rounding decides."""
    kind, integration = system.type_reduction, system.integration
    return "maxim" not in kind and (kind != "bisector" or integration == "exact")

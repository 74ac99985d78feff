"""Controllers beside each other: made-up results, of which is known who is better."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from psp3.errors import InvalidValue, UnknownName
from psp3.study.comparison import Comparison
from psp3.study.run import METRICS, Run, contents
from psp3.study.table import Table

CASE = Run("t1", payload=1.0, mass_mismatch=0.05)


def made_up(**settled: Sequence[float]) -> Comparison:
    """Return a comparison of settled errors by controller; NaN is a run that diverged."""
    rows = [
        {
            **contents(replace(CASE, controller=name, seed=seed).canonical()),
            **dict.fromkeys(METRICS, 1.0),
            "settled_error": value,
            "diverged": float(math.isnan(value)),
        }
        for name, values in settled.items()
        for seed, value in enumerate(values)
    ]
    return Comparison((CASE,), tuple(settled), 4, Table.of(rows))


def test_best_are_the_least_and_those_not_shown_to_be_worse() -> None:
    """In pairs what is always 10 % worse is worse, however much the seeds differ."""
    seeds = [1.0, 5.0, 2.0, 8.0]
    worse, alike = [1.1 * x for x in seeds], [1.3, 4.8, 1.9, 8.3]
    found = made_up(ctc=seeds, lqr=worse, t1=alike, it2=[0.1, math.nan, 0.1, 0.1])
    assert found.best(CASE, "settled_error") == ("ctc", "t1")
    assert found.ratio(CASE, "lqr", "ctc", "settled_error").value == pytest.approx(1.1)
    rows = found.rows("settled_error")
    assert [row.controller for row in rows] == ["ctc", "lqr", "t1", "it2"]
    assert rows[3].diverged.value == 0.25
    assert rows[3].mean.count == 3
    assert rows[0].mean.value == pytest.approx(4.0)
    header, rule, line = found.markdown(scale=1.0).splitlines()
    assert header == "| kg | path | records | ctc | lqr | t1 | it2 |"
    assert rule == "|---" * 7 + "|"
    assert (
        line == f"| 1 | helix | exact | **4** | 4.4 | **{np.mean(alike):.3g}** | 0.1, 1 diverged |"
    )
    header, _, line = found.ratios([("lqr", "ctc"), ("t1", "ctc")]).splitlines()
    assert header == "| kg | path | records | lqr / ctc | t1 / ctc |"
    ratio = found.ratio(CASE, "t1", "ctc", "settled_error")
    # A ratio that is the same in every pair has an interval without width.
    assert line == (
        f"| 1 | helix | exact | 1.1 (1.1 to 1.1) | {ratio.value:.3g} ({ratio.low:.3g} to "
        f"{ratio.high:.3g}) |"
    )
    assert ratio.low < 1.0 < ratio.high
    assert made_up(it2=[0.1, math.nan, 0.1, 0.1]).best(CASE) == ()


def test_values_are_those_of_the_seeds_in_order() -> None:
    found = made_up(ctc=[1.0, 5.0, 2.0, 8.0], it2=[3.0, math.nan, 4.0, 6.0])
    np.testing.assert_array_equal(found.values(CASE, "ctc", "settled_error"), [1.0, 5.0, 2.0, 8.0])
    np.testing.assert_array_equal(
        found.values(CASE, "it2", "settled_error"), [3.0, math.nan, 4.0, 6.0]
    )
    np.testing.assert_array_equal(found.values(CASE, "it2", "diverged"), [0.0, 1.0, 0.0, 0.0])
    assert np.isnan(found.values(CASE, "it2")[1]), "of any metric"


def test_controllers_that_do_not_see_what_a_case_has_are_there_once() -> None:
    """Computed torque sees no records, and without a mismatch no seed."""
    noisy = Run("t1", snr_db=20.0)
    rows = [
        {**contents(replace(noisy, controller="ctc").canonical()), **dict.fromkeys(METRICS, 0.0)}
    ]
    found = Comparison((noisy,), ("ctc",), 3, Table.of(rows))
    np.testing.assert_array_equal(found.values(noisy, "ctc"), [0.0, 0.0, 0.0])


def test_what_was_not_compared_is_refused() -> None:
    found = made_up(ctc=[1.0, 2.0, 3.0, 4.0])
    with pytest.raises(UnknownName, match="settled_error"):
        found.values(CASE, "ctc", "speed")
    with pytest.raises(InvalidValue, match="one that was compared"):
        found.values(replace(CASE, payload=3.0), "ctc")
    with pytest.raises(InvalidValue, match="one that was compared"):
        found.values(CASE, "pd")


def test_cases_say_what_they_are() -> None:
    found = made_up(ctc=[1.0, 2.0, 3.0, 4.0])
    assert found.in_words(CASE) == "1 kg, helix, exact records"
    driven = replace(CASE, trajectory="waypoints", snr_db=20.0, coulomb_friction=1.0)
    assert found.in_words(driven) == "1 kg, waypoints, records of 20 dB, driven"
    two = Comparison((CASE, replace(CASE, robot="delta")), (), 1, found.table)
    assert two.in_words(two.cases[1]) == "delta, 1 kg, sway, exact records"
    assert two.markdown().splitlines()[0] == "| robot | kg | path | records |  |".replace(
        " |  |", " |"
    )

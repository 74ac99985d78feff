"""The figure of the comparison: what is drawn is what was found."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from psp3 import plots
from psp3.errors import InvalidValue, UnknownName
from psp3.plots.study import figure_of_mismatch
from psp3.study.comparison import Comparison
from psp3.study.run import METRICS, Run, contents
from psp3.study.statistics import mean
from psp3.study.table import Table

NAMES = ("ctc", "t1")


def case(payload: float, path: str, snr: float) -> Run:
    return Run("t1", payload=payload, trajectory=path, snr_db=snr, mass_mismatch=0.05)


def comparison() -> Comparison:
    """Return made-up runs: two payloads on two paths with exact and noisy records.

    A run in eight diverged.
    """
    cases = [
        case(payload, path, snr)
        for payload in (0.0, 2.0)
        for path in ("helix", "line")
        for snr in (math.inf, 20.0)
    ]
    rng = np.random.default_rng(0)
    rows = {}
    for one in cases:
        for name in NAMES:
            for seed in range(8):
                run = replace(one, controller=name, seed=seed).canonical()
                metrics = dict(zip(METRICS, rng.uniform(0.01, 0.1, len(METRICS)), strict=True))
                rows[run] = {**contents(run), **metrics, "diverged": float(seed == 7)}
    return Comparison(cases, NAMES, 8, Table.of(rows.values()))


def test_panels_show_the_means_with_their_intervals() -> None:
    found = comparison()
    panels = figure_of_mismatch(found)
    titles = [panel.get_title() for panel in panels]
    assert titles == [
        f"{path}, {records}"
        for records in ("exact records", "records of 20 dB")
        for path in ("helix", "line")
    ]
    assert panels[0].get_ylabel() == "settled error [mm]"
    assert panels[1].get_ylabel() == ""
    assert panels[2].get_xlabel() == "payload [kg]"
    assert [label.get_text() for label in panels[3].get_xticklabels()] == ["0", "2"]
    for panel, (snr, path) in zip(
        panels, [(snr, path) for snr in (math.inf, 20.0) for path in ("helix", "line")], strict=True
    ):
        assert panel.get_yscale() == "log"
        for name, bar in zip(NAMES, panel.containers, strict=True):
            assert bar.get_label() == name
            estimates = [
                mean(found.values(case(payload, path, snr), name, "settled_error"))
                for payload in (0.0, 2.0)
            ]
            np.testing.assert_allclose(
                bar.lines[0].get_ydata(), [1e3 * estimate.value for estimate in estimates]
            )
            for segment, estimate in zip(bar.lines[2][0].get_segments(), estimates, strict=True):
                np.testing.assert_allclose(
                    segment[:, 1], [1e3 * estimate.low, 1e3 * estimate.high], rtol=1e-12
                )
    assert [text.get_text() for text in panels[0].figure.legends[0].get_texts()] == list(NAMES)


def test_other_metrics_and_given_axes() -> None:
    axes = Figure().subplots(4)
    panels = figure_of_mismatch(comparison(), "effort", axes)
    assert list(panels) == list(axes)
    assert panels[0].get_ylabel() == "effort [N² s]"
    with pytest.raises(InvalidValue, match="4 axes"):
        figure_of_mismatch(comparison(), axes=axes[:3])
    with pytest.raises(UnknownName, match="settled"):
        figure_of_mismatch(comparison(), "speed")


def test_sweep_shows_values_and_intervals() -> None:
    (panel,) = plots.figure_of_sweep(
        {"a": {0.0: (2.0, 1.0, 3.0), 0.5: (1.0, 0.5, 1.5)}}, "setting [1]"
    )
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("setting [1]", "sum of squared errors [m²]")
    (container,) = panel.containers
    np.testing.assert_array_equal(
        container.lines[0].get_data(),  # type: ignore[attr-defined]
        [[0.0, 0.5], [2.0, 1.0]],
    )


def test_an_interval_that_does_not_hold_its_value_is_drawn_all_the_same() -> None:
    """A bootstrap interval of percentiles can lie beside the estimate.

    Error bars of negative length are an error.
    """
    plots.figure_of_sweep({"a": {0.0: (2.0, 2.1, 3.0)}}, "setting")

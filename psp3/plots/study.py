"""Figures of sweeps, and of comparisons on robots that differ from the controllers' model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy2.plots.names import literal
from psp3.checks import Array, as_floats, checked_kind, known_name
from psp3.errors import InvalidValue
from psp3.plots.panels import Panels, checked_title, given_panels
from psp3.study.comparison import Comparison, records_in_words
from psp3.study.run import Run
from psp3.study.statistics import mean


def error_bars(value: Array, low: Array, high: Array) -> Array:
    """Return lengths of error bars, (2, N).

    They are never negative, although a percentile bootstrap interval need not contain the value.
    """
    return np.maximum([value - low, high - value], 0.0)


def figure_of_sweep(
    series: Mapping[str, Mapping[float, tuple[float, float, float]]],
    label: str,
    axes: Sequence[Axes] | Axes | None = None,
) -> Panels:
    """Draw the sum of squared errors against a setting, with intervals.

    Parameters
    ----------
    series : mapping of str to mapping of float to (value, low, high)
        For each series, by its name, the error and its interval [m²] at every value of the setting.
    label : str
        The setting, with its unit.
    axes : Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given, or there is no series.
    """
    checked_kind("series", series, Mapping, "a mapping from names to estimates by level")
    if not series:
        raise InvalidValue("series", series, "at least one series")
    checked_title(label, "label")
    curves = {name: _curve(name, points) for name, points in series.items()}
    (panel,) = given_panels(
        None if axes is None else list(np.ravel(np.asarray(axes, dtype=object))), 1
    ) or (Figure(figsize=(7.0, 4.0), layout="constrained").subplots(),)
    for name, (levels, (value, low, high)) in curves.items():
        panel.errorbar(
            levels,
            value,
            error_bars(value, low, high),
            marker="o",
            markersize=4.0,
            capsize=3.0,
            label=literal(name),
        )
    panel.set(yscale="log", xlabel=label, ylabel="sum of squared errors [m²]")
    panel.legend(ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return (panel,)


def _curve(name: object, points: object) -> tuple[Array, Array]:
    """Return the levels (N,) of a series, and its values with their intervals (3, N)."""
    wanted = "a mapping from names to mappings from numbers to (value, low, high)"
    if not isinstance(name, str) or not isinstance(points, Mapping) or not points:
        raise InvalidValue("series", {name: points}, wanted)
    levels = as_floats("series", list(points), "(N,) of levels")
    estimates = as_floats("series", list(points.values()), "(N, 3) of (value, low, high)")
    if estimates.shape != (len(levels), 3):
        raise InvalidValue("series", {name: points}, wanted)
    return levels, estimates.T


LABELS = {
    "sum_of_squared_errors": ("sum of squared errors [m²]", 1.0),
    "settled_error": ("settled error [mm]", 1e3),
    "effort": ("effort [N² s]", 1.0),
}
"""Axis label of each metric, and factor on its values."""

MARKERS = "osv^DPX*"


def figure_of_mismatch(
    found: Comparison, metric: str = "settled_error", axes: Sequence[Axes] | None = None
) -> tuple[Axes, ...]:
    """Draw the means of a metric over the payload, with their 95 % intervals.

    One panel for each trajectory and kind of records.

    Parameters
    ----------
    found : Comparison
        Return value of :func:`psp3.study.mismatch.compare`.
    metric : str
        One of :data:`LABELS`.
    axes : sequence of Axes, optional
        Where to draw, one for each panel; a new figure by default.

    Returns
    -------
    tuple of Axes
        The panels, those of one kind of records after those of the other.

    Raises
    ------
    UnknownName
        If there is no such metric.
    InvalidValue
        If there are not as many axes as panels.
    """
    known_name("metric", metric, LABELS)
    kinds = list(dict.fromkeys(case.snr_db for case in found.cases))
    paths = list(dict.fromkeys(case.trajectory for case in found.cases))
    groups = [
        [case for case in found.cases if (case.snr_db, case.trajectory) == (kind, path)]
        for kind in kinds
        for path in paths
    ]
    if axes is None:
        figure = Figure(
            figsize=(1.5 + 3.2 * len(paths), 1.2 + 2.8 * len(kinds)), layout="constrained"
        )
        panels = tuple(
            np.ravel(figure.subplots(len(kinds), len(paths), sharey=True, squeeze=False))
        )
    else:
        panels = tuple(axes)
    if len(panels) != len(groups):
        raise InvalidValue("axes", len(panels), f"{len(groups)} axes for this figure")
    for number, (panel, cases) in enumerate(zip(panels, groups, strict=True)):
        _draw(panel, found, cases, metric)
        if number % len(paths) == 0:
            panel.set_ylabel(LABELS[metric][0])
        if number >= len(groups) - len(paths):
            panel.set_xlabel("payload [kg]")
    if axes is None:
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=min(4, len(labels)))
    return panels


def _draw(panel: Axes, found: Comparison, cases: list[Run], metric: str) -> None:
    scale, count = LABELS[metric][1], len(found.controllers)
    for number, name in enumerate(found.controllers):
        estimates = [mean(found.values(case, name, metric)) for case in cases]
        values, low, high = (
            scale * np.array([getattr(one, end) for one in estimates])
            for end in ("value", "low", "high")
        )
        # Side by side at each payload, so intervals do not hide each other.
        x = np.arange(len(cases)) + 0.8 * ((number + 0.5) / count - 0.5)
        errors = np.nan_to_num(np.maximum(np.stack([values - low, high - values]), 0.0))
        panel.errorbar(
            x,
            values,
            yerr=errors,
            fmt=MARKERS[number % len(MARKERS)],
            markersize=4.5,
            linewidth=1.2,
            label=literal(name),
        )
    panel.set_yscale("log")
    panel.set_xticks(range(len(cases)), [f"{case.payload:g}" for case in cases])
    panel.set_xlim(-0.5, len(cases) - 0.5)
    title = f"{cases[0].trajectory}, {records_in_words(cases[0])}"
    panel.set_title(literal(title), fontsize="medium")

"""The figures of the thesis's chapters 4 to 6, by their numbers.

:data:`FIGURES` holds them all, and :func:`figure` draws one::

    figure(55, result)[0].figure.savefig("figure_55.svg")

Each is a function as well, ``figure_34`` to ``figure_64``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from fuzzy2.plots.names import literal
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control.records import Record
from psp3.plots.control import (
    DIFFERENCE_LABELS,
    draw_differences,
    draw_terms,
    draw_tracking,
    figure_of_terms,
    shown_samples,
)
from psp3.plots.panels import Panels, given_panels, muted
from psp3.plots.study import error_bars
from psp3.simulation.result import Result
from psp3.thesis.chapter_4_figures import figure_34 as figure_34
from psp3.thesis.chapter_4_figures import figure_35 as figure_35
from psp3.thesis.chapter_4_figures import figure_36 as figure_36
from psp3.thesis.chapter_4_figures import figure_40 as figure_40

if TYPE_CHECKING:
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque

Drawing = TypeVar("Drawing", bound=Callable[..., Panels])


def figure_49(record: Record, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the four inputs of the estimators while the crisp controller tracks a path (Fig. 49).

    Parameters
    ----------
    record : Record
        A recorded run, see :func:`psp3.fuzzy_control.records.record`.
    axes : sequence of 4 Axes, optional
        For the two differences of heights [m] and the two of speeds [m/s]; those of a new figure by
        default.

    Returns
    -------
    tuple of Axes
        The four axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    panels = given_panels(axes, 4)
    if panels is None:
        figure = Figure(figsize=(9.0, 4.8), layout="constrained")
        figure.suptitle("Differences while computed torque tracks the helix")
        panels = tuple(figure.subplots(2, 2, sharex=True).flat)
    every = shown_samples(record.t.size)
    for panel, values, label in zip(panels, record.inputs[every].T, DIFFERENCE_LABELS, strict=True):
        panel.plot(record.t[every], values)
        panel.set(ylabel=label, xlim=(record.t[0], record.t[-1]))
    for panel in panels[2:]:
        panel.set_xlabel("time t [s]")
    return panels


def figure_51(
    type2: FuzzyComputedTorque, type1: FuzzyComputedTorque, axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw the terms of the last input, the difference of the speeds of nuts 1 and 3.

    Type-2, and reduced to type-1 (Fig. 51).

    Parameters
    ----------
    type2, type1 : FuzzyComputedTorque
        Trained controllers.
    axes : sequence of 2 Axes, optional
        For the footprints of uncertainty and the type-1 terms; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        Both axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    panels = given_panels(axes, 2) or tuple(
        Figure(figsize=(7.0, 5.6), layout="constrained").subplots(2, 1, sharex=True)
    )
    number = len(DIFFERENCE_LABELS) - 1
    for panel, controller, title in zip(
        panels,
        (type2, type1),
        ("Type-2: footprints of uncertainty", "Reduced to type-1"),
        strict=True,
    ):
        draw_terms(panel, controller, number)
        panel.set_title(title)
    panels[0].set_xlabel("")
    return panels


class FigureOfRun(Protocol):
    """A function that draws a figure of a simulation."""

    def __call__(self, result: Result, axes: Sequence[Axes] | None = None) -> Panels:
        """Draw into the axes that are given, or into those of a new figure, and return them."""


class FigureOfController(Protocol):
    """A function that draws a figure of a trained controller."""

    def __call__(
        self, controller: FuzzyComputedTorque, axes: Sequence[Axes] | None = None
    ) -> Panels:
        """Draw into the axes that are given, or into those of a new figure, and return them."""


RUNS: Mapping[int, tuple[Callable[[Sequence[Axes] | None, Result, str], Panels], str]] = {
    52: (draw_tracking, "PD: the heights sag, the speeds agree"),
    53: (draw_tracking, "Computed torque: the start from rest dies out"),
    55: (draw_differences, "Type-1, no noise"),
    56: (draw_differences, "Type-1, 20 dB"),
    57: (draw_differences, "Type-1, 15 dB"),
    58: (draw_differences, "Type-1, 10 dB"),
    60: (draw_differences, "Type-2, no noise"),
    61: (draw_differences, "Type-2, 20 dB"),
    62: (draw_differences, "Type-2, 15 dB"),
    63: (draw_differences, "Type-2, 10 dB"),
}
"""Function and title of each figure of one run. The title names the controller, and the noise of
the records that it learned from.
"""

TERMS = {
    54: "Terms of the type-1 controller",
    59: "Terms of the type-2 controller, means ± {0.mean_variation:.2f} of the range",
}
"""Title of each figure of a controller's terms; the controller is its format argument."""


def _figure_of_run(number: int) -> FigureOfRun:
    draw, title = RUNS[number]

    def figure_of_run(result: Result, axes: Sequence[Axes] | None = None) -> Panels:
        return draw(axes, result, title)

    what, count, of_each = (
        ("heights and speeds of the nuts", 7, "three")
        if draw is draw_tracking
        else ("differences of heights and speeds", 5, "two")
    )
    figure_of_run.__doc__ = f"""Draw Figure {number}: {title}.

    Desired and actual {what}, and path of the tip.

    Parameters
    ----------
    result : Result
        The run.
    axes : sequence of {count} Axes, optional
        For heights [m] and speeds [m/s], {of_each} of each, and a 3D one for the path of the tip
        [mm]; new ones by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    return _named(figure_of_run, number)


def _figure_of_terms(number: int) -> FigureOfController:
    title = TERMS[number]

    def figure_of_controller(
        controller: FuzzyComputedTorque, axes: Sequence[Axes] | None = None
    ) -> Panels:
        return figure_of_terms(axes, controller, title.format(controller))

    figure_of_controller.__doc__ = f"""Draw Figure {number}: {title.split(",")[0].lower()}.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        A trained controller.
    axes : sequence of 4 Axes, optional
        One for each input; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The four axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    return _named(figure_of_controller, number)


def _named(draw: Drawing, number: int) -> Drawing:
    """Give a function the name under which this module exports it."""
    draw.__name__ = draw.__qualname__ = f"figure_{number}"
    return draw


figure_52, figure_53 = map(_figure_of_run, (52, 53))
figure_54, figure_59 = map(_figure_of_terms, (54, 59))
figure_55, figure_56, figure_57, figure_58 = map(_figure_of_run, (55, 56, 57, 58))
figure_60, figure_61, figure_62, figure_63 = map(_figure_of_run, (60, 61, 62, 63))


def figure_64(
    ratios: Mapping[str, Mapping[float, tuple[float, float, float]]],
    printed: Mapping[float, float] | None = None,
    axes: Sequence[Axes] | Axes | None = None,
) -> Panels:
    """Draw the error of type-1 over that of type-2 against the noise (Fig. 64).

    Above one, type-2 is better.

    The thesis's text says that the ratio of type-2 over type-1 rises with the noise. By its own
    numbers that ratio falls, and the inverse, type-1 over type-2, rises. The inverse is drawn here.

    Parameters
    ----------
    ratios : mapping of str to mapping of float to (value, low, high)
        For each series, by its name, the ratio and its interval at every signal-to-noise ratio
        [dB]; NaN leaves out an interval.
    printed : mapping of float to float, optional
        Ratios of the printed numbers.
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
    if not ratios:
        raise InvalidValue("ratios", ratios, "at least one series")
    (panel,) = given_panels(
        None if axes is None else list(np.ravel(np.asarray(axes, dtype=object))), 1
    ) or (Figure(figsize=(7.0, 4.0), layout="constrained").subplots(),)
    levels = sorted(
        {snr for series in (*ratios.values(), printed or {}) for snr in series}, reverse=True
    )
    place = {snr: number for number, snr in enumerate(levels)}
    panel.axhline(1.0, color=muted(), linewidth=1.0)
    for number, (name, series) in enumerate(ratios.items()):
        # Series are drawn side by side, because their intervals would hide one another.
        x = [place[snr] + 0.07 * (number - 0.5 * (len(ratios) - 1)) for snr in series]
        value, low, high = np.array(list(series.values())).T
        panel.errorbar(
            x,
            value,
            error_bars(value, low, high),
            marker="o",
            markersize=5.0,
            capsize=3.0,
            label=literal(name),
        )
    if printed:
        panel.plot(
            [place[snr] for snr in printed],
            list(printed.values()),
            color=rcParams["text.color"],
            marker="s",
            markersize=6.0,
            markerfacecolor="none",
            linestyle="--",
            linewidth=0.9,
            label="printed",
        )
    panel.set_xticks(range(len(levels)), ["∞" if np.isinf(snr) else f"{snr:g}" for snr in levels])
    panel.set(
        yscale="log",
        xlabel="signal-to-noise ratio [dB], noise grows to the right",
        ylabel="error of type-1 over type-2",
    )
    panel.yaxis.set_major_locator(FixedLocator([0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0]))
    panel.yaxis.set_minor_locator(NullLocator())
    panel.yaxis.set_major_formatter("{x:g}")
    panel.legend(loc="upper left")
    return (panel,)


FIGURES: Mapping[int, Callable[..., Panels]] = {
    34: figure_34,
    35: figure_35,
    36: figure_36,
    40: figure_40,
    49: figure_49,
    51: figure_51,
    52: figure_52,
    53: figure_53,
    54: figure_54,
    55: figure_55,
    56: figure_56,
    57: figure_57,
    58: figure_58,
    59: figure_59,
    60: figure_60,
    61: figure_61,
    62: figure_62,
    63: figure_63,
    64: figure_64,
}
"""Function that draws each figure, by its number in the thesis."""


def figure(number: int, *subjects: Any, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw a figure of the thesis by its number.

    Parameters
    ----------
    number : int
        Its number, see :data:`FIGURES`.
    *subjects
        Arguments of the figure's function: a result or a controller, two controllers for Figure 51,
        ratios for Figure 64, nothing for the figures of chapter 4.
    axes : sequence of Axes, optional
        Where to draw; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    UnknownName
        If there is no figure of that number.
    InvalidValue
        If another number of axes is given.
    """
    if number not in FIGURES:
        raise UnknownName("figure", number, [str(known) for known in FIGURES])
    return FIGURES[number](*subjects, axes=axes)

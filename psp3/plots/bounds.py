"""Figure of a tracking tube with a run in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from psp3.bounds.tracking_tube import TrackingTube, errors_of
from psp3.checks import checked_kind, listed
from psp3.errors import InvalidValue
from psp3.plots.control import shown_samples
from psp3.plots.panels import Panels, given_panels
from psp3.simulation.result import Result


def figure_of_tube(
    tube: TrackingTube, results: Sequence[Result], axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw the errors of runs in a tube, one panel for each coordinate.

    Parameters
    ----------
    tube : TrackingTube
        The tube.
    results : sequence of Result
        The runs, at least one. The tube is drawn about the first run, and starts with its initial
        error.
    axes : sequence of k Axes, optional
        One for each coordinate, over time [s]; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes. Errors are in m or rad, as the joints slide or turn.

    Raises
    ------
    InvalidValue
        If no run or another number of axes is given, or a run has another control period or
        coordinates.
    """
    checked_kind("tube", tube, TrackingTube, "a TrackingTube")
    wanted = "a list of one or more runs"
    runs = () if isinstance(results, Result) else listed("results", results, wanted)
    if not runs:
        raise InvalidValue("results", type(results).__name__, wanted)
    around, *_ = [tube.around(result) for result in runs]
    k = len(tube.residual)
    panels = given_panels(axes, k)
    if panels is None:
        figure = Figure(figsize=(7.0, 1.2 + 1.6 * k), layout="constrained")
        figure.suptitle(f"Tube that {100.0 * tube.share:g} % of runs keep")
        panels = tuple(np.atleast_1d(figure.subplots(k, 1, sharex=True)))
    every = shown_samples(len(around))
    t = runs[0].t[every]
    for i, panel in enumerate(panels):
        reach = around[every, i]
        panel.fill_between(t, -reach, reach, alpha=0.15, linewidth=0.0, label="tube")
        for result in runs:
            shown = shown_samples(result.t.size)
            panel.plot(result.t[shown], errors_of(result)[0][shown, i], linewidth=0.8)
        panel.set(ylabel=f"error {i + 1}", xlim=(t[0], t[-1]))
    panels[0].legend(loc="upper right")
    panels[-1].set_xlabel("time [s]")
    return panels

"""Figures 1 to 5 of the thesis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from fuzzy2.plots.operations import figure_of_join_and_meet, figure_of_operations
from fuzzy2.plots.panels import Panels, cycle_colors, given_panels, muted, new_panels
from fuzzy2.plots.sets import (
    domain_of,
    draw_footprint,
    draw_set,
    figure_from_above,
    label_memberships,
    points_of,
)
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Trapezoidal, Triangular
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array


def figure_1(axes: Sequence[Axes] | None = None) -> Panels:
    """Draw an ordinary triangular set and the type-2 set that results from blurring it.

    Blurring turns memberships into intervals (Fig. 1).

    Parameters
    ----------
    axes : sequence of 2 Axes, optional
        Axes for the ordinary and the blurred set; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        Both axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong.
    """
    panels = given_panels(axes, 2) or new_panels(9.0, 3.2, 1, 2, sharey=True)
    ordinary = Triangular(left=2.0, peak=5.0, right=8.0)
    # All triangles with corners in [1, 3], [4.5, 5.5] and [7.3, 8.7] are embedded: the upper
    # function is their maximum, the lower one their minimum.
    height = (7.3 - 3.0) / ((5.5 - 3.0) + (7.3 - 4.5))
    blurred = IntervalType2Set(
        lower=Triangular(left=3.0, peak=3.0 + height * (5.5 - 3.0), right=7.3, height=height),
        upper=Trapezoidal(a=1.0, b=4.5, c=5.5, d=8.7),
    )
    domain, (color, mark, *_) = domain_of([blurred]), cycle_colors()
    place = 4.0
    both: tuple[Type1Set | IntervalType2Set, ...] = (ordinary, blurred)
    for panel, fuzzy_set, title in zip(
        panels, both, ("Ordinary fuzzy set", "Blurred: a type-2 fuzzy set"), strict=True
    ):
        draw_set(
            panel,
            fuzzy_set,
            domain,
            color,
            "membership" if fuzzy_set is ordinary else "footprint of uncertainty",
        )
        label_memberships(panel, domain)
        panel.axvline(place, color=muted(), linewidth=0.8, linestyle=":")
        panel.set_title(title)
    low, high = blurred.footprint(place)
    panels[0].plot(place, ordinary(place), marker="o", markersize=5.0, color=mark)
    panels[0].annotate(
        "one grade at x\N{PRIME}",
        (place, float(ordinary(place))),
        xytext=(-8.0, 4.0),
        textcoords="offset points",
        ha="right",
    )
    panels[1].plot(
        [place, place],
        [low, high],
        color=mark,
        linewidth=3.0,
        solid_capstyle="butt",
        label="$J_{x'}$",
    )
    panels[1].annotate(
        "many at x\N{PRIME}",
        (place, float(high)),
        xytext=(-8.0, 2.0),
        textcoords="offset points",
        ha="right",
    )
    return panels


def figure_2(axes: Sequence[Axes] | Axes | None = None) -> Panels:
    """Draw a Gaussian type-2 set from above (Fig. 2); :func:`figure_from_above` draws any other.

    Parameters
    ----------
    axes : Axes, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes, without those of the color bar.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong.
    """
    return figure_from_above(_wide_and_narrow(5.0, 1.4), axes)


def _wide_and_narrow(mean: float, sigma: float) -> GaussianType2Set:
    """Return a Gaussian type-2 set whose secondaries are widest on the flanks.

    It looks as if the mean were uncertain.
    """
    principal = Gaussian(mean, sigma)

    def spread(x: Array) -> Array:
        return 0.02 + 0.10 * np.abs(x - mean) / sigma * principal(x)

    return GaussianType2Set(principal=principal, sigma=spread)


def figure_3(axes: Sequence[Axes] | None = None) -> Panels:
    """Draw Gaussian interval type-2 sets with uncertain mean and uncertain deviation (Fig. 3).

    Parameters
    ----------
    axes : sequence of 2 Axes, optional
        Axes for the uncertain mean and the uncertain standard deviation; by default, those of a new
        figure.

    Returns
    -------
    tuple of Axes
        Both axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong.
    """
    panels = given_panels(axes, 2) or new_panels(9.0, 3.2, 1, 2, sharey=True)
    uncertain: tuple[tuple[IntervalType2Set, list[Gaussian], str], ...] = (
        (
            GaussianUncertainMean(mean=(4.2, 5.8), sigma=1.2),
            [Gaussian(m, 1.2) for m in (4.6, 5.0, 5.4)],
            "Uncertain mean",
        ),
        (
            GaussianUncertainSigma(mean=5.0, sigma=(0.8, 1.8)),
            [Gaussian(5.0, s) for s in (1.0, 1.25, 1.5)],
            "Uncertain standard deviation",
        ),
    )
    for panel, (fuzzy_set, within, title) in zip(panels, uncertain, strict=True):
        domain = domain_of([fuzzy_set])
        points, color = points_of(domain, fuzzy_set), cycle_colors()[0]
        draw_footprint(panel, fuzzy_set, domain, color, "footprint of uncertainty")
        for one in within:
            panel.plot(
                points,
                one(points),
                color=muted(),
                linewidth=0.8,
                linestyle=":",
                label="within" if one is within[0] else None,
            )
        label_memberships(panel, domain)
        panel.set_title(title)
    return panels


def figure_4(axes: Sequence[Axes] | None = None) -> Panels:
    """Draw union and intersection of two general type-2 sets (Fig. 4).

    :func:`figure_of_operations` draws them for any other sets.

    Parameters
    ----------
    axes : sequence of 3 Axes, optional
        Axes for the sets, their union and their intersection; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The three axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong.
    """
    return figure_of_operations(_wide_and_narrow(3.5, 1.2), _wide_and_narrow(6.5, 1.0), axes=axes)


def figure_5(axes: Sequence[Axes] | None = None) -> Panels:
    """Draw join and meet of two convex normal fuzzy numbers (Fig. 5).

    They are computed under minimum and maximum, with eq. 1.14 and 1.15.

    Parameters
    ----------
    axes : sequence of 3 Axes, optional
        Axes for the numbers, their join and their meet; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The three axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong.
    """
    return figure_of_join_and_meet(
        Gaussian(0.42, 0.15), Triangular(left=0.25, peak=0.6, right=0.7), axes=axes
    )

"""Figures of operations on fuzzy sets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from fuzzy2.operations.extension import discrete_points, is_discrete
from fuzzy2.operations.join_meet import TNormLike, join, meet
from fuzzy2.operations.set_operations import FuzzySet, intersection, union
from fuzzy2.plots.panels import (
    Panels,
    cycle_colors,
    given_panels,
    muted,
    new_panels,
)
from fuzzy2.plots.sets import domain_of, draw_set, draw_type1, label_memberships
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import of_kind


def _draw_discrete(
    axes: Axes, fuzzy_set: Type1Set, color: str, label: str | None, width: float
) -> None:
    points, grades = discrete_points(fuzzy_set)
    # Plain lines, not a collection of stems, so that legend and line width match the curves of
    # other sets.
    up_and_down = np.stack([np.zeros_like(grades), grades, np.full_like(grades, np.nan)], axis=-1)
    axes.plot(np.repeat(points, 3), up_and_down.ravel(), color=color, label=label, linewidth=width)
    axes.plot(
        points, grades, linestyle="none", marker="o", markersize=2.0 + 1.5 * width, color=color
    )


def figure_of_operations(
    first: FuzzySet, second: FuzzySet, t_norm: TNormLike = "min", axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw two fuzzy sets, their union (eq. 1.9) and their intersection (eq. 1.10; after Fig. 4).

    General type-2 sets are drawn from above: the stronger the color, the higher the secondary
    grade. Lines show their principal membership functions.

    Parameters
    ----------
    first, second : FuzzySet
        The sets. If one is a general type-2 set, so are the union and the intersection.
    t_norm : str, TNorm or callable
        See :func:`fuzzy2.operations.set_operations.intersection`; the grades are combined by the
        minimum.
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
    for name, one in (("first", first), ("second", second)):
        of_kind(name, one, (Type1Set, IntervalType2Set, GeneralType2Set), "a fuzzy set")
    panels = given_panels(axes, 3) or new_panels(6.0, 7.0, 3, sharex=True)
    domain, colors = domain_of([first, second]), cycle_colors()
    results = {
        "Union": union(first, second, t_norm=t_norm, grade_t_norm="min"),
        "Intersection": intersection(first, second, t_norm=t_norm, grade_t_norm="min"),
    }
    for fuzzy_set, color, name in ((first, colors[0], "first"), (second, colors[1], "second")):
        draw_set(panels[0], fuzzy_set, domain, color, name)
    panels[0].set_title("Two fuzzy sets")
    panels[0].legend(loc="upper right")
    for panel, (name, result) in zip(panels[1:], results.items(), strict=True):
        draw_set(panel, result, domain, colors[2], name.lower())
        panel.set_title(name)
    for panel in panels:
        label_memberships(panel, domain)
    for panel in panels[:-1]:
        panel.set_xlabel("")
    return panels


def figure_of_join_and_meet(
    F: Type1Set,
    G: Type1Set,
    t_norm: TNormLike = "min",
    grade_t_norm: TNormLike | None = None,
    axes: Sequence[Axes] | None = None,
) -> Panels:
    """Draw two secondary memberships, their join and their meet (eq. 1.12; after Fig. 5).

    Discrete sets are drawn as stems.

    Parameters
    ----------
    F, G : Type1Set
        Secondary memberships.
    t_norm, grade_t_norm : str, TNorm or callable
        See :func:`fuzzy2.operations.join_meet.meet`.
    axes : sequence of 3 Axes, optional
        Axes for both sets, their join and their meet; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The three axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong.
    """
    panels = given_panels(axes, 3) or new_panels(6.0, 6.0, 3, sharex=True)
    results = {
        "Join": join(F, G, t_norm=t_norm, grade_t_norm=grade_t_norm),
        "Meet": meet(F, G, t_norm=t_norm, grade_t_norm=grade_t_norm),
    }
    domain, colors = domain_of([F, G, *results.values()]), cycle_colors()
    # Discrete sets have nothing between their points, and the join of interpolations is not the
    # interpolation of the join.
    discrete = is_discrete(F) and is_discrete(G)
    for operand, color, name in ((F, colors[0], "F"), (G, colors[1], "G")):
        if discrete:
            _draw_discrete(panels[0], operand, color, name, 1.6)
            continue
        draw_type1(panels[0], operand, domain, color, name)
        for panel in panels[1:]:
            draw_type1(panel, operand, domain, muted(), None, linewidth=0.9, linestyle="--")
    panels[0].set_title("Two fuzzy numbers")
    panels[0].legend(loc="upper right")
    for panel, (name, result) in zip(panels[1:], results.items(), strict=True):
        if discrete:
            _draw_discrete(panel, result, colors[2], name.lower(), 2.2)
        else:
            draw_type1(panel, result, domain, colors[2], name.lower(), linewidth=2.2)
        panel.set_title(f"{name} of F and G")
    for panel in panels:
        label_memberships(panel, domain, "membership \N{GREEK SMALL LETTER THETA}", "grade")
    for panel in panels[:-1]:
        panel.set_xlabel("")
    return panels

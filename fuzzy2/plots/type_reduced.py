"""Figures of type-reduced sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.numbers.affine import GaussianNumber, IntervalNumber
from fuzzy2.plots.names import literal
from fuzzy2.plots.panels import (
    Panels,
    cycle_colors,
    given_panels,
    new_panels,
)
from fuzzy2.plots.sets import POINTS, domain_of, label_memberships, points_of
from fuzzy2.reduction.general import TypeReducedPlanes, TypeReducedPoints
from fuzzy2.sets.type1 import SampledSet, Type1Set
from fuzzy2.support.checks import Array, reals

Reduced: TypeAlias = (
    ArrayLike | IntervalNumber | GaussianNumber | Type1Set | TypeReducedPlanes | TypeReducedPoints
)

REACH = 3.5
"""Half-width, in standard deviations, over which a Gaussian number is drawn."""


def figure_of_type_reduced(
    reduced: Mapping[str, Reduced] | Reduced, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    """Draw type-reduced sets, each with its crisp value as a dashed line.

    Parameters
    ----------
    reduced : type-reduced set, or mapping from names to them
        An interval (2,), a single :class:`IntervalNumber` or :class:`GaussianNumber`, a
        :class:`Type1Set`, or a result of the functions in :mod:`fuzzy2.reduction.general`. Those
        results include their crisp values; for the others it is the centroid.
    axes : Axes, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong, or if a type-reduced set is an array of several sets or has
        no value.
    """
    named: Mapping[Any, Reduced] = reduced if isinstance(reduced, Mapping) else {None: reduced}
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.0)
    colors = cycle_colors()
    ends = []
    for n, (name, one) in enumerate(named.items()):
        color = colors[n % len(colors)]
        label = None if name is None else literal(str(name))
        points, grades, crisp = _curve(one)
        if isinstance(one, TypeReducedPoints | SampledSet):
            panel.vlines(points, 0.0, grades, color=color, linewidth=1.2, label=label or "")
            panel.plot(points, grades, linestyle="none", marker="o", markersize=3.0, color=color)
        else:
            panel.fill_between(points, grades, color=color, alpha=0.2, linewidth=0.0)
            panel.plot(points, grades, color=color, label=label)
        panel.axvline(crisp, color=color, linestyle=(0, (4, 3)), linewidth=1.0)
        ends += [points[0], points[-1]]
    margin = 0.08 * (max(ends) - min(ends)) or 1.0
    label_memberships(panel, (min(ends) - margin, max(ends) + margin), "output y", "grade")
    if isinstance(reduced, Mapping):
        panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    return (panel,)


def _curve(reduced: Reduced) -> tuple[Array, Array, float]:
    """Return points and grades (N,) of the outline of a type-reduced set, and its crisp value."""
    if isinstance(reduced, TypeReducedPoints):
        return reduced.set.points, reduced.set.grades, reduced.crisp
    if isinstance(reduced, TypeReducedPlanes):
        if reduced.intervals.ndim != 2 or not np.isfinite(reduced.intervals).all():
            raise InvalidValue(
                "reduced", reduced, "the type-reduced set of a single output that has a value"
            )
        # The outline goes up the left ends and down the right ends, each level starting at the end
        # of the cut below.
        left, right = (_stairs(end, reduced.alphas) for end in reduced.intervals.T)
        return (
            np.concatenate([left[0], right[0][::-1]]),
            np.concatenate([left[1], right[1][::-1]]),
            float(reduced.crisp),
        )
    if isinstance(reduced, GaussianNumber):
        if reduced.ndim:
            raise InvalidValue("reduced", reduced.shape, "a single number; take one by its index")
        mean, sigma = float(reduced.mean), float(reduced.sigma)
        points = mean + sigma * np.linspace(-REACH, REACH, POINTS)
        return points, np.exp(-0.5 * np.linspace(-REACH, REACH, POINTS) ** 2), mean
    if isinstance(reduced, Type1Set):
        if isinstance(reduced, SampledSet):
            return (
                reduced.points,
                reduced.grades,
                float(reduced.points @ reduced.grades / reduced.grades.sum()),
            )
        points = points_of(domain_of([reduced]), reduced)
        return points, reduced(points), reduced.centroid()
    ends = reals("reduced", reduced.interval() if isinstance(reduced, IntervalNumber) else reduced)
    if ends.shape != (2,) or not np.isfinite(ends).all():
        raise InvalidValue("reduced", ends, "one interval (2,) of finite ends")
    left_end, right_end = ends.tolist()
    return (
        np.array([left_end, left_end, right_end, right_end]),
        np.array([0.0, 1.0, 1.0, 0.0]),
        0.5 * (left_end + right_end),
    )


def _stairs(ends: Array, levels: Array) -> tuple[Array, Array]:
    return np.repeat(ends, 2), np.concatenate([[0.0], np.repeat(levels, 2)[:-1]])

"""Figures of fuzzy sets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.image import AxesImage
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.operations.set_operations import FuzzySet
from fuzzy2.plots.names import literal
from fuzzy2.plots.panels import (
    Panels,
    cycle_colors,
    deep,
    given_panels,
    muted,
    new_panels,
    shades_of,
    space_panel,
)
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.support.checks import Array, of_kind, reals
from fuzzy2.support.quadrature import merged

POINTS = 513
"""Number of points along a curve, besides those where it bends."""

ACROSS = 301
"""Numbers of points and of primary memberships in the picture of a general type-2 set."""

VISIBLE = 3e-3
"""Membership grade below which the tail of an unbounded set is left out."""


def domain_of(sets: Sequence[FuzzySet]) -> tuple[float, float]:
    """Return the range in which the sets are visible, with a margin."""
    ends = []
    for fuzzy_set in sets:
        # The footprint of a set with unbounded secondary memberships is all of [0, 1] everywhere,
        # but its principal membership is not.
        shown = fuzzy_set.principal if isinstance(fuzzy_set, GeneralType2Set) else fuzzy_set.upper
        points = merged(fuzzy_set.landmarks, shown.landmarks)
        grid = merged(np.linspace(points[0], points[-1], POINTS), points)
        seen = grid[shown(grid) > VISIBLE * shown.height]
        left, right = fuzzy_set.support
        ends += [
            left if math.isfinite(left) else seen[0],
            right if math.isfinite(right) else seen[-1],
        ]
    margin = 0.04 * (max(ends) - min(ends)) or 1.0
    return min(ends) - margin, max(ends) + margin


def points_of(domain: tuple[float, float], *sets: FuzzySet) -> Array:
    """Return points across a domain, including the points where the sets bend.

    The floats on both sides of a bend are included, because it may be a jump.
    """
    bends = merged(*(fuzzy_set.landmarks for fuzzy_set in sets))
    both = merged(
        np.linspace(*domain, POINTS),
        bends,
        np.nextafter(bends, -np.inf),
        np.nextafter(bends, np.inf),
    )
    return both[(both >= domain[0]) & (both <= domain[1])]


def label_memberships(
    axes: Axes, domain: tuple[float, float], x: str = "x", u: str = "membership u"
) -> None:
    """Set limits and labels of a panel of memberships over a domain."""
    axes.set(xlim=domain, ylim=(0.0, 1.05), xlabel=x, ylabel=u)


def draw_type1(
    axes: Axes,
    fuzzy_set: Type1Set,
    domain: tuple[float, float],
    color: str,
    label: str | None,
    **line: Any,
) -> None:
    """Draw the membership function of a type-1 set; ``line`` holds options of the line."""
    if isinstance(fuzzy_set, Singleton):
        axes.plot([fuzzy_set.point] * 2, [0.0, 1.0], color=color, label=label)
        axes.plot(fuzzy_set.point, 1.0, marker="o", markersize=4.0, color=color)
        return
    points = points_of(domain, fuzzy_set)
    axes.plot(points, fuzzy_set(points), color=color, label=label, **line)
    if isinstance(fuzzy_set, SampledSet) and len(fuzzy_set) <= 50:
        axes.plot(
            fuzzy_set.points,
            fuzzy_set.grades,
            linestyle="none",
            marker="o",
            markersize=3.0,
            color=color,
        )


def draw_footprint(
    axes: Axes,
    fuzzy_set: IntervalType2Set,
    domain: tuple[float, float],
    color: str,
    label: str | None,
) -> None:
    """Draw the footprint of uncertainty of an interval type-2 set and its bounds."""
    points = points_of(domain, fuzzy_set)
    lower, upper = fuzzy_set.footprint(points).T
    axes.fill_between(points, lower, upper, color=color, alpha=0.25, linewidth=0.0, label=label)
    axes.plot(points, upper, color=color, linewidth=1.2)
    axes.plot(points, lower, color=color, linewidth=1.2, linestyle=(0, (5, 2)))


def _draw_general(
    axes: Axes,
    fuzzy_set: GeneralType2Set,
    domain: tuple[float, float],
    color: str,
    label: str | None,
) -> AxesImage:
    x, u = np.linspace(*domain, ACROSS), np.linspace(0.0, 1.0, ACROSS)
    grades = np.array([fuzzy_set.secondary(point)(u) for point in x.tolist()])
    # An image takes one pixel per point in vector formats, too, where a mesh would take a hundred
    # thousand shapes.
    half_x, half_u = 0.5 * (x[1] - x[0]), 0.5 * (u[1] - u[0])
    extent = (x[0] - half_x, x[-1] + half_x, u[0] - half_u, u[-1] + half_u)
    image = axes.imshow(
        grades.T,
        origin="lower",
        extent=extent,
        aspect="auto",
        cmap=shades_of(color),
        vmin=0.0,
        vmax=1.0,
    )
    axes.plot(x, fuzzy_set.principal(x), color=deep(color), linewidth=1.2, label=label)
    return image


def draw_set(
    axes: Axes, fuzzy_set: FuzzySet, domain: tuple[float, float], color: str, name: str | None
) -> None:
    """Draw a set of any type into a panel."""
    if isinstance(fuzzy_set, Type1Set):
        draw_type1(axes, fuzzy_set, domain, color, name)
    elif isinstance(fuzzy_set, IntervalType2Set):
        draw_footprint(axes, fuzzy_set, domain, color, name)
    else:
        _draw_general(axes, fuzzy_set, domain, color, name)


def figure_of_sets(
    sets: Mapping[str, FuzzySet] | FuzzySet, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    """Draw membership functions of type-1, interval type-2 and general type-2 sets.

    A type-1 set is drawn as a line. An interval type-2 set is drawn as its footprint of uncertainty
    (eq. 1.4) between the upper and the dashed lower membership function. A general type-2 set is
    drawn from above, with its principal membership function as a line.

    Parameters
    ----------
    sets : FuzzySet, or mapping from names to them
        The sets.
    axes : Axes, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong, or if there are no sets.
    """
    named: Mapping[Any, FuzzySet] = sets if isinstance(sets, Mapping) else {None: sets}
    for one in named.values():
        of_kind(
            "sets",
            one,
            (Type1Set, IntervalType2Set, GeneralType2Set),
            "a fuzzy set, or a mapping from names to sets",
        )
    if not named:
        raise InvalidValue("sets", sets, "at least one fuzzy set")
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.0)
    domain, colors = domain_of(list(named.values())), cycle_colors()
    for n, (name, fuzzy_set) in enumerate(named.items()):
        color = colors[n % len(colors)]
        label = None if name is None else literal(str(name))
        draw_set(panel, fuzzy_set, domain, color, label)
    label_memberships(panel, domain)
    if isinstance(sets, Mapping):
        panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(len(named), 4))
    return (panel,)


def figure_from_above(
    fuzzy_set: GeneralType2Set, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    r"""Draw a general type-2 set from above.

    Secondary grades :math:`\mu(x, u)` (eq. 1.1) are drawn as darkness (after Fig. 2).

    The line is the principal membership function, where the secondary grade is greatest.

    Parameters
    ----------
    fuzzy_set : GeneralType2Set
        The set.
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
    of_kind("fuzzy_set", fuzzy_set, GeneralType2Set, "a general type-2 set")
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.6)
    domain = domain_of([fuzzy_set])
    image = _draw_general(panel, fuzzy_set, domain, cycle_colors()[0], "principal")
    label_memberships(panel, domain)
    bar = panel.figure.colorbar(image, ax=panel, label="secondary grade")
    bar.ax.grid(visible=False)
    panel.legend(loc="upper right")
    return (panel,)


def figure_in_space(
    fuzzy_set: GeneralType2Set, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    r"""Draw a general type-2 set in space.

    The surface shows the secondary grade (eq. 1.1) over points and primary memberships.

    The surface covers the support of each vertical slice, or its α-cut at 0.01 if the support
    extends further. The footprint of uncertainty below it is drawn on the floor.

    Parameters
    ----------
    fuzzy_set : GeneralType2Set
        The set, with convex vertical slices.
    axes : 3D Axes, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong, or if they are not three-dimensional.
    NotApplicable
        If a vertical slice is not convex.
    """
    of_kind("fuzzy_set", fuzzy_set, GeneralType2Set, "a general type-2 set")
    panel = space_panel(axes)
    domain = domain_of([fuzzy_set])
    points, across = np.linspace(*domain, 121), np.linspace(0.0, 1.0, 41)
    plane = fuzzy_set.alpha_plane(0.01)
    lower, upper = plane.lower(points)[:, None], plane.upper(points)[:, None]
    u = lower + across * (upper - lower)
    grades = np.array(
        [fuzzy_set.secondary(point)(row) for point, row in zip(points.tolist(), u, strict=True)]
    )
    # Walls down to the floor at both ends make slices with vertical sides look solid.
    u = np.concatenate([u[:, :1], u, u[:, -1:]], axis=1)
    grades = np.pad(grades, ((0, 0), (1, 1)))
    x = np.broadcast_to(points[:, None], u.shape)
    # Surfaces are opaque, so that the slices behind do not show through those in front.
    shades = LinearSegmentedColormap.from_list(
        "grades", [rcParams["axes.facecolor"], cycle_colors()[0]]
    )
    panel.plot_surface(
        x,
        u,
        grades,
        cmap=shades,
        vmin=-0.5,
        vmax=1.0,
        rcount=points.size,
        ccount=u.shape[1],
        linewidth=0.0,
        shade=False,
    )
    crest = np.array([fuzzy_set.secondary(point).height for point in points.tolist()])
    panel.plot(
        points,
        fuzzy_set.principal(points),
        crest,
        color=cycle_colors()[1],
        label="principal",
        zorder=4,
    )
    panel.fill_between(
        points, lower[:, 0], 0.0, points, upper[:, 0], 0.0, color=muted(), alpha=0.35, linewidth=0.0
    )
    panel.set(xlim=domain, ylim=(0.0, 1.0), zlim=(0.0, 1.0), xlabel="x", ylabel="membership u")
    panel.set_zlabel("secondary grade")
    panel.legend(loc="upper right")
    panel.view_init(elev=48.0, azim=-70.0)
    return (panel,)


def figure_of_secondaries(
    fuzzy_set: IntervalType2Set | GeneralType2Set,
    x: ArrayLike,
    axes: Sequence[Axes] | Axes | None = None,
) -> Panels:
    """Draw vertical slices of a type-2 set.

    Each curve shows the secondary grade over the primary membership at one point (eq. 1.3).

    Parameters
    ----------
    fuzzy_set : IntervalType2Set or GeneralType2Set
        The set.
    x : (N,) array_like
        Points.
    axes : Axes, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong.
    """
    of_kind("fuzzy_set", fuzzy_set, (IntervalType2Set, GeneralType2Set), "a type-2 set")
    points = np.atleast_1d(reals("x", x))
    if points.ndim > 1 or not points.size:
        raise InvalidValue("x", x, "a list of one or more points")
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.0)
    colors = cycle_colors()
    for n, point in enumerate(points.tolist()):
        color, vertical_slice = colors[n % len(colors)], fuzzy_set.secondary(point)
        draw_type1(panel, vertical_slice, (0.0, 1.0), color, f"x = {point:.4g}")
        if not isinstance(vertical_slice, Singleton):
            u = points_of((0.0, 1.0), vertical_slice)
            panel.fill_between(u, vertical_slice(u), color=color, alpha=0.15, linewidth=0.0)
    label_memberships(panel, (0.0, 1.0), "membership u", "secondary grade")
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    return (panel,)

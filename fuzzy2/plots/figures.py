"""Figures of fuzzy sets, of what the operations make of them, and of systems.

Those of the thesis are named after their number there.

Every function draws into the axes it is given, or into those of a new figure, and returns them;
``axes[0].figure`` is the figure to save. Nothing here touches ``matplotlib.pyplot``. The look is
that of matplotlib's settings in force::

    with fuzzy2.plots.style.style():
        figure_of_sets({"low": low, "high": high})[0].figure.savefig("sets.svg")

Secondary grades are drawn as darkness (in the dark theme, brightness): the fuller the color, the
higher the grade.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgba
from matplotlib.image import AxesImage
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.numbers.affine import GaussianNumber, IntervalNumber
from fuzzy2.operations.extension import discrete_points, is_discrete
from fuzzy2.operations.join_meet import TNormLike, join, meet
from fuzzy2.operations.set_operations import FuzzySet, intersection, union
from fuzzy2.plots.panels import (
    Panels,
    cycle_colors,
    deep,
    given_panels,
    muted,
    new_panels,
    shades_of,
)
from fuzzy2.reduction.general import TypeReducedPlanes, TypeReducedPoints
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import ROUNDING, SampledSet, Singleton, Type1Set
from fuzzy2.support.checks import Array, reals
from fuzzy2.support.quadrature import merged
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.system import FuzzySystem

Reduced: TypeAlias = (
    ArrayLike | IntervalNumber | GaussianNumber | Type1Set | TypeReducedPlanes | TypeReducedPoints
)

POINTS = 513
"""Points along a curve, besides those where it bends."""
ACROSS = 301
"""Points and primary memberships in the picture of a general type-2 set."""
VISIBLE = 3e-3
"""Membership grade below which the tail of an unbounded set is left out."""
REACH = 3.5
"""Half-width, in standard deviations, over which a Gaussian number is drawn."""


def domain_of(sets: Sequence[FuzzySet]) -> tuple[float, float]:
    """Return the range in which something is to be seen of the sets, with a margin."""
    ends = []
    for fuzzy_set in sets:
        # The footprint of a set with unbounded secondaries is all of [0, 1] everywhere; its
        # principal membership is not.
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
    """Return points across a domain, with those where the sets bend.

    Of the latter also the floats on both sides, for it may be a jump.
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


def _draw_type1(
    axes: Axes,
    fuzzy_set: Type1Set,
    domain: tuple[float, float],
    color: str,
    label: str | None,
    **line: Any,
) -> None:
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


def _draw_discrete(
    axes: Axes, fuzzy_set: Type1Set, color: str, label: str | None, width: float
) -> None:
    points, grades = discrete_points(fuzzy_set)
    # Lines, not stems made of a collection, so that legend and thickness are those of the curves of
    # other sets.
    up_and_down = np.stack([np.zeros_like(grades), grades, np.full_like(grades, np.nan)], axis=-1)
    axes.plot(np.repeat(points, 3), up_and_down.ravel(), color=color, label=label, linewidth=width)
    axes.plot(
        points, grades, linestyle="none", marker="o", markersize=2.0 + 1.5 * width, color=color
    )


def draw_footprint(
    axes: Axes,
    fuzzy_set: IntervalType2Set,
    domain: tuple[float, float],
    color: str,
    label: str | None,
) -> None:
    """Draw the footprint of uncertainty of an interval type-2 set and its edges."""
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
    # An image is one pixel a point in vector formats, too, where a mesh would be a hundred thousand
    # shapes.
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
        _draw_type1(axes, fuzzy_set, domain, color, name)
    elif isinstance(fuzzy_set, IntervalType2Set):
        draw_footprint(axes, fuzzy_set, domain, color, name)
    else:
        _draw_general(axes, fuzzy_set, domain, color, name)


def figure_of_sets(
    sets: Mapping[str, FuzzySet] | FuzzySet, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    """Draw membership functions of type-1, interval type-2 and general type-2 sets.

    A type-1 set is a line; an interval type-2 set its footprint of uncertainty (eq. 1.4) between
    the upper membership function and the lower, dashed one; a general type-2 set is seen from
    above, with the principal membership function as a line.

    Parameters
    ----------
    sets : FuzzySet, or mapping from names to them
        The sets.
    axes : Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given, or there is no set.
    """
    named: Mapping[Any, FuzzySet] = sets if isinstance(sets, Mapping) else {None: sets}
    if not named:
        raise InvalidValue("sets", sets, "at least one fuzzy set")
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.0)
    domain, colors = domain_of(list(named.values())), cycle_colors()
    for n, (name, fuzzy_set) in enumerate(named.items()):
        color = colors[n % len(colors)]
        draw_set(panel, fuzzy_set, domain, color, name)
    label_memberships(panel, domain)
    if isinstance(sets, Mapping):
        panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(len(named), 4))
    return (panel,)


def figure_from_above(
    fuzzy_set: GeneralType2Set, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    r"""Draw a general type-2 set from above.

    Secondary grades :math:`\mu(x, u)` (eq. 1.1) as darkness (after Fig. 2).

    The line is the principal membership function, where the secondary grade is greatest.

    Parameters
    ----------
    fuzzy_set : GeneralType2Set
        The set.
    axes : Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes, without those of the color bar.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
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

    The secondary grade (eq. 1.1) over points and primary memberships.

    The surface spans each vertical slice from end to end of its support, or of its α-cut at 0.01
    where the support reaches further; on the floor lies what it spans, the footprint of
    uncertainty.

    Parameters
    ----------
    fuzzy_set : GeneralType2Set
        With convex vertical slices.
    axes : 3D Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given, or they are not three-dimensional.
    NotApplicable
        If a vertical slice is not convex.
    """
    panel = _space(axes)
    domain = domain_of([fuzzy_set])
    points, across = np.linspace(*domain, 121), np.linspace(0.0, 1.0, 41)
    plane = fuzzy_set.alpha_plane(0.01)
    lower, upper = plane.lower(points)[:, None], plane.upper(points)[:, None]
    u = lower + across * (upper - lower)
    grades = np.array(
        [fuzzy_set.secondary(point)(row) for point, row in zip(points.tolist(), u, strict=True)]
    )
    # Walls down to the floor at both ends, so that slices with vertical sides look solid.
    u = np.concatenate([u[:, :1], u, u[:, -1:]], axis=1)
    grades = np.pad(grades, ((0, 0), (1, 1)))
    x = np.broadcast_to(points[:, None], u.shape)
    # Opaque: the slices behind must not show through those in front.
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


def _space(axes: Sequence[Axes] | Axes | None) -> Any:
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 4.6, subplot_kw={"projection": "3d"})
    if panel.name != "3d":
        raise InvalidValue("axes", panel.name, 'three-dimensional, made with projection="3d"')
    space: Any = panel
    space.set_box_aspect(None, zoom=0.88)  # labels would be cut off otherwise
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        axis.set_pane_color(to_rgba(rcParams["grid.color"], 0.25))
    return space


def figure_of_secondaries(
    fuzzy_set: IntervalType2Set | GeneralType2Set,
    x: ArrayLike,
    axes: Sequence[Axes] | Axes | None = None,
) -> Panels:
    """Draw vertical slices of a type-2 set.

    Secondary grade over primary membership at points (eq. 1.3).

    Parameters
    ----------
    fuzzy_set : IntervalType2Set or GeneralType2Set
        The set.
    x : (N,) array_like
        Points.
    axes : Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.0)
    colors = cycle_colors()
    for n, point in enumerate(np.atleast_1d(reals("x", x)).tolist()):
        color, vertical_slice = colors[n % len(colors)], fuzzy_set.secondary(point)
        _draw_type1(panel, vertical_slice, (0.0, 1.0), color, f"x = {point:.4g}")
        if not isinstance(vertical_slice, Singleton):
            u = points_of((0.0, 1.0), vertical_slice)
            panel.fill_between(u, vertical_slice(u), color=color, alpha=0.15, linewidth=0.0)
    label_memberships(panel, (0.0, 1.0), "membership u", "secondary grade")
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    return (panel,)


def figure_of_operations(
    first: FuzzySet, second: FuzzySet, t_norm: TNormLike = "min", axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw two fuzzy sets, their union (eq. 1.9) and their intersection (eq. 1.10; after Fig. 4).

    General type-2 sets are drawn from above: the fuller the color, the higher the secondary grade;
    lines are their principal membership functions.

    Parameters
    ----------
    first, second : FuzzySet
        The sets. If one is of general type 2, so are union and intersection.
    t_norm : str, TNorm or callable
        See :func:`fuzzy2.operations.set_operations.intersection`; the grades are combined by the
        minimum.
    axes : sequence of 3 Axes, optional
        For the sets, their union and their intersection; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The three axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
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

    Discrete ones as stems.

    Parameters
    ----------
    F, G : Type1Set
        Secondary memberships.
    t_norm, grade_t_norm : str, TNorm or callable
        See :func:`fuzzy2.operations.join_meet.meet`.
    axes : sequence of 3 Axes, optional
        For both sets, their join and their meet; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The three axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    panels = given_panels(axes, 3) or new_panels(6.0, 6.0, 3, sharex=True)
    results = {
        "Join": join(F, G, t_norm=t_norm, grade_t_norm=grade_t_norm),
        "Meet": meet(F, G, t_norm=t_norm, grade_t_norm=grade_t_norm),
    }
    domain, colors = domain_of([F, G, *results.values()]), cycle_colors()
    # Among discrete sets there is nothing between the points, and joins are no interpolations of
    # joins.
    discrete = is_discrete(F) and is_discrete(G)
    for operand, color, name in ((F, colors[0], "F"), (G, colors[1], "G")):
        if discrete:
            _draw_discrete(panels[0], operand, color, name, 1.6)
            continue
        _draw_type1(panels[0], operand, domain, color, name)
        for panel in panels[1:]:
            _draw_type1(panel, operand, domain, muted(), None, linewidth=0.9, linestyle="--")
    panels[0].set_title("Two fuzzy numbers")
    panels[0].legend(loc="upper right")
    for panel, (name, result) in zip(panels[1:], results.items(), strict=True):
        if discrete:
            _draw_discrete(panel, result, colors[2], name.lower(), 2.2)
        else:
            _draw_type1(panel, result, domain, colors[2], name.lower(), linewidth=2.2)
        panel.set_title(f"{name} of F and G")
    for panel in panels:
        label_memberships(panel, domain, "membership \N{GREEK SMALL LETTER THETA}", "grade")
    for panel in panels[:-1]:
        panel.set_xlabel("")
    return panels


def figure_of_type_reduced(
    reduced: Mapping[str, Reduced] | Reduced, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    """Draw type-reduced sets, each with its crisp value as a dashed line.

    Parameters
    ----------
    reduced : type-reduced set, or mapping from names to them
        An interval (2,), a single :class:`IntervalNumber` or :class:`GaussianNumber`, a
        :class:`Type1Set`, or what the functions of :mod:`fuzzy2.reduction.general` return. The
        crisp value is what those say, and otherwise the centroid.
    axes : Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given, or a type-reduced set is an array of them or has no
        value.
    """
    named: Mapping[Any, Reduced] = reduced if isinstance(reduced, Mapping) else {None: reduced}
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.0)
    colors = cycle_colors()
    ends = []
    for n, (name, one) in enumerate(named.items()):
        color = colors[n % len(colors)]
        points, grades, crisp = _curve(one)
        if isinstance(one, TypeReducedPoints | SampledSet):
            panel.vlines(points, 0.0, grades, color=color, linewidth=1.2, label=name or "")
            panel.plot(points, grades, linestyle="none", marker="o", markersize=3.0, color=color)
        else:
            panel.fill_between(points, grades, color=color, alpha=0.2, linewidth=0.0)
            panel.plot(points, grades, color=color, label=name)
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
        # Up the left ends and down the right ones, each level from the end of the cut below to its
        # own.
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


def figure_of_response(
    system: FuzzySystem,
    varied: int = 0,
    output: int = 0,
    held: ArrayLike | None = None,
    domain: tuple[float, float] | None = None,
    axes: Sequence[Axes] | Axes | None = None,
) -> Panels:
    """Draw an output of a system over one of its inputs, with the bounds of the type-reduced set.

    Bounds are the ends of the type-reduced interval, and one standard deviation about the mean of a
    type-reduced Gaussian; those of a type-1 system coincide with its output and are left out. Where
    no rule fires there is no line.

    Parameters
    ----------
    system : Type1System, IntervalType2System or GeneralType2System
        The system.
    varied : int
        Index of the input on the abscissa.
    output : int
        Index of the output.
    held : (p,) array_like, optional
        Values of all inputs, of which the varied one does not matter; by default the middles of
        ``system.domain()``.
    domain : pair of float, optional
        Ends of the abscissa; by default those of ``system.domain()``.
    axes : Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given, or ``held`` is not one value per input.
    """
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 3.2)
    grid, X = _grid(system, (varied,), held, (domain,), 401)
    crisp, bounds = _outputs(system, X, output)
    color = cycle_colors()[0]
    if bounds is not None:
        panel.fill_between(
            grid[0],
            bounds[0],
            bounds[1],
            color=color,
            alpha=0.22,
            linewidth=0.0,
            label="type-reduced set",
        )
    panel.plot(grid[0], crisp, color=color, label="output")
    panel.set(
        xlim=(grid[0][0], grid[0][-1]),
        xlabel=system.input_names[varied],
        ylabel=system.output_names[output],
    )
    panel.legend(loc="best")
    return (panel,)


def figure_of_rule_surface(
    system: FuzzySystem,
    varied: tuple[int, int] = (0, 1),
    output: int = 0,
    held: ArrayLike | None = None,
    domains: tuple[tuple[float, float] | None, tuple[float, float] | None] = (None, None),
    axes: Sequence[Axes] | Axes | None = None,
) -> Panels:
    """Draw an output of a system over two of its inputs.

    It lies between the bounds of the type-reduced set.

    The bounds are the nets above and below; see :func:`figure_of_response`.

    Parameters
    ----------
    system : Type1System, IntervalType2System or GeneralType2System
        The system.
    varied : pair of int
        Indices of the inputs on the floor.
    output : int
        Index of the output.
    held : (p,) array_like, optional
        Values of all inputs, of which the varied ones do not matter; by default the middles of
        ``system.domain()``.
    domains : pair of pairs of float, optional
        Ends of the floor; by default those of ``system.domain()``.
    axes : 3D Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given, they are not three-dimensional, or ``held`` is not one
        value per input.
    """
    panel = _space(axes)
    grid, X = _grid(system, varied, held, domains, 41)
    crisp, bounds = _outputs(system, X, output)
    first, second = np.meshgrid(*grid, indexing="ij")
    shades = LinearSegmentedColormap.from_list(
        "heights", [rcParams["axes.facecolor"], cycle_colors()[0]]
    )
    low, high = float(np.nanmin(crisp)), float(np.nanmax(crisp))
    # The lowest point is tinted, too, and an output that never changes has some color.
    edges = {"vmin": low - 0.4 * (high - low) - 1e-300, "vmax": high}
    panel.plot_surface(
        first, second, crisp, cmap=shades, **edges, rcount=41, ccount=41, linewidth=0.0, shade=False
    )
    if bounds is not None:
        for bound, color, name in zip(
            bounds,
            (cycle_colors()[2], cycle_colors()[1]),
            ("lower bound", "upper bound"),
            strict=True,
        ):
            panel.plot_wireframe(
                first,
                second,
                bound,
                color=color,
                alpha=0.55,
                rcount=14,
                ccount=14,
                linewidth=0.7,
                label=name,
            )
    panel.set(xlabel=system.input_names[varied[0]], ylabel=system.input_names[varied[1]])
    panel.set_zlabel(system.output_names[output])
    if bounds is not None:
        panel.legend(loc="upper left")
    return (panel,)


def _grid(
    system: FuzzySystem,
    varied: Sequence[int],
    held: ArrayLike | None,
    domains: Sequence[tuple[float, float] | None],
    count: int,
) -> tuple[list[Array], Array]:
    """Return the points of the varied inputs and all inputs on their grid.

    Their shapes are (count,) each, and (count, ..., p).
    """
    covered = system.domain()
    middle = covered.mean(axis=1) if held is None else reals("held", held)
    if middle.shape != (len(covered),):
        raise InvalidValue("held", middle.shape, f"one value for each of the {len(covered)} inputs")
    ends = [
        covered[i] if domain is None else domain for i, domain in zip(varied, domains, strict=True)
    ]
    points = [np.linspace(left, right, count) for left, right in ends]
    X = np.broadcast_to(middle, (*(count,) * len(points), middle.size)).copy()
    for i, values in zip(varied, np.meshgrid(*points, indexing="ij"), strict=True):
        X[..., i] = values
    return points, X


def _outputs(
    system: FuzzySystem, X: Array, output: int
) -> tuple[Array, tuple[Array, Array] | None]:
    """Return an output at inputs (..., p), and its bounds unless they coincide."""
    crisp = system(X)[..., output]
    first, second = np.moveaxis(system.type_reduced(X)[..., output, :], -1, 0)
    if isinstance(system, GeneralType2System) and system.reduction == "gaussian":
        first, second = first - second, first + second
    width = np.nanmax(np.abs(second - first), initial=0.0)
    return crisp, None if width <= ROUNDING * np.nanmax(np.abs(crisp), initial=0.0) else (
        first,
        second,
    )

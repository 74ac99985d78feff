"""Figures of systems."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.plots.names import literal
from fuzzy2.plots.panels import (
    Panels,
    check_output,
    cycle_colors,
    given_panels,
    new_panels,
    space_panel,
)
from fuzzy2.sets.type1 import ROUNDING
from fuzzy2.support.checks import Array, ascending_pair, listed, of_kind, reals, whole_number
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.system import FuzzySystem


def figure_of_response(
    system: FuzzySystem,
    varied: int = 0,
    output: int = 0,
    held: ArrayLike | None = None,
    domain: tuple[float, float] | None = None,
    axes: Sequence[Axes] | Axes | None = None,
) -> Panels:
    """Draw an output of a system over one of its inputs, with the bounds of the type-reduced set.

    The bounds are the ends of the type-reduced interval, or one standard deviation on both sides of
    the mean of a type-reduced Gaussian. The bounds of a type-1 system coincide with its output and
    are left out. Where no rule fires, no line is drawn.

    Parameters
    ----------
    system : Type1System, IntervalType2System or GeneralType2System
        The system.
    varied : int
        Index of the input on the abscissa.
    output : int
        Index of the output.
    held : (p,) array_like, optional
        Values of all inputs, where that of the varied input is ignored; by default the middles of
        ``system.domain()``.
    domain : pair of float, optional
        Ends of the abscissa; by default those of ``system.domain()``.
    axes : Axes, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong, or if ``held`` does not have one value for each input.
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
        xlabel=literal(system.input_names[varied]),
        ylabel=literal(system.output_names[output]),
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

    The output lies between the bounds of the type-reduced set.

    The bounds are drawn as nets above and below the output; see :func:`figure_of_response`.

    Parameters
    ----------
    system : Type1System, IntervalType2System or GeneralType2System
        The system.
    varied : pair of int
        Indices of the inputs on the floor.
    output : int
        Index of the output.
    held : (p,) array_like, optional
        Values of all inputs, where those of the varied inputs are ignored; by default the middles
        of ``system.domain()``.
    domains : pair of pairs of float, optional
        Ends of both axes of the floor; by default those of ``system.domain()``.
    axes : 3D Axes, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If the number of axes is wrong, if they are not three-dimensional, or if ``held`` does not
        have one value for each input.
    """
    if len(listed("varied", varied, "two numbers of inputs")) != 2:
        raise InvalidValue("varied", varied, "two numbers of inputs")
    panel = space_panel(axes)
    grid, X = _grid(system, varied, held, domains, 41)
    crisp, bounds = _outputs(system, X, output)
    first, second = np.meshgrid(*grid, indexing="ij")
    shades = LinearSegmentedColormap.from_list(
        "heights", [rcParams["axes.facecolor"], cycle_colors()[0]]
    )
    low, high = float(np.nanmin(crisp)), float(np.nanmax(crisp))
    # The color range starts below the lowest point, so that it is tinted, too, and a constant
    # output is visible.
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
    floor = (literal(system.input_names[i]) for i in varied)
    panel.set(**dict(zip(("xlabel", "ylabel"), floor, strict=True)))
    panel.set_zlabel(literal(system.output_names[output]))
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
    """Return the points of the varied inputs, and all inputs on their grid.

    The points have the shape (count,) for each varied input, the grid has the shape (count, ...,
    p).
    """
    of_kind("system", system, FuzzySystem, "a fuzzy system")
    covered = system.domain()
    varied = listed("varied", varied, "numbers of inputs")
    given = listed("domains", domains, "pairs of numbers, or None for those of the system")
    if len(varied) != len(given):
        wanted = f"a pair of numbers, or None, for each of the {len(given)} axes"
        raise InvalidValue("varied and domains", (varied, given), wanted)
    for i in varied:
        if whole_number("varied", i, 0) >= len(covered):
            raise InvalidValue("varied", i, f"numbers of the {len(covered)} inputs, from 0")
    middle = covered.mean(axis=1) if held is None else reals("held", held)
    if middle.shape != (len(covered),):
        raise InvalidValue("held", middle.shape, f"one value for each of the {len(covered)} inputs")
    rest = np.delete(middle, varied)
    if not np.isfinite(rest).all():
        raise InvalidValue("held", held, "finite but for inputs that vary")
    ends = [
        covered[i] if domain is None else ascending_pair("domain", domain)
        for i, domain in zip(varied, given, strict=True)
    ]
    for left, right in ends:
        if left == right:
            raise InvalidValue("domain", (left, right), "two different numbers")
    points = [np.linspace(left, right, count) for left, right in ends]
    X = np.broadcast_to(middle, (*(count,) * len(points), middle.size)).copy()
    for i, values in zip(varied, np.meshgrid(*points, indexing="ij"), strict=True):
        X[..., i] = values
    return points, X


def _outputs(
    system: FuzzySystem, X: Array, output: int
) -> tuple[Array, tuple[Array, Array] | None]:
    """Return an output at inputs (..., p), and its bounds unless they coincide."""
    check_output(output, system.n_outputs)
    crisp = system(X)[..., output]
    first, second = np.moveaxis(system.type_reduced(X)[..., output, :], -1, 0)
    if isinstance(system, GeneralType2System) and system.reduction == "gaussian":
        first, second = first - second, first + second
    width = np.nanmax(np.abs(second - first), initial=0.0)
    return crisp, None if width <= ROUNDING * np.nanmax(np.abs(crisp), initial=0.0) else (
        first,
        second,
    )

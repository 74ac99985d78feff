"""Figures of fuzzy sets and systems.

What stands on the axes, and whether the curves are the numbers they claim to be.
"""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from fuzzy2 import plots
from fuzzy2.errors import ApproximationWarning, InvalidValue
from fuzzy2.numbers import GaussianNumber, IntervalNumber
from fuzzy2.plots.style import style
from fuzzy2.reduction.general import TypeReducedPlanes, TypeReducedPoints
from fuzzy2.sets.functional_type2 import FunctionalType2Set
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System

Array = NDArray[np.float64]

FUZZY = GaussianType2Set(principal=Gaussian(5.0, 1.0), sigma=0.1)
TRIANGLES = FunctionalType2Set(lambda x: Triangular(0.2, 0.5, 0.9), 0.0, 2.0)
TERMS = [GaussianUncertainMean(mean=(m - 0.1, m + 0.1), sigma=0.5) for m in (-1.0, 0.0, 1.0)]
RULES = [[i, j] for i in range(3) for j in range(3)]
CONSEQUENTS = [[i * j + 0.5 * i, -1.0] for i, j in RULES]
SYSTEM = IntervalType2System(
    [TERMS, TERMS],
    RULES,
    CONSEQUENTS,
    input_names=["a [m]", "b [m]"],
    output_names=["force [N]", "other"],
)

FIGURES: dict[str, tuple[Callable[..., tuple[Axes, ...]], int]] = {
    "figure_1": (plots.figure_1, 2),
    "figure_2": (plots.figure_2, 1),
    "figure_3": (plots.figure_3, 2),
    "figure_4": (plots.figure_4, 3),
    "figure_5": (plots.figure_5, 3),
    "sets": (
        lambda axes=None: plots.figure_of_sets(
            {"low": Triangular(0.0, 1.0, 2.0), "fuzzy": FUZZY, "now": Singleton(3.0)}, axes
        ),
        1,
    ),
    "secondaries": (lambda axes=None: plots.figure_of_secondaries(FUZZY, [4.0, 5.0], axes), 1),
    "reduced": (
        lambda axes=None: plots.figure_of_type_reduced(
            {"one": [1.0, 2.0], "two": GaussianNumber(3.0, 0.5)}, axes
        ),
        1,
    ),
    "response": (lambda axes=None: plots.figure_of_response(SYSTEM, axes=axes), 1),
}
IN_SPACE: dict[str, Callable[..., tuple[Axes, ...]]] = {
    "set": lambda axes=None: plots.figure_in_space(TRIANGLES, axes),
    "surface": lambda axes=None: plots.figure_of_rule_surface(SYSTEM, axes=axes),
}


@pytest.fixture(autouse=True)
def _styled() -> Iterator[None]:
    with style():
        yield


def curve(axes: Axes, label: str) -> Array:
    """Return the data of the line with that label, (2, N)."""
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return np.array(line.get_data(), dtype=float)


def band(axes: Axes, label: str | None = None, index: int = 0) -> Array:
    """Return the corners of a filled band, (N, 2): of the one with that label, or by its index."""
    fills: Any = [one for one in axes.collections if label is None or one.get_label() == label]
    return np.asarray(fills[index].get_paths()[0].vertices)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Array]:
    """Coordinates (3, ...) of every surface and net that is drawn in space, in order.

    Matplotlib does not give them back.
    """
    seen: list[Array] = []
    for name in ("plot_surface", "plot_wireframe"):
        draw = getattr(Axes3D, name)

        def record(
            panel: Axes3D, *coordinates: Array, draw: Callable[..., Any] = draw, **options: Any
        ) -> Any:
            seen.append(np.stack(coordinates))
            return draw(panel, *coordinates, **options)

        monkeypatch.setattr(Axes3D, name, record)
    return seen


def edges(corners: Array, x: float) -> tuple[float, float]:
    """Return lower and upper edge of a band at the drawn point nearest to x."""
    nearest = corners[np.argmin(np.abs(corners[:, 0] - x)), 0]
    at = corners[corners[:, 0] == nearest, 1]
    return float(at.min()), float(at.max())


def test_figure_1_blurs_a_triangle() -> None:
    """Triangles of all corners from those of the figure fill the footprint from edge to edge.

    J at x′ is its section.
    """
    ordinary, blurred = plots.figure_1()
    x, u = curve(ordinary, "membership")
    np.testing.assert_allclose(
        u, np.clip(np.minimum((x - 2.0) / 3.0, (8.0 - x) / 3.0), 0.0, 1.0), atol=1e-15
    )
    corners = band(blurred, "footprint of uncertainty")
    lefts, peaks, rights = np.meshgrid(
        np.linspace(1.0, 3.0, 5), np.linspace(4.5, 5.5, 11), np.linspace(7.3, 8.7, 5)
    )
    for point in np.unique(corners[:, 0])[5:-5:10]:
        grades = np.clip(
            np.minimum((point - lefts) / (peaks - lefts), (rights - point) / (rights - peaks)),
            0.0,
            1.0,
        )
        # Peaks are 0.1 apart, and between two of them a triangle reaches 0.05 times a slope of at
        # most 0.56 higher.
        np.testing.assert_allclose([grades.min(), grades.max()], edges(corners, point), atol=0.03)
        low, high = edges(corners, point)
        assert low - 1e-12 <= grades.min() <= grades.max() <= high + 1e-12
    place, ends = curve(blurred, "$J_{x'}$")
    assert place.tolist() == [4.0, 4.0]
    # half a step of 0.016 times a slope of 0.4
    np.testing.assert_allclose(ends, edges(corners, 4.0), atol=4e-3)


def test_figure_2_shows_secondary_grades() -> None:
    (panel,) = plots.figure_2()
    (image,) = panel.images
    grades: Any = image.get_array()
    left, right, bottom, top = image.get_extent()
    rows, columns = grades.shape
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    u = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    # The set of the figure, written out again.
    principal = np.exp(-0.5 * ((x - 5.0) / 1.4) ** 2)
    spread = 0.02 + 0.10 * np.abs(x - 5.0) / 1.4 * principal
    np.testing.assert_allclose(
        grades, np.exp(-0.5 * ((u[:, None] - principal) / spread) ** 2), atol=1e-9
    )
    np.testing.assert_allclose(curve(panel, "principal"), [x, principal], atol=1e-12)
    np.testing.assert_allclose([u[0], u[-1]], [0.0, 1.0], atol=1e-15)
    assert image.get_clim() == (0.0, 1.0)
    assert [axes.get_ylabel() for axes in panel.figure.axes] == ["membership u", "secondary grade"]


def test_figure_3_shows_what_gaussians_of_uncertain_parameters_cover() -> None:
    """Lower and upper edge are the extremes over many means.

    Or over many standard deviations, from the interval of the uncertain one.
    """
    for panel, curves in zip(
        plots.figure_3(),
        (
            lambda x: [np.exp(-0.5 * ((x - m) / 1.2) ** 2) for m in np.linspace(4.2, 5.8, 801)],
            lambda x: [np.exp(-0.5 * ((x - 5.0) / s) ** 2) for s in np.linspace(0.8, 1.8, 801)],
        ),
        strict=True,
    ):
        corners = band(panel, "footprint of uncertainty")
        for x in np.unique(corners[:, 0])[10:-10:25]:
            grades = curves(x)
            # 801 means are 0.002 apart, over which a Gaussian changes by less than 1e-6 at its top,
            # where they fall between two.
            np.testing.assert_allclose(edges(corners, x), [min(grades), max(grades)], atol=1e-6)
    assert panel.get_title(loc="left") == "Uncertain standard deviation"


def test_figure_4_shows_union_and_intersection() -> None:
    """Principal curves under minimum and maximum are those of the principal curves.

    For convex normal sets.
    """
    sets, union, intersection = plots.figure_4()
    x, first = curve(sets, "first")
    _, second = curve(sets, "second")
    # The secondary of a Gaussian cut at 0 or 1 has its peak there, so its principal curve stays as
    # it is.
    np.testing.assert_allclose(curve(union, "union"), [x, np.maximum(first, second)], atol=1e-9)
    np.testing.assert_allclose(
        curve(intersection, "intersection"), [x, np.minimum(first, second)], atol=1e-9
    )
    grades: Any = intersection.images[0].get_array()
    assert grades.max() > 0.9
    assert [panel.get_title(loc="left") for panel in (union, intersection)] == [
        "Union",
        "Intersection",
    ]


def test_figure_5_shows_join_and_meet() -> None:
    """Against the extension principle on a grid of 1001 memberships.

    1e-3 is a step of the grid times the greatest slope, 10.
    """
    numbers, join, meet = plots.figure_5()
    v = np.linspace(0.0, 1.0, 1001)
    f = np.exp(-0.5 * ((v - 0.42) / 0.15) ** 2)
    g = np.clip(np.minimum((v - 0.25) / 0.35, (0.7 - v) / 0.1), 0.0, 1.0)
    grades = np.minimum(f[:, None], g)
    for panel, name, image in (
        (join, "join", np.maximum(v[:, None], v)),
        (meet, "meet", np.minimum(v[:, None], v)),
    ):
        theta, drawn = curve(panel, name)
        for point in (0.3, 0.42, 0.5, 0.6, 0.65, 0.69):
            expected = grades[np.isclose(image, point, atol=1e-9)].max()
            assert abs(np.interp(point, theta, drawn) - expected) < 1e-2
    assert {line.get_label() for line in numbers.lines} == {"F", "G"}
    assert meet.get_xlabel() == "membership θ"


def test_join_and_meet_of_discrete_sets_are_stems() -> None:
    """By hand: maxima and minima of the four pairs.

    Each has the smaller of both grades, and of equal ones the best counts.
    """
    _, join, meet = plots.figure_of_join_and_meet(
        SampledSet([0.2, 0.6], [0.5, 1.0]), SampledSet([0.4, 0.6], [1.0, 0.3])
    )
    for panel, points, grades in (
        (join, [0.4, 0.6], [0.5, 1.0]),
        (meet, [0.2, 0.4, 0.6], [0.5, 1.0, 0.3]),
    ):
        theta, drawn = (np.asarray(values, dtype=float) for values in panel.lines[1].get_data())
        np.testing.assert_array_equal([theta, drawn], [points, grades])
        assert panel.lines[1].get_linestyle() == "None"
        np.testing.assert_array_equal(
            panel.lines[0].get_ydata(), [end for grade in grades for end in (0.0, grade, np.nan)]
        )


def test_sets_of_every_type_share_axes() -> None:
    shapes = {
        "triangle": Triangular(0.0, 1.0, 2.0),
        "shoulder": Trapezoidal(2.0, 4.0, np.inf, np.inf),
        "footprint": IntervalType2Set(
            lower=Triangular(1.0, 2.0, 3.0, height=0.5), upper=Triangular(0.0, 2.0, 4.0)
        ),
        "fuzzy": FUZZY,
        "discrete": SampledSet([0.5, 1.5], [0.4, 1.0]),
        "point": Singleton(3.0),
    }
    (panel,) = plots.figure_of_sets(shapes)
    x, u = curve(panel, "triangle")
    np.testing.assert_allclose(u, np.clip(1.0 - np.abs(x - 1.0), 0.0, 1.0), atol=1e-15)
    left, right = panel.get_xlim()
    assert left < 0.0
    # The Gaussian falls to the visibility of 0.003 at 3.4 standard deviations; a landmark is there
    # at 4.
    assert 8.2 < right < 9.4
    assert edges(band(panel, "footprint"), 2.0) == (0.5, 1.0)
    legend = panel.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == list(shapes)
    np.testing.assert_array_equal(curve(panel, "point"), [[3.0, 3.0], [0.0, 1.0]])
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x", "membership u")


def test_a_single_set_needs_no_name() -> None:
    (panel,) = plots.figure_of_sets(Interval(1.0, 2.0))
    assert panel.get_legend() is None
    x, u = np.array(panel.lines[0].get_data(), dtype=float)
    # Vertical edges stay vertical: neighboring floats lie on both sides.
    np.testing.assert_array_equal(u, (x >= 1.0) & (x <= 2.0))
    assert np.diff(x)[np.diff(u) != 0.0].max() < 1e-15
    (alone,) = plots.figure_of_sets(Singleton(2.0))
    assert alone.get_xlim() == (1.0, 3.0)


def test_secondaries_are_vertical_slices() -> None:
    (panel,) = plots.figure_of_secondaries(FUZZY, [4.0, 6.5])
    for x in (4.0, 6.5):
        u, grades = curve(panel, f"x = {x:g}")
        np.testing.assert_allclose(
            grades, np.exp(-0.5 * ((u - np.exp(-0.5 * (x - 5.0) ** 2)) / 0.1) ** 2), atol=1e-12
        )
    (panel,) = plots.figure_of_secondaries(GaussianUncertainSigma(mean=0.0, sigma=(1.0, 2.0)), 1.0)
    u, grades = curve(panel, "x = 1")
    np.testing.assert_allclose(
        u[grades == 1.0][[0, -1]], [np.exp(-0.5), np.exp(-0.125)], atol=1e-15
    )
    (panel,) = plots.figure_of_secondaries(TRIANGLES, [3.0])
    np.testing.assert_array_equal(curve(panel, "x = 3"), [[0.0, 0.0], [0.0, 1.0]])
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("membership u", "secondary grade")


def test_a_set_in_space_stands_over_its_footprint(drawn: list[Array]) -> None:
    panel: Any = plots.figure_in_space(TRIANGLES)[0]
    x, u, crest = (np.asarray(values) for values in panel.lines[0].get_data_3d())
    inside = (x >= 0.0) & (x <= 2.0)
    np.testing.assert_allclose(u, np.where(inside, 0.5, 0.0), atol=1e-12)
    np.testing.assert_array_equal(crest, 1.0)
    (surface,) = drawn
    over = surface.reshape(3, -1).T
    over = over[(over[:, 0] >= 0.0) & (over[:, 0] <= 2.0)]
    expected = np.clip(np.minimum((over[:, 1] - 0.2) / 0.3, (0.9 - over[:, 1]) / 0.4), 0.0, 1.0)
    # Walls at the α-cut of 0.01 go down to the floor.
    assert (np.isclose(over[:, 2], expected, atol=1e-9) | (over[:, 2] == 0.0)).all()
    assert over[:, 2].max() > 0.97
    assert (panel.get_xlabel(), panel.get_ylabel(), panel.get_zlabel()) == (
        "x",
        "membership u",
        "secondary grade",
    )


def test_type_reduced_sets_show_ends_grades_and_crisp_values() -> None:
    planes = TypeReducedPlanes(
        np.array([0.5, 1.0]), np.array([[1.0, 4.0], [2.0, 3.5]]), np.array(2.6)
    )
    points = TypeReducedPoints(SampledSet([5.0, 6.0, 8.0], [0.5, 1.0, 0.5]), 6.25)
    reduced: dict[str, plots.Reduced] = {
        "interval": [1.0, 3.0],
        "number": IntervalNumber(2.0, 0.5),
        "Gaussian": GaussianNumber(4.0, 0.5),
        "planes": planes,
        "set": Triangular(0.0, 1.0, 5.0),
        "samples": SampledSet([1.0, 2.0], [1.0, 0.5]),
        "points": points,
    }
    (panel,) = plots.figure_of_type_reduced(reduced)
    np.testing.assert_array_equal(
        curve(panel, "interval"), [[1.0, 1.0, 3.0, 3.0], [0.0, 1.0, 1.0, 0.0]]
    )
    np.testing.assert_array_equal(curve(panel, "number")[0], [1.5, 1.5, 2.5, 2.5])
    y, grades = curve(panel, "Gaussian")
    np.testing.assert_allclose(grades, np.exp(-0.5 * ((y - 4.0) / 0.5) ** 2), atol=1e-15)
    np.testing.assert_array_equal(
        curve(panel, "planes"), [[1, 1, 2, 2, 3.5, 3.5, 4, 4], [0, 0.5, 0.5, 1, 1, 0.5, 0.5, 0]]
    )
    crisp = [
        line.get_xdata()[0]  # type: ignore[index]
        for line in panel.lines
        if line.get_linestyle() == "--"
    ]
    # The centroid of a triangle is the mean of its corners; of samples, the weighted mean.
    np.testing.assert_allclose(crisp, [2.0, 2.0, 4.0, 2.6, 2.0, 4.0 / 3.0, 6.25], rtol=1e-12)
    stems: Any = next(one for one in panel.collections if one.get_label() == "points")
    np.testing.assert_array_equal(stems.get_segments()[1], [[6.0, 0.0], [6.0, 1.0]])
    assert panel.get_xlabel() == "output y"


@pytest.mark.parametrize(
    "reduced",
    [
        [1.0, 2.0, 3.0],
        [np.nan, np.nan],
        IntervalNumber([1.0, 2.0], [0.1, 0.1]),
        GaussianNumber([1.0, 2.0], [0.1, 0.1]),
        TypeReducedPlanes(np.array([1.0]), np.full((1, 2), np.nan), np.array(np.nan)),
    ],
)
def test_what_is_no_single_type_reduced_set_is_refused(reduced: Any) -> None:
    with pytest.raises(InvalidValue, match="reduced"):
        plots.figure_of_type_reduced(reduced)


def test_response_shows_output_and_bounds() -> None:
    (panel,) = plots.figure_of_response(SYSTEM, varied=1, held=[0.3, 0.0], domain=(-0.5, 0.8))
    b, y = curve(panel, "output")
    X = np.stack([np.full_like(b, 0.3), b], axis=-1)
    np.testing.assert_array_equal(y, [SYSTEM(one)[0] for one in X])
    low, high = edges(band(panel, "type-reduced set"), b[100])
    np.testing.assert_array_equal([low, high], SYSTEM.type_reduced(X[100])[0])
    assert (b[0], b[-1]) == (-0.5, 0.8)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("b [m]", "force [N]")


def test_response_has_no_line_where_no_rule_fires_and_no_band_without_uncertainty() -> None:
    system = Type1System(
        [[Triangular(0.0, 1.0, 2.0), Triangular(3.0, 4.0, 5.0)]], [[0], [1]], [[1.0], [7.0]]
    )
    (panel,) = plots.figure_of_response(system, domain=(0.0, 5.0))
    x, y = curve(panel, "output")
    np.testing.assert_array_equal(np.isnan(y), (x <= 0.0) | ((x >= 2.0) & (x <= 3.0)) | (x >= 5.0))
    assert not panel.collections
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x1", "y1")


def test_bounds_of_the_gaussian_corollary_are_one_standard_deviation() -> None:
    terms = [GaussianType2Set(principal=Gaussian(m, 1.0), sigma=0.05) for m in (0.0, 2.0)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ApproximationWarning)
        system = GeneralType2System([terms], [[0], [1]], [[0.0], [1.0]], reduction="gaussian")
    (panel,) = plots.figure_of_response(system)
    x, y = curve(panel, "output")
    mean, sigma = system.type_reduced([x[200]])[0]
    np.testing.assert_allclose(
        [y[200], *edges(band(panel, "type-reduced set"), x[200])],
        [mean, mean - sigma, mean + sigma],
        rtol=1e-12,
    )


def test_rule_surface_lies_between_its_bounds(drawn: list[Array]) -> None:
    panel: Any = plots.figure_of_rule_surface(SYSTEM, domains=((-1.0, 1.0), (-0.5, 0.5)))[0]
    surface, lower, upper = drawn
    X = np.moveaxis(surface[:2], 0, -1)
    np.testing.assert_array_equal([X[0, 0], X[-1, -1]], [[-1.0, -0.5], [1.0, 0.5]])
    np.testing.assert_allclose(surface[2], SYSTEM(X)[..., 0], rtol=1e-14)
    np.testing.assert_array_equal(
        np.stack([lower[2], upper[2]], axis=-1), SYSTEM.type_reduced(X)[..., 0, :]
    )
    assert (lower[2] < surface[2]).all()
    assert (surface[2] < upper[2]).all()
    assert [one.get_label() for one in panel.collections[1:]] == ["lower bound", "upper bound"]
    assert (panel.get_xlabel(), panel.get_ylabel(), panel.get_zlabel()) == (
        "a [m]",
        "b [m]",
        "force [N]",
    )


def test_rule_surface_of_a_constant_type_1_system(drawn: list[Array]) -> None:
    term = Gaussian(0.0, 1.0)
    system = Type1System([[term], [term]], [[0, 0]], [[2.0]])
    panel: Any = plots.figure_of_rule_surface(system, domains=((-1.0, 1.0), (-1.0, 1.0)))[0]
    (surface,) = drawn
    np.testing.assert_allclose(surface[2], 2.0, rtol=1e-14)
    assert panel.get_legend() is None


def test_held_inputs_must_be_one_for_each_input() -> None:
    with pytest.raises(InvalidValue, match="one value for each of the 2 inputs"):
        plots.figure_of_response(SYSTEM, held=[1.0])


def test_no_sets_are_no_figure() -> None:
    with pytest.raises(InvalidValue, match="at least one fuzzy set"):
        plots.figure_of_sets({})


@pytest.mark.parametrize("name", list(FIGURES))
def test_figures_draw_into_the_axes_they_are_given(name: str) -> None:
    draw, count = FIGURES[name]
    figure = Figure(figsize=(6.0, 3.0 * count), layout="constrained")
    axes = figure.subplots(count, 1, squeeze=False).ravel()
    assert list(draw(axes)) == list(axes)
    # A color bar brings axes of its own.
    assert len(figure.axes) == count + (name == "figure_2")
    with pytest.raises(InvalidValue, match=f"axes must be {count} axes"):
        draw([*axes, axes[0]])


@pytest.mark.parametrize("name", list(IN_SPACE))
def test_figures_in_space_need_three_dimensional_axes(name: str) -> None:
    figure = Figure()
    space = figure.add_subplot(projection="3d")
    assert IN_SPACE[name](space) == (space,)
    with pytest.raises(InvalidValue, match="three-dimensional"):
        IN_SPACE[name](figure.add_subplot())


@pytest.mark.parametrize("name", [*FIGURES, *IN_SPACE])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_is_inside_the_figure_and_does_not_lie_on_other_text(name: str, theme: str) -> None:
    """Bounding boxes from matplotlib's own renderer; one pixel is the rounding of the boxes."""
    with style(theme):
        panel = (FIGURES[name][0] if name in FIGURES else IN_SPACE[name])()[0]
        figure: Any = panel.figure
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        renderer = canvas.get_renderer()
        boxes = []
        for axes in figure.axes:
            legend = axes.get_legend()
            labels = [
                axes.xaxis.label,
                axes.yaxis.label,
                *([axes.zaxis.label] if hasattr(axes, "zaxis") else []),
            ]
            texts = [
                *axes.texts,
                *labels,
                axes._left_title,
                *(legend.get_texts() if legend else []),
            ]
            boxes += [
                (text.get_text(), text.get_window_extent(renderer))
                for text in texts
                if text.get_text()
            ]
        assert len(boxes) >= 2
        for text, box in boxes:
            assert box.x0 > figure.bbox.x0 - 1, text
            assert box.x1 < figure.bbox.x1 + 1, text
            assert box.y0 > figure.bbox.y0 - 1, text
            assert box.y1 < figure.bbox.y1 + 1, text
        for n, (text, box) in enumerate(boxes):
            for other, other_box in boxes[:n]:
                apart = (
                    box.x0 > other_box.x1 - 1
                    or other_box.x0 > box.x1 - 1
                    or box.y0 > other_box.y1 - 1
                    or other_box.y0 > box.y1 - 1
                )
                assert apart, f"{text} lies on {other}"
        # Light text on dark ground, or the other way round: most of the picture is ground.
        ground = np.median(np.asarray(canvas.buffer_rgba())[..., :3])
        assert ground > 240 if theme == "light" else ground < 60


def test_drawing_leaves_pyplot_alone() -> None:
    """In a fresh process, because another test may have imported pyplot."""
    program = (
        "import sys; from fuzzy2.plots import figure_2; figure_2(); sys.exit('matplotlib.pyplot' "
        "in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0

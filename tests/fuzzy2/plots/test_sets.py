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
from matplotlib.figure import Figure
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
from tests.fuzzy2.plots.drawn import band, curve, edges
from tests.legible import check_texts, labels_of

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
        texts = []
        for axes in figure.axes:
            texts += [*axes.texts, *labels_of(axes)]
        assert check_texts(figure, texts) >= 2
        # Light text on dark ground, or the other way round: most of the picture is ground.
        ground = np.median(np.asarray(figure.canvas.buffer_rgba())[..., :3])
        assert ground > 240 if theme == "light" else ground < 60


def test_drawing_leaves_pyplot_alone() -> None:
    """In a fresh process, because another test may have imported pyplot."""
    program = (
        "import sys; from fuzzy2.plots import figure_2; figure_2(); sys.exit('matplotlib.pyplot' "
        "in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0

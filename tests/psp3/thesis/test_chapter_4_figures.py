"""Figures of chapter 4.

What stands on the axes, and whether the curves are the numbers they claim to be.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from io import BytesIO

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fuzzy2.plots.style import style
from psp3.errors import InvalidValue
from psp3.thesis import chapter_4_figures as figures
from tests.fuzzy2.plots.drawn import curve
from tests.legible import check_texts, labels_of

FIGURES: dict[int, tuple[Callable[..., tuple[Axes, ...]], int]] = {
    34: (figures.figure_34, 2),
    35: (figures.figure_35, 2),
    36: (figures.figure_36, 2),
    40: (figures.figure_40, 7),
}


@pytest.fixture(autouse=True)
def _styled() -> Iterator[None]:
    with style():
        yield


def pixels(figure: Figure) -> NDArray[np.uint8]:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())


@pytest.mark.parametrize(
    ("number", "poles"),
    [
        (34, [-5.0 - np.sqrt(21.0), -5.0 + np.sqrt(21.0)]),
        (35, [-0.5 - 0.5j * np.sqrt(15.0), -0.5 + 0.5j * np.sqrt(15.0)]),
        (36, [-2.0, -2.0]),
    ],
)
def test_figures_of_the_release_show_poles_and_response(number: int, poles: list[complex]) -> None:
    """Poles by the quadratic formula, worked out by hand.

    The response as the inverse Laplace transform of its partial fractions.
    """
    left, right = FIGURES[number][0]()
    re, im = curve(left, "poles")
    np.testing.assert_allclose(re + 1j * im, poles, rtol=1e-14)
    assert left.get_xlabel() == "Re s [1/s]"
    assert left.get_ylabel() == "Im s [1/s]"
    low, high = left.get_xlim()
    assert low < re.min()
    assert high > 0.0  # the border of stability is in the picture
    case = {34: "overdamped", 35: "underdamped", 36: "critically damped"}[number]
    t, x = curve(right, case)
    first, second = poles
    if first == second:
        expected = -(1.0 - first * t) * np.exp(first * t)
    else:
        expected = np.real(
            (second * np.exp(first * t) - first * np.exp(second * t)) / (first - second)
        )
    np.testing.assert_allclose(x, expected, rtol=0.0, atol=1e-13)
    assert (t[0], x[0], t[-1]) == (0.0, -1.0, 10.0)
    assert right.get_xlabel() == "time t [s]"
    assert right.get_ylabel() == "position x [m]"
    for unit in ("kg", "N s/m", "N/m"):
        assert unit in right.get_title(loc="left")
    assert case in left.get_title(loc="left").lower()


def test_envelope_of_the_underdamped_response_touches_it_and_is_never_crossed() -> None:
    _, right = figures.figure_35()
    envelope, x = curve(right, "envelope")[1], np.abs(curve(right, "underdamped")[1])
    gap = (envelope - x) / envelope
    assert (gap >= -1e-12).all()
    # −x is a cosine of ωt − 0.253 with ω = 1.936 1/s: it touches at 0.13 s and every 1.62 s from
    # there, seven times in ten seconds. Half a sample of 0.02 s off a touch, the gap is 1 −
    # cos(0.019) < 2e-4.
    touching = (gap[1:-1] < 2e-4) & (gap[1:-1] <= gap[:-2]) & (gap[1:-1] <= gap[2:])
    assert np.count_nonzero(touching) == 7


def test_figure_36_compares_with_the_other_two() -> None:
    _, right = figures.figure_36()
    np.testing.assert_array_equal(
        curve(right, "overdamped"), curve(figures.figure_34()[1], "overdamped")
    )
    np.testing.assert_array_equal(
        curve(right, "underdamped"), curve(figures.figure_35()[1], "underdamped")
    )


def test_figure_40_shows_one_error_and_two_forces() -> None:
    """The error is −(critical response) worked out by hand for kp = 16.

    (1 + (4 + π/2) t) e^{−4t}, from e0 = 1 and e0' = π/2.
    """
    _, *panels = figures.figure_40()
    forces = []
    for position, error, force in (panels[:3], panels[3:]):
        t, e = curve(error, "simulated")
        np.testing.assert_allclose(
            e, (1.0 + (4.0 + np.pi / 2.0) * t) * np.exp(-4.0 * t), rtol=0.0, atol=1e-8
        )
        marks, expected = curve(error, "eq. 4.18")
        np.testing.assert_allclose(expected, np.interp(marks, t, e), rtol=0.0, atol=1e-8)
        desired, x = curve(position, "desired, $x_d$")[1], curve(position, "x")[1]
        np.testing.assert_allclose(desired, np.sin(np.pi / 2.0 * t), rtol=0.0, atol=1e-15)
        np.testing.assert_allclose(x, desired - e, rtol=0.0, atol=1e-15)
        assert (position.get_ylabel(), error.get_ylabel()) == ("position [m]", "error e [m]")
        assert (force.get_xlabel(), force.get_ylabel()) == ("time t [s]", "force F [N]")
        forces.append(curve(force, "F")[1])
        low, high = force.get_ylim()
        assert low < forces[-1].min() < forces[-1].max() < high
    # Once the error is gone, F = m x_d'' + b x_d' + k x_d or k x_d³.
    t = curve(panels[0], "x")[0]
    late = t > 5.0
    x, v, a = (
        np.sin(np.pi / 2 * t),
        np.pi / 2 * np.cos(np.pi / 2 * t),
        -(np.pi**2) / 4 * np.sin(np.pi / 2 * t),
    )
    np.testing.assert_allclose(forces[0][late], (a + v + 20.0 * x)[late], rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(forces[1][late], (a + v + 20.0 * x**3)[late], rtol=0.0, atol=1e-5)


def test_diagram_of_figure_40_names_every_block() -> None:
    words = {text.get_text() for text in figures.figure_40()[0].texts}
    assert {
        "$k_p$",
        "$k_v$",
        r"$\alpha(x)$",
        r"$\beta(x, \dot x)$",
        r"$m(x)\,\ddot x + f(x, \dot x) = F$",
        "$F$",
    } <= words
    assert {"servo (eq. 4.16)", "model (eq. 4.10)", "system (eq. 4.9)"} <= words


@pytest.mark.parametrize("number", list(FIGURES))
def test_figures_draw_into_the_axes_they_are_given(number: int) -> None:
    draw, count = FIGURES[number]
    figure = Figure(figsize=(12.0, 9.0), layout="constrained")
    axes = figure.subplots(count, 1) if count == 2 else figure.subplots(1, count)
    returned = draw(axes)
    assert list(returned) == list(axes)
    assert len(figure.axes) == count
    with pytest.raises(InvalidValue, match=f"axes must be {count} axes"):
        draw(axes[:1])


@pytest.mark.slow
@pytest.mark.parametrize("number", list(FIGURES))
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_is_inside_the_figure_and_does_not_lie_on_other_text(number: int, theme: str) -> None:
    """Bounding boxes from matplotlib's own renderer; one pixel is the rounding of the boxes."""
    with style(theme):
        figure = FIGURES[number][0]()[0].figure
        assert isinstance(figure, Figure)
        texts = []
        for axes in figure.axes:
            texts += [*axes.texts, *labels_of(axes)]
        assert check_texts(figure, texts) >= 7


def test_a_figure_saved_as_svg_twice_is_the_same_file() -> None:
    files = []
    for _ in range(2):
        file = BytesIO()
        figures.figure_34()[0].figure.savefig(file, format="svg", metadata={"Date": None})
        files.append(file.getvalue())
    assert files[0] == files[1]


def test_dark_theme_reaches_the_picture() -> None:
    light = pixels(figures.figure_34()[0].figure)  # type: ignore[arg-type]
    with style("dark"):
        dark = pixels(figures.figure_34()[0].figure)  # type: ignore[arg-type]
    assert light[0, 0].tolist() == [255, 255, 255, 255]
    assert dark[0, 0, :3].max() < 40
    assert np.median(dark[..., 0]) < 40


def test_drawing_leaves_pyplot_alone() -> None:
    """In a fresh process, because another test may have imported pyplot."""
    program = (
        "import sys; from psp3.thesis.chapter_4_figures import figure_40; figure_40(); "
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0

"""Figures: what stands on the axes, and whether the curves are the numbers they claim to be."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

import psp3
from fuzzy2.plots.style import style
from psp3 import plots
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control import records
from psp3.fuzzy_control.records import Record
from psp3.study import run as runs
from psp3.thesis import figures
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


def curve(axes: Axes, label: str) -> NDArray[np.float64]:
    """Return the data of the line with that label, (2, N)."""
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return np.array(line.get_data(), dtype=float)


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
        "import sys; from psp3.thesis.figures import figure_40; figure_40(); "
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


# Figures of chapters 5 and 6


@pytest.fixture(scope="module")
def record() -> Record:
    robot = psp3.load("psp3")
    return records.record(robot, psp3.trajectories.Helix(robot=robot), period=0.01)


@pytest.fixture(scope="module")
def controllers(record: Record) -> dict[tuple[str, int], psp3.FuzzyComputedTorque]:
    robot = psp3.load("psp3")
    return {
        (kind, terms): psp3.FuzzyComputedTorque(
            kind, robot, n_terms=terms, learner="strict", mean_variation=0.1
        ).learn(record)
        for kind in ("t1", "it2")
        for terms in (2, 3)
    }


@pytest.fixture(scope="module")
def result() -> psp3.Result:
    return runs.simulate_run(psp3.Run("t1", snr_db=20.0)).result


INPUT_LABELS = [
    r"$\Delta q_{12}$ [m]",
    r"$\Delta q_{13}$ [m]",
    r"$\Delta\dot{q}_{12}$ [m/s]",
    r"$\Delta\dot{q}_{13}$ [m/s]",
]


def test_figure_49_shows_the_recorded_inputs(record: Record) -> None:
    panels = figures.figure_49(record)
    assert [panel.get_ylabel() for panel in panels] == INPUT_LABELS
    assert [panel.get_xlabel() for panel in panels[2:]] == ["time t [s]"] * 2
    for panel, values in zip(panels, record.inputs.T, strict=True):
        t, shown = np.array(panel.lines[0].get_data(), dtype=float)
        assert (t[0], t[-1]) == (0.0, pytest.approx(10.4, abs=0.03))
        np.testing.assert_array_equal(shown, np.interp(t, record.t, values))


def test_figure_51_shows_footprints_above_and_their_middles_below(
    controllers: dict[tuple[str, int], psp3.FuzzyComputedTorque],
) -> None:
    """Against the Gaussians worked out here.

    Three means over the range, crossing at 1/2, moved by a tenth of the range.
    """
    type2 = controllers["it2", 3]
    above, below = figures.figure_51(type2, controllers["t1", 3])
    assert below.get_xlabel() == INPUT_LABELS[3]
    assert above.get_ylabel() == below.get_ylabel() == "membership u"
    low, high = type2.ranges_[:, 3]
    sigma = 0.5 * (high - low) / (2.0 * np.sqrt(2.0 * np.log(2.0)))
    for number, name in enumerate(("Low", "Mid", "High")):
        x, u = curve(below, name)
        mean = low + 0.5 * number * (high - low)
        np.testing.assert_allclose(
            u, np.exp(-0.5 * ((x - mean) / sigma) ** 2), rtol=0.0, atol=1e-12
        )
        upper, lower = (
            np.array(above.lines[2 * number + k].get_data(), dtype=float) for k in range(2)
        )
        reach = 0.1 * (high - low)
        nearest = np.maximum(np.abs(upper[0] - mean) - reach, 0.0)
        np.testing.assert_allclose(
            upper[1], np.exp(-0.5 * (nearest / sigma) ** 2), rtol=0.0, atol=1e-12
        )
        farthest = np.abs(lower[0] - mean) + reach
        np.testing.assert_allclose(
            lower[1], np.exp(-0.5 * (farthest / sigma) ** 2), rtol=0.0, atol=1e-12
        )
    assert [
        text.get_text()
        for text in above.get_legend().get_texts()  # type: ignore[union-attr]
    ] == ["Low", "Mid", "High"]


@pytest.mark.parametrize(("draw", "kind"), [(figures.figure_54, "t1"), (figures.figure_59, "it2")])
def test_terms_of_all_inputs_with_the_trained_range(
    draw: Callable[..., tuple[Axes, ...]],
    kind: str,
    controllers: dict[tuple[str, int], psp3.FuzzyComputedTorque],
) -> None:
    controller = controllers[kind, 2]
    panels = draw(controller)
    assert [panel.get_xlabel() for panel in panels] == INPUT_LABELS
    for number, panel in enumerate(panels):
        ends = [
            line.get_xdata()[0]  # type: ignore[index]
            for line in panel.lines
            if line.get_linestyle() == ":"
        ]
        assert ends == controller.ranges_[:, number].tolist()
        assert len(panel.collections) == (2 if kind == "it2" else 0)
        left, right = panel.get_xlim()
        assert left < ends[0] < ends[1] < right


@pytest.mark.parametrize("number", [55, 56, 57, 58, 60, 61, 62, 63])
def test_differences_solid_as_they_are_and_dashed_as_desired(
    number: int, result: psp3.Result
) -> None:
    panels = getattr(figures, f"figure_{number}")(result)
    assert [panel.get_ylabel() for panel in panels[:4]] == INPUT_LABELS
    assert [panel.get_xlabel() for panel in panels[2:4]] == ["time t [s]"] * 2
    figure = panels[0].figure
    assert isinstance(figure, Figure)
    title = figure.get_suptitle()
    assert title.startswith("Type-1" if number < 59 else "Type-2")
    assert title.endswith({0: "no noise", 1: "20 dB", 2: "15 dB", 3: "10 dB"}[(number - 55) % 5])
    a, v, desired = result.heights, result.speeds, result.desired
    columns = [a[:, 0] - a[:, 1], a[:, 0] - a[:, 2], v[:, 0] - v[:, 1], v[:, 0] - v[:, 2]]
    a, v = desired.heights, desired.speeds
    wanted = [a[:, 0] - a[:, 1], a[:, 0] - a[:, 2], v[:, 0] - v[:, 1], v[:, 0] - v[:, 2]]
    for panel, actual, aim in zip(panels[:4], columns, wanted, strict=True):
        for label, values, dashes in (("actual", actual, "-"), ("desired", aim, "--")):
            (line,) = (line for line in panel.lines if line.get_label() == label)
            assert line.get_linestyle() == dashes
            t, shown = np.array(line.get_data(), dtype=float)
            np.testing.assert_allclose(shown, np.interp(t, result.t, values), rtol=0.0, atol=1e-15)
    space: Any = panels[4]
    assert (space.get_xlabel(), space.get_ylabel(), space.get_zlabel()) == (
        "x [mm]",
        "y [mm]",
        "z [mm]",
    )
    for line, tip, dashes in zip(space.lines, (result.tip, desired.tip), ("-", "--"), strict=True):
        assert line.get_linestyle() == dashes
        np.testing.assert_allclose(np.transpose(line.get_data_3d())[0], 1e3 * tip[0], rtol=1e-12)


def test_a_run_that_ended_early_is_drawn_as_far_as_it_went() -> None:
    early = runs.simulate_run(psp3.Run("feed-forward")).result
    assert early.t[-1] < 10.0
    panels = plots.figure_of_differences(early, "lost")
    assert panels[0].get_xlim()[1] <= early.t[-1]


def test_every_figure_is_drawn_by_its_number_and_by_its_name(
    result: psp3.Result, controllers: dict[tuple[str, int], psp3.FuzzyComputedTorque]
) -> None:
    for number, draw in figures.FIGURES.items():
        assert getattr(figures, f"figure_{number}") is draw
        assert draw.__name__ == f"figure_{number}"
        assert f"Figure {number}" in str(draw.__doc__) or f"Fig. {number}" in str(draw.__doc__)
    for number, subject, title in (
        (34, (), ""),
        (53, (result,), "Computed torque: the start from rest dies out"),
        (57, (result,), "Type-1, 15 dB"),
        (54, (controllers["t1", 2],), "Terms of the type-1 controller"),
        (
            59,
            (controllers["it2", 2],),
            "Terms of the type-2 controller, means ± 0.10 of the range",
        ),
    ):
        figure = figures.figure(number, *subject)[0].figure
        assert isinstance(figure, Figure)
        assert figure.get_suptitle() == title
    given = Figure().subplots(1, 2)
    assert figures.figure(35, axes=given) == tuple(given)


def test_a_number_without_a_figure_is_refused_with_those_there_are() -> None:
    with pytest.raises(UnknownName, match=r"unknown figure 50; known are 34, 35, 36, 40, 49, 51"):
        figures.figure(50)


def test_figure_64_sets_levels_in_order_of_noise_with_intervals_and_the_printed_ratios() -> None:
    ratios = {
        "one": {20.0: (2.0, 1.5, 3.0), np.inf: (1.0, np.nan, np.nan)},
        "other": {20.0: (0.8, 0.6, 0.9)},
    }
    (panel,) = figures.figure_64(ratios, {np.inf: 1.0, 20.0: 2.0, 10.0: 4.0})
    assert [label.get_text() for label in panel.get_xticklabels()] == ["∞", "20", "10"]
    assert "dB" in panel.get_xlabel()
    assert "type-1 over type-2" in panel.get_ylabel()
    printed = curve(panel, "printed")
    np.testing.assert_array_equal(printed, [[0.0, 1.0, 2.0], [1.0, 2.0, 4.0]])
    bars = {container.get_label(): container for container in panel.containers}
    assert list(bars) == ["one", "other"]
    segments = bars["one"].lines[2][0].get_segments()  # type: ignore[attr-defined]
    np.testing.assert_allclose(segments[0][:, 1], [1.5, 3.0])
    # Series stand beside one another, each near its level.
    x, y = (
        np.array(bars[name].lines[0].get_data(), dtype=float)  # type: ignore[attr-defined]
        for name in ("one", "other")
    )
    assert abs(x[0, 0] - 1.0) < 0.2
    assert x[0, 0] != y[0, 0]


@pytest.mark.parametrize(
    "draw", [figures.figure_64, lambda series: plots.figure_of_sweep(series, "setting")]
)
def test_no_series_is_refused(draw: Callable[..., tuple[Axes, ...]]) -> None:
    with pytest.raises(InvalidValue, match="at least one series"):
        draw({})


def test_new_figures_draw_into_the_axes_they_are_given(
    record: Record,
    result: psp3.Result,
    controllers: dict[tuple[str, int], psp3.FuzzyComputedTorque],
) -> None:
    one, two = controllers["t1", 2], controllers["it2", 2]
    series = {"a": {20.0: (2.0, 1.0, 3.0)}}
    cases: list[tuple[int, Callable[[Any], tuple[Axes, ...]]]] = [
        (4, lambda axes: figures.figure_49(record, axes)),
        (2, lambda axes: figures.figure_51(two, one, axes)),
        (4, lambda axes: figures.figure_54(one, axes)),
        (4, lambda axes: figures.figure_59(two, axes)),
        (1, lambda axes: figures.figure_64(series, axes=axes)),
        (1, lambda axes: plots.figure_of_sweep(series, "setting", axes)),
    ]
    for count, draw in cases:
        figure = Figure(figsize=(12.0, 9.0), layout="constrained")
        axes = np.ravel(figure.subplots(1, count))
        assert list(draw(axes)) == list(axes)
        assert len(figure.axes) == count
        with pytest.raises(InvalidValue, match=f"axes must be {count} axes"):
            draw([*axes, axes[0]])
    with pytest.raises(InvalidValue, match="axes must be 5 axes"):
        figures.figure_55(result, [])


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_of_new_figures_is_inside_and_does_not_lie_on_other_text(
    theme: str,
    record: Record,
    result: psp3.Result,
    controllers: dict[tuple[str, int], psp3.FuzzyComputedTorque],
) -> None:
    """As above: bounding boxes from matplotlib's own renderer; one pixel is their rounding."""
    series = {
        "strongest sample": {np.inf: (1.0, np.nan, np.nan), 20.0: (2.0, 1.0, 3.0)},
        "ridge": {20.0: (0.7, 0.5, 1.0)},
    }
    with style(theme):
        for panels in (
            figures.figure_49(record),
            figures.figure_51(controllers["it2", 3], controllers["t1", 3]),
            figures.figure_54(controllers["t1", 2]),
            figures.figure_59(controllers["it2", 2]),
            figures.figure_56(result),
            figures.figure_64(series, {np.inf: 1.0, 10.0: 4.0}),
            plots.figure_of_sweep(series, "setting"),
        ):
            figure = panels[0].figure
            assert isinstance(figure, Figure)
            check_texts(figure, [text for axes in figure.axes for text in labels_of(axes)])

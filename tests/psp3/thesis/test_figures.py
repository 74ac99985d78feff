"""Figures of chapters 5 and 6.

What stands on the axes, and whether the curves are the numbers they claim to be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import psp3
from fuzzy2.plots.style import style
from psp3 import plots
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control import records
from psp3.fuzzy_control.records import Record
from psp3.study import execution as runs
from psp3.thesis import figures
from tests.fuzzy2.plots.drawn import curve
from tests.legible import check_texts, labels_of


@pytest.fixture(autouse=True)
def _styled() -> Iterator[None]:
    with style():
        yield


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


@pytest.mark.slow
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_of_new_figures_is_inside_and_does_not_lie_on_other_text(
    theme: str,
    record: Record,
    result: psp3.Result,
    controllers: dict[tuple[str, int], psp3.FuzzyComputedTorque],
) -> None:
    """Bounding boxes from matplotlib's own renderer; one pixel is their rounding."""
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

"""The figures of the report.

Each is drawn by its function in :mod:`psp3.plots`, saved, and described in words.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from fuzzy2.support.text_files import written_whole
from psp3 import published
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import INPUT_NAMES, record
from psp3.plots import study
from psp3.plots.panels import Panels
from psp3.simulation.metrics import largest_tip_error, sum_of_squared_errors
from psp3.simulation.result import Result
from psp3.study.intervals import coverage_in_words
from psp3.thesis import figures, opening
from psp3.thesis.findings import Drawing, significant
from psp3.thesis.machine import figure_of_machine
from psp3.thesis.plan import NOISY, Plan, Series, count, decibels
from psp3.three_psp.robot import PSP3
from psp3.trajectories.paths import Helix

TEN_PERCENT = 20.0
"""Signal-to-noise ratio of Figure 51, 10 % of the amplitude [dB]."""

_LINES = "Solid: actual, dashed: desired."


def draw_all(
    robot: PSP3,
    results: Mapping[str, Result],
    seed: int,
    curves: Mapping[str, Series],
    plan: Plan,
    directory: Path,
) -> Iterator[Drawing]:
    """Draw the machine, the result, Figures 49 and 51 to 64, and the sweep of the mean variation.

    Parameters
    ----------
    robot : PSP3
        The robot.
    results : mapping of Result
        ``"PD"``, ``"CTC"``, and ``"type-1, 20 dB"`` and the like.
    seed : int
        Seed of the noise in the results of fuzzy controllers.
    curves : mapping of Series
        ``"result"``, ``"figure_64"`` and ``"mean_variation"``.
    plan : Plan
        Plan whose seeds are behind the curves.
    directory : path
        Where the SVG files go.

    Yields
    ------
    Drawing
        Each figure after it was saved.
    """

    def saved(name: str, panels: Panels, caption: str, description: str) -> Drawing:
        path = directory / f"{name}.svg"
        figure = panels[0].get_figure(root=True)
        assert figure is not None
        with written_whole(path, "wb") as file:
            figure.savefig(file, format="svg", metadata={"Date": None})
        return Drawing(path, caption, description)

    yield saved(
        "machine",
        figure_of_machine(robot),
        "The 3-PSP robot. Three motors turn three upright screws; on each a nut moves up and down, "
        "at the heights a₁, a₂ and a₃ [m]. Through a ball joint each nut guides an arm of the "
        "star, which carries the tool.",
        "Three upright screws stand on a base. The orange star lies across them, tilted a little, "
        "and each of its arms slides in a ball at one of the nuts.",
    )
    lines = {label: sum_of_squared_errors(results[name]) for name, label in opening.LINES.items()}
    yield saved(
        "result",
        opening.figure_of_result(curves["result"], lines),
        "The result: the error of fuzzy controllers that learn from noisy records, means with 95 % "
        f"intervals ({count(plan.seeds)}), beside two controllers that do not learn. Rules keep "
        "the sample that fires them most, or average all samples. A signal-to-noise ratio of "
        "S dB means noise with an amplitude of 10^(−S/20) times the root mean square of the "
        "recorded quantity. Lower is better.",
        "; ".join(
            f"{name}: "
            + ", ".join(
                f"{significant(value)} at {decibels(snr)} dB"
                for snr, (value, _, _) in points.items()
            )
            for name, points in curves["result"].items()
        )
        + f" m². {', '.join(f'{name}: {significant(value)} m²' for name, value in lines.items())}.",
    )

    recorded = record(robot, Helix(robot=robot))
    ranges = ", ".join(
        f"{name} from {low:.3f} to {high:.3f}"
        for name, low, high in zip(
            INPUT_NAMES, recorded.inputs.min(axis=0), recorded.inputs.max(axis=0), strict=True
        )
    )
    yield saved(
        "figure_49",
        figures.figure_49(recorded),
        "Figure 49: the four inputs of the estimators, while crisp computed torque tracks the "
        "helix. The rules are learned from samples of this run.",
        f"Four curves over 10.4 s, periodic in two seconds: {ranges}, in m and m/s.",
    )

    three = {
        kind: FuzzyComputedTorque(kind, robot, n_terms=3, learner="strict", snr_db=TEN_PERCENT)
        for kind in ("it2", "t1")
    }
    for controller in three.values():
        controller.learn(recorded, rng=np.random.default_rng(0))
    yield saved(
        "figure_51",
        figures.figure_51(three["it2"], three["t1"]),
        f"Figure 51: three terms of {INPUT_NAMES[3]} at 10 % noise ({TEN_PERCENT:g} dB): "
        "footprints of uncertainty of the type-2 terms, means ± "
        f"{three['it2'].mean_variation:.2f} of the range, and the same terms reduced to type-1. "
        "Dotted: the trained range.",
        "Two panels. Above: Low, Mid and High as shaded bands between a lower and an upper "
        "membership function, which overlap widely. Below: three Gaussian curves that cross at "
        "one half.",
    )

    for number, key, words in (
        (
            52,
            "PD",
            "The heights lag by the sag under gravity, the speeds agree.",
        ),
        (
            53,
            "CTC",
            (
                "The error of the start from rest dies out within about ten seconds at the "
                "thesis's gains."
            ),
        ),
    ):
        yield saved(
            f"figure_{number}",
            figures.figure(number, results[key]),
            f"Figure {number}: {key}. Heights and speeds of the three nuts and the path of "
            f"the tip. {_LINES} {words}",
            f"Three panels of heights, three of speeds and the helix of the tip under {key}. "
            f"{_in_words(results[key])}",
        )

    two = {kind: FuzzyComputedTorque(kind, robot, snr_db=TEN_PERCENT) for kind in ("t1", "it2")}
    for controller in two.values():
        controller.learn(recorded, rng=np.random.default_rng(0))
    first = {"t1": 55, "it2": 60}
    for kind, label in (("t1", "type-1"), ("it2", "type-2")):
        terms = first[kind] - 1
        shape = (
            "two Gaussian curves"
            if kind == "t1"
            else "two shaded bands, each between a lower and an upper membership function"
        )
        yield saved(
            f"figure_{terms}",
            figures.figure(terms, two[kind]),
            f"Figure {terms}: membership functions of the inputs of the {label} controller"
            f"{'' if kind == 't1' else f' at {TEN_PERCENT:g} dB'}. Dotted: the trained range.",
            f"Four panels, one for each of {', '.join(INPUT_NAMES)}, each with {shape}, Low and "
            "High, crossing in the middle of the range.",
        )
        for number, snr in enumerate((math.inf, *NOISY), start=first[kind]):
            result = results[f"{label}, {decibels(snr)} dB"]
            noise = (
                "rules learned without noise"
                if math.isinf(snr)
                else f"rules learned at {snr:g} dB, seed {seed}"
            )
            yield saved(
                f"figure_{number}",
                figures.figure(number, result),
                f"Figure {number}: {label} fuzzy controller, {noise}: the four differences and "
                f"the path of the tip. {_LINES} Sum of squared errors of this run: "
                f"{significant(sum_of_squared_errors(result))} m²."
                + (
                    ""
                    if math.isinf(snr)
                    else " Of all seeds this one comes nearest to the medians."
                ),
                f"Four panels over time and the path of the tip in space. {_in_words(result)}",
            )

    printed = {snr: one / other for snr, (one, other) in published.TABLE_6_3_FUZZY.items()}
    yield saved(
        "figure_64",
        figures.figure_64(curves["figure_64"], printed),
        "Figure 64: squared error of type-1 over that of type-2, ratios of means with 95 % "
        "intervals, for three learners, and as printed. Above one, type-2 is better. "
        f"{count(plan.seeds)}, without those with which one of the two diverged; "
        f"{coverage_in_words('ratio of means', seeds=plan.seeds)}.",
        "; ".join(
            f"{name}: "
            + ", ".join(
                f"{value:.2f} at {decibels(snr)} dB" for snr, (value, _, _) in points.items()
            )
            for name, points in {
                **curves["figure_64"],
                "printed": {snr: (ratio, 0.0, 0.0) for snr, ratio in printed.items()},
            }.items()
        )
        + ".",
    )
    yield saved(
        "mean_variation",
        study.figure_of_sweep(
            curves["mean_variation"], "mean variation, share of each input's range"
        ),
        "Sum of squared errors against the mean variation of the type-2 terms; 0 is type-1. "
        f"Means with 95 % intervals. {count(plan.sweep_seeds)}, without the runs that diverged; "
        f"{coverage_in_words('mean', seeds=plan.sweep_seeds)}.",
        "; ".join(
            f"{name}: "
            + ", ".join(
                f"{significant(value)} at {variation:g}"
                for variation, (value, _, _) in points.items()
            )
            for name, points in curves["mean_variation"].items()
        )
        + " m².",
    )


def _in_words(result: Result) -> str:
    return (
        "The greatest distance of the tip from its desired path is "
        f"{1e3 * largest_tip_error(result):.0f} mm."
    )

"""The opening of the report: one sentence, the curves of one figure, and the table of verdicts.

All of it is generated from the numbers that the other modules found, and changes with them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

from fuzzy2.plots.names import literal
from psp3.plots.panels import Panels
from psp3.plots.study import error_bars
from psp3.study.run import Run
from psp3.thesis.chapter_6 import REASONS, reason_of_noise
from psp3.thesis.findings import Reproduction, Table, significant, verdict
from psp3.thesis.plan import ERROR, NOISY, Outcomes, Plan, Series, count, decibels, listed

MARKERS = ("o", "s", "^", "D", "v")

LINES = {"PD": "PD", "CTC": "exact computed torque"}
"""Names in the figure of controllers that do not learn."""


def errors_of_result(results: Outcomes, plan: Plan) -> Series:
    """Return the mean errors of the figure of the result, by signal-to-noise ratio [dB]."""
    widest = plan.widths[-1]
    series = {
        "type-1": Run("t1"),
        "type-2": Run("it2"),
        f"type-1, terms {widest:g} times as wide": Run("t1", term_width=widest),
        "type-1, rules that average": Run("t1", learner="average"),
        "type-2, rules that average": Run("it2", learner="average"),
    }
    found: Series = {}
    for name, run in series.items():
        means = {
            snr: results.mean(replace(run, snr_db=snr), plan.seeds) for snr in plan.sweep_levels
        }
        found[name] = {snr: (one.value, one.low, one.high) for snr, one in means.items()}
    return found


def figure_of_result(
    errors: Mapping[str, Mapping[float, tuple[float, float, float]]], lines: Mapping[str, float]
) -> Panels:
    """Draw the errors of the fuzzy controllers against the noise, and two lines to compare with.

    Parameters
    ----------
    errors : mapping of str to mapping of float to (value, low, high)
        For each controller, by its name, the mean error and its interval [m²] at every
        signal-to-noise ratio [dB].
    lines : mapping of str to float
        Errors that no noise changes [m²], by name.

    Returns
    -------
    tuple of Axes
        The one panel.
    """
    panel = Figure(figsize=(4.8, 4.8), layout="constrained").subplots()
    levels = list(next(iter(errors.values())))
    for place, (name, points) in enumerate(errors.items()):
        value, low, high = np.array(list(points.values())).T
        panel.errorbar(
            [at + 0.12 * (place - 0.5 * (len(errors) - 1)) for at in range(len(levels))],
            value,
            error_bars(value, low, high),
            linestyle="none",
            marker=MARKERS[place % len(MARKERS)],
            capsize=3.0,
            label=literal(name),
        )
    for name, value in lines.items():
        panel.axhline(value, linestyle="--", linewidth=1.0, color=rcParams["text.color"])
        panel.annotate(
            name,
            (len(levels) - 0.5, value),
            xytext=(-2, -4),
            textcoords="offset points",
            ha="right",
            va="top",
        )
    panel.set_xticks(range(len(levels)), [f"{decibels(snr)} dB" for snr in levels])
    panel.set(
        yscale="log",
        xlabel="signal-to-noise ratio, noise grows to the right",
        ylabel="sum of squared errors [m²]",
        xlim=(-0.5, len(levels) - 0.5),
    )
    # Room for the name below the lowest line.
    panel.set_ylim(bottom=0.5 * panel.get_ylim()[0])
    panel.legend(
        ncols=2,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        frameon=False,
        columnspacing=1.0,
        handletextpad=0.2,
    )
    return (panel,)


def opening(plan: Plan, outcome: Reproduction) -> None:
    """Add the sentence that the report opens with and, before all others, the table of verdicts."""
    outcome.sentence = _sentence(plan, outcome.numbers)
    rows = [
        *_rows_of_errors(outcome.numbers),
        *_rows_of_ratios(plan, outcome.numbers),
        _row_of_time(outcome.numbers),
        *_rows_of_dynamics(outcome.numbers),
    ]
    table = Table(
        "What the thesis prints, and what comes out here",
        ["what", "printed", "computed", "verdict and reason"],
        rows,
        "An error is the sum of the squared errors of the three nut heights, one sample every "
        f"0.05 s [m²]. PD is a proportional-derivative controller; computed torque (CTC) uses the "
        "robot's equation of motion, M(a) ä + C(a, ȧ) ȧ + G(a) = τ, with a the heights of the "
        "nuts, M the mass matrix, C the Coriolis matrix, G the forces of gravity and τ those of "
        "the screws. The fuzzy controllers estimate M, C and G by rules that they learn from "
        "noisy records. The membership functions of their inputs are called terms. A type-2 term "
        "has an uncertain mean, known to ± the mean variation, a share of the input's range. At a "
        "signal-to-noise ratio (SNR) of S dB the noise has an amplitude of 10^(−S/20) times a "
        "reference, here the root mean square of each entry. Fuzzy errors are means over "
        f"{count(plan.seeds)}, each one draw of the noise, without the runs that diverged. Same "
        "order: within a factor of three.",
        opening=True,
    )
    outcome.tables.insert(0, table)


def _sentence(plan: Plan, numbers: Mapping[str, Any]) -> str:
    """Return the result for a reader who knows neither the robot nor the thesis."""
    definitions = numbers["definitions"]
    won = [
        all(entry["verdict"] == "type-2 better" for entry in by_level.values())
        for by_level in definitions.values()
    ]
    wide = numbers["wider_type_1_terms"]
    widest = f"{plan.widths[-1]:g}"
    wider = all(
        wide[decibels(snr)][widest]["value"] < wide[decibels(snr)]["it2"]["value"]
        for snr in plan.sweep_levels
    )
    exact = numbers["table_6_3"]["CTC"][ERROR]
    best = min(
        entry["mean"]["value"]
        for by_kind in numbers["table_6_3"]["fuzzy"].values()
        for entry in by_kind.values()
        if not math.isnan(entry["mean"]["value"])
    )
    return (
        "When fuzzy rules learn the robot's dynamics from noisy data, type-2 tracks a path better "
        f"than type-1 under {sum(won)} of {len(won)} definitions of the noise"
        + ("; type-1 with wider membership functions tracks better still" if wider else "")
        + (
            "; the exact equations of motion, which need no learning, track best."
            if exact < best
            else "; the exact equations of motion do not track better than the best of them."
        )
    )


def _rows_of_errors(numbers: Mapping[str, Any]) -> list[list[str]]:
    table = numbers["table_6_3"]
    rows = []
    for name, label in (("PD", "error under PD [m²]"), ("CTC", "error under computed torque [m²]")):
        printed, computed = table[name]["printed_sum_of_squared_errors"], table[name][ERROR]
        words = verdict(computed, printed, reason=REASONS[name], fitted=name == "PD")
        rows.append([label, f"{printed:.4f}", significant(computed), words])
    for snr in (math.inf, *NOISY):
        for kind, label in (("t1", "type-1"), ("it2", "type-2")):
            entry = table["fuzzy"][decibels(snr)][kind]
            where = "without noise" if math.isinf(snr) else f"at {snr:g} dB"
            computed, printed = entry["mean"]["value"], entry["printed"]
            words = verdict(computed, printed, reason=reason_of_noise(snr))
            rows.append(
                [f"error of {label} {where} [m²]", f"{printed:.4f}", significant(computed), words]
            )
    return rows


def _rows_of_ratios(plan: Plan, numbers: Mapping[str, Any]) -> list[list[str]]:
    found = numbers["type_2_against_type_1"]
    words = [entry["verdict"] for entry in found.values()]
    ratios = {
        name: listed([f"{value:.2f}" for value in values])
        for name, values in (
            ("printed", [entry["printed_ratio"] for entry in found.values()]),
            ("computed", [entry["ratio"]["value"] for entry in found.values()]),
        )
    }
    said = (
        words[0]
        if len(set(words)) == 1
        else "; ".join(f"{level} dB: {word}" for level, word in zip(found, words, strict=True))
    )
    return [
        [
            f"error of type-2 over type-1 at {listed(list(found))} dB",
            ratios["printed"],
            ratios["computed"],
            f"{said}: by the difference of the means over {count(plan.seeds)}; printed numbers "
            "are one run each",
        ]
    ]


def _row_of_time(numbers: Mapping[str, Any]) -> list[str]:
    step = numbers["table_6_2"]["CTC, closed_form"]
    printed, median = step["printed"], step["median"]
    return [
        "time of one step of computed torque [ms]",
        f"{1e3 * printed:g}",
        f"{1e3 * median:.4f}",
        f"not reproduced: {printed / median:,.0f} times faster, in closed form and on a newer "
        "computer",
    ]


def _rows_of_dynamics(numbers: Mapping[str, Any]) -> list[list[str]]:
    table = numbers["table_5_1"]
    return [
        [
            "M of Table 5.1, largest difference [kg]",
            "–",
            f"{table['largest_mass_error']:.4f}",
            "matched by a fit: the masses were chosen to match this table",
        ],
        [
            "C of Table 5.1, column sums off the rate of M's [kg/s]",
            "–",
            f"{table['printed_coriolis_column_sum_gap']:.3f}",
            "not reproducible: the printed C contradicts the printed M",
        ],
    ]

"""The numbers of chapter 6: Tables 6.1 to 6.3, and the comparisons that the thesis never showed.

The runs come from one study, :class:`Plan`. Every function here adds a table, its numbers and a
sentence of the answer to a :class:`~psp3.thesis.findings.Reproduction`. All sentences are generated
from the runs and change with their numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from psp3 import published
from psp3.control.classical import PD, PID, ComputedTorque
from psp3.errors import SimulationDiverged
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.published import DURATION, THESIS_SAMPLING_PERIOD
from psp3.simulation.metrics import (
    integral_of_squared_error,
    largest_tip_error,
    rms_error,
    sum_of_squared_errors,
)
from psp3.simulation.tracking import simulate
from psp3.study import statistics
from psp3.study.intervals import coverage_in_words
from psp3.study.latency import Latency
from psp3.study.run import Run
from psp3.thesis.findings import (
    Reproduction,
    Table,
    as_numbers,
    significant,
    verdict,
    with_interval,
)
from psp3.thesis.plan import (
    ERROR,
    FUZZY,
    LABELS,
    NOISY,
    Outcomes,
    Plan,
    count,
    decibels,
    listed,
    percent,
    with_share,
)
from psp3.three_psp.robot import PSP3
from psp3.trajectories.paths import Helix

REASONS = {
    "PD": "the length of the run was chosen to match it",
    "CTC": "all of it is the start of the run, which the thesis does not describe",
}
"""Reasons why errors of classical controllers agree with the printed ones, or do not."""


def reason_of_noise(snr_db: float) -> str:
    """Return why errors of fuzzy controllers do not agree with the printed ones."""
    if math.isinf(snr_db):
        return "the thesis names neither its path nor its sampling"
    return "the thesis does not say what its noise is relative to"


def table_6_1(robot: PSP3, outcome: Reproduction) -> None:
    """Add Table 6.1: the default gains of this package."""
    fuzzy = {kind: FuzzyComputedTorque(kind, robot) for kind in ("t1", "it2")}
    used: dict[str, PD | ComputedTorque | FuzzyComputedTorque]
    used = {
        "PD": PD(),
        "CTC": ComputedTorque(robot),
        "T1 fuzzy CTC": fuzzy["t1"],
        "T2 fuzzy CTC": fuzzy["it2"],
    }
    rows, levels = [], ", ".join(decibels(snr) for snr in published.TABLE_6_1_SNR)
    for name, controller in used.items():
        gains = (controller.kp, controller.kv)
        same, tail, more = gains == published.TABLE_6_1[name], "", ""
        if isinstance(controller, FuzzyComputedTorque):
            same &= controller.n_terms == published.TABLE_6_1_TERMS and set(
                published.TABLE_6_1_SNR
            ) == {math.inf, *NOISY}
            tail, more = (
                f"; SNR {levels} dB; {published.TABLE_6_1_TERMS} terms",
                f"; {controller.n_terms} terms",
            )
        printed = "{:g} / {:g}".format(*published.TABLE_6_1[name])
        rows.append(
            [
                name,
                printed + tail,
                f"{gains[0]:g} / {gains[1]:g}{more}",
                "as printed" if same else "not as printed",
            ]
        )
    outcome.tables.append(
        Table(
            "Table 6.1: gains and settings",
            ["controller", "printed: kp / kv", "used", "verdict"],
            rows,
            "The gains of PD are in N/m and N s/m. Those of the others are in 1/s² and 1/s, "
            "because their model turns the robot into a unit mass. kp = 10 and kv = 1 are soft, a "
            "natural frequency of 0.5 Hz with a damping ratio of 0.16, so the servo hides no "
            "error of the model. PD relies on stiffness instead.",
            detail=True,
        )
    )


def table_6_2(latencies: Mapping[str, Latency], outcome: Reproduction) -> None:
    """Add Table 6.2: how long a step takes."""
    names = {
        "PD": ("PD", "PD"),
        "CTC, noc": ("CTC, natural orthogonal complement", "CTC"),
        "CTC, pinocchio": ("CTC, Pinocchio", "CTC"),
        "CTC, closed_form": ("CTC, closed form", "CTC"),
        "t1": ("type-1", "T1 fuzzy CTC"),
        "it2": ("type-2", "T2 fuzzy CTC"),
        "gt2": ("general type-2", ""),
    }
    rows, numbers = [], {}
    for name, latency in latencies.items():
        label, printed_name = names[name]
        printed = published.TABLE_6_2.get(printed_name)
        numbers[name] = {**latency._asdict(), "printed": printed}
        times = [f"{1e3 * value:.4f}" for value in latency[1:]]
        fits = (
            "within 2 ms"
            if latency.worst <= published.STEP_BUDGET
            else "median within 2 ms, not every step"
        )
        fits = fits if latency.median <= published.STEP_BUDGET else "not within 2 ms"
        if printed is None:
            words = f"not in the thesis; {fits}"
        elif name == "PD":
            words = (
                f"{'reproduced: less than' if latency.median < printed else 'not reproduced: over'}"
                f" the printed bound; {fits}"
            )
        else:
            words = (
                f"not reproduced: {printed / latency.median:,.0f} times faster, on a newer "
                f"computer; {fits}"
            )
        shown = "–" if printed is None else f"{'< ' if name == 'PD' else ''}{1e3 * printed:g}"
        rows.append([label, shown, *times, words])
    outcome.numbers["table_6_2"] = numbers
    exact, noc, it2 = (latencies[name] for name in ("CTC, closed_form", "CTC, noc", "it2"))
    errors = outcome.numbers["table_6_3"]
    better_exact = (
        errors["CTC"][ERROR] < errors["fuzzy"][decibels(math.inf)]["it2"]["mean"]["value"]
    )
    closer = ", and tracks better than every estimate learned by default" if better_exact else ""
    order = [latencies[name].median for name in ("PD", "t1", "it2", "CTC, noc")]
    outcome.tables.append(
        Table(
            "Table 6.2: time of one control step",
            [
                "controller",
                "printed [ms]",
                "median [ms]",
                "99 % [ms]",
                "99.9 % [ms]",
                "worst [ms]",
                "verdict",
            ],
            rows,
            "Each call of controller.torque from Python is timed on its own, on states along the "
            f"helix, after a warm-up: {noc.steps:,} calls of the models that take milliseconds "
            f"and {exact.steps:,} of the others. The times depend on this machine; percentiles "
            "above the median measure the machine as much as the controller. The thesis used a "
            "Pentium 4 of 3 GHz and had a budget of 2 ms. Its premise was that exact computed "
            "torque cannot run in real time and must be estimated. The same equations take "
            f"{1e3 * noc.median:.1f} ms through the natural orthogonal complement in Python, with "
            "the loops closed in every call by Newton's method from home, as in the thesis's "
            f"255 ms. In closed form they take {1e6 * exact.median:.0f} µs: "
            f"{published.TABLE_6_2['CTC'] / exact.median:,.0f} times less than printed, and "
            f"{published.STEP_BUDGET / exact.median:.0f} times within the budget. The fuzzy "
            f"estimate takes {1e6 * it2.median:.0f} µs, {it2.median / exact.median:.1f} times "
            "the exact one, so time is no longer a reason to estimate M, C and G. The printed "
            "order, PD, type-1, type-2, CTC, "
            f"{'holds' if order == sorted(order) else 'does not hold'} with the CTC of the "
            "thesis.",
        )
    )
    outcome.answer.append(
        "The reason to estimate M, C and G is gone: in the thesis a step of exact computed torque "
        f"took 255 ms. In closed form it takes {1e6 * exact.median:.0f} µs from Python "
        f"(type-2: {1e6 * it2.median:.0f} µs), on a budget of 2 ms{closer}."
    )


def table_6_3(robot: PSP3, results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add Table 6.3: the tracking errors of all controllers.

    For the reading ``parameters`` and the default learner.
    """
    tracked = {name: outcome.results[name] for name in ("PD", "CTC", "PD with gravity")}
    tracked["PID"] = simulate(robot, PID(), Helix(robot=robot), DURATION)
    rows: list[list[str]] = []
    numbers: dict[str, Any] = {}
    for name, result in tracked.items():
        squares, printed, tip = (
            sum_of_squared_errors(result),
            published.TABLE_6_3.get(name),
            largest_tip_error(result),
        )
        numbers[name] = {
            ERROR: squares,
            "printed_sum_of_squared_errors": printed,
            "integral_of_squared_error": integral_of_squared_error(result),
            "rms_error": rms_error(result),
            "largest_tip_error": tip,
            "largest_torque": float(np.abs(result.torque).max()),
        }
        shown, words = (
            ("–", "not in the thesis")
            if printed is None
            else (
                f"{printed:.4f}",
                verdict(squares, printed, reason=REASONS[name], fitted=name == "PD"),
            )
        )
        rows.append([name, "–", shown, f"{squares:.4f}", "–", f"{1e3 * tip:.0f}", words])
    numbers["PD"]["sag"] = _sag(robot)
    numbers["PD with the gains of CTC"] = _soft_pd(robot)
    fuzzy: dict[str, Any] = {}
    ends: list[list[str]] = []
    for snr in (math.inf, *NOISY):
        at = fuzzy[decibels(snr)] = {}
        for kind, old in zip(FUZZY, (*published.TABLE_6_3_FUZZY[snr], None), strict=True):
            run = Run(kind, snr_db=snr)
            average, median = (
                results.mean(run, plan.seeds),
                statistics.median(results.values(run, plan.seeds)),
            )
            tip = results.mean(run, plan.seeds, "largest_tip_error").value
            # Without noise there is no spread of runs, so the printed number is compared directly.
            spread = None if math.isinf(snr) else results.spread(run, plan.seeds)
            diverged, left, coverage = (
                results.average(run, plan.seeds, name)
                for name in ("diverged", "left_stroke", "coverage")
            )
            at[kind] = {
                "mean": as_numbers(average),
                "median": as_numbers(median),
                "diverged": diverged,
                "left_stroke": left,
                "printed": old,
                "spread": spread,
                "coverage": coverage,
                "largest_tip_error": tip,
                "values": results.values(run, plan.seeds).tolist(),
            }
            shown, words = "–", "not in the thesis"
            if old is not None:
                shown = f"{old:.4f}"
                words = verdict(average.value, old, spread, reason=reason_of_noise(snr))
                if kind == "it2" and math.isinf(snr):
                    words += "; type-1 by construction"
            mean = f"{average.value:.4f}" if math.isinf(snr) else with_share(average, diverged)
            rows.append(
                [
                    LABELS[kind],
                    decibels(snr),
                    shown,
                    mean,
                    "–" if spread is None else " to ".join(map(significant, spread)),
                    f"{1e3 * tip:.0f}" if np.isfinite(tip) else "–",
                    words,
                ]
            )
            if not math.isinf(snr):
                ends.append(
                    [
                        LABELS[kind],
                        decibels(snr),
                        with_interval(median),
                        *map(percent, (diverged, left, coverage)),
                    ]
                )
    t1, it2 = (results.values(Run(kind), 1)[0] for kind in ("t1", "it2"))
    numbers |= {"fuzzy": fuzzy, "gap_without_noise": abs(it2 - t1) / t1}
    outcome.numbers["table_6_3"] = numbers
    averaged = [
        results.mean(Run("t1", snr_db=snr, learner="average"), plan.seeds).value
        for snr in plan.sweep_levels
    ]
    kept = [results.mean(Run("t1", snr_db=snr), plan.seeds).value for snr in plan.sweep_levels]
    printed_rows = [published.TABLE_6_3_FUZZY[snr][0] for snr in plan.sweep_levels]
    between = all(
        low <= old <= high for low, old, high in zip(averaged, printed_rows, kept, strict=True)
    )
    outcome.tables += [
        Table(
            f"Table 6.3: sum of squared tracking errors, {count(plan.seeds)}",
            [
                "controller",
                "SNR [dB]",
                "printed [m²]",
                "mean (95 % interval) [m²]",
                "single runs, 2.5 to 97.5 % [m²]",
                "largest tip error [mm]",
                "verdict",
            ],
            rows,
            f"Helix of radius 20 mm, period 2 s, rise 10 mm/s, started at rest, {DURATION} s, "
            f"control at 2 ms; one sample every {THESIS_SAMPLING_PERIOD} s is summed. The thesis "
            "specifies neither its helix nor its sampling, so only orders of magnitude and the "
            "ranking can be compared. PD has no gravity term: every nut sags by G/kp = "
            f"{1e3 * _sag(robot):.1f} mm, and its error is this sag alone. The length of the runs "
            "was fitted to the printed PD error. The error of CTC comes only from the start at "
            "rest; when started on the path, CTC has no error. Fuzzy rows: the recorded M, C and G "
            "are noisy, and every rule keeps the one noisy sample that fires it most, so the full "
            "noise of that sample is in the torque. "
            + (
                (
                    "The printed type-1 errors lie between these and those of rules that average, "
                    "see the table of learners. "
                )
                if between
                else ""
            )
            + (
                f"Intervals of 95 %: {coverage_in_words('mean', seeds=plan.seeds)}. Means leave "
                "out the runs that diverged, which favors the controller that diverges. A printed "
                "noisy number is one run, so it is compared with the spread of single runs."
            ),
        ),
        Table(
            f"Table 6.3 continued: how the noisy runs end, {count(plan.seeds)}",
            [
                "controller",
                "SNR [dB]",
                "median error (95 % interval) [m²]",
                "diverged",
                "off stroke",
                "inside the trained range",
            ],
            ends,
            "Diverged: share of the runs that ended early because the robot left its reachable "
            "poses. Off stroke: share of the runs in which a nut passed the end of its screw, "
            "which the simulation allows, as the thesis does. Last column: mean share of the "
            "control steps whose four inputs lie within the trained range; other inputs are "
            "clamped to it. Intervals of 95 %: "
            f"{coverage_in_words('median', seeds=plan.seeds)}.",
            detail=True,
        ),
    ]


def answer_of_table_6_3(robot: PSP3, results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add sentences on what Table 6.3 shows about the classical controllers.

    They also cover the fuzzy controllers without noise.
    """
    numbers = outcome.numbers["table_6_3"]
    pd, ctc, simple = (numbers[name][ERROR] for name in ("PD", "CTC", "PD with gravity"))
    fuzzy = {kind: numbers["fuzzy"][decibels(math.inf)][kind]["mean"]["value"] for kind in FUZZY}
    if simple < min(fuzzy.values()):
        outcome.answer.append(
            "A PD controller with the gains of Table 6.1 and the exact forces of gravity G, which "
            f"the thesis did not try, has an error of {simple:.4f} m². On this helix that is less "
            "than the error of every fuzzy controller with default rules, even without noise"
            f"{_on_other_paths(results, plan)}."
        )
    sag, gap = _sag(robot), numbers["gap_without_noise"]
    outcome.answer.append(
        f"The error is {pd:.2f} m² under PD and {ctc:.4f} m² under CTC (printed: "
        f"{published.TABLE_6_3['PD']} and {published.TABLE_6_3['CTC']}). The ranking of Table "
        f"6.3 {'holds' if ctc < pd else 'does not hold'}. PD's error is its sag of "
        f"{1e3 * sag:.0f} mm under gravity: it says nothing about tracking, and we chose the "
        "length of the run to fit it. Without noise type-1 and type-2 are the same "
        f"controller, {fuzzy['t1']:.4f} m² (printed: {published.TABLE_6_3_FUZZY[math.inf][0]}; "
        f"they agree {'to the last bit' if gap == 0.0 else f'to {gap:.0e}'})."
    )


def _on_other_paths(results: Outcomes, plan: Plan) -> str:
    """Return on which other paths PD with gravity has less error than fuzzy control, or more.

    The fuzzy controllers have default rules and no noise.
    """
    less, more = [], []
    for trajectory in plan.trajectories[1:]:
        simple, *fuzzy = (
            results.values(Run(name, trajectory=trajectory), 1)[0]
            for name in ("pd-gravity", *FUZZY)
        )
        # A path on which a run diverged is left out, because its error is NaN.
        if simple < np.min(fuzzy):
            less.append(trajectory)
        elif simple > np.max(fuzzy):
            more.append(trajectory)
    return (f", and so it is on {listed(less)}" if less else "") + (
        f"; on {listed(more)} it is more than theirs without noise" if more else ""
    )


def _sag(robot: PSP3) -> float:
    """Return the sag of each nut at rest under PD [m]."""
    return float(robot.gravity(np.zeros(3)).mean()) / published.TABLE_6_1["PD"][0]


def _soft_pd(robot: PSP3) -> dict[str, float]:
    """Return the time at which PD with the gains of computed torque loses the robot [s]."""
    controller = PD(*published.TABLE_6_1["CTC"])
    try:
        result = simulate(robot, controller, Helix(robot=robot), DURATION)
    except SimulationDiverged as error:
        result = error.result
    return {"end_time": float(result.t[-1])}


def typical_seed(results: Outcomes, plan: Plan) -> int:
    """Return the seed whose noisy runs of type-1 and type-2 come nearest to their medians.

    The distance is that of the logarithms of the errors.
    """
    distance = np.zeros(plan.seeds)
    for kind in ("t1", "it2"):
        for snr in NOISY:
            errors = results.values(Run(kind, snr_db=snr), plan.seeds)
            # A run that diverged counts as infinitely far from the medians.
            distance += np.where(
                np.isfinite(errors), np.abs(np.log(errors / np.nanmedian(errors))), np.inf
            )
    return int(np.argmin(distance))

"""The numbers of chapter 6: Tables 6.1 to 6.3, and the comparisons that the thesis never showed.

The runs come from one study, :class:`Plan`; every function here adds a table, its numbers and a sentence of the answer to a
:class:`~psp3.findings.Reproduction`. Nothing is said that is not read off the runs: sentences change with the numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fuzzy2.noise import mean_variation_from_snr
from psp3 import published, statistics
from psp3.arrays import Array
from psp3.controllers import PD, PID, ComputedTorque
from psp3.findings import Reproduction, Table, as_numbers, better, significant, verdict, with_interval
from psp3.fuzzy_computed_torque import FuzzyComputedTorque
from psp3.latency import Latency
from psp3.metrics import (
    THESIS_SAMPLING_PERIOD,
    integral_of_squared_error,
    largest_tip_error,
    rms_error,
    sum_of_squared_errors,
)
from psp3.records import DURATION
from psp3.robot import PSP3
from psp3.runs import TRAJECTORIES, Run
from psp3.simulation import simulate
from psp3.statistics import Estimate
from psp3.study import grid
from psp3.study_file import Row, field_types
from psp3.trajectories import Helix

LABELS = {
    "feed-forward": "feed-forward", "pd": "PD", "pd-gravity": "PD with gravity", "ctc": "CTC",
    "t1": "type-1", "it2": "type-2", "gt2": "general type-2",
}  # fmt: skip
"""Controllers as tables name them."""

FUZZY = ("t1", "it2", "gt2")

LEARNERS = {
    "strongest": "strongest sample", "average": "weighted average", "strict": "strict table look-up", "ridge": "ridge",
}  # fmt: skip
"""Learners as tables name them; the first is the default."""

READINGS = {
    "measurement": "noise on measured heights and speeds",
    "online": "noise on M, C and G at run time",
    "plant": "masses and inertias off, unknown payload",
}
"""Readings of noise besides the default one, as tables name them."""

NOISY = (20.0, 15.0, 10.0)
"""Finite signal-to-noise ratios of Table 6.3 [dB]."""

NOISIER = (5.0, 0.0)
"""Signal-to-noise ratios below those of the thesis [dB], to find out where controllers break."""

MOST_SWEEP_SEEDS = 10
"""Seeds of the comparisons that the thesis never showed."""

ERROR = "sum_of_squared_errors"


@dataclass(frozen=True)
class Plan:
    """What is run.

    Parameters
    ----------
    seeds : int
        Seeds of Table 6.3 and of the comparison of learners.
    sweep_seeds : int
        Seeds of everything else.
    sweep_levels : tuple of float
        Signal-to-noise ratios of everything else [dB], besides none.
    variations : tuple of float
        Mean variations that are tried, as shares of each input's range.
    terms : tuple of int
        Numbers of terms of each input that are tried.
    widths : tuple of float
        Factors of the standard deviation of type-1 terms that are tried.
    trajectories : tuple of str
        Names of the trajectories, that of the training first.
    """

    seeds: int
    sweep_seeds: int
    sweep_levels: tuple[float, ...] = NOISY
    variations: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.4, 0.6)
    terms: tuple[int, ...] = (2, 3, 4)
    widths: tuple[float, ...] = (1.5, 2.0, 3.0)
    trajectories: tuple[str, ...] = tuple(TRAJECTORIES)

    @classmethod
    def of(cls, seeds: int, quick: bool = False) -> Plan:
        """Return the whole plan, or one that is done in seconds and shows only that everything works."""
        if quick:
            few = min(seeds, 2)
            return cls(few, few, sweep_levels=(20.0,), variations=(0.1, 0.4), terms=(2, 3), widths=(2.0,), trajectories=("helix", "circle"))
        return cls(seeds, min(seeds, MOST_SWEEP_SEEDS))

    def runs(self) -> tuple[Run, ...]:
        """Return all runs; the study does those that differ in nothing that matters once."""
        all_seeds, seeds = range(self.seeds), range(self.sweep_seeds)
        levels, classical = (math.inf, *self.sweep_levels), ("pd", "pd-gravity", "ctc")
        return (
            *grid(controller=classical),
            *grid(controller=FUZZY, snr_db=(math.inf, *NOISY), seed=all_seeds),
            *grid(controller=FUZZY, learner=LEARNERS, snr_db=levels, seed=all_seeds),
            *grid(controller=FUZZY, learner=("strongest", "average"), snr_db=NOISIER, seed=seeds),
            *grid(controller=(*classical, *FUZZY), reading=READINGS, snr_db=self.sweep_levels, seed=seeds),
            *grid(controller="t1", term_width=self.widths, snr_db=levels, seed=all_seeds),
            *grid(controller="it2", mean_variation=self.variations, snr_db=levels, seed=seeds),
            *grid(controller=("t1", "it2"), learner="strict", n_terms=self.terms, snr_db=levels, seed=seeds),
            *grid(controller=("feed-forward", *classical, *FUZZY), trajectory=self.trajectories),
            *grid(controller="t1", trajectory=self.trajectories, learner="ridge"),
            *grid(controller=("t1", "it2"), trajectory=self.trajectories, snr_db=20.0, seed=seeds),
        )  # fmt: skip


class Outcomes:
    """Results of the study by run.

    Parameters
    ----------
    rows : iterable of Row
        From :meth:`psp3.Study.rows`.
    """

    def __init__(self, rows: Iterable[Row]) -> None:
        self._rows = {Run(**{name: row[name] for name in field_types()}): row for row in rows}

    def values(self, run: Run, seeds: int, metric: str = ERROR) -> Array:
        """Return a metric of a run for each seed; of a run without noise, which no seed changes, once."""
        if run.canonical().snr_db == math.inf:
            seeds = 1
        return np.array([self._rows[replace(run, seed=seed).canonical()][metric] for seed in range(seeds)])

    def mean(self, run: Run, seeds: int, metric: str = ERROR) -> Estimate:
        """Return the mean over the seeds that did not diverge."""
        return statistics.mean(self.values(run, seeds, metric))

    def average(self, run: Run, seeds: int, metric: str = "diverged") -> float:
        """Return the average over all seeds: of what is 0 or 1, the share."""
        return float(self.values(run, seeds, metric).mean())

    def difference(self, run: Run, controller: str, seeds: int) -> Estimate:
        """Return the mean difference of the errors by seed, that controller's minus type-1's."""
        return statistics.paired_difference(*self._pair(run, controller, seeds))

    def ratio(self, run: Run, controller: str, seeds: int, inverse: bool = False) -> Estimate:
        """Return the ratio of the mean errors over the same seeds, that controller's over type-1's, or the inverse."""
        pair = self._pair(run, controller, seeds)
        return statistics.ratio_of_means(*(pair[::-1] if inverse else pair))

    def shown(self, run: Run, seeds: int) -> str:
        """Return the mean error with its interval, and the share of the runs that diverged if any did, as tables show it."""
        return _with_share(self.mean(run, seeds), self.average(run, seeds))

    def _pair(self, run: Run, controller: str, seeds: int) -> tuple[Array, Array]:
        return tuple(self.values(replace(run, controller=name), seeds) for name in (controller, "t1"))  # type: ignore[return-value]


def decibels(snr_db: float) -> str:
    """Return a signal-to-noise ratio as tables show it."""
    return "∞" if math.isinf(snr_db) else f"{snr_db:g}"


def count(seeds: int) -> str:
    """Return the number of seeds in words."""
    return f"{seeds} seed{'' if seeds == 1 else 's'}"


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def table_6_1(robot: PSP3, outcome: Reproduction) -> None:
    """Add Table 6.1: the gains that this package takes unless given others."""
    fuzzy = {kind: FuzzyComputedTorque(kind, robot) for kind in ("t1", "it2")}
    used: dict[str, PD | ComputedTorque | FuzzyComputedTorque]
    used = {"PD": PD(), "CTC": ComputedTorque(robot), "T1 fuzzy CTC": fuzzy["t1"], "T2 fuzzy CTC": fuzzy["it2"]}
    rows, levels = [], ", ".join(decibels(snr) for snr in published.TABLE_6_1_SNR)
    for name, controller in used.items():
        gains = (controller.kp, controller.kv)
        same, tail, more = gains == published.TABLE_6_1[name], "", ""
        if isinstance(controller, FuzzyComputedTorque):
            same &= controller.n_terms == published.TABLE_6_1_TERMS and set(published.TABLE_6_1_SNR) == {math.inf, *NOISY}
            tail, more = f"; SNR {levels} dB; {published.TABLE_6_1_TERMS} terms", f"; {controller.n_terms} terms"
        printed = "{:g} / {:g}".format(*published.TABLE_6_1[name])
        rows.append([name, printed + tail, f"{gains[0]:g} / {gains[1]:g}{more}", "as printed" if same else "not as printed"])
    outcome.tables.append(
        Table(
            "Table 6.1: gains and settings", ["controller", "printed: kp / kv", "used", "verdict"], rows,
            "Gains of PD in N/m and N s/m, of the others in 1/s² and 1/s: these act on a robot that the model has made a unit mass. "
            "kp = 10 and kv = 1 are soft, a natural frequency of 0.5 Hz with a damping ratio of 0.16, so whatever the model gets wrong "
            "shows in full. PD has stiffness instead.",
            detail=True,
        )
    )  # fmt: skip


def table_6_2(latencies: Mapping[str, Latency], outcome: Reproduction) -> None:
    """Add Table 6.2: how long a step takes."""
    names = {
        "PD": ("PD", "PD"), "CTC, noc": ("CTC, natural orthogonal complement", "CTC"), "CTC, pinocchio": ("CTC, Pinocchio", "CTC"),
        "CTC, closed_form": ("CTC, closed form", "CTC"), "t1": ("type-1", "T1 fuzzy CTC"), "it2": ("type-2", "T2 fuzzy CTC"),
        "gt2": ("general type-2", ""),
    }  # fmt: skip
    rows, numbers = [], {}
    for name, latency in latencies.items():
        label, printed_name = names[name]
        printed = published.TABLE_6_2.get(printed_name)
        numbers[name] = {**latency._asdict(), "printed": printed}
        times = [f"{1e3 * value:.4f}" for value in latency[1:]]
        fits = "within 2 ms" if latency.worst <= published.STEP_BUDGET else "median within 2 ms, not every step"
        fits = fits if latency.median <= published.STEP_BUDGET else "not within 2 ms"
        if printed is None:
            words = f"not in the thesis; {fits}"
        elif name == "PD":
            words = f"{'reproduced' if latency.median < printed else 'not reproduced'}; {fits}"
        else:
            words = f"not reproduced: {printed / latency.median:,.0f} times faster; {fits}"
        shown = "–" if printed is None else f"{'< ' if name == 'PD' else ''}{1e3 * printed:g}"
        rows.append([label, shown, *times, words])
    outcome.numbers["table_6_2"] = numbers
    exact, noc, it2 = (latencies[name] for name in ("CTC, closed_form", "CTC, noc", "it2"))
    errors = outcome.numbers["table_6_3"]
    better_exact = errors["CTC"][ERROR] < errors["fuzzy"][decibels(math.inf)]["it2"]["mean"]["value"]
    closer = ", and tracks better than every estimate learned by default" if better_exact else ""
    order = [latencies[name].median for name in ("PD", "t1", "it2", "CTC, noc")]
    outcome.tables.append(
        Table(
            "Table 6.2: time of one control step",
            ["controller", "printed [ms]", "median [ms]", "99 % [ms]", "99.9 % [ms]", "worst [ms]", "verdict"],
            rows,
            f"One call of controller.torque at a time from Python, {noc.steps:,} calls of the models that take milliseconds and "
            f"{exact.steps:,} of the others, on states along the helix, after a warm-up, by the clock of the machine this ran on; beyond "
            "the median it is the machine that is measured as much as the controller. The thesis: a Pentium 4 of 3 GHz, and a budget of "
            "2 ms. Its premise was that exact computed torque cannot run in real time and must be estimated. The same equations take "
            f"{1e3 * noc.median:.1f} ms through the natural orthogonal complement in Python, but in closed form "
            f"{1e6 * exact.median:.0f} µs: {published.TABLE_6_2['CTC'] / exact.median:,.0f} times less than printed, and "
            f"{published.STEP_BUDGET / exact.median:.0f} times within the budget. The fuzzy estimate takes {1e6 * it2.median:.0f} µs, "
            f"{it2.median / exact.median:.1f} times the exact one, so time is no longer a reason to estimate M, C and G. The printed "
            f"order, PD, type-1, type-2, CTC, {'holds' if order == sorted(order) else 'does not hold'} with the CTC of the thesis.",
        )
    )
    outcome.answer.append(
        f"The premise is gone: the thesis estimates M, C and G because exact computed torque took 255 ms a step. In closed form it takes "
        f"{1e6 * exact.median:.0f} µs from Python (type-2: {1e6 * it2.median:.0f} µs), on a budget of 2 ms{closer}."
    )


def table_6_3(robot: PSP3, results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add Table 6.3: the tracking errors of all controllers, the reading ``parameters``, the default learner."""
    tracked = {name: outcome.results[name] for name in ("PD", "CTC", "PD with gravity")}
    tracked["PID"] = simulate(robot, PID(), Helix(robot=robot), DURATION)
    rows: list[list[str]] = []
    numbers: dict[str, Any] = {}
    for name, result in tracked.items():
        squares, printed, tip = sum_of_squared_errors(result), published.TABLE_6_3.get(name), largest_tip_error(result)
        numbers[name] = {
            ERROR: squares, "printed_sum_of_squared_errors": printed, "integral_of_squared_error": integral_of_squared_error(result),
            "rms_error": rms_error(result), "largest_tip_error": tip, "largest_torque": float(np.abs(result.torque).max()),
        }  # fmt: skip
        shown, words = ("–", "not in the thesis") if printed is None else (f"{printed:.4f}", verdict(squares, printed))
        rows.append([name, "–", shown, f"{squares:.4f}", f"{1e3 * tip:.0f}", words])
    fuzzy: dict[str, Any] = {}
    ends: list[list[str]] = []
    for snr in (math.inf, *NOISY):
        at = fuzzy[decibels(snr)] = {}
        for kind, old in zip(FUZZY, (*published.TABLE_6_3_FUZZY[snr], None), strict=True):
            run = Run(kind, snr_db=snr)
            average, median = results.mean(run, plan.seeds), statistics.median(results.values(run, plan.seeds))
            tip = results.mean(run, plan.seeds, "largest_tip_error").value
            diverged, left, coverage = (results.average(run, plan.seeds, name) for name in ("diverged", "left_stroke", "coverage"))
            at[kind] = {
                "mean": as_numbers(average), "median": as_numbers(median), "diverged": diverged, "left_stroke": left, "printed": old,
                "coverage": coverage, "largest_tip_error": tip, "values": results.values(run, plan.seeds).tolist(),
            }  # fmt: skip
            shown, words = "–", "not in the thesis"
            if old is not None:
                shown, words = f"{old:.4f}", verdict(average.value, old, (average.low, average.high))
            mean = f"{average.value:.4f}" if math.isinf(snr) else _with_share(average, diverged)
            rows.append([LABELS[kind], decibels(snr), shown, mean, f"{1e3 * tip:.0f}" if np.isfinite(tip) else "–", words])
            if not math.isinf(snr):
                ends.append([LABELS[kind], decibels(snr), with_interval(median), *map(_percent, (diverged, left, coverage))])
    t1, it2 = (results.values(Run(kind), 1)[0] for kind in ("t1", "it2"))
    numbers |= {"fuzzy": fuzzy, "gap_without_noise": abs(it2 - t1) / t1}
    outcome.numbers["table_6_3"] = numbers
    averaged = [results.mean(Run("t1", snr_db=snr, learner="average"), plan.seeds).value for snr in plan.sweep_levels]
    kept = [results.mean(Run("t1", snr_db=snr), plan.seeds).value for snr in plan.sweep_levels]
    printed_rows = [published.TABLE_6_3_FUZZY[snr][0] for snr in plan.sweep_levels]
    between = all(low <= old <= high for low, old, high in zip(averaged, printed_rows, kept, strict=True))
    outcome.tables += [
        Table(
            f"Table 6.3: sum of squared tracking errors, {count(plan.seeds)}",
            ["controller", "SNR [dB]", "printed [m²]", "mean (95 % interval) [m²]", "largest tip error [mm]", "verdict"],
            rows,
            f"Helix of radius 20 mm, period 2 s, rise 10 mm/s, started at rest, {DURATION} s, control at 2 ms; one sample every "
            f"{THESIS_SAMPLING_PERIOD} s is summed. The thesis names neither its helix nor its sampling, so orders of magnitude and "
            f"ranking are what can be compared. PD has no gravity term: every screw sags by G/kp = {1e3 * _sag(robot):.1f} mm, and that "
            "sag is the whole of its row. The CTC row is the start from rest; started on the path CTC has no error at all. Fuzzy rows: "
            "noise on the recorded M, C and G, and every rule keeps the one noisy sample that fires it most, so its noise is in the "
            "torque undiminished. "
            + (
                "The printed type-1 errors lie between these and those of rules that average, see the table of learners. "
                if between
                else ""
            )
            + "Intervals: bootstrap over seeds. Means leave out the runs that diverged, which favors the controller that diverges.",
        ),
        Table(
            f"Table 6.3 continued: how the noisy runs end, {count(plan.seeds)}",
            ["controller", "SNR [dB]", "median error (95 % interval) [m²]", "diverged", "off stroke", "inside the trained range"],
            ends,
            "Diverged: share of the runs that ended early because the robot left the poses it can take. Off stroke: share of those in "
            "which a nut passed the end of its screw, which the simulation, as the thesis, lets it do. Last column: mean share of the "
            "control steps whose four inputs lie within what the rules were learned on; elsewhere they are clamped to it.",
            detail=True,
        ),
    ]


def _with_share(average: Estimate, diverged: float) -> str:
    return with_interval(average) + _diverged(diverged)


def _diverged(share: float) -> str:
    return f", {_percent(share)} diverged" if share > 0.0 else ""


def answer_of_table_6_3(robot: PSP3, outcome: Reproduction) -> None:
    """Add what Table 6.3 says of the classical controllers, and of the fuzzy ones without noise, in sentences."""
    numbers = outcome.numbers["table_6_3"]
    pd, ctc, simple = (numbers[name][ERROR] for name in ("PD", "CTC", "PD with gravity"))
    fuzzy = {kind: numbers["fuzzy"][decibels(math.inf)][kind]["mean"]["value"] for kind in FUZZY}
    if simple < min(fuzzy.values()):
        outcome.answer.append(
            f"A PD controller of the same gains with the exact G added, which the thesis did not try, leaves {simple:.4f} m²: less than "
            "every fuzzy controller with default rules, even without noise."
        )
    sag, gap = _sag(robot), numbers["gap_without_noise"]
    outcome.answer.append(
        f"PD leaves {pd:.2f} m² and CTC {ctc:.4f} m² of summed squared error (printed: {published.TABLE_6_3['PD']} and "
        f"{published.TABLE_6_3['CTC']}): the ranking of Table 6.3 {'holds' if ctc < pd else 'does not hold'}, and PD's row is its sag of "
        f"{1e3 * sag:.0f} mm under gravity. Without noise type-1 and type-2 are the same controller, {fuzzy['t1']:.4f} m² (printed: "
        f"{published.TABLE_6_3_FUZZY[math.inf][0]}; they agree {'to the last bit' if gap == 0.0 else f'to {gap:.0e}'})."
    )


def _sag(robot: PSP3) -> float:
    """Return how far every screw sags under PD at rest [m]."""
    return float(robot.gravity(np.zeros(3)).mean()) / published.TABLE_6_1["PD"][0]


def type_2_against_type_1(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add the paired differences and ratios behind Figure 64."""
    rows, numbers, words, ratios, inverses = [], {}, [], [], []
    for snr in NOISY:
        run, old = Run(snr_db=snr), published.TABLE_6_3_FUZZY[snr]
        difference, ratio, inverse = _comparison(results, run, "it2", plan.seeds)
        words.append(better(difference, "type-2", "type-1"))
        ratios.append(f"{ratio.value:.2f}")
        inverses.append(inverse.value)
        printed = old[1] / old[0]
        rows.append(
            [
                decibels(snr), with_interval(difference, plan.seeds), f"{printed:.2f}", with_interval(ratio), f"{1.0 / printed:.2f}",
                with_interval(inverse), f"{words[-1]}; ratio {verdict(ratio.value, printed, (ratio.low, ratio.high))}",
            ]
        )  # fmt: skip
        numbers[decibels(snr)] = {
            "difference": as_numbers(difference), "ratio": as_numbers(ratio), "inverse": as_numbers(inverse),
            "printed_ratio": printed, "verdict": words[-1],
        }  # fmt: skip
    outcome.numbers["type_2_against_type_1"] = numbers
    won = [word == "type-2 better" for word in words]
    levels = _listed([decibels(snr) for snr in NOISY])
    outcome.tables.append(
        Table(
            f"Figure 64 in numbers: type-2 against type-1, seed by seed, {count(plan.seeds)}",
            ["SNR [dB]", "type-2 minus type-1 [m²]", "printed T2/T1", "T2/T1", "printed T1/T2", "T1/T2", "verdict"],
            rows,
            "Both controllers of a seed learn from the same noise. Seeds with which one of the two diverged are left out; n says how many "
            "are left where that is not all. The thesis writes that T2/T1 rises with the noise; its own numbers give 1, 0.51, 0.28, "
            "0.25, which falls. What rises is T1/T2, and so Figure 64 is drawn. Here T1/T2 is "
            f"{_listed([f'{inverse:.2f}' for inverse in inverses])} at {levels} dB, and "
            f"{'rises' if inverses == sorted(inverses) else 'does not rise'} with the noise.",
            figures=("figure_64",),
        )
    )
    if all(won):
        claim, proof = "holds for the thesis's table look-up", "every 95 % interval of the difference by seed excludes zero"
    else:
        claim = f"is {'shown in part only' if any(won) else 'not shown'} for the thesis's table look-up"
        proof = "; ".join(f"{decibels(snr)} dB: {word}" for snr, word in zip(NOISY, words, strict=True))
    outcome.answer.append(
        f"The main claim, that type-2 tracks better than type-1 when rules are learned from noisy M, C and G, {claim}: its squared error "
        f"is {_listed(ratios)} of type-1's at {levels} dB, printed 0.51, 0.28 and 0.25 ({count(plan.seeds)}; {proof})."
    )


def _comparison(results: Outcomes, run: Run, controller: str, seeds: int) -> tuple[Estimate, ...]:
    ratios = (results.ratio(run, controller, seeds, inverse) for inverse in (False, True))
    return results.difference(run, controller, seeds), *ratios


def learners(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add what the learner does, with type-1, type-2 and general type-2."""
    rows, numbers, not_better, means = [], {}, [], {}
    for learner, label in LEARNERS.items():
        for snr in (math.inf, *plan.sweep_levels):
            run = Run(learner=learner, snr_db=snr)
            average = {kind: results.mean(replace(run, controller=kind), plan.seeds) for kind in FUZZY}
            means[learner, snr] = {kind: estimate.value for kind, estimate in average.items()}
            diverged = " / ".join(_percent(results.average(replace(run, controller=kind), plan.seeds)) for kind in FUZZY)
            cells = [with_interval(estimate) for estimate in average.values()]
            entry: dict[str, Any] = {kind: as_numbers(estimate) for kind, estimate in average.items()}
            if math.isinf(snr):
                rows.append([label, "∞", *cells, "–", "–", diverged, "the same"])
            else:
                ratios = {kind: results.ratio(run, kind, plan.seeds) for kind in ("it2", "gt2")}
                word = better(results.difference(run, "it2", plan.seeds), "type-2", "type-1")
                entry |= {f"ratio_{kind}": as_numbers(ratio) for kind, ratio in ratios.items()} | {"verdict": word}
                rows.append([label, decibels(snr), *cells, *map(with_interval, ratios.values()), diverged, word])
                if word != "type-2 better":
                    not_better.append((label, snr, means[learner, snr]["t1"], means[learner, snr]["it2"], word))
            numbers[f"{learner}, {decibels(snr)}"] = entry
    outcome.numbers["learners"] = numbers
    first = plan.sweep_levels[0]
    averaged, strongest = means["average", first]["t1"], means["strongest", first]["it2"]
    said = "; ".join(f"{label} at {snr:g} dB, {significant(one)} against {significant(two)} m², {word}"
                     for label, snr, one, two, word in not_better)  # fmt: skip
    outcome.tables.append(
        Table(
            f"What the learner does: sum of squared errors [m²], {count(plan.seeds)}",
            ["learner", "SNR [dB]", "type-1", "type-2", "general type-2", "type-2 / type-1", "general / type-1", "diverged", "verdict"],
            rows,
            "Reading 'parameters', two terms an input. Strongest sample: every rule keeps the sample that fires it most (table look-up, "
            "the default). Weighted average: the mean of all samples, weighted with how strongly they fire the rule. Strict table "
            "look-up: as Wang and Mendel published it, empty cells take the nearest rule. Ridge: least squares, held near the average. "
            "Diverged: shares for type-1, type-2 and general type-2. "
            + (f"Where type-2 does not beat type-1: {said}." if not_better else "Type-2 beats type-1 in every noisy row."),
            detail=True,
        )
    )
    sentence = (
        f"What the learner does matters more than the type: at {first:g} dB type-1 with rules that average their samples leaves "
        f"{significant(averaged)} m², type-2 with rules that keep one sample {significant(strongest)} m²."
        if averaged < strongest
        else f"At {first:g} dB type-2 with rules that keep one sample leaves {significant(strongest)} m², type-1 with rules that average "
        f"{significant(averaged)} m²."
    )
    if not_better:
        sentence += f" And type-2 is not always better (type-1 first): {said}."
    outcome.answer.append(sentence)


def averaging(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add type-1 with wider terms: whether averaging over rules is what type-2 gains."""
    rows, numbers, matched = [], {}, []
    for snr in (math.inf, *plan.sweep_levels):
        type1 = Run("t1", snr_db=snr)
        type2 = replace(type1, controller="it2")
        cells = [results.shown(type1, plan.seeds)]
        differences = []
        numbers[decibels(snr)] = entry = {"it2": as_numbers(results.mean(type2, plan.seeds))}
        for width in plan.widths:
            wider = replace(type1, term_width=width)
            cells.append(results.shown(wider, plan.seeds))
            differences.append(statistics.paired_difference(results.values(wider, plan.seeds), results.values(type2, plan.seeds)))
            entry[f"{width:g}"] = as_numbers(results.mean(wider, plan.seeds))
        words = [better(difference, f"type-1 × {width:g}", "type-2") for width, difference in zip(plan.widths, differences, strict=True)]
        if math.isinf(snr):
            words = ["type-2 is type-1 here"]
        else:
            matched.append(words[-1].startswith("type-1"))
        rows.append([decibels(snr), *cells, results.shown(type2, plan.seeds), "; ".join(words)])
    outcome.numbers["wider_type_1_terms"] = numbers
    widest = plan.widths[-1]
    outcome.tables.append(
        Table(
            f"Is it type-2, or averaging? Type-1 with wider terms, sum of squared errors [m²], {count(plan.seeds)}",
            ["SNR [dB]", "type-1", *(f"type-1, terms × {width:g}" for width in plan.widths), "type-2", "verdict by seed, against type-2"],
            rows,
            "Type-2 terms reach over more of each input's range, so more rules fire, and the noise in their consequents averages out. "
            "Type-1 terms with a greater standard deviation do the same with the same rules. The first row is what wide terms cost where "
            "there is no noise to average.",
            detail=True,
        )
    )
    if all(matched):
        levels, wide, type_2 = (
            _listed([say(decibels(snr)) for snr in plan.sweep_levels])
            for say in (
                str,
                lambda at: significant(numbers[at][f"{widest:g}"]["value"]),
                lambda at: significant(numbers[at]["it2"]["value"]),
            )
        )
        outcome.answer.append(
            f"The gain is that of averaging over rules, and needs no type-2: plain type-1 with terms {widest:g} times as wide, on the same "
            f"noisy rules, leaves {wide} m² at {levels} dB, type-2 {type_2} m²."
        )


def readings(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add the three other readings of noise in the system parameters."""
    rows, numbers, verdicts = [], {}, []
    names = ("pd", "pd-gravity", "ctc", *FUZZY)
    for reading, label in READINGS.items():
        for snr in plan.sweep_levels:
            run = Run(reading=reading, snr_db=snr)
            average = {name: results.mean(replace(run, controller=name), plan.sweep_seeds) for name in names}
            difference = results.difference(run, "it2", plan.sweep_seeds)
            verdicts.append((reading, better(difference, "type-2", "type-1")))
            lost = [results.average(replace(run, controller=name), plan.sweep_seeds) for name in names]
            rows.append([label, decibels(snr), *(significant(average[name].value) + _diverged(share)
                                                 for name, share in zip(names, lost, strict=True)),
                         with_interval(difference, plan.sweep_seeds), verdicts[-1][1]])  # fmt: skip
            numbers[f"{reading}, {decibels(snr)}"] = {
                **{name: as_numbers(estimate) for name, estimate in average.items()}, "difference": as_numbers(difference),
            }  # fmt: skip
    outcome.numbers["readings"] = numbers
    outcome.tables.append(
        Table(
            f"Other readings of 'noise in the system parameters': mean sum of squared errors [m²], {count(plan.sweep_seeds)}",
            ["reading", "SNR [dB]", *(LABELS[name] for name in names), "type-2 minus type-1, by seed", "verdict"],
            rows,
            "Rules are learned without noise here, with the mean variation that belongs to the signal-to-noise ratio. Masses off: every "
            "mass and inertia of the robot by a factor exp(q ε), and a payload of 5 kg · q |ε| on the star, with q = 10^(−SNR/20) and ε "
            "standard normal; no controller knows of it.",
            detail=True,
        )
    )
    helped = [reading for reading, word in verdicts if word == "type-2 better"]
    worse = sum(word == "type-1 better" for _, word in verdicts)
    if helped:
        outcome.answer.append(f"Under other readings of the noise type-2 is shown to be better in {len(helped)} of {len(verdicts)} cases.")
    else:
        cost = ": its wider terms cost accuracy that no averaging pays back" if worse else ""
        outcome.answer.append(
            "Under the other readings (noise on measurements, on M, C and G at run time, or masses that are off) type-2 is never shown to "
            f"beat type-1, and is shown to be worse in {worse} of {len(verdicts)} cases{cost}."
        )


def breaking_noise(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add the noise at which each fuzzy controller breaks: loses a nut off its screw, or the robot altogether."""
    rows, numbers, levels = [], {}, (*plan.sweep_levels, *NOISIER)
    for learner in ("strongest", "average"):
        for name in FUZZY:
            cells, entry = [], {}
            for snr in levels:
                run = Run(name, learner=learner, snr_db=snr)
                left, lost = (results.average(run, plan.sweep_seeds, metric) for metric in ("left_stroke", "diverged"))
                cells.append(f"{_percent(left)} / {_percent(lost)}")
                entry[decibels(snr)] = {"left_stroke": left, "diverged": lost}
            rows.append([LABELS[name], LEARNERS[learner], *cells])
            numbers[f"{name}, {learner}"] = entry
    outcome.numbers["breaking_noise"] = numbers
    outcome.tables.append(
        Table(
            f"Where each controller breaks: share of runs in which a nut leaves its screw / the robot is lost, {count(plan.sweep_seeds)}",
            ["controller", "rules", *(f"{decibels(snr)} dB" for snr in levels)],
            rows,
            "On the helix the rules were learned on, noise on the recorded M, C and G. The thesis stops at 10 dB.",
            detail=True,
        )
    )


Series = dict[str, dict[float, tuple[float, float, float]]]


def mean_variations(results: Outcomes, plan: Plan, outcome: Reproduction) -> Series:
    """Add the sweep of the mean variation, and return its curves."""
    levels = (math.inf, *plan.sweep_levels)
    series: Series = {("no noise" if math.isinf(snr) else f"{snr:g} dB"): {} for snr in levels}
    rows, numbers = [], {}
    for variation in (0.0, *plan.variations):
        cells = []
        for snr, points in zip(levels, series.values(), strict=True):
            run = Run("t1", snr_db=snr) if variation == 0.0 else Run("it2", snr_db=snr, mean_variation=variation)
            average = results.mean(run, plan.sweep_seeds)
            diverged = results.average(run, plan.sweep_seeds)
            points[variation] = (average.value, average.low, average.high)
            numbers[f"{variation:g}, {decibels(snr)}"] = {**as_numbers(average), "diverged": diverged}
            cells.append(_with_share(average, diverged))
        rows.append([f"{variation:g}{' (type-1)' if variation == 0.0 else ''}", *cells])
    outcome.numbers["mean_variation"] = numbers
    at = _listed([decibels(snr) for snr in levels])
    rule = [f"{float(mean_variation_from_snr(snr)):.2f}" for snr in levels]
    least = [f"{min(points, key=lambda variation: points[variation][0]):g}" for points in series.values()]
    outcome.tables.append(
        Table(
            f"Sensitivity to the mean variation: sum of squared errors of type-2 [m²], {count(plan.sweep_seeds)}",
            ["mean variation, share of the range", *series],
            rows,
            f"Reading 'parameters', strongest sample. The rule of this package takes {_listed(rule)} at {at} dB; the least mean errors "
            f"are at {_listed(least)}, of what was tried.",
            figures=("mean_variation",),
            detail=True,
        )
    )
    return series


def numbers_of_terms(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add the sweep of the number of terms."""
    levels = (math.inf, *plan.sweep_levels)
    rows, numbers = [], {}
    for terms in plan.terms:
        for kind in ("t1", "it2"):
            cells = []
            for snr in levels:
                run = Run(kind, learner="strict", n_terms=terms, snr_db=snr)
                average, diverged = results.mean(run, plan.sweep_seeds), results.average(run, plan.sweep_seeds)
                numbers[f"{terms}, {kind}, {decibels(snr)}"] = {**as_numbers(average), "diverged": diverged}
                cells.append(_with_share(average, diverged))
            rows.append([f"{terms} ({terms**4} rules)", LABELS[kind], *cells])
    outcome.numbers["terms"] = numbers
    few, many, noisiest = plan.terms[0], plan.terms[-1], decibels(plan.sweep_levels[0])
    shares = _listed(
        [
            f"{numbers[f'{many}, {kind}, {snr}']['value'] / numbers[f'{few}, {kind}, {snr}']['value']:.2f} of the error of {LABELS[kind]} "
            f"{'without noise' if snr == decibels(math.inf) else f'at {snr} dB'}"
            for kind, snr in (("it2", decibels(math.inf)), ("t1", noisiest), ("it2", noisiest))
        ]
    )
    outcome.tables.append(
        Table(
            f"Sensitivity to the number of terms: sum of squared errors [m²], {count(plan.sweep_seeds)}",
            ["terms of an input", "controller", *("no noise" if math.isinf(snr) else f"{snr:g} dB" for snr in levels)],
            rows,
            "Strict table look-up, because only it fills the cells that the helix never visits, with the nearest rule: with three terms or "
            "more the other learners find rules that no sample fires, and refuse. The thesis says that more terms 'do not offer "
            f"significant improvements' and shows no numbers. Here {plan.terms[-1]} terms instead of {plan.terms[0]} leave {shares}.",
            detail=True,
        )
    )


def other_trajectories(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add trajectories that the rules were not learned on, and where each controller breaks."""
    rows, numbers = [], {}
    for trajectory in plan.trajectories:
        open_loop = Run("feed-forward", trajectory=trajectory)
        lost = results.average(open_loop, 1) > 0.0
        end = results.values(open_loop, 1, "end_time")[0]
        cells = [f"lost after {end:.1f} s" if lost else significant(results.values(open_loop, 1)[0])]
        runs = {LABELS[name]: Run(name, trajectory=trajectory) for name in ("pd", "pd-gravity", "ctc")}
        runs |= {
            "fuzzy": Run("it2", trajectory=trajectory), "fuzzy, ridge": Run("t1", trajectory=trajectory, learner="ridge"),
            "type-1, 20 dB": Run("t1", trajectory=trajectory, snr_db=20.0), "type-2, 20 dB": Run("it2", trajectory=trajectory, snr_db=20.0),
        }  # fmt: skip
        averages = {name: results.mean(run, plan.sweep_seeds) for name, run in runs.items()}
        cells += [results.shown(run, plan.sweep_seeds) for run in runs.values()]
        covered = results.values(runs["fuzzy"], 1, "coverage")[0]
        numbers[trajectory] = {
            **{name: as_numbers(estimate) for name, estimate in averages.items()}, "coverage": covered,
            "feed-forward": {"diverged": lost, "end_time": end},
        }  # fmt: skip
        rows.append([trajectory + (" (learned)" if trajectory == plan.trajectories[0] else ""), *cells, _percent(covered)])
    outcome.numbers["trajectories"] = numbers
    outcome.tables.append(
        Table(
            f"Other trajectories: sum of squared errors [m²], {count(plan.sweep_seeds)} where there is noise",
            ["trajectory", *(LABELS[name] for name in ("feed-forward", "pd", "pd-gravity", "ctc")), "fuzzy, no noise",
             "fuzzy, ridge, no noise", "type-1, 20 dB", "type-2, 20 dB", "steps inside the trained range"],
            rows,
            "Rules are learned on the helix (20 mm, 2 s a turn); fast-helix: 1 s a turn; fastest-helix: 0.4 s; large-helix: 23.5 mm, at "
            "the fold of the tip's workspace; waypoints: a square, a corner a second. The circle asks for the same differences of heights "
            "as the helix, so to the rules it is no new path. Without noise type-1 and type-2 are the same. Open loop has nothing that "
            "holds the robot on its path, and is lost wherever it starts with the wrong speed. Outside of the trained range the inputs are "
            "clamped to it (last column: without noise, default rules).",
            detail=True,
        )
    )  # fmt: skip
    home = numbers[plan.trajectories[0]]["fuzzy"]["value"]
    held = [name for name in plan.trajectories[1:] if np.isfinite(numbers[name]["fuzzy"]["value"])]
    lost_on = [name for name in plan.trajectories[1:] if name not in held]
    if not held:
        outcome.answer.append("Away from the helix they learned on, the fuzzy controllers diverge, even without noise.")
        return
    worst = max(held, key=lambda name: numbers[name]["fuzzy"]["value"])
    outcome.answer.append(
        f"Away from the helix they learned on, the fuzzy controllers {f'diverge on {_listed(lost_on)}' if lost_on else 'keep working'} "
        f"without noise, with the greatest error {'of the rest ' if lost_on else ''}on {worst} "
        f"({significant(numbers[worst]['fuzzy']['value'])} m², {significant(home)} m² on the helix, CTC "
        f"{significant(numbers[worst]['CTC']['value'])} m²)."
    )


def typical_seed(results: Outcomes, plan: Plan) -> int:
    """Return the seed whose noisy runs of type-1 and type-2 come nearest to their medians, by the logarithms of their errors."""
    distance = np.zeros(plan.seeds)
    for kind in ("t1", "it2"):
        for snr in NOISY:
            errors = results.values(Run(kind, snr_db=snr), plan.seeds)
            # A run that diverged is as far from the others as can be.
            distance += np.where(np.isfinite(errors), np.abs(np.log(errors / np.nanmedian(errors))), np.inf)
    return int(np.argmin(distance))


def ratios_of_figure_64(results: Outcomes, plan: Plan) -> Series:
    """Return type-1's error over type-2's at every noise level, for three learners."""
    series: Series = {}
    for learner in ("strongest", "average", "ridge"):
        points = {math.inf: (1.0, math.nan, math.nan)}
        for snr in NOISY if learner == "strongest" else plan.sweep_levels:
            inverse = results.ratio(Run(learner=learner, snr_db=snr), "it2", plan.seeds, inverse=True)
            points[snr] = (inverse.value, inverse.low, inverse.high)
        series[LEARNERS[learner]] = points
    return series

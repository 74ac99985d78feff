"""Comparisons that the thesis lacks: other learners, readings of noise, terms and trajectories."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from fuzzy2.learning.noise import mean_variation_from_snr
from psp3.study import statistics
from psp3.study.run import Run
from psp3.thesis.findings import Reproduction, Table, as_numbers, better, significant, with_interval
from psp3.thesis.plan import (
    FUZZY,
    LABELS,
    LEARNERS,
    NOISIER,
    READINGS,
    Outcomes,
    Plan,
    Series,
    count,
    decibels,
    in_brackets,
    listed,
    percent,
    share_diverged,
    with_share,
    won,
)


def learners(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add the comparison of learners, with type-1, type-2 and general type-2."""
    rows, numbers, not_better, means = [], {}, [], {}
    for learner, label in LEARNERS.items():
        for snr in (math.inf, *plan.sweep_levels):
            run = Run(learner=learner, snr_db=snr)
            average = {
                kind: results.mean(replace(run, controller=kind), plan.seeds) for kind in FUZZY
            }
            means[learner, snr] = {kind: estimate.value for kind, estimate in average.items()}
            diverged = " / ".join(
                percent(results.average(replace(run, controller=kind), plan.seeds))
                for kind in FUZZY
            )
            cells = [with_interval(estimate) for estimate in average.values()]
            entry: dict[str, Any] = {
                kind: as_numbers(estimate) for kind, estimate in average.items()
            }
            if math.isinf(snr):
                rows.append([label, "∞", *cells, "–", "–", diverged, "the same"])
            else:
                ratios = {kind: results.ratio(run, kind, plan.seeds) for kind in ("it2", "gt2")}
                word = better(results.difference(run, "it2", plan.seeds), "type-2", "type-1")
                entry |= {f"ratio_{kind}": as_numbers(ratio) for kind, ratio in ratios.items()} | {
                    "verdict": word
                }
                cells += map(with_interval, ratios.values())
                rows.append([label, decibels(snr), *cells, diverged, word])
                if word != "type-2 better":
                    not_better.append(
                        (label, snr, means[learner, snr]["t1"], means[learner, snr]["it2"], word)
                    )
            numbers[f"{learner}, {decibels(snr)}"] = entry
    outcome.numbers["learners"] = numbers
    first = plan.sweep_levels[0]
    averaged, strongest = means["average", first]["t1"], means["strongest", first]["it2"]
    said = "; ".join(
        f"{label} at {snr:g} dB, {significant(one)} against {significant(two)} m², {word}"
        for label, snr, one, two, word in not_better
    )
    outcome.tables.append(
        Table(
            f"What the learner does: sum of squared errors [m²], {count(plan.seeds)}",
            [
                "learner",
                "SNR [dB]",
                "type-1",
                "type-2",
                "general type-2",
                "type-2 / type-1",
                "general / type-1",
                "diverged",
                "verdict",
            ],
            rows,
            "Reading 'parameters', two terms per input. Strongest sample: every rule keeps the "
            "sample that fires it most (the default of this package). Weighted average: the mean "
            "of all samples, weighted with how strongly they fire the rule. Table look-up of "
            "Wang and Mendel: the procedure that we take the thesis to cite, as published; empty "
            "cells take the nearest rule. Ridge: least squares, regularized towards the "
            "average. Diverged: shares for type-1, type-2 and "
            "general type-2. Verdict: by the difference of means, seed by seed. "
            f"{in_brackets([plan.seeds], 'mean', 'ratio of means')} "
            + (
                f"Where type-2 does not beat type-1: {said}."
                if not_better
                else "Type-2 beats type-1 in every noisy row."
            ),
            detail=True,
        )
    )
    sentence = (
        f"The learner matters more than the type: at {first:g} dB the error is "
        f"{significant(averaged)} m² for type-1 with rules that average their samples, and "
        f"{significant(strongest)} m² for type-2 with rules that keep one sample."
        if averaged < strongest
        else f"At {first:g} dB the error is {significant(strongest)} m² for type-2 with rules that "
        f"keep one sample, and {significant(averaged)} m² for type-1 with rules that average "
        "their samples."
    )
    if not_better:
        sentence += f" Type-2 is not always better (type-1 first): {said}."
    outcome.answer.append(sentence)


def averaging(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add type-1 with wider terms, to see whether type-2 gains by averaging over rules."""
    rows: list[list[str]] = []
    found = {
        learner: _wider_terms(results, plan, learner, seeds, rows)
        for learner, seeds in (("strongest", plan.seeds), ("average", plan.sweep_seeds))
    }
    outcome.numbers["wider_type_1_terms"] = found["strongest"]
    outcome.numbers["wider_type_1_terms_average"] = found["average"]
    widest = f"{plan.widths[-1]:g}"
    outcome.tables.append(
        Table(
            "Is it type-2, or averaging? Type-1 with wider terms, sum of squared errors [m²], "
            f"{count(plan.seeds)} ({plan.sweep_seeds} of rules that average)",
            [
                "rules",
                "SNR [dB]",
                "type-1",
                *(f"type-1, terms × {width:g}" for width in plan.widths),
                "type-2",
                f"type-1 × {widest} wins, seeds",
                "verdict by seed, against type-2",
            ],
            rows,
            "Type-2 terms reach over more of each input's range, so more rules fire, and the "
            "noise in their consequents averages out. Type-1 terms with a greater standard "
            "deviation do the same with the same rules. The row without noise shows the cost of "
            "wide terms when there is no noise to average. "
            f"{in_brackets([plan.seeds, plan.sweep_seeds], 'mean')}",
            detail=True,
        )
    )
    levels = listed([decibels(snr) for snr in plan.sweep_levels])
    sentences = []
    for learner, label in (
        ("strongest", "that keep the strongest sample"),
        ("average", "that average their samples"),
    ):
        noisy = [found[learner][decibels(snr)] for snr in plan.sweep_levels]
        if all(entry["type_1_wins"] > 0.5 * entry["seeds_compared"] for entry in noisy):
            wide, type_2 = (
                listed([significant(entry[name]["value"]) for entry in noisy])
                for name in (widest, "it2")
            )
            wins = listed(
                [f"{entry['type_1_wins']} of {entry['seeds_compared']}" for entry in noisy]
            )
            sentences.append(
                f"With rules {label} its error is {wide} m² at {levels} dB, that of type-2 is "
                f"{type_2} m², and it wins in {wins} seeds."
            )
    if sentences:
        outcome.answer.append(
            "The gain comes from averaging over rules, and does not need type-2. Type-1 with "
            f"terms {widest} times as wide learns from the same noise. {' '.join(sentences)}"
        )


def _wider_terms(
    results: Outcomes, plan: Plan, learner: str, seeds: int, rows: list[list[str]]
) -> dict[str, dict[str, Any]]:
    """Add a learner's rows of type-1 with wider terms, and return its numbers by noise level."""
    numbers: dict[str, dict[str, Any]] = {}
    for snr in (math.inf, *plan.sweep_levels):
        type1 = Run("t1", snr_db=snr, learner=learner)
        type2 = replace(type1, controller="it2")
        cells, words = [results.shown(type1, seeds)], []
        entry: dict[str, Any] = {"it2": as_numbers(results.mean(type2, seeds))}
        for width in plan.widths:
            wider = replace(type1, term_width=width)
            cells.append(results.shown(wider, seeds))
            difference = statistics.paired_difference(
                results.values(wider, seeds), results.values(type2, seeds)
            )
            words.append(better(difference, f"type-1 × {width:g}", "type-2"))
            entry[f"{width:g}"] = as_numbers(results.mean(wider, seeds))
        wins, both = results.wins(replace(type1, term_width=plan.widths[-1]), type2, seeds)
        numbers[decibels(snr)] = entry | {
            "type_1_wins": wins,
            "seeds_compared": both,
            "verdicts": dict(zip([f"{width:g}" for width in plan.widths], words, strict=True)),
        }
        of_seeds = won(wins, both)
        if math.isinf(snr):
            words, of_seeds = ["type-2 is type-1 here"], "–"
        rows.append(
            [
                LEARNERS[learner],
                decibels(snr),
                *cells,
                results.shown(type2, seeds),
                of_seeds,
                "; ".join(words),
            ]
        )
    return numbers


def readings(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add the three other readings of noise in the system parameters."""
    rows, numbers, verdicts = [], {}, []
    names = ("pd", "pd-gravity", "ctc", *FUZZY)
    for reading, label in READINGS.items():
        for snr in plan.sweep_levels:
            run = Run(reading=reading, snr_db=snr)
            average = {
                name: results.mean(replace(run, controller=name), plan.sweep_seeds)
                for name in names
            }
            difference = results.difference(run, "it2", plan.sweep_seeds)
            verdicts.append((reading, better(difference, "type-2", "type-1")))
            lost = [
                results.average(replace(run, controller=name), plan.sweep_seeds) for name in names
            ]
            rows.append(
                [
                    label,
                    decibels(snr),
                    *(
                        significant(average[name].value) + share_diverged(share)
                        for name, share in zip(names, lost, strict=True)
                    ),
                    with_interval(difference, plan.sweep_seeds),
                    verdicts[-1][1],
                ]
            )
            numbers[f"{reading}, {decibels(snr)}"] = {
                **{name: as_numbers(estimate) for name, estimate in average.items()},
                "difference": as_numbers(difference),
            }
    outcome.numbers["readings"] = numbers
    outcome.tables.append(
        Table(
            "Other readings of 'noise in the system parameters': mean sum of squared errors "
            f"[m²], {count(plan.sweep_seeds)}",
            [
                "reading",
                "SNR [dB]",
                *(LABELS[name] for name in names),
                "type-2 minus type-1, by seed",
                "verdict",
            ],
            rows,
            "Rules are learned without noise here, with the mean variation for the "
            "signal-to-noise ratio. Masses off: every mass and inertia of the robot is off by a "
            "factor exp(q ε), and a payload of 5 kg · q |ε| is on the star, with "
            "q = 10^(−SNR/20) and ε standard normal; no controller's model includes this. "
            f"{in_brackets([plan.sweep_seeds], 'difference of means')}",
            detail=True,
        )
    )
    helped = [reading for reading, word in verdicts if word == "type-2 better"]
    worse = sum(word == "type-1 better" for _, word in verdicts)
    if helped:
        outcome.answer.append(
            "With noise elsewhere, or wrong masses, type-2 is shown to be better in "
            f"{len(helped)} of {len(verdicts)} cases."
        )
    else:
        cost = ", because its wider terms are less accurate" if worse else ""
        outcome.answer.append(
            "If the noise is on the measurements, on M, C and G at run time, or if masses are "
            "wrong, type-2 is never shown to be better than type-1. It is shown to be "
            f"worse in {worse} of {len(verdicts)} cases{cost}."
        )


def breaking_noise(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add the noise level at which each fuzzy controller breaks.

    It breaks when a nut leaves its screw or the robot is lost.
    """
    rows, numbers, levels = [], {}, (*plan.sweep_levels, *NOISIER)
    for learner in ("strongest", "average"):
        for name in FUZZY:
            cells, entry = [], {}
            for snr in levels:
                run = Run(name, learner=learner, snr_db=snr)
                left, lost = (
                    results.average(run, plan.sweep_seeds, metric)
                    for metric in ("left_stroke", "diverged")
                )
                cells.append(f"{percent(left)} / {percent(lost)}")
                entry[decibels(snr)] = {"left_stroke": left, "diverged": lost}
            rows.append([LABELS[name], LEARNERS[learner], *cells])
            numbers[f"{name}, {learner}"] = entry
    outcome.numbers["breaking_noise"] = numbers
    outcome.tables.append(
        Table(
            "Where each controller breaks: share of runs in which a nut leaves its screw / the "
            f"robot is lost, {count(plan.sweep_seeds)}",
            ["controller", "rules", *(f"{decibels(snr)} dB" for snr in levels)],
            rows,
            "On the helix the rules were learned on, noise on the recorded M, C and G. The "
            "thesis stops at 10 dB.",
            detail=True,
        )
    )


def mean_variations(results: Outcomes, plan: Plan, outcome: Reproduction) -> Series:
    """Add the sweep of the mean variation, and return its curves."""
    levels = (math.inf, *plan.sweep_levels)
    series: Series = {("no noise" if math.isinf(snr) else f"{snr:g} dB"): {} for snr in levels}
    rows, numbers = [], {}
    for variation in (0.0, *plan.variations):
        cells = []
        for snr, points in zip(levels, series.values(), strict=True):
            run = (
                Run("t1", snr_db=snr)
                if variation == 0.0
                else Run("it2", snr_db=snr, mean_variation=variation)
            )
            average = results.mean(run, plan.sweep_seeds)
            diverged = results.average(run, plan.sweep_seeds)
            points[variation] = (average.value, average.low, average.high)
            numbers[f"{variation:g}, {decibels(snr)}"] = {
                **as_numbers(average),
                "diverged": diverged,
            }
            cells.append(with_share(average, diverged))
        rows.append([f"{variation:g}{' (type-1)' if variation == 0.0 else ''}", *cells])
    outcome.numbers["mean_variation"] = numbers
    at = listed([decibels(snr) for snr in levels])
    rule = [f"{float(mean_variation_from_snr(snr)):.2f}" for snr in levels]
    least = [
        f"{min(points, key=lambda variation: points[variation][0]):g}" for points in series.values()
    ]
    outcome.tables.append(
        Table(
            "Sensitivity to the mean variation: sum of squared errors of type-2 [m²], "
            f"{count(plan.sweep_seeds)}",
            ["mean variation, share of the range", *series],
            rows,
            "Reading 'parameters', strongest sample. The rule of this package takes "
            f"{listed(rule)} at {at} dB; of the values tried, the least mean errors are at "
            f"{listed(least)}. {in_brackets([plan.sweep_seeds], 'mean')}",
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
                average, diverged = (
                    results.mean(run, plan.sweep_seeds),
                    results.average(run, plan.sweep_seeds),
                )
                numbers[f"{terms}, {kind}, {decibels(snr)}"] = {
                    **as_numbers(average),
                    "diverged": diverged,
                }
                cells.append(with_share(average, diverged))
            rows.append([f"{terms} ({terms**4} rules)", LABELS[kind], *cells])
    outcome.numbers["terms"] = numbers
    few, many = plan.terms[0], plan.terms[-1]
    noisiest = decibels(plan.sweep_levels[0])

    def error(terms: int, kind: str, snr: str) -> float:
        return float(numbers[f"{terms}, {kind}, {snr}"]["value"])

    shares = listed(
        [
            f"{error(many, kind, snr) / error(few, kind, snr):.2f} of the error of {LABELS[kind]} "
            f"{'without noise' if snr == decibels(math.inf) else f'at {snr} dB'}"
            for kind, snr in (("it2", decibels(math.inf)), ("t1", noisiest), ("it2", noisiest))
        ]
    )
    outcome.tables.append(
        Table(
            "Sensitivity to the number of terms: sum of squared errors [m²], "
            f"{count(plan.sweep_seeds)}",
            [
                "terms of an input",
                "controller",
                *("no noise" if math.isinf(snr) else f"{snr:g} dB" for snr in levels),
            ],
            rows,
            "The learner is the table look-up of Wang and Mendel. Only it can fill the cells that "
            "the helix never visits, with the nearest rule; with three terms or more the other "
            "learners find rules that no sample fires, and raise an error. The thesis says that "
            "more terms 'do not "
            f"offer significant improvements' and shows no numbers. Here {plan.terms[-1]} terms "
            f"instead of {plan.terms[0]} leave {shares}. "
            f"{in_brackets([plan.sweep_seeds], 'mean')}",
            detail=True,
        )
    )


def other_trajectories(results: Outcomes, plan: Plan, outcome: Reproduction) -> None:
    """Add trajectories that the rules were not learned on, and where controllers break."""
    rows, numbers = [], {}
    for trajectory in plan.trajectories:
        open_loop = Run("feed-forward", trajectory=trajectory)
        lost = results.average(open_loop, 1) > 0.0
        end = results.values(open_loop, 1, "end_time")[0]
        cells = [
            f"lost after {end:.1f} s" if lost else significant(results.values(open_loop, 1)[0])
        ]
        runs = {
            LABELS[name]: Run(name, trajectory=trajectory) for name in ("pd", "pd-gravity", "ctc")
        }
        runs |= {
            "fuzzy": Run("it2", trajectory=trajectory),
            "fuzzy, ridge": Run("t1", trajectory=trajectory, learner="ridge"),
            "type-1, 20 dB": Run("t1", trajectory=trajectory, snr_db=20.0),
            "type-2, 20 dB": Run("it2", trajectory=trajectory, snr_db=20.0),
        }
        averages = {name: results.mean(run, plan.sweep_seeds) for name, run in runs.items()}
        cells += [results.shown(run, plan.sweep_seeds) for run in runs.values()]
        covered = results.values(runs["fuzzy"], 1, "coverage")[0]
        numbers[trajectory] = {
            **{name: as_numbers(estimate) for name, estimate in averages.items()},
            "coverage": covered,
            "feed-forward": {"diverged": lost, "end_time": end},
        }
        rows.append(
            [
                trajectory + (" (learned)" if trajectory == plan.trajectories[0] else ""),
                *cells,
                percent(covered),
            ]
        )
    outcome.numbers["trajectories"] = numbers
    outcome.tables.append(
        Table(
            f"Other trajectories: sum of squared errors [m²], {count(plan.sweep_seeds)} where "
            "there is noise",
            [
                "trajectory",
                *(LABELS[name] for name in ("feed-forward", "pd", "pd-gravity", "ctc")),
                "fuzzy, no noise",
                "fuzzy, ridge, no noise",
                "type-1, 20 dB",
                "type-2, 20 dB",
                "steps inside the trained range",
            ],
            rows,
            "Rules are learned on the helix (20 mm, 2 s per turn); fast-helix: 1 s per turn; "
            "fastest-helix: 0.4 s; large-helix: 23.5 mm, at the fold of the tip's workspace; "
            "waypoints: a square, one corner per second. The circle needs the same differences of "
            "heights as the helix, so it is not a new path for the rules. Without noise type-1 and "
            "type-2 are the same. Open-loop control does not hold the robot on its path, and "
            "loses it wherever it starts with the wrong speed. Outside of the trained range the "
            "inputs are clamped to it (last column: without noise, default rules). "
            f"{in_brackets([plan.sweep_seeds], 'mean')}",
            detail=True,
        )
    )
    home = numbers[plan.trajectories[0]]["fuzzy"]["value"]
    held = [name for name in plan.trajectories[1:] if np.isfinite(numbers[name]["fuzzy"]["value"])]
    lost_on = [name for name in plan.trajectories[1:] if name not in held]
    if not held:
        outcome.answer.append(
            "Away from the helix they learned on, the fuzzy controllers diverge, even without "
            "noise."
        )
        return
    worst = max(held, key=lambda name: numbers[name]["fuzzy"]["value"])
    outcome.answer.append(
        "Away from the helix they learned on, the fuzzy controllers "
        f"{f'diverge on {listed(lost_on)}' if lost_on else 'keep working'} without noise, with "
        f"the greatest error {'of the rest ' if lost_on else ''}on {worst} "
        f"({significant(numbers[worst]['fuzzy']['value'])} m², {significant(home)} m² on the "
        f"helix, CTC {significant(numbers[worst]['CTC']['value'])} m²)."
    )

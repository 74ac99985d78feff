"""Where numbers of the documents come from.

The job's ``results.json``, what the thesis prints, pages that other tests or programs write, and
constants that tests assert.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from psp3 import published
from psp3.study.run import Run
from psp3.study.table import Row
from psp3.thesis.findings import REPRODUCED, SAME_ORDER, Reproduction
from psp3.thesis.plan import NOISY, Outcomes, decibels
from tests.cross import test_built_robots, test_mujoco_robots, test_pinocchio
from tests.processes import ROOT

LEVELS = [decibels(snr) for snr in NOISY]
KINDS = ("t1", "it2")
NOTEBOOK_SEEDS = 12
"""Seeds of the studies in notebook 5."""
OTHER_PATHS = ["circle", "line", "large-helix", "waypoints"]
"""Paths besides the helix that are no faster than it."""


def sources(outcome: Reproduction, numbers: Mapping[str, Any], runs: list[Row]) -> dict[str, Any]:
    """Return all sources.

    Parameters
    ----------
    outcome : Reproduction
        What the job found, for its tables.
    numbers : mapping
        Its ``results.json``.
    runs : list of Row
        The runs in its study.
    """
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return {
        **numbers,
        "rows": {
            "results": _result_rows(outcome),
            "definitions": _definition_rows(numbers["definitions"]),
        },
        "printed": _printed(),
        "derived": _derived(numbers),
        "notebook": _of_the_notebook(Outcomes(runs)),
        "µs": _times(),
        "along a path": _along_a_path(),
        "board": _board(),
        "timed system": _timed_system(),
        "first use": _first_use(),
        "order": _tables("concepts/fuzzy_computed_torque.md", ("torque", "tracking"), r"\d+ dB"),
        "bars": {
            **test_pinocchio.BARS,
            "states": sum(test_pinocchio.STATES.values()),
            "mujoco": test_mujoco_robots.TOLERANCE,
            "mujoco states": test_mujoco_robots.STATES,
            "built": f"{test_built_robots.BAR:.0e}".replace("e-0", "e-"),
            "rounded": test_built_robots.ROUNDED,
        },
        "verdict": {"reproduced": REPRODUCED, "same order": SAME_ORDER},
        "python": project["requires-python"].removeprefix(">="),
        "version": project["version"],
        "license": project["license"],
    }


def beaten_on(trajectories: Mapping[str, Any]) -> list[str]:
    """Return the paths on which PD with gravity leaves less than the fuzzy controller."""
    return [
        name
        for name, found in trajectories.items()
        if found["PD with gravity"]["value"] < found["fuzzy"]["value"]
    ]


def rises(learners: Mapping[str, Any], learner: str) -> bool:
    """Return whether type-1's error over type-2's rises with the noise."""
    ratios = [learners[f"{learner}, {level}"]["ratio_it2"]["value"] for level in LEVELS]
    return ratios == sorted(ratios, reverse=True)


def rises_beyond_intervals(learners: Mapping[str, Any], learner: str) -> bool:
    """Return whether the intervals at the least and the most noise have nothing in common."""
    least, most = (learners[f"{learner}, {level}"]["ratio_it2"] for level in ("20", "10"))
    return bool(most["high"] < least["low"])


def row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _result_rows(outcome: Reproduction) -> list[str]:
    """Return the rows of the last table of docs/results.md: Table 6.3 and Figure 64."""

    def table(title: str) -> list[list[str]]:
        return next(table.rows for table in outcome.tables if table.title.startswith(title))

    rows = []
    for name, snr, printed, mean, spread, _, verdict in table("Table 6.3:"):
        if name not in ("PID", "general type-2"):
            at = {"–": "", "∞": ", no noise"}.get(snr, f" at {snr} dB")
            rows.append(row(name + at, printed, mean, spread, verdict))
    for rules, snr, _, printed, ratio, spread, _, wins, lost, verdict in table("Figure 64"):
        label = f"type-2 / type-1 at {snr} dB, {rules.partition(' of ')[0]}"
        more = f"{verdict}; type-1 wins in {wins.partition(',')[0]}; {lost} left out"
        rows.append(row(label, printed, ratio, spread, more))
    rows = [line.replace("spread of single runs", "spread") for line in rows]
    # Why, the page says above its table.
    rows = [re.sub(r"(\((?:×|[-+])[^)]*\)): [^;|]*?(?=;| \|)", r"\1", line) for line in rows]
    # A line of Markdown has plain spaces.
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in rows]


def _definition_rows(numbers: Mapping[str, Any]) -> list[str]:
    """Return the rows of the first table of docs/results.md: ratios by rule and at their best."""
    return [
        row(
            label,
            *(
                f"{by_level[snr]['ratio']['value']:.2f} / "
                f"{by_level[snr]['best_ratio']['value']:.2f}"
                for snr in LEVELS
            ),
            f"{by_level['20']['type_1']['value']:.3f}",
        )
        for label, by_level in numbers.items()
    ]


def _printed() -> dict[str, Any]:
    """Return what the thesis prints."""
    fuzzy = {
        decibels(snr): {**dict(zip(KINDS, pair, strict=True)), "ratio": pair[1] / pair[0]}
        for snr, pair in published.TABLE_6_3_FUZZY.items()
    }
    return {
        **published.TABLE_6_3,
        **fuzzy,
        "inverse": {snr: 1.0 / pair["ratio"] for snr, pair in fuzzy.items()},
        "step": dict(published.TABLE_6_2),
        "budget": published.STEP_BUDGET,
        "gains": {
            name: dict(zip("pv", pair, strict=True)) for name, pair in published.TABLE_6_1.items()
        },
        "terms": published.TABLE_6_1_TERMS,
        "growth": fuzzy["10"]["t1"] / fuzzy["20"]["t1"],
        # Section 5.4, of the terms that the figure draws.
        "noise of Figure 51": 0.1,
        "C11": published.TABLE_5_1_CORIOLIS[0, 0],
        "C31": published.TABLE_5_1_CORIOLIS[2, 0],
        "right C11": -published.TABLE_5_1_CORIOLIS[0, 1:].sum(),
        "right C31": -published.TABLE_5_1_CORIOLIS[2, 1:].sum(),
    }


def _derived(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Return ratios and extremes of numbers of the job."""
    fuzzy, learners = numbers["table_6_3"]["fuzzy"], numbers["learners"]
    times = {
        snr: {
            kind: fuzzy[snr][kind]["mean"]["value"] / fuzzy[snr][kind]["printed"] for kind in KINDS
        }
        for snr in ("∞", *LEVELS)
    }
    noisy = [times[snr][kind] for snr in LEVELS for kind in KINDS]

    def value(learner: str, snr: str, kind: str) -> float:
        return float(learners[f"{learner}, {snr}"][kind]["value"])

    wide = numbers["wider_type_1_terms"]
    averaged = [value("average", snr, "t1") / value("strongest", snr, "it2") for snr in LEVELS]
    widened = [wide[snr]["3"]["value"] / wide[snr]["it2"]["value"] for snr in LEVELS]
    others = [
        by_level
        for label, by_level in numbers["definitions"].items()
        if label not in ("mean square of each entry (taken here)", "mean square, on G alone")
    ]
    whole = [
        by_level
        for label, by_level in numbers["definitions"].items()
        if "taken here" not in label and "alone" not in label
    ]
    terms = {name: entry["value"] for name, entry in numbers["terms"].items()}
    classical = {
        name: numbers["table_6_3"][name]["sum_of_squared_errors"]
        for name in ("PD", "CTC", "PD with gravity")
    }
    readings = numbers["readings"].values()
    strongest = numbers["type_2_against_type_1"]
    looked_up = [
        value("strict", snr, kind) / fuzzy[snr][kind]["printed"] for snr in LEVELS for kind in KINDS
    ]
    worse = [
        entry["verdict"] == "type-1 better" for by_level in others for entry in by_level.values()
    ]
    small = numbers["definitions"]["mean square, on M and C alone"]
    coverage = {
        seeds: [share for name, share in by_interval.items() if name != "median"]
        for seeds, by_interval in numbers["measured_coverage"].items()
    }
    # Noise of 20 dB on G is a tenth of its root mean square.
    gravity = numbers["noise_on_gravity_at_20_dB"]
    share_of_what_varies = 10.0 * gravity["noise"] / gravity["standard_deviation"]
    return {
        "coverage": {
            seeds: {"least": min(shares), "most": max(shares)} for seeds, shares in coverage.items()
        },
        "of what G varies": {
            learner: share_of_what_varies * numbers["estimates"][learner]["G"]
            for learner in ("strongest", "ridge")
        },
        "star": numbers["parameters"]["default"]["star_inertia"][0]
        / numbers["parameters"]["table_3_1"]["star_inertia"][0],
        "strict times": {"min": min(looked_up), "max": max(looked_up)},
        "worse cells": sum(worse),
        "other cells": len(worse),
        "growth on M and C": small["10"]["type_1"]["value"] / small["20"]["type_1"]["value"],
        "largest type-1 under others": max(
            entry["type_1"]["value"] for by_level in whole for entry in by_level.values()
        ),
        "times": times,
        "least times": min(noisy),
        "most times": max(noisy),
        "CTC": classical["CTC"] / published.TABLE_6_3["CTC"],
        "PD": classical["PD"] / published.TABLE_6_3["PD"] - 1.0,
        "growth": fuzzy["10"]["t1"]["mean"]["value"] / fuzzy["20"]["t1"]["mean"]["value"],
        "better under": sum(
            all(entry["verdict"] == "type-2 better" for entry in by_level.values())
            for by_level in numbers["definitions"].values()
        ),
        "definitions": len(numbers["definitions"]),
        "averaged": {"least": min(averaged), "most": max(averaged)},
        "wide share": {
            snr: wide[snr]["3"]["value"] / fuzzy[snr]["t1"]["mean"]["value"] for snr in LEVELS
        },
        "widened": {"least": min(widened), "most": max(widened)},
        "ours": {
            extreme.__name__: extreme(entry["ratio"]["value"] for entry in strongest.values())
            for extreme in (min, max)
        },
        "others": {
            extreme.__name__: extreme(
                entry["ratio"]["value"] for by_level in others for entry in by_level.values()
            )
            for extreme in (min, max)
        },
        "whole": {
            extreme.__name__: extreme(
                entry["ratio"]["value"] for by_level in whole for entry in by_level.values()
            )
            for extreme in (min, max)
        },
        "type-1 under others": {
            extreme.__name__: extreme(entry["20"]["type_1"]["value"] for entry in whole)
            for extreme in (min, max)
        },
        "growth under others": {
            extreme.__name__: extreme(
                entry["10"]["type_1"]["value"] / entry["20"]["type_1"]["value"] for entry in whole
            )
            for extreme in (min, max)
        },
        "typical inverse": {
            snr: 1.0 / strongest[snr]["ratio_of_geometric_means"]["value"] for snr in LEVELS
        },
        "inverse of averages": {
            snr: 1.0 / learners[f"average, {snr}"]["ratio_it2"]["value"] for snr in LEVELS
        },
        "four terms": {
            kind: {
                snr: terms[f"4, {kind}, {snr}"] / terms[f"2, {kind}, {snr}"]
                for snr in ("∞", *LEVELS)
            }
            for kind in KINDS
        },
        "left out": {
            snr: numbers["seeds"]["table_6_3"] - entry["seeds_compared"]
            for snr, entry in strongest.items()
        },
        "wins": {
            snr: entry["type_1_wins"] / entry["seeds_compared"] for snr, entry in strongest.items()
        },
        "worse readings": sum(entry["difference"]["low"] > 0.0 for entry in readings),
        "readings": len(numbers["readings"]),
        "sags": {
            extreme.__name__: extreme(
                numbers["trajectories"][name]["PD"]["value"] for name in OTHER_PATHS
            )
            for extreme in (min, max)
        },
        "PD over PD with gravity": classical["PD"] / classical["PD with gravity"],
    }


def _of_the_notebook(results: Outcomes) -> dict[str, Any]:
    """Return what notebook 5 finds with its seeds, from the same runs of the job."""
    levels, learners = {"20": 20.0, "10": 10.0}, ("strongest", "average", "ridge")
    ratios = {
        learner: {
            name: results.ratio(Run(learner=learner, snr_db=snr), "it2", NOTEBOOK_SEEDS)
            for name, snr in levels.items()
        }
        for learner in learners
    }
    clear = [ratio.value for learner in learners[:2] for ratio in ratios[learner].values()]

    def type_1(learner: str, snr: float) -> float:
        return results.mean(Run("t1", learner=learner, snr_db=snr), NOTEBOOK_SEEDS).value

    runs = (
        *(Run("t1", snr_db=20.0, term_width=width) for width in (1.0, 1.5, 2.0)),
        Run("it2", snr_db=20.0),
    )
    errors = [results.values(run, NOTEBOOK_SEEDS) for run in runs]
    spreads = [float(values.max() / values.min()) for values in errors]
    return {
        "seeds": NOTEBOOK_SEEDS,
        "ratios": ratios,
        "least ratio": min(clear),
        "most ratio": max(clear),
        "learner": {
            name: type_1("strongest", snr) / type_1("average", snr) for name, snr in levels.items()
        },
        "type": {name: 1.0 / ratios["strongest"][name].value for name in levels},
        "least spread": min(spreads),
        "most spread": max(spreads),
        "diverged": round(results.average(Run("t1", snr_db=10.0), NOTEBOOK_SEEDS) * NOTEBOOK_SEEDS),
    }


def _times() -> dict[str, dict[str, str]]:
    """Return the first column of every table of docs/benchmarks.md, by the section's heading."""
    text = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    found: dict[str, dict[str, str]] = {}
    for section in text.split("\n## ")[1:]:
        heading, _, rest = section.partition("\n")
        found[heading] = dict(re.findall(r"^\| ([^|]+) \| ([^|]+) \|", rest, flags=re.MULTILINE))
    return found


def _along_a_path() -> dict[str, str]:
    """Return the times of inverse dynamics in docs/benchmarks.md, and those over MuJoCo's."""
    text = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    section = text.partition("## Robots with loops in general")[2].partition("chains of")[0]
    robots, times = re.findall(
        r"^\| (?:\[µs\]|inverse_dynamics, from the pose before) \| (.*) \|$",
        section,
        flags=re.MULTILINE,
    )
    (of_mujoco,) = re.findall(r"`inverse_dynamics` takes ([\d.]+) ×", section)
    return {
        **dict(zip(robots.split(" | "), times.split(" | "), strict=True)),
        "of MuJoCo": of_mujoco,
    }


def _board() -> dict[str, Any]:
    """Return how many entries the board of docs/how_to/benchmark.md has, and its best learner."""
    text = (ROOT / "docs" / "how_to" / "benchmark.md").read_text(encoding="utf-8")
    rows = re.findall(
        r"^\| \d+ \| `([^`]+)` \| (the model|samples) \| (.*) \|$", text, re.MULTILINE
    )
    entry, _, cells = next(row for row in rows if row[1] == "samples")
    times = re.search(r"([\d.]+) \(([\d.]+) to ([\d.]+)\)", cells)
    assert times is not None
    return {
        "entries": len(rows),
        "learner": {
            "entry": entry,
            **dict(zip(("times", "low", "high"), times.groups(), strict=True)),
        },
    }


def _timed_system() -> dict[str, str]:
    """Return the size of the fuzzy systems that docs/benchmarks.md times."""
    text = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    match = re.search(r"(?P<rules>\d+) rules, (?P<outputs>\d+) outputs", text)
    assert match is not None
    return match.groupdict()


def _first_use() -> dict[str, str]:
    """Return the times of docs/benchmarks.md from a clone to a robot that moves, and to the job."""
    text = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    match = re.search(
        r"`make view` takes (?P<view>\d+) s .*`make reproduce`\s+takes (?P<reproduce>\d+) s",
        text,
        flags=re.DOTALL,
    )
    assert match is not None
    return match.groupdict()


def _tables(page: str, names: tuple[str, ...], first: str) -> dict[str, dict[str, list[str]]]:
    """Return tables of a page by names and by the first cells of their rows, which match ``first``.

    A table begins where a first cell comes again.
    """
    text = (ROOT / "docs" / Path(page)).read_text(encoding="utf-8")
    tables: list[dict[str, list[str]]] = [{}]
    for head, rest in re.findall(rf"^\| ({first}) \| (.*) \|$", text, flags=re.MULTILINE):
        if head in tables[-1]:
            tables.append({})
        tables[-1][head] = [cell.strip() for cell in rest.split("|")]
    return dict(zip(names, tables, strict=True))

"""The results in the README are those of the job, cell by cell.

They are worked out anew, with the seeds that the README names. A row that is not the report's fails
with the row that is.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

import psp3
from psp3.loading import load
from psp3.study.run import Run, simulate_run
from psp3.thesis import chapter_6, definitions, figure_64
from psp3.thesis.findings import Reproduction, Table
from psp3.thesis.plan import DEFINITIONS, FUZZY, NOISY, Outcomes, Plan, decibels
from tests.processes import ROOT

pytestmark = pytest.mark.slow

README = (ROOT / "README.md").read_text(encoding="utf-8")
PLAN = replace(Plan.of(30), sweep_levels=NOISY)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Reproduction:
    """Return what the job finds, of the part of its runs that the README shows."""
    path: Path = tmp_path_factory.mktemp("readme") / "study.sqlite"
    seeds = range(PLAN.seeds)
    runs = (
        *psp3.grid(controller=FUZZY, snr_db=(float("inf"), *NOISY), seed=seeds),
        *psp3.grid(controller="t1", learner="average", snr_db=NOISY, seed=seeds),
        *psp3.grid(controller=("t1", "it2"), learner="strict", snr_db=NOISY, seed=seeds),
        *PLAN.of_definitions(),
    )
    study = psp3.Study(path, runs)
    study.run()
    outcome, results = Reproduction(), Outcomes(study.rows())
    for name, controller in (("PD", "pd"), ("CTC", "ctc"), ("PD with gravity", "pd-gravity")):
        outcome.results[name] = simulate_run(Run(controller)).result
    robot = load("psp3")
    definitions.definitions(robot, results, PLAN, outcome)
    chapter_6.table_6_3(robot, results, PLAN, outcome)
    figure_64.type_2_against_type_1(results, PLAN, outcome)
    return outcome


def table(outcome: Reproduction, title: str) -> Table:
    return next(table for table in outcome.tables if table.title.startswith(title))


def shown(first: str) -> list[str]:
    """Return the rows of the README's table with that first heading."""
    match = re.search(
        rf"^\| {re.escape(first)} \|.*\n\|[-|]+\|\n((?:\|.*\n)+)", README, re.MULTILINE
    )
    assert match is not None
    return match.group(1).splitlines()


def row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def expected_results(outcome: Reproduction) -> list[str]:
    """Return printed, mean, spread of single runs and verdict of Table 6.3 and Figure 64."""
    rows = []
    for name, snr, printed, mean, spread, _, verdict in table(outcome, "Table 6.3:").rows:
        if name not in ("PID", "general type-2"):
            at = {"–": "", "∞": ", no noise"}.get(snr, f" at {snr} dB")
            rows.append(row(name + at, printed, mean, spread, verdict))
    for rules, snr, _, printed, ratio, spread, _, wins, lost, verdict in table(
        outcome, "Figure 64"
    ).rows:
        label = f"type-2 / type-1 at {snr} dB, {rules}"
        more = f"{verdict}; type-1 wins in {wins}; {lost} left out"
        rows.append(row(label, printed, ratio, spread, more))
    return rows


def expected_definitions(outcome: Reproduction) -> list[str]:
    """Ratios by rule and with the mean variation that suits best, of every definition."""
    numbers = outcome.numbers["definitions"]
    return [
        row(
            label,
            *(
                f"{entry['ratio']['value']:.2f} / {entry['best_ratio']['value']:.2f}"
                for entry in (numbers[label][decibels(snr)] for snr in NOISY)
            ),
            *(f"{numbers[label]['20']['type_1']['value']:.3f}",),
        )
        for label in DEFINITIONS
    ]


def test_results_are_those_of_the_report(found: Reproduction) -> None:
    expected = expected_results(found)
    assert shown("result") == expected, "\n".join(["the rows are", *expected])


def test_definitions_are_those_of_the_report(found: Reproduction) -> None:
    expected = expected_definitions(found)
    assert shown("noise against") == expected, "\n".join(["the rows are", *expected])

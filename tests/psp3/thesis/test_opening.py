"""What the report opens with, on results that are made up."""

from __future__ import annotations

import math
from typing import Any

import pytest

from psp3.thesis import beyond, definitions, figure_64, opening
from psp3.thesis.findings import Reproduction
from psp3.thesis.plan import Outcomes
from psp3.three_psp.robot import PSP3
from tests.legible import check_texts, labels_of
from tests.psp3.thesis.outcomes import PLAN, rows


def numbers(robot: PSP3, exact: float, **factors: float) -> dict[str, Any]:
    """Return what the modules of the tables would find, but for what is measured or simulated."""
    results, outcome = Outcomes(rows(**factors)), Reproduction()
    definitions.definitions(robot, results, PLAN, outcome)
    figure_64.type_2_against_type_1(results, PLAN, outcome)
    beyond.averaging(results, PLAN, outcome)
    fuzzy = {
        level: {kind: {"mean": {"value": 1.0}, "printed": 2.0} for kind in ("t1", "it2")}
        for level in ("∞", "20", "15", "10")
    }
    fuzzy["10"]["t1"]["mean"]["value"] = math.nan
    errors = {
        name: {"sum_of_squared_errors": exact, "printed_sum_of_squared_errors": exact}
        for name in ("PD", "CTC")
    }
    return outcome.numbers | {
        "table_6_3": {**errors, "fuzzy": fuzzy},
        "table_6_2": {"CTC, closed_form": {"printed": 0.255, "median": 1e-5}},
        "table_5_1": {"largest_mass_error": 0.007, "printed_coriolis_column_sum_gap": 0.03},
    }


@pytest.mark.parametrize(
    ("exact", "it2", "said", "unsaid"),
    [
        (0.5, 0.5, "under 6 of 6 definitions", "wider membership functions"),
        (0.5, 2.0, "under 0 of 6 definitions", "do not track better"),
        (1.5, 0.5, "do not track better than the best of them.", "track best"),
    ],
)
def test_the_sentence_changes_with_the_numbers(
    exact: float, it2: float, said: str, unsaid: str
) -> None:
    outcome = Reproduction(numbers=numbers(opening_robot(), exact, it2=it2))
    opening.opening(PLAN, outcome)
    assert said in outcome.sentence
    assert unsaid not in outcome.sentence
    assert outcome.sentence.count(".") == 1
    (table,) = outcome.tables
    assert table.opening
    assert {len(row) for row in table.rows} == {len(table.columns)}
    verdicts = {row[0]: row[-1] for row in table.rows}
    assert verdicts["error of type-1 at 10 dB [m²]"] == "not reproduced: every run diverged"
    assert all(":" in verdict for verdict in verdicts.values())


def opening_robot() -> PSP3:
    from psp3.loading import load

    robot = load("psp3")
    assert isinstance(robot, PSP3)
    return robot


def test_the_figure_has_a_point_for_every_mean_and_readable_texts() -> None:
    errors = opening.errors_of_result(Outcomes(rows(it2=0.5)), PLAN)
    assert list(errors["type-2"]) == [20.0, 15.0, 10.0]
    assert errors["type-2"][20.0][0] == pytest.approx(0.5 * errors["type-1"][20.0][0], rel=1e-12)
    (panel,) = opening.figure_of_result(errors, {"PD": 4.66, "exact computed torque": 0.0185})
    assert len(panel.containers) == len(errors) == 5
    figure = panel.get_figure(root=True)
    assert figure is not None
    check_texts(figure, [*labels_of(panel), *panel.texts])

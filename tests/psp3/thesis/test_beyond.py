"""What the thesis did not show: the tables say what the runs say."""

from __future__ import annotations

import math

import pytest

from psp3.study.run import Run
from psp3.thesis import beyond, plan
from psp3.thesis.findings import Reproduction
from psp3.thesis.plan import Outcomes
from tests.psp3.thesis.outcomes import PLAN, rows


def test_learners_where_type_2_always_wins() -> None:
    outcome = Reproduction()
    beyond.learners(Outcomes(rows(it2=0.5)), PLAN, outcome)
    assert "Type-2 beats type-1 in every noisy row" in outcome.tables[0].note
    assert "not always" not in outcome.answer[0]
    assert "matters more than the type" in outcome.answer[0]


def test_readings_count_what_was_shown() -> None:
    outcome = Reproduction()
    beyond.readings(Outcomes(rows(it2=1.5)), PLAN, outcome)
    assert "worse in 9 of 9" in outcome.answer[0]
    beyond.readings(Outcomes(rows(it2=0.5)), PLAN, outcome)
    assert "better in 9 of 9" in outcome.answer[1]
    beyond.readings(Outcomes(rows(it2=1.0)), PLAN, outcome)
    assert outcome.answer[2].endswith("worse in 0 of 9 cases.")


def test_readings_show_how_many_runs_diverged() -> None:
    outcome = Reproduction()
    made_up = rows(it2=1.5)
    for row in made_up:
        if (row["controller"], row["reading"], row["snr_db"], row["seed"]) == (
            "ctc",
            "plant",
            15.0,
            2,
        ):
            row.update(diverged=1.0, sum_of_squared_errors=math.nan)
    beyond.readings(Outcomes(made_up), PLAN, outcome)
    cells = [cell for row in outcome.tables[0].rows for cell in row if "diverged" in cell]
    assert len(cells) == 1
    assert cells[0].endswith(", 17 % diverged")


def test_sweeps_have_a_row_for_every_value_and_say_where_the_least_error_is() -> None:
    outcome = Reproduction()
    made_up = rows(it2=0.8)
    for row in made_up:
        if row["mean_variation"] == 0.3 and row["snr_db"] == 15.0:
            row["sum_of_squared_errors"] *= 0.1
    series = beyond.mean_variations(Outcomes(made_up), PLAN, outcome)
    assert list(series) == ["no noise", "20 dB", "15 dB", "10 dB"]
    for points in series.values():
        assert list(points) == [0.0, *PLAN.variations]
    assert [row[0] for row in outcome.tables[0].rows] == [
        "0 (type-1)",
        *(f"{value:g}" for value in PLAN.variations),
    ]
    least = outcome.tables[0].note.split("least mean errors are at ")[1]
    assert least.split(", ")[2].startswith("0.3 and")
    beyond.numbers_of_terms(Outcomes(made_up), PLAN, outcome)
    assert [row[0] for row in outcome.tables[1].rows] == ["2 (16 rules)"] * 2 + ["3 (81 rules)"] * 2


def test_trajectories_show_where_open_loop_is_lost() -> None:
    outcome = Reproduction()
    made_up = rows()
    for row in made_up:
        if row["controller"] == "feed-forward" and row["trajectory"] == "circle":
            row.update(diverged=1.0, end_time=3.21, sum_of_squared_errors=math.nan)
        if row["controller"] == "it2" and row["trajectory"] == "line" and row["snr_db"] == math.inf:
            row["sum_of_squared_errors"] = 7.0
    beyond.other_trajectories(Outcomes(made_up), PLAN, outcome)
    cells = {row[0]: row[1] for row in outcome.tables[0].rows}
    assert cells["circle"] == "lost after 3.2 s"
    assert "lost" not in cells["line"]
    assert (
        "keep working without noise, with the greatest error on line (7.00 m²" in outcome.answer[0]
    )


def test_trajectories_on_which_learned_controllers_are_lost_are_named() -> None:
    outcome = Reproduction()
    made_up = rows()
    for row in made_up:
        if (
            row["controller"] == "it2"
            and (row["trajectory"] == "fast-helix" or row["seed"] == 1)
            and row["trajectory"] != "helix"
        ):
            row.update(diverged=1.0, sum_of_squared_errors=math.nan)
    beyond.other_trajectories(Outcomes(made_up), PLAN, outcome)
    assert (
        "diverge on fast-helix without noise, with the greatest error of the rest on"
        in outcome.answer[0]
    )
    shown = {row[0]: row[8] for row in outcome.tables[0].rows}
    assert shown["fast-helix"] == "–, 100 % diverged"
    assert shown["line"].endswith("), 17 % diverged")
    for row in made_up:
        if row["controller"] == "it2" and row["trajectory"] != "helix":
            row.update(diverged=1.0, sum_of_squared_errors=math.nan)
    beyond.other_trajectories(Outcomes(made_up), PLAN, outcome)
    assert "the fuzzy controllers diverge, even without noise" in outcome.answer[1]


@pytest.mark.parametrize(("gain", "said"), [(0.5, 1), (2.0, 0)])
def test_wider_type_1_terms_are_set_against_type_2(gain: float, said: int) -> None:
    """The table and the sentence follow the runs.

    Here wide type-1 terms leave ``gain`` times what type-2 leaves.
    """
    made_up = rows(it2=0.5)
    type2 = Outcomes(made_up)
    for row in made_up:
        if row["term_width"] != 1.0:
            run = Run("it2", snr_db=row["snr_db"], seed=row["seed"], learner=row["learner"])
            row[plan.ERROR] = gain * float(type2.values(run, row["seed"] + 1)[-1])
    outcome = Reproduction()
    beyond.averaging(Outcomes(made_up), PLAN, outcome)
    assert len(outcome.answer) == said
    of_strongest, of_average = outcome.tables[0].rows[:4], outcome.tables[0].rows[4:]
    for first, *noisy in (of_strongest, of_average):
        assert all(("type-1 × 3 better" in row[-1]) == (gain < 1.0) for row in noisy)
        assert all(row[-2] == ("6 of 6, 100 %" if said else "0 of 6, 0 %") for row in noisy)
        assert (first[1], first[-1], len(noisy)) == ("∞", "type-2 is type-1 here", 3)
    if said:
        assert outcome.answer[0].count("wins in 6 of 6, 6 of 6 and 6 of 6 seeds") == 2


def test_shares_of_broken_runs_are_those_of_the_runs() -> None:
    made_up = rows()
    for row in made_up:
        row["left_stroke"] = float(row["snr_db"] <= 5.0)
        row["diverged"] = float(row["snr_db"] <= 0.0 and row["controller"] == "t1")
    outcome = Reproduction()
    beyond.breaking_noise(Outcomes(made_up), PLAN, outcome)
    (table,) = outcome.tables
    for controller, _, *cells in table.rows:
        assert cells == ["0 % / 0 %"] * 3 + [
            "100 % / 0 %",
            f"100 % / {100 if controller == 'type-1' else 0} %",
        ]

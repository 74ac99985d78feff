"""Scores, order and intervals, against loops and a bootstrap by brute force."""

from __future__ import annotations

import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import psp3.benchmark
from psp3.benchmark.board import Board
from psp3.benchmark.trial import Trial
from psp3.checks import Array
from tests.psp3.benchmark.made import (
    CONDITIONS,
    DURATION,
    PERIOD,
    Exact,
    board_of,
    entry_of,
    outcome_of,
)

SEEDS = 12
SCHEMA = json.loads((Path(psp3.benchmark.__file__).parent / "schema.json").read_text("utf-8"))


def skewed(scale: float, seed: int, spread: float = 0.4) -> Array:
    """Return errors [m] by condition, seed and path; those of a seed have a common factor."""
    common = np.random.default_rng(99).lognormal(0.0, 0.6, (1, SEEDS, 1))
    own = np.random.default_rng(seed).lognormal(0.0, spread, (2, SEEDS, 2))
    return scale * common * own


ERRORS = {"ctc": skewed(1e-4, 1), "third": skewed(4e-3, 2), "second": skewed(1e-3, 3)}


def scores_by_hand(board: Board, name: str) -> list[float]:
    """Return the score of every seed by loops; cells are in the order of conditions and paths."""
    scores = []
    for seed in range(SEEDS):
        product, count = 1.0, 0
        for condition in range(2):
            for path in range(2):
                most = board.extent(board.cells[2 * condition + path])
                error = float(ERRORS_OF[name][condition, seed, path])
                product *= error if error < most else most
                count += 1
        scores.append(product ** (1.0 / count))
    return scores


ERRORS_OF = ERRORS | {
    "lost": np.where(np.arange(SEEDS)[:, np.newaxis] < 3, np.inf, skewed(2e-3, 4)),
    "far": np.full((2, SEEDS, 2), 7.0),
}


@pytest.fixture(scope="module")
def board() -> Board:
    return board_of(ERRORS_OF)


def test_order_and_scores_are_those_of_loops(board: Board) -> None:
    expected = {
        name: math.exp(sum(map(math.log, scores_by_hand(board, name))) / SEEDS)
        for name in ERRORS_OF
    }
    assert [score.entry.name for score in board.ranked] == sorted(
        expected, key=expected.__getitem__
    )
    for place, score in enumerate(board.scores):
        assert score.error.value == pytest.approx(expected[score.entry.name], rel=1e-12)
        assert score.problem == ""
        if place:
            assert score.to_best.value == pytest.approx(
                expected[score.entry.name] / expected["ctc"], rel=1e-12
            )


def test_paired_intervals_are_those_of_a_bootstrap_of_seeds_by_brute_force(board: Board) -> None:
    """Percentiles of a hundred thousand resamples of whole seeds.

    They know nothing of Student's law, whose reach at 12 seeds is 2.20 standard errors where theirs
    is 1.96 times the square root of 11/12: wider by 1.17. The rest is skewness.
    """
    one, other = (np.array(scores_by_hand(board, name)) for name in ("third", "second"))
    drawn = np.random.default_rng(5).integers(SEEDS, size=(100_000, SEEDS))
    ratios = np.exp((np.log(one) - np.log(other))[drawn].mean(axis=1))
    low, high = np.quantile(ratios, [0.025, 0.975])
    found = board.ratio("third", "second")
    assert found.value == pytest.approx(np.exp(np.log(one / other).mean()), rel=1e-12)
    widths = np.log(found.high / found.low), np.log(high / low)
    assert widths[0] / widths[1] == pytest.approx(1.17, abs=0.06)
    assert np.log(found.low / low) == pytest.approx(np.log(high / found.high), abs=0.1 * widths[0])


def test_seeds_are_paired(board: Board) -> None:
    """What seeds have in common is not in the ratio: shuffled seeds would make it much wider."""
    one, other = (np.array(scores_by_hand(board, name)) for name in ("third", "second"))
    apart = np.hypot(np.log(one).std(ddof=1), np.log(other).std(ddof=1))
    found = board.ratio("third", "second")
    assert np.log(found.high / found.low) < 0.6 * 2.0 * 2.2 * apart / np.sqrt(SEEDS)


def test_who_loses_the_robot_counts_as_who_is_off_by_the_whole_path(board: Board) -> None:
    by_name = {score.entry.name: score for score in board.scores}
    far, lost = by_name["far"], by_name["lost"]
    assert far.error.value == pytest.approx(
        np.exp(np.mean([np.log(board.extent(cell)) for cell in board.cells]))
    )
    assert (far.diverged, lost.diverged) == (0.0, 0.25)
    assert lost.effort == 1.0
    for cell, one in lost.cells.items():
        assert one.diverged.value == 0.25
        assert one.error.value < board.extent(cell)


def test_who_raised_has_no_place_and_its_error_is_said() -> None:
    board = board_of(ERRORS, ("second", "ValueError: no"))
    assert [score.entry.name for score in board.scores] == ["ctc", "third", "second"]
    assert board.scores[-1].problem == "psp3: ValueError: no"
    assert math.isnan(board.scores[-1].to_best.value)


def test_trials_that_are_not_done_are_said() -> None:
    board = board_of({"ctc": ERRORS["ctc"]})
    short = Board(
        board.entries,
        dict(list(board._outcomes.items())[:-1]),
        *map(board.__getattribute__, ("robots", "conditions", "seeds", "duration", "period")),
    )
    assert short.scores[0].problem == "not all of its trials are done"


@pytest.mark.parametrize("problem", [None, ("second", "ValueError: no")])
def test_numbers_follow_the_schema_and_hold_the_scores(problem: tuple[str, str] | None) -> None:
    board = board_of(ERRORS_OF, problem)
    numbers = json.loads(json.dumps(board.as_numbers(), allow_nan=False))
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.validate(numbers, SCHEMA)
    by_name = {score.entry.name: score for score in board.scores}
    for entry in numbers["entries"]:
        score = by_name[entry["name"]]
        assert (entry["place"] is None) == bool(score.problem)
        if not score.problem:
            assert entry["error"]["value"] == score.error.value
            assert entry["to_best"]["high"] == score.to_best.high
            assert len(entry["cells"]) == len(board.cells)


def test_schema_refuses_what_is_missing() -> None:
    numbers = board_of(ERRORS).as_numbers()
    del numbers["entries"][0]["effort"]
    with pytest.raises(jsonschema.ValidationError, match="effort"):
        jsonschema.validate(numbers, SCHEMA)


def test_what_no_seed_changes_is_one_run() -> None:
    """Who draws nothing runs once without noise; with noise every seed is a run of its own."""
    by_seed = [Trial("psp3", "outputs", 20.0, seed, DURATION, PERIOD) for seed in range(SEEDS)]
    once = Trial("psp3", seed=0, duration=DURATION, period=PERIOD)
    outcomes = {
        ("mine", trial): outcome_of({"trained": math.inf, "untrained": 1e-3 * (2 + trial.seed)})
        for trial in (once, *by_seed)
    }
    mine = entry_of("mine", Exact)
    board = Board((mine,), outcomes, ("psp3",), CONDITIONS, SEEDS, DURATION, PERIOD)
    (score,) = board.ranked
    counts = {(cell.reading, cell.path): one for cell, one in score.cells.items()}
    for path, lost in (("trained", 1.0), ("untrained", 0.0)):
        for reading, count in (("none", 1), ("outputs", SEEDS)):
            found = counts[reading, path]
            assert (found.diverged.value, found.diverged.count) == (lost, count)
            assert found.error.count == count
    # Of one run there is no interval of the error; of the seeds there is one.
    assert math.isnan(counts["none", "untrained"].error.low)
    assert counts["outputs", "untrained"].error.low < counts["outputs", "untrained"].error.value
    # Wilson's for all of 12: 1 / (1 + z² / n).
    assert counts["outputs", "trained"].diverged.low == pytest.approx(1 / (1 + 1.959964**2 / SEEDS))
    assert score.diverged == 0.5
    assert score.error.count == SEEDS

"""``psp3 benchmark`` as a user meets it: the board, the files, wrong input."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from psp3.benchmark import benchmark as library
from psp3.benchmark.entries import Entry
from psp3.benchmark.trial import Outcome, Trial
from tests.psp3.cli.answers import Run, words

QUICK = ("--robot", "psp3", "--seeds", 2, "--duration", 0.2, "--workers", 1)
MINE = """
import numpy as np

class Mean:
    def fit(self, X, Y):
        self.mean = Y.mean(axis=0)

    def predict(self, X):
        return np.tile(self.mean, (len(X), 1))
"""


def test_a_file_is_ranked_beside_names_and_the_pages_are_written(
    psp3_command: Run, tmp_path: Path
) -> None:
    (tmp_path / "mine.py").write_text(MINE, "utf-8")
    status, out, err = psp3_command("benchmark", "mine.py", "t1-average", *QUICK)
    assert status == 0
    assert max(map(len, out.splitlines())) <= 80
    assert err.splitlines()[0] == "[0/7]"
    assert re.fullmatch(r"\[7/7\] \d+\.\d trials/s", err.splitlines()[-1])
    assert out.splitlines()[-2:] == ["benchmark/benchmark.html", "benchmark/benchmark.json"]
    board = json.loads((tmp_path / "benchmark" / "benchmark.json").read_text("utf-8"))
    assert [entry["name"] for entry in board["entries"]] != ["mine"]
    assert {entry["name"] for entry in board["entries"]} == {"ctc", "mine", "t1-average"}
    assert all(entry["place"] for entry in board["entries"])
    best = board["entries"][0]
    assert f"First of all is {best['name']}" in words(out)
    again = psp3_command("benchmark", "mine.py", "t1-average", *QUICK)
    assert again.err == "[7/7]\n"
    assert again.out == out


def test_all_readings_are_asked_for_by_one_word(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def fails(trial: Trial, entry: Entry) -> Outcome:
        return {"error": "no"}

    monkeypatch.setattr(library, "execute", fails)
    arguments = ("--reading", "all", "--snr", 20, "--snr", 10, *QUICK, "--out", "there")
    assert psp3_command("benchmark", "lqr", *arguments).status == 0
    board = json.loads((tmp_path / "there" / "benchmark.json").read_text("utf-8"))
    assert len(board["settings"]["levels"]) == 1 + 7 * 2


def test_ctrl_c_says_what_is_kept(psp3_command: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(trial: Trial, entry: Entry) -> Outcome:
        raise KeyboardInterrupt

    monkeypatch.setattr(library, "execute", interrupted)
    status, _, err = psp3_command("benchmark", "lqr", *QUICK)
    assert status == 130
    assert "0 of 2 runs are in benchmark; run the same command to continue" in words(err)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("best",), "unknown entry 'best'"),
        (("absent.py",), "absent.py: no such file"),
        (("ctc", "--robot", "hexapod"), "unknown robot of the benchmark 'hexapod'"),
        (("ctc", "--reading", "loud"), "unknown reading of noise 'loud'"),
        (
            ("ctc", "--workers", "2", "--scheduler", "tcp://127.0.0.1:8786"),
            "--workers does not apply to --scheduler, which has its own",
        ),
        (("ctc", "--scheduler", "there"), "scheduler must be an address such as tcp://host:8786"),
    ],
)
def test_wrong_input_is_said_in_one_line(
    psp3_command: Run, arguments: tuple[str, ...], message: str
) -> None:
    status, _, err = psp3_command("benchmark", *arguments)
    assert status == 2
    assert message in words(err)

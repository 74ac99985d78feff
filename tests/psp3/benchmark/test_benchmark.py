"""The benchmark: what is done once, what is resumed, what ends it."""

from __future__ import annotations

import math
import os
import pickle
import signal
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from psp3.benchmark import benchmark, file
from psp3.benchmark.baselines import BASELINES
from psp3.benchmark.benchmark import ALL, FILE, Benchmark
from psp3.benchmark.entries import MODEL, SAMPLES, Entry, load_entry
from psp3.benchmark.file import OutcomeFile
from psp3.benchmark.readings import NONE
from psp3.benchmark.tasks import task
from psp3.benchmark.trial import Outcome, Trial
from psp3.errors import (
    InvalidEntry,
    InvalidValue,
    MissingPackage,
    StudyInterrupted,
    UnknownName,
    WorkersLost,
)
from tests.psp3.benchmark.made import Exact, entry_of, outcome_of

QUICK: dict[str, Any] = {"robots": ("psp3",), "seeds": 2, "duration": 0.2}
MINE = entry_of("mine", Exact)


@pytest.fixture
def done(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, Trial]]:
    """Count trials instead of doing them."""
    found: list[tuple[str, Trial]] = []

    def invented(trial: Trial, entry: Entry) -> Outcome:
        found.append((entry.name, trial))
        error = 1e-3 * (1 + trial.seed)
        return outcome_of({"trained": error, "untrained": 2.0 * error})

    monkeypatch.setattr(benchmark, "execute", invented)
    return found


def test_what_a_seed_does_not_change_is_done_once(
    tmp_path: Path, done: list[tuple[str, Trial]]
) -> None:
    """Exact computed torque sees noise of measurement only, and others see theirs.

    So it runs once without noise and twice with that noise; who learns and draws nothing once
    without and twice under each reading; who draws twice under everything.
    """
    asked = Benchmark(
        tmp_path,
        [MINE, replace(MINE, name="drawing", draws=True)],
        readings=("outputs", "measurement"),
        **QUICK,
    )
    assert asked.run(workers=1) == len(done) == 3 + 5 + 6
    assert [trial.seed for name, trial in done if name == "ctc" and trial.reading == NONE] == [0]
    assert not [name for name, trial in done if name == "ctc" and trial.reading == "outputs"]


def test_what_is_in_the_file_is_not_done_again_and_a_changed_entry_is(
    tmp_path: Path, done: list[tuple[str, Trial]]
) -> None:
    heard: list[tuple[int, int]] = []
    assert Benchmark(tmp_path, [MINE], **QUICK).run(1) == 4
    again = Benchmark(tmp_path, [MINE], **QUICK)
    assert again.run(1, progress=lambda now, total, rate: heard.append((now, total))) == 0
    assert heard == [(4, 4)]
    assert Benchmark(tmp_path, [MINE], **QUICK | {"seeds": 4}).run(1) == 2
    assert Benchmark(tmp_path, [replace(MINE, mark="new")], **QUICK).run(1) == 3


def test_an_edited_file_and_edited_packages_run_anew_and_their_old_outcomes_stay(
    tmp_path: Path, done: list[tuple[str, Trial]], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.py"
    text = "class A:\n def fit(self, X, Y): {}\n def predict(self, X): 0\n"

    def run(content: str) -> int:
        path.write_text(text.format(content), "utf-8")
        return Benchmark(tmp_path, [str(path)], **QUICK).run(1)

    assert [run(content) for content in ("0", "0", "1", "0")] == [4, 0, 3, 0]
    monkeypatch.setattr(file, "stamp", lambda: "other sources")
    assert run("0") == 4
    monkeypatch.undo()


def test_an_entry_of_a_file_goes_to_workers_as_what_was_read(tmp_path: Path) -> None:
    """The file has changed meanwhile, and is not there on other machines."""
    path = tmp_path / "mine.py"
    path.write_text(
        "class A:\n said = 1\n def reset(self): 0\n def torque(self, t, a, v, d): 0", "utf-8"
    )
    entry = load_entry(path)
    path.write_text("none of this", "utf-8")
    again = pickle.loads(pickle.dumps(entry))
    assert again == entry
    controller: Any = again.make(SimpleNamespace(task=task("psp3"), rng=None))
    assert controller.said == 1


@pytest.mark.parametrize("name", BASELINES)
def test_entries_of_the_package_go_to_workers(name: str) -> None:
    again = pickle.loads(pickle.dumps(BASELINES[name]))
    assert (again.name, again.knows, again.draws) == (
        *(name, BASELINES[name].knows),
        BASELINES[name].draws,
    )


def test_ctrl_c_keeps_what_is_done_and_the_same_benchmark_goes_on(
    tmp_path: Path, done: list[tuple[str, Trial]], monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = benchmark.execute

    def interrupted(trial: Trial, entry: Entry) -> Outcome:
        if len(done) == 3:
            raise KeyboardInterrupt
        return counted(trial, entry)

    monkeypatch.setattr(benchmark, "execute", interrupted)
    asked = Benchmark(tmp_path, [MINE], **QUICK)
    with pytest.raises(StudyInterrupted, match="3 of 4 runs") as end:
        asked.run(1)
    assert end.value.path == (tmp_path / FILE).resolve()
    assert asked.board().scores[-1].problem == "not all of its trials are done"
    monkeypatch.setattr(benchmark, "execute", counted)
    assert asked.run(1) == 1
    assert len(asked.board().ranked) == 2


MOMENTS = [
    (OutcomeFile, "__init__", 0),
    (OutcomeFile, "outcomes", 0),
    (OutcomeFile, "add", 1),
    (benchmark, "execute", 0),
    (benchmark, "own_trial", 0),
]


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize(("owner", "name", "least"), MOMENTS)
def test_ctrl_c_at_any_moment_says_what_is_kept(
    tmp_path: Path,
    done: list[tuple[str, Trial]],
    monkeypatch: pytest.MonkeyPatch,
    owner: Any,
    name: str,
    least: int,
    after: bool,
) -> None:
    """A signal before or after a step: while the file is opened, in a trial, between two."""
    asked, step, left = Benchmark(tmp_path, [MINE], **QUICK), getattr(owner, name), [signal.SIGINT]

    def interrupted(*arguments: Any) -> Any:
        if left and not after:
            os.kill(os.getpid(), left.pop())
        answer = step(*arguments)
        if left:
            os.kill(os.getpid(), left.pop())
        return answer

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, interrupted)
            with pytest.raises(StudyInterrupted) as end:
                asked.run(1)
    finally:
        signal.signal(signal.SIGINT, before)
    assert end.value.total == 4
    assert end.value.done == len(OutcomeFile(tmp_path / FILE).outcomes()) >= least
    assert asked.run(1) == 4 - end.value.done


def test_ctrl_c_ends_a_progress_callback_that_waits(
    tmp_path: Path, done: list[tuple[str, Trial]]
) -> None:
    went_on = []

    def wait(now: int, total: int, rate: float) -> None:
        if now == 2:
            os.kill(os.getpid(), signal.SIGINT)
            went_on.append(now)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(StudyInterrupted) as end:
            Benchmark(tmp_path, [MINE], **QUICK).run(1, progress=wait)
    finally:
        signal.signal(signal.SIGINT, before)
    assert not went_on
    assert end.value.done == len(OutcomeFile(tmp_path / FILE).outcomes()) == 2


def test_an_entry_that_raises_is_reported_and_tried_again(tmp_path: Path) -> None:
    def fails(course: object) -> Any:
        raise ValueError("no such luck")

    asked = Benchmark(tmp_path, [Entry("unlucky", SAMPLES, fails)], **QUICK)
    assert asked.run(1) == 4
    ranked, unlucky = asked.board().scores
    assert (ranked.entry.name, ranked.problem) == ("ctc", "")
    assert unlucky.problem == "psp3: ValueError: no such luck"
    assert asked.run(1) == 3


def test_names_files_and_all_are_entries(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text("class A:\n def fit(self, X, Y): 0\n def predict(self, X): 0\n", "utf-8")
    assert list(Benchmark(tmp_path, ["ridge", str(path)]).entries) == ["ctc", "ridge", "mine"]
    assert list(Benchmark(tmp_path, [ALL, str(path)]).entries) == [*BASELINES, "mine"]
    assert not (tmp_path / FILE).exists()


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"entries": ["best"]}, UnknownName),
        ({"entries": ["absent.py"]}, InvalidEntry),
        ({"entries": [Entry("ctc", MODEL, print)]}, InvalidValue),
        ({"robots": ["hexapod"]}, UnknownName),
        ({"robots": []}, InvalidValue),
        ({"readings": ["loud"]}, UnknownName),
        ({"levels": [math.inf]}, InvalidValue),
        ({"seeds": 0}, InvalidValue),
        ({"duration": 0.0}, InvalidValue),
    ],
)
def test_wrong_arguments_are_refused_before_any_work(
    tmp_path: Path, arguments: dict[str, Any], error: type[Exception]
) -> None:
    with pytest.raises(error):
        Benchmark(tmp_path, **arguments)


def test_to_ask_for_no_noise_says_that_it_is_always_done(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="known are outputs,"):
        Benchmark(tmp_path, readings=["none"])
    with pytest.raises(InvalidValue, match="runs without noise are always done, too, got inf"):
        Benchmark(tmp_path, levels=[math.inf])


def test_without_scikit_learn_what_needs_it_is_refused_and_the_rest_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "sklearn", None)
    with pytest.raises(MissingPackage, match=r"psp3\[benchmark\]"):
        Benchmark(tmp_path)
    Benchmark(tmp_path, ["t1-average", "anfis"])


@pytest.mark.slow
def test_processes_find_the_same_as_this_one_and_their_end_is_said(tmp_path: Path) -> None:
    """All but times, which are measured. The entry then ends the process that runs it."""
    text = "import os\nclass A:\n def fit(self, X, Y): {}\n def predict(self, X): return self.Y\n"
    path = tmp_path / "mine.py"
    path.write_text(text.format("self.Y = Y.mean(axis=0, keepdims=True)"), "utf-8")
    found = []
    for workers in (1, 2):
        asked = Benchmark(tmp_path / str(workers), [str(path)], **QUICK | {"seeds": 1})
        assert asked.run(workers) == 3
        outcomes = OutcomeFile(tmp_path / str(workers) / FILE).outcomes()
        found.append({name: outcome["runs"] for name, outcome in outcomes.items()})
    assert found[0] == found[1]
    path.write_text(text.format("os._exit(1)"), "utf-8")
    with pytest.raises(WorkersLost, match="workers=1"):
        Benchmark(tmp_path / "2", [str(path)], **QUICK | {"seeds": 1}).run(2)

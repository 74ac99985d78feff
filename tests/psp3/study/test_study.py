"""Studies.

Every run once, whatever stops them and whoever works on them, and the same table at the end.
"""

from __future__ import annotations

import csv
import math
import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
import tracemalloc
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from psp3.errors import (
    InvalidStudyFile,
    InvalidValue,
    RunsFailed,
    StudyFileNotWritable,
    StudyInterrupted,
    StudyInUse,
    StudyMismatch,
    UnknownName,
)
from psp3.study import Study, grid, study
from psp3.study.execution import execute
from psp3.study.file import GROUP, Additions, StudyFile
from psp3.study.keys import Runs
from psp3.study.run import METRICS, Run, field_types
from psp3.study.under_way import UnderWay
from tests.processes import PATIENCE, PROCESSES, answer_of, start
from tests.study_helpers import QUICK, count_rows, invented, run_and_tell, run_until

ROOT = Path(__file__).parents[3]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Name a file that does not exist yet."""
    return tmp_path / "study.sqlite"


@pytest.fixture
def no_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace runs by something that takes no time; the threads of this process see it."""
    monkeypatch.setattr(study, "execute", invented)


def done(path: Path, runs: tuple[Run, ...], **options: Any) -> list[dict[str, Any]]:
    whole = Study(path, runs)
    whole.run(**options)
    return list(whole.rows())


def same(rows: Iterable[dict[str, Any]]) -> str:
    """Return text that is the same for rows that are the same bit for bit.

    NaN does not equal itself.
    """
    return repr(list(rows))


# Grids


def test_grid_is_the_product_with_seeds_slowest() -> None:
    runs = grid(controller=["t1", "it2"], snr_db=(20, 10), seed=range(2), trajectory="circle")
    assert [(run.seed, run.controller, run.snr_db) for run in runs] == [
        (seed, controller, snr)
        for seed in (0, 1)
        for controller in ("t1", "it2")
        for snr in (20.0, 10.0)
    ]
    assert {run.trajectory for run in runs} == {"circle"}
    assert grid() == (Run(),)


def test_grid_takes_arrays_and_None() -> None:
    (run, other) = grid(seed=np.arange(3, 5), snr_db=np.float64(20.0), mean_variation=[None])
    assert (type(run.seed), run.seed, other.seed) == (int, 3, 4)
    assert type(run.snr_db) is float
    assert run.mean_variation is None


@pytest.mark.parametrize(
    ("values", "error", "words"),
    [
        ({"seed": range(0)}, InvalidValue, "seed must be at least one value"),
        ({"seed": 1.5}, InvalidValue, "seed must be an integer, got 1.5"),
        ({"seed": True}, InvalidValue, "seed must be an integer"),
        ({"seed": None}, InvalidValue, "seed must be an integer"),
        ({"snr_db": "20"}, InvalidValue, "snr_db must be a number, got '20'"),
        (
            {"seed": 2**63},
            InvalidValue,
            "seed must be an integer of at most 63 bits, got 9223372036854775808",
        ),
        ({"snr_db": math.nan}, InvalidValue, "snr_db must be a number, got nan"),
        ({"controller": 1}, InvalidValue, "controller must be a text"),
        (
            {"controllers": "t1"},
            UnknownName,
            "unknown field of a run 'controllers'; known are controller",
        ),
    ],
)
def test_grid_refuses_what_no_run_can_have(
    values: dict[str, Any], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        grid(**values)


# What a study is given


@pytest.mark.parametrize(
    ("runs", "words"),
    [
        ((), "runs must be at least one run"),
        (grid(robot="eiffel_tower"), "unknown robot 'eiffel_tower'"),
        (grid(controller="t3"), "unknown controller 't3'"),
        (grid(reading="hearsay"), "unknown reading"),
        (grid(trajectory="spiral"), "unknown trajectory"),
        (grid(seed=-1), "seed"),
        (
            grid(duration=(1.0, 2.0)),
            "duration must be the same in all runs of a study.* others have 1.0, got 2.0",
        ),
        (grid(duration=math.inf), "duration must be finite"),
    ],
)
def test_nonsense_is_refused_before_there_is_a_file(
    path: Path, runs: tuple[Run, ...], words: str
) -> None:
    with pytest.raises((InvalidValue, UnknownName), match=words):
        Study(path, runs)
    assert not path.exists()


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_number_of_workers_is_a_positive_integer(path: Path, workers: Any) -> None:
    with pytest.raises(InvalidValue, match="workers must be a whole number of at least 1"):
        Study(path, grid()).run(workers)
    assert not path.exists()


def test_files_that_cannot_be_written_are_refused_before_any_work(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "execute", lambda run: pytest.fail("work began"))
    with pytest.raises(StudyFileNotWritable, match="no directory"):
        Study(path.parent / "nowhere" / path.name, grid()).run()
    path.touch()
    path.chmod(0o444)
    with pytest.raises(StudyFileNotWritable, match="read-only"):
        Study(path, grid()).run()
    path.chmod(0o644)
    path.write_text("something else")
    with pytest.raises(InvalidStudyFile, match="not the file of a study"):
        Study(path, grid()).run()
    assert path.read_text() == "something else"


def test_study_without_runs_reads_and_does_nothing_else(path: Path, no_simulation: None) -> None:
    with pytest.raises(InvalidStudyFile, match="no such file"):
        Study(path).rows()
    rows = done(path, grid(seed=range(3), snr_db=20.0))
    assert same(Study(path).rows()) == same(rows)
    with pytest.raises(InvalidValue, match="runs must be given"):
        Study(path).run()


def test_runs_of_another_duration_need_another_file(path: Path, no_simulation: None) -> None:
    done(path, grid())
    with pytest.raises(StudyMismatch, match="duration"):
        Study(path, grid(duration=1.0))


# Rows


def test_rows_are_those_of_single_runs(path: Path) -> None:
    """Against :func:`execute` called one by one, exactly: a run depends on its fields alone."""
    runs = grid(**QUICK, seed=range(2))
    rows = done(path, runs)
    expected = {run.canonical(): execute(run.canonical()) for run in runs}
    assert len(rows) == len(expected) == 9
    for row in rows:
        run = Run(**{field.name: row.pop(field.name) for field in fields(Run)})
        assert same([row]) == same([expected[run]])


def test_number_of_workers_changes_nothing(path: Path) -> None:
    """One, two and four threads, bit for bit.

    All the readings, because each draws its noise elsewhere.
    """
    runs = grid(**QUICK, seed=range(3), reading=("parameters", "measurement", "online", "plant"))
    tables = [
        same(done(path.with_suffix(f".{workers}"), runs, workers=workers)) for workers in (1, 2, 4)
    ]
    assert tables[0] == tables[1] == tables[2]
    assert "nan" not in tables[0]


@pytest.mark.slow
def test_first_runs_of_a_process_may_be_compiled_by_several_threads_at_once() -> None:
    code = """
import threading
from concurrent.futures import ThreadPoolExecutor
from psp3.study.execution import execute
from psp3.study.run import Run
together = threading.Barrier(4)
def run(controller):
    together.wait()
    return execute(Run(controller, snr_db=20.0, duration=0.01))
with ThreadPoolExecutor(4) as threads:
    print(len(list(threads.map(run, ["t1", "it2", "it2", "gt2"]))))
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.stdout == "4\n", done.stderr


def test_what_does_not_depend_on_the_seed_is_run_once(path: Path, no_simulation: None) -> None:
    runs = grid(controller=("pd", "ctc", "t1"), snr_db=(math.inf, 20.0), seed=range(30))
    whole = Study(path, runs)
    assert len(runs) == 180
    # PD, CTC and t1 without noise once each, and t1 with noise for every seed.
    assert whole.run() == len(whole.runs or ()) == 3 + 30


def test_finished_study_does_nothing_and_one_with_more_seeds_only_those(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[int] = []

    def counted(run: Run) -> dict[str, float]:
        calls.append(run.seed)
        return invented(run)

    monkeypatch.setattr(study, "execute", counted)
    few, many = (
        Study(path, grid(snr_db=20.0, seed=range(3))),
        Study(path, grid(snr_db=20.0, seed=range(5))),
    )
    assert (few.run(), few.run(), many.run()) == (3, 0, 2)
    assert sorted(calls) == [0, 1, 2, 3, 4]
    fresh = path.with_name("fresh.sqlite")
    assert same(many.rows()) == same(done(fresh, grid(snr_db=20.0, seed=range(5))))
    assert len(few.rows()) == 3, "a study's rows are those of its own runs"
    assert len(Study(path).rows()) == 5


def test_other_runs_can_be_added_to_a_file(path: Path, no_simulation: None) -> None:
    done(path, grid(controller="t1", snr_db=20.0, seed=range(3)))
    assert (
        len(done(path, grid(controller="it2", trajectory="line", snr_db=20.0, seed=range(3)))) == 3
    )
    assert len(Study(path).rows()) == 6


def test_rows_are_selected_by_fields(path: Path, no_simulation: None) -> None:
    rows = done(path, grid(controller=("t1", "it2"), snr_db=(20.0, 10.0), seed=range(3)))
    assert list(rows[0]) == [*(field.name for field in fields(Run)), *METRICS]
    whole = Study(path)
    assert same(whole.rows(controller="it2", snr_db=20)) == same(
        [row for row in rows if row["controller"] == "it2" and row["snr_db"] == 20.0]
    )
    assert {row["seed"] for row in whole.rows(seed=range(1, 9))} == {1, 2}
    assert len(whole.rows(controller=["t1", "it2"], seed=0)) == 4
    assert list(whole.rows(snr_db=15)) == []
    with pytest.raises(UnknownName, match="unknown field of a run 'snr'"):
        whole.rows(snr=20)


def test_export_can_be_read_back_exactly(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    awkward = [math.nan, math.inf, -math.inf, 0.1, 1e-310, 1 / 3]
    monkeypatch.setattr(
        study,
        "execute",
        lambda run: {
            name: awkward[(run.seed + k) % len(awkward)] for k, name in enumerate(METRICS)
        },
    )
    rows = done(
        path,
        grid(controller="pd", reading="measurement", snr_db=20.0, seed=range(6))
        + grid(controller="t1"),
    )
    table = path.with_suffix(".csv")
    assert Study(path).export(table) == table
    with table.open(encoding="utf-8", newline="") as file:
        read = list(csv.DictReader(file))
    assert [list(row) for row in read] == [list(row) for row in rows]
    optional = {
        name: (lambda text, kind=kind: kind(text) if text else None)
        for name, kind in field_types().items()
        if Run.__dataclass_fields__[name].default is None
    }
    types = {field.name: type(rows[0][field.name]) for field in fields(Run)} | optional
    converted = [{name: types.get(name, float)(text) for name, text in row.items()} for row in read]
    assert same(converted) == same(rows)
    assert {name for name, text in read[0].items() if not text} == {
        name for name, value in rows[0].items() if value is None
    }, "None is an empty cell"
    assert [entry.name for entry in path.parent.iterdir() if entry.name.endswith(".part")] == []
    Study(path).export(table, controller="t1")
    assert len(table.read_text().splitlines()) == 2


def test_export_does_not_overwrite_the_study(path: Path, no_simulation: None) -> None:
    rows = done(path, grid())
    with pytest.raises(InvalidValue, match="another file"):
        Study(path).export(path)
    assert same(Study(path).rows()) == same(rows)


def test_progress_counts_what_is_there_and_what_is_done_now(
    path: Path, no_simulation: None
) -> None:
    done(path, grid(snr_db=20.0, seed=range(4)))
    reports: list[tuple[int, int, float]] = []
    done(path, grid(snr_db=20.0, seed=range(10)), progress=lambda *report: reports.append(report))
    counts = [count for count, _, _ in reports]
    assert counts == sorted(counts)
    assert (counts[0], counts[-1]) == (4, 10)
    assert {total for _, total, _ in reports} == {10}
    assert reports[0][2] == 0.0
    assert all(rate > 0.0 for _, _, rate in reports[1:])


def test_only_a_few_runs_are_under_way_at_a_time(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the size of the study: two for each of three workers."""
    under_way, most = 0, 0
    lock = threading.Lock()

    class Counting(ThreadPoolExecutor):
        def submit(
            self, function: Callable[..., Any], /, *arguments: Any, **options: Any
        ) -> Future[Any]:
            nonlocal under_way, most
            with lock:
                under_way += 1
                most = max(most, under_way)
            future = super().submit(function, *arguments, **options)
            future.add_done_callback(self._count)
            return future

        @staticmethod
        def _count(_: Future[Any]) -> None:
            nonlocal under_way
            with lock:
                under_way -= 1

    monkeypatch.setattr(study, "ThreadPoolExecutor", Counting)
    monkeypatch.setattr(study, "execute", invented)
    assert len(done(path, grid(snr_db=20.0, seed=range(300)), workers=3)) == 300
    assert 3 <= most <= 6


# What goes wrong


def test_failed_run_is_named_and_the_others_are_kept(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def moody(run: Run) -> dict[str, float]:
        if run.seed == 2:
            raise ZeroDivisionError("no\nway")
        return invented(run)

    runs = grid(snr_db=20.0, seed=range(8))
    monkeypatch.setattr(study, "execute", moody)
    with pytest.raises(
        RunsFailed, match=r"snr_db=20.0, seed=2.* failed: ZeroDivisionError: no way"
    ) as failed:
        Study(path, runs).run(workers=2)
    ((run, reason),) = failed.value.failures
    assert isinstance(run, Run)
    assert (run.seed, reason) == (2, "ZeroDivisionError: no way")
    assert isinstance(failed.value.__cause__, ZeroDivisionError)
    assert "\n" not in str(failed.value)
    assert [row["seed"] for row in Study(path).rows()] == [0, 1, 3, 4, 5, 6, 7]
    monkeypatch.setattr(study, "execute", invented)
    assert Study(path, runs).run() == 1


def test_error_of_a_real_run_that_only_shows_at_run_time_is_named(path: Path) -> None:
    """Under a hundred times as much noise as signal learning fails.

    The mean of the learned mass matrices is not positive definite.
    """
    impossible, possible = Run("t1", snr_db=-40.0, seed=1, duration=0.1), Run("pd", duration=0.1)
    with pytest.raises(RunsFailed, match=r"snr_db=-40.0, seed=1.*UnusableEstimate"):
        Study(path, [impossible, possible]).run()
    assert [row["controller"] for row in Study(path).rows()] == ["pd"]


def test_study_gives_up_when_everything_fails(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(run: Run) -> dict[str, float]:
        raise ZeroDivisionError

    monkeypatch.setattr(study, "execute", broken)
    with pytest.raises(RunsFailed, match=r"and \d+ more.*were not started") as failed:
        Study(path, grid(snr_db=20.0, seed=range(1000))).run(workers=2)
    assert study.MOST_FAILURES <= len(failed.value.failures) < study.MOST_FAILURES + 2 * 2
    assert failed.value.not_started == 1000 - len(failed.value.failures)


def test_two_studies_on_one_file(path: Path, no_simulation: None) -> None:
    """The second one is refused at its start, and the first one does not notice."""
    refusals: list[str] = []

    def meddle(done: int, total: int, rate: float) -> None:
        with pytest.raises(StudyInUse) as refusal:
            Study(path, grid(controller="t1")).run()
        refusals.append(str(refusal.value))

    assert len(done(path, grid(snr_db=20.0, seed=range(5)), progress=meddle)) == 5
    assert f"process {os.getpid()}" in refusals[0]
    assert len(done(path, grid(controller="t1"))) == 1


def test_interrupt_keeps_what_is_done_and_says_how_to_go_on(path: Path) -> None:
    runs = grid(**QUICK, seed=range(4))
    total = len(Study(path, runs).runs or ())

    def interrupt(done: int, total: int, rate: float) -> None:
        if done >= 5:
            raise KeyboardInterrupt

    with pytest.raises(StudyInterrupted, match="run the same study again") as interrupted:
        Study(path, runs).run(workers=2, progress=interrupt)
    assert isinstance(interrupted.value, KeyboardInterrupt)
    assert interrupted.value.total == total
    assert 5 <= interrupted.value.done == count_rows(path) < total
    assert same(done(path, runs)) == same(done(path.with_name("whole.sqlite"), runs))


@pytest.fixture
def ctrl_c() -> Iterator[Callable[[], None]]:
    """Do what Ctrl-C does, once, however the tests were started."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    left = [signal.SIGINT]

    def interrupt() -> None:
        if left:
            os.kill(os.getpid(), left.pop())

    yield interrupt
    assert not left, "it came"
    signal.signal(signal.SIGINT, before)


MOMENTS = [
    (StudyFile, "_check_permissions", 0),
    (StudyFile, "_create", 0),
    (Runs, "missing", 0),
    (study, "execute", 1),
    (Additions, "commit", None),
    (Additions, "_numbered", None),
    (UnderWay, "hand_out", 0),
    (UnderWay, "take", None),
    (sqlite3, "connect", None),
]


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize(("owner", "name", "least"), MOMENTS)
def test_ctrl_c_at_any_moment_says_what_is_kept(
    path: Path,
    monkeypatch: pytest.MonkeyPatch,
    ctrl_c: Callable[[], None],
    owner: Any,
    name: str,
    least: int | None,
    after: bool,
) -> None:
    """A signal before or after a step: while the file is opened, between two rows, at the end."""
    monkeypatch.setattr(study, "execute", invented)
    whole = Study(path, grid(snr_db=20.0, seed=range(6)))
    step = getattr(owner, name)

    def interrupted(*arguments: Any, **options: Any) -> Any:
        if not after:
            ctrl_c()
        answer = step(*arguments, **options)
        ctrl_c()
        return answer

    with monkeypatch.context() as patch:
        patch.setattr(owner, name, interrupted)
        with pytest.raises(StudyInterrupted) as end:
            whole.run(workers=2)
    assert end.value.done == count_rows(path) >= (least or 0)
    assert end.value.total == 6
    assert whole.run() == 6 - end.value.done
    assert len(whole.rows()) == 6


def test_ctrl_c_when_all_is_done_is_not_lost(
    path: Path, no_simulation: None, ctrl_c: Callable[[], None]
) -> None:
    whole = Study(path, grid(snr_db=20.0, seed=range(3)))
    whole.run()
    with pytest.raises(StudyInterrupted, match="after 3 of 3 runs"):
        whole.run(progress=lambda *_: ctrl_c())


def test_ctrl_c_ends_a_progress_callback_that_waits(
    path: Path, no_simulation: None, ctrl_c: Callable[[], None]
) -> None:
    """For a pipe that is full, or a person: between any two instructions of it."""
    went_on = []

    def wait(done: int, total: int, rate: float) -> None:
        if done:
            ctrl_c()
            went_on.append(done)

    with pytest.raises(StudyInterrupted) as end:
        Study(path, grid(snr_db=20.0, seed=range(9))).run(progress=wait)
    assert not went_on
    assert 1 <= end.value.done == count_rows(path)


def test_runs_under_way_when_interrupted_are_kept(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[int] = []
    second_has_begun, interrupted = threading.Event(), threading.Event()

    def recorded(run: Run) -> dict[str, float]:
        begun.append(run.seed)
        if len(begun) == 2:
            second_has_begun.set()
            assert interrupted.wait(PATIENCE)
        return invented(run)

    def interrupt(done: int, total: int, rate: float) -> None:
        if done:
            assert second_has_begun.wait(PATIENCE)
            interrupted.set()
            raise KeyboardInterrupt

    monkeypatch.setattr(study, "execute", recorded)
    with pytest.raises(StudyInterrupted):
        Study(path, grid(snr_db=20.0, seed=range(50))).run(workers=1, progress=interrupt)
    assert [row["seed"] for row in Study(path).rows()] == begun
    assert 2 <= len(begun) < 50


def test_error_in_the_progress_callback_loses_nothing_that_was_committed(
    path: Path, no_simulation: None
) -> None:
    def fail(done: int, total: int, rate: float) -> None:
        if done >= 3:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        Study(path, grid(snr_db=20.0, seed=range(9))).run(progress=fail)
    assert count_rows(path) >= 3


def test_killed_study_resumes_and_ends_with_the_same_table(path: Path) -> None:
    """``kill -9`` at two moments; against a study that nobody disturbed."""
    runs = grid(**QUICK, seed=range(8))
    total = len(Study(path, runs).runs or ())
    for moment in (3, 15):
        ours, theirs = PROCESSES.Pipe()
        process = start(run_until, path, runs, 2, moment, theirs)
        assert moment <= answer_of(process, ours) < total
        process.kill()
        process.join()
        assert process.exitcode == -signal.SIGKILL
        assert moment <= count_rows(path) < total
    assert Study(path, runs).run() > 0
    assert same(Study(path, runs).rows()) == same(done(path.with_name("whole.sqlite"), runs))


def test_kill_loses_no_more_than_half_a_second(path: Path) -> None:
    """What had come back so long before the kill is in the file, and the rest is done again.

    The clock is the system's, the same in all processes.
    """
    ours, theirs = PROCESSES.Pipe()
    child = start(run_and_tell, path, 100_000, theirs)
    answer_of(child, ours)
    reports = []
    until = time.monotonic() + 3.0 * GROUP
    while time.monotonic() < until:
        if ours.poll(0.01):
            reports.append(ours.recv())
    child.kill()
    killed = time.monotonic()
    child.join()
    kept = count_rows(path)
    assert kept >= max(done for at, done in reports if at <= killed - GROUP) > 0
    assert Study(path, grid(snr_db=20.0, seed=range(100_000))).rows().seeds.max() < 100_000


def test_reads_of_a_study_that_is_running_see_whole_rows(path: Path) -> None:
    runs = grid(**QUICK, seed=range(4))
    ours, theirs = PROCESSES.Pipe()
    process = start(run_until, path, runs, 2, 1, theirs)
    theirs.close()
    seen = 0
    while True:
        try:
            done_there = ours.recv()
        except EOFError:
            break
        # It goes on while its rows are read here.
        ours.send(True)
        rows = Study(path).rows()
        assert done_there <= len(rows)
        assert len(rows) >= seen
        assert all(len(row) == len(fields(Run)) + len(METRICS) for row in rows)
        seen = len(rows)
    process.join()
    assert process.exitcode == 0
    assert same(Study(path, runs).rows()) == same(done(path.with_name("whole.sqlite"), runs))


# Many runs


def test_many_runs_take_no_memory_of_their_own(path: Path) -> None:
    """Runs are made when they are handed out; a study of them holds 24 bytes of key each.

    And their places, in what keeps numbers of 8 bytes: 40 bytes a run, and a few hundred kB.
    """
    runs = grid(controller=("t1", "it2"), snr_db=(20.0, 10.0), seed=range(10_000))
    Study(path, runs[:10])
    tracemalloc.start()
    whole = Study(path, runs)
    held, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(whole.runs or ()) == 40_000
    assert held < 40 * 40_000 + 500_000
    assert peak < 250 * 40_000


def test_rows_are_columns(path: Path, no_simulation: None) -> None:
    """Of 0.1 kB a row: a setting's number, a seed, and metrics."""
    done(path, grid(controller=("t1", "it2"), snr_db=20.0, seed=range(100)))
    table = Study(path).rows()
    arrays = (table.setting, table.seeds, table.metrics)
    assert sum(array.nbytes for array in arrays) == len(table) * (4 + 8 + 8 * len(METRICS))
    assert len(table.settings) == 2

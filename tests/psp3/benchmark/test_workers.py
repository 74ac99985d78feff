"""Who does trials: workers of a dask cluster find what this process does, and what ends them."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from psp3.benchmark import benchmark, workers
from psp3.benchmark.benchmark import FILE, Benchmark
from psp3.benchmark.entries import Entry
from psp3.benchmark.file import OutcomeFile
from psp3.benchmark.trial import Outcome, Trial
from psp3.errors import InvalidValue, SchedulerUnavailable
from tests.processes import start_server
from tests.psp3.benchmark.made import Exact, entry_of, outcome_of

QUICK: dict[str, Any] = {"robots": ("psp3",), "seeds": 1, "duration": 0.2}
MEAN = """
import os
class Mean:
    def fit(self, X, Y):
        self.mean = Y.mean(axis=0, keepdims=True)
    def predict(self, X):
        return self.mean
"""
ENDS = MEAN.replace("return self.mean", "os._exit(1)")

needs_dask = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None and not os.environ.get("CI"),
    reason="distributed is not installed (pip install 'psp3[cluster]')",
)


def test_trials_that_do_not_come_back_are_outcomes_and_a_lost_cluster_is_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    entry = entry_of("mine", Exact)
    work = {str(seed): (Trial("psp3", seed=seed), entry) for seed in range(5)}

    def done(trial: Trial, entry: Entry) -> Outcome:
        if trial.seed == 3:
            raise OSError("no way\n back")
        if trial.seed == 4:
            raise CancelledError
        return outcome_of({"trained": 1e-3, "untrained": 2e-3})

    monkeypatch.setattr(workers, "_execute_alone", done)
    kept: dict[str, Outcome] = {}
    with ThreadPoolExecutor(1) as pool, pytest.raises(CancelledError):
        workers.done_by(pool, lambda: 1, work, kept.__setitem__, lambda: None)
    assert sorted(kept) == ["0", "1", "2", "3"]
    assert kept["3"] == {"error": "OSError: no way back"}


def test_few_trials_are_under_way_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two for each worker, however many are to be done."""
    entry, most = entry_of("mine", Exact), 0
    work = {str(seed): (Trial("psp3", seed=seed), entry) for seed in range(40)}
    handed_out: list[Future[Outcome]] = []

    class Counting(ThreadPoolExecutor):
        def submit(self, *arguments: Any, **named: Any) -> Any:
            handed_out.append(super().submit(*arguments, **named))
            return handed_out[-1]

    def keep(name: str, outcome: Outcome) -> None:
        nonlocal most
        kept.append(name)
        most = max(most, len(handed_out) - len(kept) + 1)

    kept: list[str] = []
    monkeypatch.setattr(workers, "_execute_alone", lambda trial, entry: {"error": None})
    with Counting(3) as pool:
        workers.done_by(pool, lambda: 3, work, keep, lambda: None)
    assert sorted(kept) == sorted(work)
    assert most <= 6


def test_workers_and_scheduler_exclude_each_other(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match="workers must be left out"):
        Benchmark(tmp_path, ["lqr"], **QUICK).run(workers=2, scheduler="tcp://127.0.0.1:8786")


def cluster_of(count: int, threads: int, processes: bool) -> Any:
    """Return a cluster; its processes are forked from the server of the tests."""
    import dask
    import distributed

    make: Any = distributed.LocalCluster
    with dask.config.set({"distributed.worker.multiprocessing-method": "forkserver"}):
        return make(
            n_workers=count,
            threads_per_worker=threads,
            processes=processes,
            protocol="tcp://",
            dashboard_address=":0",
            silence_logs=50,
        )


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    start_server()
    with cluster_of(2, 1, True) as started:
        yield started.scheduler_address


@needs_dask
@pytest.mark.slow
def test_a_cluster_finds_what_this_process_finds(tmp_path: Path, address: str) -> None:
    """All but times, which are measured. The file is gone when the workers learn."""
    path, found = tmp_path / "mine.py", []
    for place in ("here", "there"):
        path.write_text(MEAN, "utf-8")
        asked = Benchmark(tmp_path / place, [str(path), "t1-average"], **QUICK)
        path.unlink()
        where: dict[str, Any] = {"workers": 1} if place == "here" else {"scheduler": address}
        assert asked.run(**where) == 5
        outcomes = OutcomeFile(tmp_path / place / FILE).outcomes()
        found.append({name: outcome["runs"] for name, outcome in outcomes.items()})
    assert found[0] == found[1]


@needs_dask
@pytest.mark.slow
def test_an_entry_that_ends_its_workers_is_reported_and_the_others_are_ranked(
    tmp_path: Path, address: str
) -> None:
    """Dask gives up on a task when it has lost four workers."""
    path = tmp_path / "mine.py"
    path.write_text(ENDS, "utf-8")
    asked = Benchmark(tmp_path, [str(path)], **QUICK)
    assert asked.run(scheduler=address) == 3
    ranked, lost = asked.board().scores
    assert (ranked.entry.name, ranked.problem) == ("ctc", "")
    assert "KilledWorker" in lost.problem


@needs_dask
@pytest.mark.slow
def test_workers_of_several_threads_or_other_sources_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = Benchmark(tmp_path, ["lqr"], **QUICK)
    with cluster_of(1, 3, False) as started:
        with pytest.raises(SchedulerUnavailable, match=r"has 3 threads.*--nthreads 1 --nworkers 3"):
            asked.run(scheduler=started.scheduler_address)
        here = iter(["mine", "theirs"])
        monkeypatch.setattr(benchmark, "stamp", lambda: next(here))
        with pytest.raises(SchedulerUnavailable, match="has psp3 theirs, but this is psp3 mine"):
            asked.run(scheduler=started.scheduler_address)

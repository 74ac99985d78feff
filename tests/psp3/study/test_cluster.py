"""Studies on a dask cluster of real worker processes.

The same table, whatever happens to workers and scheduler.
"""

from __future__ import annotations

import http.server
import importlib.util
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import psp3
from psp3.errors import InvalidValue, RunsFailed, SchedulerUnavailable
from psp3.study import Study, cluster, grid, study
from psp3.study.run import Run, execute
from tests.study_helpers import QUICK, count_rows, invented, slow

ROOT = Path(__file__).parents[3]

if importlib.util.find_spec("distributed") is None and not os.environ.get("CI"):
    pytest.skip(
        "distributed is not installed (pip install 'psp3[cluster]')", allow_module_level=True
    )

import distributed  # noqa: E402 (only where it is)

WORKERS = 3


@pytest.fixture(scope="module")
def workers() -> Iterator[Any]:
    """Three worker processes of one thread.

    Each is watched by a nanny that starts another one if it dies.
    """
    make: Any = distributed.LocalCluster
    with make(
        n_workers=WORKERS,
        threads_per_worker=1,
        processes=True,
        dashboard_address=":0",
        silence_logs=50,
    ) as started:
        yield started


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Name a file that does not exist yet."""
    return tmp_path / "study.sqlite"


def signed(run: Run) -> dict[str, float]:
    """Do a real run and say who did it.

    That takes the place of the effort. It takes so long that a worker can be killed in the middle.
    """
    metrics = execute(run) | {"effort": float(os.getpid())}
    time.sleep(0.1)
    return metrics


def test_table_is_that_of_threads_here_even_if_a_worker_is_killed(
    workers: Any, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Real runs, compared bit for bit.

    Every worker has two at hand when one of them is killed that has done some already.
    """
    monkeypatch.setattr(study, "execute", signed)
    runs = grid(**QUICK, seed=range(10))
    victims: list[int] = []

    def kill(done: int, total: int, rate: float) -> None:
        did = [int(row["effort"]) for row in Study(path).rows()] if done else []
        alive = [nanny.pid for nanny in workers.workers.values()]
        if not victims and len(set(did)) == WORKERS:
            victims.append(next(process for process in did if process in alive))
            os.kill(victims[0], signal.SIGKILL)

    here, there = Study(path.with_name("here.sqlite"), runs), Study(path, runs)
    here.run()
    assert there.run(scheduler=workers.scheduler_address, progress=kill) == len(there.runs or ())
    rows = there.rows()
    processes = [int(row.pop("effort")) for row in rows]
    assert 0 < processes.count(victims[0]) < len(rows) // 2
    assert repr(rows) == repr(
        [{name: value for name, value in row.items() if name != "effort"} for row in here.rows()]
    )


def fail_for_one_seed(run: Run) -> dict[str, float]:
    if run.seed == 2:
        raise ZeroDivisionError("no way")
    return invented(run)


def test_failed_run_is_named_and_the_others_are_kept(
    workers: Any, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "execute", fail_for_one_seed)
    with pytest.raises(RunsFailed, match=r"seed=2.* failed: ZeroDivisionError: no way"):
        Study(path, grid(snr_db=20.0, seed=range(8))).run(scheduler=workers.scheduler_address)
    assert [row["seed"] for row in Study(path).rows()] == [0, 1, 3, 4, 5, 6, 7]


def test_two_studies_at_a_time_on_one_cluster(
    workers: Any, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Equal calls are not one to dask, so neither study ends with the results of the other one."""
    monkeypatch.setattr(study, "execute", slow)
    other = path.with_name("other.sqlite")
    runs = grid(snr_db=20.0, seed=range(9))
    thread = threading.Thread(
        target=lambda: Study(other, runs).run(scheduler=workers.scheduler_address)
    )
    thread.start()
    Study(path, runs).run(scheduler=workers.scheduler_address)
    thread.join()
    assert count_rows(path) == count_rows(other) == 9


# Schedulers that cannot be used


def refusal(address: str, error: type[Exception] = SchedulerUnavailable) -> str:
    """Return the message with which an address is refused, within a few seconds."""
    start = time.monotonic()
    with pytest.raises(error) as refused, cluster.connected(address):
        pass
    assert time.monotonic() - start < cluster.PATIENCE + 2.0
    assert "\n" not in str(refused.value)
    return str(refused.value)


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


@pytest.mark.parametrize(
    "address",
    [
        "",
        "somewhere",
        "tcp://127.0.0.1",
        "tcp://:8786",
        "tcp://127.0.0.1:port",
        "tcp://127.0.0.1:99999",
        "http://a:1",
    ],
)
def test_what_is_no_address(address: str) -> None:
    assert "scheduler must be an address such as tcp://host:8786" in refusal(address, InvalidValue)


def test_nobody_listens_and_no_run_is_done(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    address = f"tcp://127.0.0.1:{free_port()}"
    message = refusal(address)
    assert message.startswith(f"scheduler {address}: cannot be reached (ConnectionRefusedError")
    assert "dask scheduler" in message
    monkeypatch.setattr(study, "execute", lambda run: pytest.fail("work began"))
    with pytest.raises(SchedulerUnavailable, match="cannot be reached"):
        Study(path, grid()).run(scheduler=address)
    assert not path.with_name(path.name + ".lock").exists()


def test_what_listens_is_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    """A web server, to which dask's own client would wait for ever."""
    monkeypatch.setattr(cluster, "PATIENCE", 1.0)
    monkeypatch.setattr(http.server.BaseHTTPRequestHandler, "log_message", lambda *_: None)
    with http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), http.server.BaseHTTPRequestHandler
    ) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            assert "cannot be reached" in refusal(f"tcp://127.0.0.1:{server.server_address[1]}")
        finally:
            server.shutdown()
            thread.join()


def test_scheduler_without_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 1.0)
    make: Any = distributed.LocalCluster
    with make(
        n_workers=0, processes=False, dashboard_address=":0", silence_logs=50, protocol="tcp://"
    ) as empty:
        assert f"has no workers; start some with: dask worker {empty.scheduler_address}" in refusal(
            empty.scheduler_address
        )


def test_workers_with_another_version(workers: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    there = psp3.__version__
    monkeypatch.setattr("psp3.version.__version__", "99.0")
    assert f"has psp3 {there}, but this is psp3 99.0" in refusal(workers.scheduler_address)


def test_workers_and_scheduler_exclude_each_other(path: Path) -> None:
    with pytest.raises(InvalidValue, match="workers must be left out"):
        Study(path, grid()).run(workers=2, scheduler="tcp://127.0.0.1:8786")


def test_lost_scheduler_ends_the_study_with_what_was_done(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A scheduler with its worker in one process, which is killed."""
    monkeypatch.setattr(study, "execute", slow)
    code = """
import distributed, time
with distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, \
protocol="tcp://", dashboard_address=":0") as cluster:
    print(cluster.scheduler_address, flush=True)
    time.sleep(60)
"""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, "-c", code],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as server:
        assert server.stdout is not None
        address = server.stdout.readline().strip()

        def kill(done: int, total: int, rate: float) -> None:
            if done >= 3:
                server.kill()

        runs = grid(snr_db=20.0, seed=range(40))
        with pytest.raises(SchedulerUnavailable, match=r"connection was lost after \d+ of 40 runs"):
            Study(path, runs).run(scheduler=address, progress=kill)
    kept = count_rows(path)
    assert 3 <= kept < 40
    assert Study(path, runs).run() == 40 - kept

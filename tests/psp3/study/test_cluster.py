"""Studies on a dask cluster of real worker processes.

The same table, whatever happens to workers and scheduler.
"""

from __future__ import annotations

import http.server
import importlib.util
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest

import psp3
from psp3.errors import InvalidValue, RunsFailed, SchedulerUnavailable
from psp3.study import Study, cluster, grid, study
from psp3.study import file as study_file
from psp3.study.execution import execute
from psp3.study.run import Run
from psp3.study.under_way import UnderWay
from tests.processes import PATIENCE, PROCESSES, answer_of, start, start_server
from tests.study_helpers import QUICK, count_rows, invented

pytestmark = pytest.mark.slow

if importlib.util.find_spec("distributed") is None and not os.environ.get("CI"):
    pytest.skip(
        "distributed is not installed (pip install 'psp3[cluster]')", allow_module_level=True
    )

import dask  # noqa: E402 (only where it is)
import distributed  # noqa: E402

WORKERS = 3


@pytest.fixture(scope="module")
def workers() -> Iterator[Any]:
    """Three worker processes of one thread.

    Each is watched by a nanny that starts another one if it dies. They are forked from the server
    of the tests, which has imported everything.
    """
    start_server()
    make: Any = distributed.LocalCluster
    with (
        dask.config.set({"distributed.worker.multiprocessing-method": "forkserver"}),
        make(
            n_workers=WORKERS,
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",
            silence_logs=50,
        ) as started,
    ):
        yield started


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Name a file that does not exist yet."""
    return tmp_path / "study.sqlite"


def signed(run: Run, folder: Path) -> dict[str, float]:
    """Do a real run and say who did it, which takes the place of the effort.

    The first runs end when every worker has begun one, and further ones when one was killed.
    """
    begun = folder / f"begun by {os.getpid()}"
    if begun.exists():
        wait_until((folder / "killed").exists)
    begun.touch()
    wait_until(lambda: len(list(folder.glob("begun by *"))) >= WORKERS)
    return execute(run) | {"effort": float(os.getpid())}


def wait_until(condition: Callable[[], bool]) -> None:
    """Look again and again, here or in a worker, as long as any machine may take."""
    until = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < until, f"this has not come in {PATIENCE} s"
        time.sleep(0.01)


def test_table_is_that_of_threads_here_even_if_a_worker_is_killed(
    workers: Any, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Real runs, compared bit for bit.

    Every worker has two at hand when one of them is killed, after its first run and before the end
    of its second one.
    """
    # What is reported is in the file at once, for the file is what says who did it.
    monkeypatch.setattr(study_file, "GROUP", 0.0)
    runs = grid(**QUICK, seed=range(10))
    victims: list[int] = []

    def kill(done: int, total: int, rate: float) -> None:
        did = [int(row["effort"]) for row in Study(path).rows()] if done else []
        if not victims and len(set(did)) == WORKERS:
            victims.append(did[0])
            os.kill(victims[0], signal.SIGKILL)
            (path.parent / "killed").touch()

    here, there = Study(path.with_name("here.sqlite"), runs), Study(path, runs)
    here.run()
    monkeypatch.setattr(study, "execute", partial(signed, folder=path.parent))
    assert there.run(scheduler=workers.scheduler_address, progress=kill) == len(there.runs or ())
    rows = list(there.rows())
    processes = [int(row.pop("effort")) for row in rows]
    assert processes.count(victims[0]) == 1
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


def invented_then(run: Run, go: Path) -> dict[str, float]:
    """Return an invented result as soon as there is a file."""
    wait_until(go.exists)
    return invented(run)


def test_two_studies_at_a_time_on_one_cluster(
    workers: Any, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Equal calls are not one to dask, so neither study ends with the results of the other one.

    No run ends until both studies have handed out theirs.
    """
    go, other = path.with_name("go"), path.with_name("other.sqlite")
    both = threading.Barrier(2, action=go.touch)
    handed_out: set[int] = set()

    finished: Any = UnderWay.finished

    def wait(*arguments: Any) -> Any:
        if threading.get_ident() not in handed_out:
            handed_out.add(threading.get_ident())
            both.wait(PATIENCE)
        return finished(*arguments)

    monkeypatch.setattr(UnderWay, "finished", wait)
    monkeypatch.setattr(study, "execute", partial(invented_then, go=go))
    runs = grid(snr_db=20.0, seed=range(9))

    def run(file: Path) -> int:
        try:
            return Study(file, runs).run(scheduler=workers.scheduler_address)
        except BaseException:
            both.abort()
            raise

    with ThreadPoolExecutor(1) as thread:
        second = thread.submit(run, other)
        assert run(path) == 9
        assert second.result() == 9
    assert count_rows(path) == count_rows(other) == 9


# Schedulers that cannot be used


def refusal(address: str, error: type[Exception] = SchedulerUnavailable) -> str:
    """Return the message with which an address is refused."""
    with pytest.raises(error) as refused, cluster.connected(address):
        pass
    assert "\n" not in str(refused.value)
    return str(refused.value)


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
    """At once, without the patience that a scheduler gets."""
    monkeypatch.setattr(cluster, "_shake_hands", lambda _: pytest.fail("somebody listens"))
    with socket.socket() as nobody:
        # A port that nobody else gets, and nobody listens to.
        nobody.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{nobody.getsockname()[1]}"
        message = refusal(address)
        assert message.startswith(f"scheduler {address}: cannot be reached (ConnectionRefusedError")
        assert "dask scheduler" in message
        monkeypatch.setattr(study, "execute", lambda run: pytest.fail("work began"))
        with pytest.raises(SchedulerUnavailable, match="cannot be reached"):
            Study(path, grid()).run(scheduler=address)
    assert not path.with_name(path.name + ".lock").exists()


def test_what_listens_is_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    """A web server, to which dask's own client would wait for ever.

    With less patience than usual, which a busy machine may use up earlier: the answer is the same.
    """
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
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
    monkeypatch.setattr(cluster, "FIRST_WORKER", 0.1)
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


def serve(address: Connection) -> None:
    """Be a scheduler with a worker of two threads, until killed or the parent is gone."""
    make: Any = distributed.LocalCluster
    with make(
        n_workers=1,
        threads_per_worker=2,
        processes=False,
        protocol="tcp://",
        dashboard_address=":0",
        silence_logs=50,
    ) as started:
        address.send(started.scheduler_address)
        address.recv()


def invented_for_few(run: Run) -> dict[str, float]:
    """Return an invented result for three seeds, and never one for others."""
    if run.seed >= 3:
        threading.Event().wait()
    return invented(run)


def test_lost_scheduler_ends_the_study_with_what_was_done(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A scheduler with its worker in one process, which is killed after three runs."""
    ours, theirs = PROCESSES.Pipe()
    server = start(serve, theirs)
    address = answer_of(server, ours)

    def kill(done: int, total: int, rate: float) -> None:
        if done == 3:
            server.kill()

    runs = grid(snr_db=20.0, seed=range(40))
    monkeypatch.setattr(study, "execute", invented_for_few)
    with (
        # How long its client tries to come back.
        dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
        pytest.raises(SchedulerUnavailable, match="connection was lost after 3 of 40 runs"),
    ):
        Study(path, runs).run(scheduler=address, progress=kill)
    assert count_rows(path) == 3
    monkeypatch.setattr(study, "execute", invented)
    assert Study(path, runs).run() == 37


def test_scheduler_that_falls_silent_ends_the_study_with_what_was_done(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when the network between stalls: nothing is refused, and nothing comes."""
    ours, theirs = PROCESSES.Pipe()
    server = start(serve, theirs)
    address = answer_of(server, ours)

    def stop(done: int, total: int, rate: float) -> None:
        if done == 3:
            os.kill(server.pid or 0, signal.SIGSTOP)

    monkeypatch.setattr(study, "execute", invented_for_few)
    monkeypatch.setattr(study, "LOOK_UP", 0.1)
    monkeypatch.setattr(cluster, "ASKED_AGAIN", 0.1)
    monkeypatch.setattr(cluster, "SILENCE", 2.0)
    try:
        with (
            # How long its client waits for an answer to its farewell.
            dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
            pytest.raises(SchedulerUnavailable, match="connection was lost after 3 of 40 runs"),
        ):
            Study(path, grid(snr_db=20.0, seed=range(40))).run(scheduler=address, progress=stop)
    finally:
        server.kill()
    assert count_rows(path) == 3

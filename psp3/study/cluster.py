"""The workers of a dask.distributed cluster behind the interface of :mod:`concurrent.futures`."""

from __future__ import annotations

import asyncio
import logging
import socket
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any
from urllib.parse import urlsplit

from psp3.checks import checked_kind
from psp3.errors import InvalidValue, SchedulerUnavailable

PROTOCOLS = ("tcp", "tls", "ws", "wss")
"""What dask speaks over the network."""

PATIENCE = 30.0
"""How long to wait for an answer of the scheduler, which may be busy [s]."""

FIRST_WORKER = 5.0
"""How long to wait for the first worker of a scheduler that has answered [s]."""

SILENCE = 60.0
"""How long a scheduler may give no answer until it counts as lost [s]."""

ASKED_AGAIN = 5.0
"""How old the number of threads of a cluster may be until its scheduler is asked anew [s]."""


def package_version() -> str:
    """Return the version of psp3."""
    from psp3.version import __version__

    return __version__


@contextmanager
def connected(
    address: str, version: Callable[[], str] = package_version, one_thread: bool = False
) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Connect to a scheduler, and check that its workers can do the work.

    Parameters
    ----------
    address : str
        Where the scheduler listens, ``tcp://host:port``.
    version : callable
        Returns what must be the same here and on each worker.
    one_thread : bool
        Whether workers must have one thread each.

    Yields
    ------
    executor, workers
        The executor, and a function that tells how many runs the cluster does at a time.

    Raises
    ------
    InvalidValue
        If this is no address.
    SchedulerUnavailable
        If there is no scheduler, which a refused connection tells at once and silence in half a
        minute, or it has no workers, or they have another version of psp3, none, or too many
        threads.
    """
    host, port = host_and_port(address)
    try:
        import distributed
    except ImportError as error:
        reason = (
            f"the package distributed cannot be imported ({error}); install it with: pip install "
            "'psp3[cluster]'"
        )
        raise SchedulerUnavailable(address, reason) from error
    make_client: Any = distributed.Client
    try:
        # Dask would try again and again; this tells at once whether anything listens there.
        socket.create_connection((host, port), PATIENCE).close()
        _shake_hands(address)
        client = make_client(address, timeout=PATIENCE, set_as_default=False)
    except Exception as error:
        # Anything can come of talking to what is no scheduler.
        reason = f"cannot be reached ({_in_one_line(error)}); start one with: dask scheduler"
        raise SchedulerUnavailable(address, reason) from error
    with _quiet(), client:
        _check_workers(client, address, version, one_thread)
        # Impure, because equal calls would share one result, and a run that was lost could come
        # back as that of another.
        executor = client.get_executor(pure=False)
        try:
            yield executor, _Capacity(client)
        finally:
            executor.shutdown(wait=False)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep dask from logging at length what an error of ours says in a line.

    That the connection was lost.
    """
    loggers = [logging.getLogger(name) for name in ("distributed.client", "tornado.application")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


class _Capacity:
    """How many runs a cluster does at a time.

    Workers come and go, so its scheduler is asked now and then; nobody waits for the answer, since
    results are to be kept meanwhile.

    Raises ``CancelledError`` when the connection is gone for good, or the scheduler is silent.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._last: int = sum(client.nthreads().values())
        self._asked = self._answered = time.monotonic()
        self._answer: Future[dict[str, int]] | None = None

    def __call__(self) -> int:
        if self._client.status == "closed":
            raise CancelledError
        now = time.monotonic()
        if self._answer is not None and self._answer.done():
            # A client that cannot reach its scheduler tries again for a while, and then cancels its
            # runs and closes itself.
            with suppress(OSError):
                self._last, self._answered = sum(self._answer.result().values()), now
            self._answer, self._asked = None, now
        if self._answer is None and now - self._asked > ASKED_AGAIN:
            self._answer = asyncio.run_coroutine_threadsafe(
                self._client.scheduler.ncores(), self._client.loop.asyncio_loop
            )
        if now - self._answered > SILENCE:
            raise CancelledError
        return self._last


def host_and_port(address: object) -> tuple[str, int]:
    """Return where a scheduler listens; raise :class:`InvalidValue` if something is no address."""
    checked_kind("scheduler", address, str, "an address such as tcp://host:8786")
    assert isinstance(address, str)
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
    except ValueError:  # the port is not a number
        host = port = None
    if host is None or port is None or parts.scheme not in PROTOCOLS:
        raise InvalidValue("scheduler", address, "an address such as tcp://host:8786")
    return host, port


def _shake_hands(address: str) -> None:
    """Connect as dask does, but not without end.

    Its client waits forever for the greeting of what is no scheduler.
    """
    import distributed

    security: Any = distributed.Security
    connect: Any = distributed.comm.core.connect

    async def greet() -> None:
        comm = await asyncio.wait_for(
            connect(address, PATIENCE, **security().get_connection_args("client")), PATIENCE
        )
        comm.abort()

    # In a thread, because a notebook has an event loop of its own running in this one.
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, greet()).result()


def _check_workers(client: Any, address: str, version: Callable[[], str], one_thread: bool) -> None:
    try:
        client.wait_for_workers(1, timeout=FIRST_WORKER)
    except TimeoutError as error:
        raise SchedulerUnavailable(
            address, f"has no workers; start some with: dask worker {address}"
        ) from error
    here = version()
    try:
        versions = client.run(version)
    except Exception as error:
        # Whatever goes wrong on the way to a worker, a module that it lacks above all.
        reason = (
            f"a worker cannot run psp3 ({_in_one_line(error)}); install psp3 {here} on every worker"
        )
        raise SchedulerUnavailable(address, reason) from error
    for worker, there in versions.items():
        if there != here:
            raise SchedulerUnavailable(
                address,
                f"worker {worker} has psp3 {there}, but this is psp3 {here}; install the same "
                "everywhere",
            )
    if not one_thread:
        return
    for worker, threads in client.nthreads().items():
        if threads != 1:
            raise SchedulerUnavailable(
                address,
                f"worker {worker} has {threads} threads, and what is timed wants one; start "
                f"workers with: dask worker --nthreads 1 --nworkers {threads} {address}",
            )


def _in_one_line(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__

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
"""Network protocols that dask uses."""

PATIENCE = 30.0
"""How long to wait for the scheduler to answer; it may be busy [s]."""

FIRST_WORKER = 5.0
"""How long to wait for the first worker of a scheduler that has answered [s]."""

SILENCE = 60.0
"""A scheduler that is silent for longer than this counts as lost [s]."""

ASKED_AGAIN = 5.0
"""How long a cluster's thread count is reused before the scheduler is asked again [s]."""


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
        Returns a value that must be the same here and on each worker.
    one_thread : bool
        Whether workers must have one thread each.

    Yields
    ------
    executor, workers
        The executor, and a function that returns how many runs the cluster does at a time.

    Raises
    ------
    InvalidValue
        If ``address`` is not a valid address.
    SchedulerUnavailable
        If there is no scheduler: a refused connection shows this at once, silence in half a minute.
        Also if the scheduler has no workers, or if the workers lack psp3, have another version of
        it, or have too many threads.
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
        # Dask would retry for a long time; this fails at once if nothing listens there.
        socket.create_connection((host, port), PATIENCE).close()
        _shake_hands(address)
        client = make_client(address, timeout=PATIENCE, set_as_default=False)
    except Exception as error:
        # A server that is not a scheduler can answer anything, so any exception is possible.
        reason = f"cannot be reached ({_in_one_line(error)}); start one with: dask scheduler"
        raise SchedulerUnavailable(address, reason) from error
    with _quiet(), client:
        _check_workers(client, address, version, one_thread)
        # Impure, because dask would share one result among equal calls, and a lost run could come
        # back with the result of another one.
        executor = client.get_executor(pure=False)
        try:
            yield executor, _Capacity(client)
        finally:
            executor.shutdown(wait=False)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep dask from logging at length what one of our errors says in a line.

    The message is that the connection was lost.
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

    Workers come and go, so the scheduler is asked now and then. Nobody waits for its answer,
    because results must be saved in the meantime.

    A call raises ``CancelledError`` when the connection is lost for good, or the scheduler is
    silent.
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
    """Return a scheduler's host and port; raise :class:`InvalidValue` if the address is invalid."""
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
    """Connect as dask does, but with a time limit.

    Dask's client waits forever for the greeting of a server that is not a scheduler.
    """
    import distributed

    security: Any = distributed.Security
    connect: Any = distributed.comm.core.connect

    async def greet() -> None:
        comm = await asyncio.wait_for(
            connect(address, PATIENCE, **security().get_connection_args("client")), PATIENCE
        )
        comm.abort()

    # In another thread, because a notebook already runs an event loop in this one.
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
        # Most often a module that the worker lacks, but any failure on the worker ends up here.
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
                f"worker {worker} has {threads} threads, but timed work needs one; start "
                f"workers with: dask worker --nthreads 1 --nworkers {threads} {address}",
            )


def _in_one_line(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__

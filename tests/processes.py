"""Processes of the tests' own.

A new Python imports and loads kernels for one or two seconds. These processes are forked from a
server that has done so once; a plain fork of the tests would copy locks of their threads. What they
do is done in a process all the same: it has descriptors, signals and an exit code, and can be
killed.

However the tests were started, signals are at their defaults. Shells let jobs in the background
ignore interrupts, and these ignore them for what they start.

None of them lives for ever: after :data:`PATIENCE` it says where it is, and ends. So does whoever
waits for it, since its pipes are closed then.
"""

from __future__ import annotations

import contextlib
import faulthandler
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from multiprocessing import forkserver
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import pytest

PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload(["tests.prepared"])

PATIENCE = 900.0
"""How long a process of the tests lives, and is waited for [s]: so busy is no machine."""

ROOT = Path(__file__).resolve().parents[1]
ENVIRONMENT = {
    "PATH": os.environ.get("PATH", os.defpath),
    "PYTHONPATH": str(ROOT),
    "LC_ALL": "C.UTF-8",
    "COLUMNS": "80",
    "NO_COLOR": "1",
    "TERM": "dumb",
}
"""Of every command: a plain terminal of 80 columns, whatever the tests themselves run in."""


def start_server() -> None:
    """Start the server of processes, for whoever else forks from it."""
    forkserver.ensure_running()


def heed_signals() -> None:
    """Let signals do what they do by default."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def _call(function: Callable[..., object], arguments: tuple[object, ...]) -> None:
    heed_signals()
    # In a thread of C, which locks of Python do not hold up.
    faulthandler.dump_traceback_later(PATIENCE, exit=True, file=2)
    function(*arguments)


def start(function: Callable[..., object], *arguments: object) -> BaseProcess:
    """Call a function of a module in a new process."""
    process = PROCESSES.Process(target=_call, args=(function, arguments), daemon=True)
    process.start()
    return process


def answer_of(process: BaseProcess, answers: Connection) -> Any:
    """Return what a process sends; fail if it ends without, or sends nothing."""
    if not wait([answers, process.sentinel], PATIENCE):
        process.kill()
    if answers.poll():
        with contextlib.suppress(EOFError):
            return answers.recv()
    process.join()
    pytest.fail(f"the process ended before it came to that; exit code {process.exitcode}")


def computed(process: int) -> float:
    """Return the seconds that a process has computed, of which others on the machine take none."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Program:
    """``psp3`` with some arguments in a process of its own."""

    def __init__(self, process: BaseProcess, out: Connection, err: Connection) -> None:
        self.process = process
        self.out = open(out.fileno(), encoding="utf-8", closefd=False)  # noqa: SIM115
        self.err = open(err.fileno(), encoding="utf-8", closefd=False)  # noqa: SIM115
        self._descriptors = (out, err)

    def interrupt(self) -> None:
        """Do what Ctrl-C does."""
        assert self.process.pid is not None
        os.kill(self.process.pid, signal.SIGINT)

    def close_output(self) -> None:
        """Read no more of what the program prints."""
        self._descriptors[0].close()

    def end(self) -> tuple[int | None, str, str]:
        """Wait for its end; return exit code, output and errors.

        Errors are read first, since they are short, and the output fits into a pipe or is closed.
        """
        err = self.err.read()
        out = "" if self._descriptors[0].closed else self.out.read()
        self.process.join()
        return self.process.exitcode, out, err


def _run(
    prepare: Callable[..., object] | None,
    given: tuple[object, ...],
    arguments: tuple[str, ...],
    environment: Mapping[str, str],
    folder: Path,
    out: Connection,
    err: Connection,
) -> None:
    """Be the program: take its environment, folder and descriptors, and call its main function."""
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    encoding = environment.get("PYTHONIOENCODING", "utf-8")
    for number, connection in ((1, out), (2, err)):
        os.dup2(connection.fileno(), number)
        connection.close()
    sys.stdout = sys.__stdout__ = open(1, "w", encoding=encoding, closefd=False)  # type: ignore[misc]  # noqa: SIM115
    sys.stderr = sys.__stderr__ = open(2, "w", encoding=encoding, closefd=False)  # type: ignore[misc]  # noqa: SIM115
    sys.argv = ["psp3", *arguments]
    if prepare is not None:
        prepare(*given)
    from psp3.cli.entry import main

    main()


@contextlib.contextmanager
def program(
    *arguments: object,
    folder: Path,
    environment: Mapping[str, str] = ENVIRONMENT,
    prepare: Callable[..., object] | None = None,
    given: tuple[object, ...] = (),
) -> Iterator[Program]:
    """Start ``psp3`` in a folder; kill it at the end if it is still running.

    ``prepare(*given)`` is called in the process before.
    """
    (out, their_out), (err, their_err) = (PROCESSES.Pipe(duplex=False) for _ in range(2))
    with out, err:
        texts = tuple(map(str, arguments))
        process = start(_run, prepare, given, texts, environment, folder, their_out, their_err)
        their_out.close()
        their_err.close()
        try:
            yield Program(process, out, err)
        finally:
            process.kill()
            process.join()

"""Studies, benchmarks and saves that are ended at random moments, and what is then on the disk.

A process does the work and tells what it has done; a signal ends it after a random time, and what
is on the disk is compared with what was told. Then the same work goes on, until it is whole and
begins anew. As a program::

    python -m tests.hostile.endings 200 0

ends 200 of them with SIGKILL and 200 with SIGINT, at moments of the seed 0, and prints the counts.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy2.support.text_files import write_text
from psp3.benchmark import Benchmark, benchmark
from psp3.benchmark.benchmark import FILE
from psp3.benchmark.file import OutcomeFile
from psp3.errors import StudyInterrupted
from psp3.study import Study, grid, study
from psp3.study.file import GROUP
from psp3.study.run import METRICS, Run
from tests.processes import PROCESSES, start
from tests.study_helpers import invented

LONGEST = 1.2
"""The longest time before the signal [s]: more than two groups of a study."""

RUNS = 3000
TRIALS = 400
SIZE = 200_000
"""Numbers of runs of a study and of trials of a benchmark, and characters of what is saved."""

PACKAGES = ("/psp3/", "/fuzzy2/")
"""What is in the path of a file of ours; an interrupt before we are called is outside."""

LETTERS = "abcdefghij"


class Told(NamedTuple):
    """What a process tells: how much it had done, and when; or how its work ended."""

    word: str
    done: int
    at: float


def _told(answers: Connection, work: Callable[[Callable[[int], None]], None]) -> None:
    def tell(done: int) -> None:
        answers.send(Told("done", done, time.monotonic()))

    try:
        answers.send(Told("ready", 0, time.monotonic()))
        work(tell)
        end = Told("whole", 0, time.monotonic())
    except StudyInterrupted as error:
        end = Told("StudyInterrupted", error.done, time.monotonic())
    except BaseException as error:
        frames = traceback.extract_tb(error.__traceback__)
        ours = any(folder in frame.filename for frame in frames for folder in PACKAGES)
        end = Told(type(error).__name__ if ours else "outside", 0, time.monotonic())
    answers.send(end)


# What processes do


def _studied(path: Path, answers: Connection) -> None:
    def slowly(run: Run) -> dict[str, float]:
        time.sleep(0.001)
        return invented(run)

    study.execute = slowly  # type: ignore[attr-defined]
    wanted = Study(path, _runs())
    _told(answers, lambda tell: _ignored(wanted.run(2, progress=lambda done, *_: tell(done))))


def _tried(folder: Path, answers: Connection) -> None:
    benchmark.execute = _outcome  # type: ignore[attr-defined]
    wanted = _benchmark(folder)
    _told(answers, lambda tell: _ignored(wanted.run(1, progress=lambda done, *_: tell(done))))


def _saved(path: Path, answers: Connection) -> None:
    def save(tell: Callable[[int], None]) -> None:
        first = _number_in(path) + 1
        for number in range(first, first + 1000):
            write_text(_text(number), path)
            tell(number)

    _told(answers, save)


def _ignored(_: object) -> None:
    pass


def _runs() -> Any:
    return grid(snr_db=20.0, seed=range(RUNS))


def _benchmark(folder: Path) -> Benchmark:
    return Benchmark(folder, ["anfis"], robots=["delta"], seeds=TRIALS, duration=0.1)


def _outcome(*_: object) -> dict[str, Any]:
    time.sleep(0.001)
    return {"error": None, "number": 0.1 + 0.2}


def _text(number: int) -> str:
    return f"{number} ".ljust(SIZE, LETTERS[number % len(LETTERS)])


def _number_in(path: Path) -> int:
    return int(path.read_text("utf-8").partition(" ")[0]) if path.exists() else 0


# What must be on the disk


def _check_study(folder: Path, told: list[Told], killed: float) -> bool:
    """Return whether it is whole."""
    path = folder / "study.sqlite"
    rows = Study(path).rows() if path.exists() and path.stat().st_size else []
    for row in rows:
        expected = invented(Run(seed=row["seed"]))
        assert {name: row[name] for name in METRICS} == expected, "a row is what was found"
    safe = max((one.done for one in told if one.at <= killed - GROUP), default=0)
    assert len(rows) >= safe, f"{len(rows)} rows of {safe} that came back {GROUP} s before"
    if told[-1].word == "StudyInterrupted":
        assert told[-1].done in (len(rows), 0), "an interrupt says how many rows there are"
        assert len(rows) >= max(one.done for one in told), "and loses none of them"
    return len(rows) == RUNS


def _check_benchmark(folder: Path, told: list[Told], killed: float) -> bool:
    path = folder / FILE
    outcomes = OutcomeFile(path).outcomes() if path.exists() else {}
    assert all(outcome == _outcome() for outcome in outcomes.values())
    assert len(outcomes) >= max(one.done for one in told), "each is kept when it is done"
    return told[-1].word == "whole"


def _check_saves(folder: Path, told: list[Told], killed: float) -> bool:
    path = folder / "text"
    number = _number_in(path)
    assert number == 0 or path.read_text("utf-8") == _text(number), "it is whole"
    assert number >= max(one.done for one in told), "and not older than what was saved"
    write_text("another", folder / "another")
    assert {entry.name for entry in folder.iterdir()} <= {"text", "another"}, "no draft stays"
    return number >= 1000


KINDS: dict[str, tuple[Any, str, Callable[[Path, list[Told], float], bool]]] = {
    "study": (_studied, "study.sqlite", _check_study),
    "benchmark": (_tried, "", _check_benchmark),
    "saves": (_saved, "text", _check_saves),
}


def ended(kind: str, how: signal.Signals, folder: Path, drawn: random.Random) -> tuple[str, bool]:
    """End a process of a kind at a random moment, and check what is on the disk.

    Returns
    -------
    word : str
        How it ended.
    whole : bool
        Whether all of the work is done.
    """
    work, name, check = KINDS[kind]
    ours, theirs = PROCESSES.Pipe(duplex=False)
    process = start(work, folder / name, theirs)
    theirs.close()
    told: list[Told] = [ours.recv()]
    until = time.monotonic() + drawn.uniform(0.0, LONGEST)
    killed = 0.0
    while True:
        if not killed and time.monotonic() >= until:
            killed = time.monotonic()
            if process.is_alive():
                os.kill(process.pid or 0, how)
        try:
            if ours.poll(1.0 if killed else max(0.0, until - time.monotonic())):
                told.append(ours.recv())
        except EOFError:
            break
    process.join()
    killed = killed or time.monotonic()
    word = told[-1].word if how == signal.SIGINT or told[-1].word == "whole" else "killed"
    # The work itself may have been done before the signal came.
    expected = {"killed", "whole", "outside", "StudyInterrupted"}
    if kind == "saves":
        expected.add("KeyboardInterrupt")
    assert word in expected, f"{kind} ended by {how.name} with {word}"
    return word, check(folder, told, killed)


def campaign(count: int, seed: int, kinds: tuple[str, ...] = tuple(KINDS)) -> Counter[Any]:
    """End so many processes with each signal, of all kinds in turn; return how they ended."""
    drawn, words = random.Random(seed), Counter[Any]()
    for kind in kinds:
        with tempfile.TemporaryDirectory() as name:
            number = 0
            for k in range(2 * count):
                if k // 2 % len(kinds) != kinds.index(kind):
                    continue
                how = (signal.SIGKILL, signal.SIGINT)[k % 2]
                folder = Path(name, str(number))
                folder.mkdir(exist_ok=True)
                word, is_whole = ended(kind, how, folder, drawn)
                words[kind, how.name, word] += 1
                number += is_whole
    return words


def main() -> None:
    """Print the counts of a campaign: so many endings with each signal, a seed, and kinds."""
    # No run is simulated here, so nothing need be compiled before.
    PROCESSES.set_forkserver_preload(["psp3.benchmark.benchmark", "tests.study_helpers"])
    begun = time.monotonic()
    count, seed, *kinds = sys.argv[1:]
    words = campaign(int(count), int(seed), tuple(kinds) or tuple(KINDS))
    for (kind, how, word), number in sorted(words.items()):
        sys.stdout.write(f"{kind:10} {how:8} {word:20} {number}\n")
    took = time.monotonic() - begun
    total = sum(words.values())
    sys.stdout.write(f"{total} endings in {took:.0f} s, nothing lost beyond what is stated\n")


if __name__ == "__main__":
    main()

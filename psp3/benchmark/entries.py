"""Entries: what takes part in the benchmark, by name or from a file.

A file of an entry has one class, of one of two kinds:

* a *regressor* with ``fit(X, Y)`` and ``predict(X)``, of which computed torque is made
  (:mod:`psp3.benchmark.learned`): rows of X are the robot's inputs, rows of Y the upper triangle of
  M, C and G, stacked, in SI units;
* a *controller* with ``reset()`` and ``torque(t, positions, speeds, desired)``. If it has ``fit``,
  too, it learns from the same samples.

Its constructor gets what it names among its parameters: ``robot``, ``kp`` and ``kv``, the gains of
the servo, and ``rng``, a :class:`numpy.random.Generator`. Who asks for the robot is said to know
the model.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from psp3.benchmark.learned import LearnedComputedTorque
from psp3.benchmark.readings import Lesson
from psp3.benchmark.tasks import Task
from psp3.control.controller import Controller
from psp3.errors import InvalidEntry

MODEL, SAMPLES, BOTH, NEITHER = "the model", "samples", "model and samples", "nothing"
"""What an entry can know of the robot."""

GIVEN = ("robot", "kp", "kv", "rng")
"""What the constructor of a class in a file can ask for."""


class Course(NamedTuple):
    """What an entry is given for one robot and one draw of the noise.

    The ``task``, the ``lesson`` with its noise, the ``reading`` and the ratio ``snr_db`` that it
    was made with and the seed ``noise`` of it, ``rng`` for what the entry draws itself, and the
    control ``period`` [s].
    """

    task: Task
    lesson: Lesson
    reading: str
    snr_db: float
    noise: tuple[int, int]
    rng: np.random.Generator
    period: float


@dataclass(frozen=True)
class Entry:
    """Something that takes part.

    Parameters
    ----------
    name : str
        What it is called on the board.
    knows : str
        ``MODEL``, ``SAMPLES``, ``BOTH`` or ``NEITHER``.
    make : callable
        Returns the controller of a :class:`Course`, trained.
    draws : bool
        Whether it draws random numbers, so that seeds differ without noise, too.
    mark : str
        Changes with whatever changes the entry; with the name it says which results are its own.
    """

    name: str
    knows: str
    make: Callable[[Course], Controller]
    draws: bool = False
    mark: str = ""

    @property
    def learns(self) -> bool:
        """Whether it sees the samples, and so their noise."""
        return self.knows in (SAMPLES, BOTH)


def load_entry(path: str | Path) -> Entry:
    """Return the entry of a file; its name is that of the file without the suffix.

    The file is run, with all rights of this process.

    Parameters
    ----------
    path : path
        A Python file.

    Returns
    -------
    Entry

    Raises
    ------
    InvalidEntry
        If the file cannot be read or run, has no class that can be an entry or several, or its
        constructor asks for what there is not.
    """
    path = Path(path)
    try:
        source = path.read_bytes()
    except OSError as error:
        raise InvalidEntry(str(path), f"cannot be read: {error.strerror}") from error
    mark = hashlib.sha256(source).hexdigest()[:16]
    kind = _the_class(path, mark)
    wanted = _asked_for(path, kind)
    fits = callable(getattr(kind, "fit", None))
    knows = {
        (True, True): BOTH,
        (True, False): MODEL,
        (False, True): SAMPLES,
        (False, False): NEITHER,
    }["robot" in wanted, fits]
    is_regressor = callable(getattr(kind, "predict", None))

    def make(course: Course) -> Controller:
        task = course.task
        there = {"robot": task.robot, "kp": task.kp, "kv": task.kv, "rng": course.rng}
        made: Any = kind(**{name: there[name] for name in wanted})
        if is_regressor:
            return of_regressor(made, course, path.stem)
        if fits:
            made.fit(course.lesson.inputs.copy(), course.lesson.outputs.copy())
        controller: Controller = made
        return controller

    return Entry(path.stem, knows, make, "rng" in wanted, mark)


def of_regressor(regressor: Any, course: Course, name: str) -> LearnedComputedTorque:
    """Return computed torque with what a regressor learns from the samples of a course."""
    task = course.task
    return LearnedComputedTorque(regressor, course.lesson, task.inputs_of, task.kp, task.kv, name)


def _the_class(path: Path, mark: str) -> type:
    """Run a file, and return its class that can be an entry."""
    name = f"psp3_benchmark_entry_{mark}"
    specification = importlib.util.spec_from_file_location(name, path)
    if specification is None or specification.loader is None:
        raise InvalidEntry(str(path), "is not a Python file; its name must end in .py")
    module = importlib.util.module_from_spec(specification)
    # Classes that are pickled, and dataclasses, look their module up.
    sys.modules[name] = module
    try:
        specification.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise InvalidEntry(str(path), f"raises {said(error)}") from error
    found = [
        kind
        for kind in vars(module).values()
        if isinstance(kind, type) and kind.__module__ == name and _can_enter(kind)
    ]
    if len(found) != 1:
        names = ", ".join(kind.__name__ for kind in found) or "none"
        raise InvalidEntry(
            str(path),
            "must have one class with fit(X, Y) and predict(X), or with reset() and "
            f"torque(t, positions, speeds, desired); found {names}",
        )
    return found[0]


def _can_enter(kind: type) -> bool:
    return any(
        all(callable(getattr(kind, method, None)) for method in methods)
        for methods in (("fit", "predict"), ("reset", "torque"))
    )


def _asked_for(path: Path, kind: type) -> tuple[str, ...]:
    """Return the names of the parameters of a constructor that are given."""
    parameters = inspect.signature(kind).parameters.values()
    named = [one for one in parameters if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)]
    for one in named:
        if one.name not in GIVEN and one.default is one.empty:
            raise InvalidEntry(
                str(path),
                f"{kind.__name__} asks for {one.name!r}; it can have {', '.join(GIVEN)}, other "
                "parameters need defaults",
            )
    return tuple(one.name for one in named if one.name in GIVEN)


def said(error: BaseException) -> str:
    """Return an error in one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"

"""Entries of the benchmark, by name or from a file.

A file of an entry has one class, of one of two kinds:

* a *regressor* with ``fit(X, Y)`` and ``predict(X)``, which is used for computed torque
  (:mod:`psp3.benchmark.learned`): rows of X are the robot's inputs, rows of Y the upper triangle of
  M, C and G, stacked, in SI units;
* a *controller* with ``reset()`` and ``torque(t, positions, speeds, desired)``. If it has ``fit``,
  too, it learns from the same samples.

Its constructor can have these parameters: ``robot``, ``kp`` and ``kv``, the gains of the servo, and
``rng``, a :class:`numpy.random.Generator`. An entry with the parameter ``robot`` is listed as
knowing the model.
"""

from __future__ import annotations

import hashlib
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.bounded_files import not_read
from psp3.benchmark.learned import LearnedComputedTorque
from psp3.benchmark.readings import Lesson
from psp3.benchmark.tasks import Task
from psp3.checks import checked_path
from psp3.control.controller import Controller
from psp3.errors import InvalidEntry

MODEL, SAMPLES, BOTH, NEITHER = "the model", "samples", "model and samples", "nothing"
"""What an entry can know about the robot."""

GIVEN = ("robot", "kp", "kv", "rng")
"""Parameters that the constructor of a class in a file can have."""


class Course(NamedTuple):
    """The input of an entry for one robot and one draw of the noise.

    It holds the ``task``, the ``lesson`` with noise, the noise's ``reading``, ratio ``snr_db`` and
    seed ``noise``, ``rng`` for random numbers of the entry, and the control ``period`` [s].
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
    """A participant of the benchmark.

    Parameters
    ----------
    name : str
        Its name on the board.
    knows : str
        ``MODEL``, ``SAMPLES``, ``BOTH`` or ``NEITHER``.
    make : callable
        Returns the controller of a :class:`Course`, trained.
    draws : bool
        Whether it draws random numbers, so its results depend on the seed even without noise.
    mark : str
        A text that changes whenever the entry changes; name and mark identify the results of the
        entry.
    """

    name: str
    knows: str
    make: Callable[[Course], Controller]
    draws: bool = False
    mark: str = ""

    @property
    def learns(self) -> bool:
        """Whether it sees the samples, and thus their noise."""
        return self.knows in (SAMPLES, BOTH)


def load_entry(path: str | Path) -> Entry:
    """Return the entry of a file; its name is that of the file without the suffix.

    The file is executed with all rights of this process.

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
        If the file cannot be read or executed, if it does not have exactly one class that can be an
        entry, or if a parameter of its constructor is unknown.
    """
    path = checked_path("path", path)
    try:
        source = path.read_bytes()
    except OSError as error:
        raise InvalidEntry(str(path), not_read(error)) from error
    if path.suffix != ".py":
        raise InvalidEntry(str(path), "is not a Python file; its name must end in .py")
    made = _OfFile(str(path), source)
    fits = callable(getattr(made.kind, "fit", None))
    knows = {
        (True, True): BOTH,
        (True, False): MODEL,
        (False, True): SAMPLES,
        (False, False): NEITHER,
    }["robot" in made.wanted, fits]
    return Entry(path.stem, knows, made, "rng" in made.wanted, made.mark)


@dataclass(frozen=True)
class _OfFile:
    """A function that makes the controller of an entry from the content of its file.

    Other processes and machines receive this content, so they execute what was read here.
    """

    path: str
    source: bytes

    def __reduce__(self) -> tuple[type[_OfFile], tuple[str, bytes]]:
        return _OfFile, (self.path, self.source)

    @property
    def mark(self) -> str:
        """Mark that changes with the content."""
        return hashlib.sha256(self.source).hexdigest()[:16]

    @cached_property
    def kind(self) -> type:
        """Class of the entry; the file is executed to get it."""
        return _the_class(self.path, self.source, self.mark)

    @cached_property
    def wanted(self) -> tuple[str, ...]:
        """Names of the parameters that its constructor gets."""
        return _asked_for(self.path, self.kind)

    def __call__(self, course: Course) -> Controller:
        task = course.task
        there = {"robot": task.robot, "kp": task.kp, "kv": task.kv, "rng": course.rng}
        made: Any = self.kind(**{name: there[name] for name in self.wanted})
        if callable(getattr(self.kind, "predict", None)):
            return of_regressor(made, course, Path(self.path).stem)
        if callable(getattr(self.kind, "fit", None)):
            made.fit(course.lesson.inputs.copy(), course.lesson.outputs.copy())
        controller: Controller = made
        return controller


def of_regressor(regressor: Any, course: Course, name: str) -> LearnedComputedTorque:
    """Return computed torque with a regressor that learns from the samples of a course."""
    task = course.task
    return LearnedComputedTorque(regressor, course.lesson, task.inputs_of, task.kp, task.kv, name)


def _the_class(path: str, source: bytes, mark: str) -> type:
    """Execute the content of a file, and return its class that can be an entry."""
    name = f"psp3_benchmark_entry_{mark}"
    module = ModuleType(name)
    module.__file__ = path
    # Pickled classes and dataclasses look up their module.
    sys.modules[name] = module
    try:
        exec(compile(source, path, "exec"), vars(module))
    except (Exception, SystemExit) as error:
        raise InvalidEntry(path, f"raises {said(error)}") from error
    found = [
        kind
        for kind in vars(module).values()
        if isinstance(kind, type) and kind.__module__ == name and _can_enter(kind)
    ]
    if len(found) != 1:
        names = ", ".join(kind.__name__ for kind in found) or "none"
        raise InvalidEntry(
            path,
            "must have one class with fit(X, Y) and predict(X), or with reset() and "
            f"torque(t, positions, speeds, desired); found {names}",
        )
    return found[0]


def _can_enter(kind: type) -> bool:
    return any(
        all(callable(getattr(kind, method, None)) for method in methods)
        for methods in (("fit", "predict"), ("reset", "torque"))
    )


def _asked_for(path: str, kind: type) -> tuple[str, ...]:
    """Return the names of a constructor's parameters, which the benchmark provides."""
    parameters = inspect.signature(kind).parameters.values()
    named = [one for one in parameters if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)]
    for one in named:
        if one.name not in GIVEN and one.default is one.empty:
            raise InvalidEntry(
                path,
                f"{kind.__name__} asks for {one.name!r}; it can have {', '.join(GIVEN)}, other "
                "parameters need defaults",
            )
    return tuple(one.name for one in named if one.name in GIVEN)


def said(error: BaseException) -> str:
    """Return an error in one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"

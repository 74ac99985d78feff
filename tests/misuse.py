"""Misuse: a public callable with good arguments but one, and what may come of it.

Of each argument a good value is known. It is replaced by each of the things that people pass by
mistake (:func:`mistakes`), and by the same numbers in another form (:func:`other_forms`). A mistake
must be refused by an error of the project, with a message that can be shown; a number that is only
very large or very small may also be computed with, if what comes of it is finite. Another form must
give the very same numbers. No argument is ever written to.

All calls of all tables take minutes. Unless ``MISUSE=all`` stands in the environment (``make
misuse``), one of :data:`PARTS` is made: the good call always, and of the others those whose names
have a checksum that :data:`SEED` chooses, the same ones in every run. Each argument of each
callable is tried, whatever the sample.
"""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import importlib
import inspect
import math
import os
import pkgutil
import tempfile
import warnings
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.errors import RaisedOnPurpose, in_words

LONGEST_MESSAGE = 3000
"""More than this is no message but a listing [characters]."""

ONLY_UNUSUAL = ("huge", "tiny", "true", "huge entries", "tiny entries", "true entries")
"""Numbers like any other: an answer to them is no fault if it is finite."""

ROUNDS = (np.float32, np.int64)

PARTS = 1 if os.environ.get("MISUSE") == "all" else 8
"""One of so many wrong calls is made."""

SEED = 18
"""Which ones: another number, another sample."""


class Call(NamedTuple):
    """A public callable with a good value of each of its parameters.

    ``takes`` names, argument by argument, the mistakes that are none there (a title may be any
    text), ``"*"`` for all of them. ``reads`` turns what the callable returns into what must be
    finite and the same for every form of an argument; without it all numbers in it are.
    """

    function: Callable[..., Any]
    arguments: Mapping[str, Any]
    takes: Mapping[str, Collection[str]] = {}
    reads: Callable[[Any], Any] | None = None


class Outcome(NamedTuple):
    """What came of a call: an answer in numbers, an error on purpose, or a ``fault`` in words."""

    numbers: list[np.ndarray[Any, Any]] | None
    error: BaseException | None
    fault: str


def mistakes(good: Any) -> Iterator[tuple[str, Any]]:
    """Yield what may stand in place of a good argument, each with its name."""
    yield "NaN", math.nan
    yield "infinite", math.inf
    yield "huge", 1e300
    yield "tiny", 1e-320
    yield "400 digits", 10**400
    yield "5000 digits", 10**5000  # more digits than Python turns into text
    yield "complex", 1.0 + 1.0j
    yield "true", True
    yield "text", "no such thing"
    yield "bytes", b"no such thing"
    yield "object", object()
    yield "date", np.datetime64("2020-02-20")
    yield "masked", np.ma.masked
    yield "empty", []
    yield "ragged", [[1.0, 2.0], [3.0]]
    yield "mapping", {"a": 1.0}
    if good is not None:
        yield "None", None
    if not is_numbers(good):
        return
    array = np.array(good, dtype=np.float64)
    yield from _wrong_entries(array)
    yield "one entry too many", np.zeros((*array.shape[:-1], array.shape[-1] + 1))
    yield "one entry too few", np.zeros((*array.shape[:-1], array.shape[-1] - 1))
    yield "column", array[..., None]


def _wrong_entries(array: np.ndarray[Any, Any]) -> Iterator[tuple[str, Any]]:
    """Yield arrays of the right shape with one wrong entry, or all of a wrong kind."""
    for name, number in (("NaN entry", math.nan), ("infinite entry", math.inf)):
        wrong = array.copy()
        wrong.flat[-1] = number
        yield name, wrong
    for name, value in (
        ("None entry", None),
        ("text entry", "1.0"),
        ("entry of 400 digits", 10**400),
        ("date entry", np.datetime64("2020-02-20")),
        ("object entry", object()),
    ):
        mixed = array.astype(object)
        mixed.flat[-1] = value
        yield name, mixed
    yield "complex entries", array + 1e-20j
    yield "text entries", array.astype(str)
    yield "bytes entries", array.astype(bytes)
    yield "date entries", np.full(array.shape, np.datetime64("2020-02-20"))
    yield "void entries", np.zeros(array.shape, dtype=[("a", float)])
    yield "masked entries", np.ma.masked_array(array, mask=np.arange(array.size) == array.size - 1)
    yield "huge entries", np.copysign(1e300, array)
    yield "tiny entries", np.copysign(1e-320, array)
    yield "true entries", np.ones(array.shape, dtype=bool)


def other_forms(good: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield a good number or array in another form, with the plain one of the same numbers."""
    if isinstance(good, float | int) and not isinstance(good, bool):
        if isinstance(good, int):
            yield "numpy's int", np.int32(good), good
        else:
            yield "numpy's float", np.float64(good), good
            yield "float32", np.float32(good), float(np.float32(good))
            if math.isfinite(good):
                yield "int", round(good), float(round(good))
    if not is_numbers(good):
        return
    array = np.array(good)
    if array.dtype.kind == "i":
        yield "int32", array.astype(np.int32), array
    else:
        for kind in ROUNDS:
            coarse = (np.rint(array) if kind is np.int64 else array).astype(kind)
            yield kind.__name__, coarse, coarse.astype(np.float64)
        yield "of objects", array.astype(object), array
    spread = np.zeros((*array.shape[:-1], 2 * array.shape[-1]), dtype=array.dtype)
    spread[..., ::2] = array
    yield "strided", spread[..., ::2], array
    yield "backward", np.ascontiguousarray(array[..., ::-1])[..., ::-1], array
    yield "by columns", np.asfortranarray(array), array
    yield "other byte order", array.astype(array.dtype.newbyteorder()), array
    yield "list", array.tolist(), array
    kept = array.copy()
    kept.flags.writeable = False
    yield "read-only", kept, array


def is_numbers(good: Any) -> bool:
    """Tell whether a good argument is an array, a list or a tuple of numbers."""
    if not isinstance(good, np.ndarray | list | tuple) or hasattr(good, "_fields"):
        return False
    try:
        array = np.asarray(good)
    except ValueError:
        return False
    return array.dtype.kind in "fi" and array.ndim > 0 and array.size > 0


def numbers_in(thing: Any, deep: int = 5) -> list[np.ndarray[Any, Any]]:
    """Return all numbers that something holds, down to a depth, as arrays."""
    if isinstance(thing, bool | np.bool_ | str | bytes | Path) or thing is None or deep == 0:
        return []
    if isinstance(thing, int | float | complex | np.number):
        return [np.asarray(thing)]
    if isinstance(thing, np.ndarray) and thing.dtype.kind != "O":
        return [thing] if thing.dtype.kind in "fiuc" else []
    parts: Iterable[Any]
    if isinstance(thing, Mapping):
        parts = thing.values()
    elif isinstance(thing, tuple | list | set | frozenset | np.ndarray):
        parts = thing
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        parts = [getattr(thing, field.name) for field in dataclasses.fields(thing)]
    elif type(thing).__module__.startswith(("psp3", "fuzzy2")):
        parts = _public_values(thing)
    else:
        parts = []
    return [array for part in parts for array in numbers_in(part, deep - 1)]


def _public_values(thing: Any) -> list[Any]:
    """Return what an object shows: its attributes, or, where it keeps them back, its properties."""
    if hasattr(thing, "__dict__"):
        return [value for name, value in vars(thing).items() if not name.startswith("_")]
    kind = type(thing)
    return [getattr(thing, name) for name in dir(kind) if isinstance(getattr(kind, name), property)]


def outcome(call: Call, arguments: Mapping[str, Any]) -> Outcome:
    """Call, and tell what came of it; a warning that is not the project's own is a fault."""
    given = {name: _kept(value) for name, value in arguments.items()}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            answer = call.function(**arguments)
            found = numbers_in(answer if call.reads is None else call.reads(answer))
            result = Outcome(found, None, "")
        except RaisedOnPurpose as error:
            result = Outcome(None, error, _fault_of_message(error))
        except Exception as error:
            result = Outcome(None, error, _fault_of_foreign(error))
    foreign = [one for one in told if not issubclass(one.category, RaisedOnPurpose)]
    if foreign:
        result = result._replace(fault=f"foreign warning: {foreign[0].message}")
    written = [name for name, value in arguments.items() if not _same(given[name], value)]
    return result._replace(fault=f"wrote to {', '.join(written)}") if written else result


def faults(name: str, call: Call, parts: int = PARTS) -> list[str]:
    """Return what is wrong with a callable, one line a fault; one of so many calls is made.

    What a call writes to a name that was meant as a mistake goes to a folder that is empty before
    and gone after.
    """
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        return list(_faults(name, call, parts))


def _faults(name: str, call: Call, parts: int) -> Iterator[str]:
    good = outcome(call, call.arguments)
    if good.numbers is None or good.fault:
        yield f"{name}: good arguments: {good.fault or good.error!r}"
        return
    for argument, value in call.arguments.items():
        for mistake, wrong in sample(f"{name} {argument}", mistakes(value), parts):
            fault = _fault_of_mistake(call, argument, mistake, wrong)
            if fault:
                yield f"{name}: {argument} = {mistake}: {fault}"
        for form, changed, plain in sample(f"{name} {argument} as", other_forms(value), parts):
            fault = _fault_of_form(call, argument, changed, plain)
            if fault:
                yield f"{name}: {argument} as {form}: {fault}"


def sample(where: str, cases: Iterable[Any], parts: int) -> Iterator[Any]:
    """Yield one of so many cases, each a tuple that begins with its name, and one at least."""
    kept = list(cases)
    numbers = [zlib.crc32(f"{SEED} {where} {case[0]}".encode()) for case in kept]
    first = min(range(len(kept)), key=numbers.__getitem__, default=0)
    for place, case in enumerate(kept):
        if place == first or numbers[place] % parts == 0:
            yield case


def public_packages(root: ModuleType) -> list[ModuleType]:
    """Return a package and all below it that say what they offer."""
    names = [
        root.__name__,
        *(
            found.name
            for found in pkgutil.walk_packages(root.__path__, f"{root.__name__}.")
            if found.ispkg
        ),
    ]
    packages = [importlib.import_module(name) for name in names]
    return [package for package in packages if hasattr(package, "__all__")]


def public_callables(packages: Iterable[ModuleType]) -> dict[str, Any]:
    """Return functions, classes and their public methods with parameters, by name.

    The name is that of the class or function, and of a method ``Class.method``. Errors and what is
    no more than a type are left out.
    """
    found: dict[str, Any] = {}
    for package in packages:
        for name in package.__all__:
            thing = getattr(package, name)
            if inspect.isfunction(thing):
                found[name] = thing
            elif inspect.isclass(thing) and not issubclass(thing, BaseException):
                found[name] = thing
                found |= {f"{name}.{method}": function for method, function in methods_of(thing)}
    return {name: thing for name, thing in found.items() if parameters_of(thing)}


def without_arguments(package: ModuleType) -> set[str]:
    """Return the names of a facade that no table can have: what is no callable with parameters.

    Errors and warnings are left out, too: they are raised, and not called.
    """
    tried = {name.partition(".")[0] for name in public_callables([package])}
    things = {name: getattr(package, name) for name in set(package.__all__) - tried}
    return {
        name
        for name, thing in things.items()
        if not (inspect.isclass(thing) and issubclass(thing, BaseException))
    }


def methods_of(kind: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods of a class that one of the packages wrote."""
    for name in dir(kind):
        static = inspect.getattr_static(kind, name)
        function = getattr(static, "__func__", static)
        if name.startswith("_") or not inspect.isfunction(inspect.unwrap(function)):
            continue
        if function.__module__.startswith(("psp3", "fuzzy2")):
            yield name, function


def parameters_of(function: Any) -> list[str]:
    """Return the names of the parameters, without ``self`` and those of any number."""
    several = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    return [
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if name not in ("self", "cls") and parameter.kind not in several
    ]


def _fault_of_mistake(call: Call, argument: str, mistake: str, wrong: Any) -> str:
    result = outcome(call, {**call.arguments, argument: wrong})
    if result.fault or result.numbers is None:
        return result.fault
    taken = call.takes.get(argument, ())
    if mistake in taken or "*" in taken:
        return ""
    if mistake == "empty" and not any(array.size for array in result.numbers):
        return ""  # nothing of nothing
    if mistake not in ONLY_UNUSUAL:
        return f"accepted, {_shown(result.numbers)}"
    finite = all(np.isfinite(array).all() for array in result.numbers)
    return "" if finite else f"an answer that is not finite, {_shown(result.numbers)}"


def _fault_of_form(call: Call, argument: str, changed: Any, plain: Any) -> str:
    expected = outcome(call, {**call.arguments, argument: plain})
    result = outcome(call, {**call.arguments, argument: changed})
    if result.fault:
        return result.fault
    if (expected.numbers is None) != (result.numbers is None):
        return f"{_answer(result)}, where the plain one is {_answer(expected)}"
    if expected.numbers is None or result.numbers is None:
        return ""
    same = len(expected.numbers) == len(result.numbers) and all(
        np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
        for one, other in zip(expected.numbers, result.numbers, strict=True)
    )
    return "" if same else f"{_shown(result.numbers)}, not {_shown(expected.numbers)}"


def _answer(result: Outcome) -> str:
    return "accepted" if result.numbers is not None else f"refused ({str(result.error)[:120]})"


def _fault_of_foreign(error: Exception) -> str:
    return f"foreign {type(error).__name__}: {' '.join(str(error)[:200].split())}"


def _fault_of_message(error: BaseException) -> str:
    try:
        length = len(str(error))
    except Exception as trouble:
        return f"its message cannot be shown: {trouble!r}"
    return f"a message of {length} characters" if length > LONGEST_MESSAGE else ""


def _shown(numbers: list[np.ndarray[Any, Any]]) -> str:
    return in_words([array.tolist() for array in numbers])[:100]


def _kept(value: Any) -> Any:
    """Return a copy of what could be written to, and anything else as it is."""
    if isinstance(value, np.ndarray) or is_numbers(value):
        return copy.deepcopy(value)
    return list(value) if isinstance(value, list | dict) else value


def _same(before: Any, after: Any) -> bool:
    if isinstance(before, np.ndarray):
        return bool(
            before.shape == after.shape
            and before.dtype == after.dtype
            and (
                before.dtype.kind == "O"
                or np.asarray(before).tobytes() == np.asarray(after).tobytes()
            )
        )
    if is_numbers(before):
        return bool(np.array_equal(before, after))
    return not isinstance(before, list) or list(map(id, before)) == list(map(id, after))

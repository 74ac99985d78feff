"""One self-contained .c and .h file made from translated kernels.

The exported functions take plain arrays and numbers; their state between two calls is a struct that
the caller owns. Programs, tests and models around the code are made from the same description of
the functions.
"""

from __future__ import annotations

import hashlib
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzzy2.errors import InvalidValue, NotExportable
from fuzzy2.export.c_text import RESERVED, comment
from fuzzy2.export.numbers import Precision
from fuzzy2.export.translator import Program
from fuzzy2.export.values import BOOL, INT, NOTHING, REAL, Record, Row, Scalar, Value
from fuzzy2.support.text_files import made_folder, write_text
from fuzzy2.support.version import __version__


@dataclass(frozen=True)
class Known:
    """Argument of a kernel with a known value that is written into the code.

    Parameters
    ----------
    name : str
        Name of its tables.
    thing : object
        The value.
    """

    name: str
    thing: Any


@dataclass(frozen=True)
class Argument:
    """Argument of an exported function.

    Parameters
    ----------
    name : str
        Its name.
    about : str
        What it is, with its unit.
    size : int, optional
        Number of entries of an array; None for a single number.
    role : {"in", "out", "state"}
        Whether it is read, written, or part of the struct that holds the state between two calls.
    is_whole : bool
        Whether its numbers are whole numbers.
    """

    name: str
    about: str
    size: int | None = None
    role: str = "in"
    is_whole: bool = False


@dataclass(frozen=True)
class Mixed:
    """Argument of a kernel that is a NamedTuple with some arrays in the state struct.

    Its other values are known.

    Parameters
    ----------
    name : str
        Name of its tables.
    thing : NamedTuple
        The value.
    states : mapping of str to Argument
        Arrays that are part of the state struct, by their places in the NamedTuple: ``"memory"``,
        ``"model.memory"``.
    """

    name: str
    thing: Any
    states: Mapping[str, Argument]

    def filled(self, given: Iterator[Any]) -> Any:
        """Return the NamedTuple with its state arrays replaced."""
        thing, arrays = self.thing, {name: next(given) for name in self.arguments}
        for path, argument in self.states.items():
            thing = _replaced(thing, path.split("."), arrays[argument.name])
        return thing

    @property
    def arguments(self) -> dict[str, Argument]:
        """The states by name; a state may occur in several places."""
        return {argument.name: argument for argument in self.states.values()}


def _replaced(thing: Any, path: list[str], array: Any) -> Any:
    part = getattr(thing, path[0])
    new = array.reshape(part.shape) if len(path) == 1 else _replaced(part, path[1:], array)
    return thing._replace(**{path[0]: new})


@dataclass(frozen=True)
class CFunction:
    """A function in C that users call.

    Parameters
    ----------
    name : str
        Name of the function, with the prefix.
    does : str
        Description of the function in one sentence.
    arguments : tuple of Argument
        Arguments in the order of the kernel.
    result : str
        Description of the return value; empty if there is none.
    returns : {"int", "real", "void"}
        Type of the return value.
    kernel : callable
        The kernel; with ``known`` it is the same function in Python.
    known : tuple
        Arguments of the kernel in order: known values, None for each of ``arguments``, or
        :class:`Mixed`, which takes several of these.
    """

    name: str
    does: str
    arguments: tuple[Argument, ...]
    result: str
    returns: str
    kernel: Callable[..., Any]
    known: tuple[Any, ...]

    @property
    def visible(self) -> tuple[Argument, ...]:
        """The arguments that are not part of the state struct."""
        return tuple(argument for argument in self.arguments if argument.role != "state")

    @property
    def has_state(self) -> bool:
        """Whether the function takes the state struct."""
        return any(argument.role == "state" for argument in self.arguments)

    def in_python(self, *arguments: Any) -> Any:
        """Call the kernel with its arguments as arrays, including those of the state struct."""
        given = iter(arguments)
        return self.kernel(
            *(
                next(given) if k is None else k.filled(given) if isinstance(k, Mixed) else k
                for k in self.known
            )
        )


@dataclass(frozen=True)
class CCode:
    """A .c and a .h file, with a description of their functions.

    Parameters
    ----------
    name : str
        Prefix of all names, and name of the files.
    precision : Precision
        Precision of all numbers.
    header, source : str
        Text of the files.
    functions : tuple of CFunction
        Functions that users call.
    hash : str
        The first sixteen digits of the source's SHA-256.
    """

    name: str
    precision: Precision
    header: str
    source: str
    functions: tuple[CFunction, ...]
    hash: str

    def write(self, folder: str | Path) -> tuple[Path, Path]:
        """Write ``name.h`` and ``name.c`` to a folder, and return their paths."""
        where = made_folder(folder)
        paths = where / f"{self.name}.h", where / f"{self.name}.c"
        for path, text in zip(paths, (self.header, self.source), strict=True):
            write_text(text, path)
        return paths


class CWriter:
    """Collects functions and writes them as C.

    Parameters
    ----------
    name : str
        Prefix of all names: an identifier in C.
    precision : {"double", "single"}
        Precision of all numbers.
    about : sequence of str
        Paragraphs for the header: purpose, units, order of joints, and origin of the code.
    unrolled, never : tuple of str
        See :class:`fuzzy2.export.definitions.Definitions`.
    constants : mapping of str to number, optional
        Constants of the kernels' modules, by name, that have other values in this code.

    Raises
    ------
    InvalidValue
        If the name is not an identifier.
    UnknownName
        If there is no such precision.
    """

    def __init__(
        self,
        name: str,
        precision: str,
        about: list[str],
        unrolled: tuple[str, ...] = (),
        constants: Mapping[str, float] | None = None,
        never: tuple[str, ...] = (),
    ) -> None:
        of_c = isinstance(name, str) and re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII)
        if not of_c or name in RESERVED:
            raise InvalidValue("name", name, "letters, digits and _, a letter first, no word of C")
        self.name, self.about = name, about
        self.precision = Precision(precision)
        numbers = self.precision.constants | dict(constants or {})
        self.program = Program(
            *(name, self.precision, frozenset(unrolled), numbers, frozenset(never))
        )
        self.functions: list[CFunction] = []
        self.bodies: list[str] = []

    def add(
        self,
        name: str,
        does: str,
        kernel: Callable[..., Any],
        arguments: Sequence[Known | Argument | Mixed],
        result: str = "",
    ) -> CFunction:
        """Add a function.

        Parameters
        ----------
        name : str
            Name of the function, without the prefix.
        does : str
            Description of the function in one sentence.
        kernel : callable
            The kernel that it calls.
        arguments : sequence of Known, Argument or Mixed
            Arguments of the kernel, in order.
        result : str
            Description of the return value; empty if there is none.
        """
        # A kernel must not have the name of an exported function.
        own = f"{self.name}_{name}"
        other = self.program.reserved(own)
        self.bodies = [re.sub(rf"\b{own}\b", other, body) for body in self.bodies]
        values = [self._value(argument) for argument in arguments]
        said = self.program.call(kernel, values)
        known = tuple(
            a.thing if isinstance(a, Known) else a if isinstance(a, Mixed) else None
            for a in arguments
        )
        asked = tuple(
            one
            for a in arguments
            if not isinstance(a, Known)
            for one in ([a] if isinstance(a, Argument) else a.arguments.values())
        )
        if not isinstance(said.type, Scalar):
            raise NotExportable(
                name, "it returns more than a number", "a kernel that writes the rest"
            )
        kind = {INT: "int", BOOL: "int"}.get(said.type, said.type.name)
        function = CFunction(f"{self.name}_{name}", does, asked, result, kind, kernel, known)
        code = f"return {said.code};" if said.type != NOTHING else f"{said.code};"
        self.functions.append(function)
        self.bodies.append(f"{self._head(function)}\n{{\n    {code}\n}}\n")
        return function

    def _value(self, argument: Known | Argument | Mixed) -> Value:
        if isinstance(argument, Known):
            return self.precision.value_of(argument.name, argument.thing)
        if isinstance(argument, Mixed):
            return self._mixed(argument.name, argument.thing, argument.states, "")
        if argument.size is None:
            return Value(REAL, argument.name)
        return self._array(argument, (argument.size,))

    def _array(self, argument: Argument, shape: tuple[int, ...]) -> Value:
        kind = Row(INT if argument.is_whole else REAL, argument.role == "in", shape)
        place = f"state->{argument.name}" if argument.role == "state" else argument.name
        sizes = ", ".join(str(size) for size in shape)
        return Value(kind, f"({self.program.c_type(kind)}){{{place}, {sizes}}}")

    def _mixed(self, name: str, thing: Any, states: Mapping[str, Argument], path: str) -> Value:
        parts = {}
        for field in thing._fields:
            here, part = f"{path}{field}", getattr(thing, field)
            if here in states:
                parts[field] = self._array(states[here], part.shape)
            elif any(other.startswith(f"{here}.") for other in states):
                parts[field] = self._mixed(f"{name}_{field}", part, states, f"{here}.")
            else:
                parts[field] = self.precision.value_of(f"{name}_{field}", part)
        kind = Record(type(thing).__name__, tuple((n, v.type) for n, v in parts.items()))
        return Value(kind, self.program.literal(Value(kind, name, parts)), parts)

    def _head(self, function: CFunction) -> str:
        item = self.precision.type
        parts = [f"{self.name}_state *state"] if function.has_state else []
        for argument in function.visible:
            if argument.size is None:
                parts.append(f"{item} {argument.name}")
            elif argument.role == "in":
                parts.append(f"const {item} {argument.name}[{argument.size}]")
            else:
                parts.append(f"{item} {argument.name}[{argument.size}]")
        kind = item if function.returns == "real" else function.returns
        return f"{kind} {function.name}({', '.join(parts) or 'void'})"

    def code(self) -> CCode:
        """Return the text of the files."""
        heads = [body.split("\n")[0] for body in self.bodies]
        calls = "\n".join(self.bodies)
        parts = [
            f'#include "{self.name}.h"\n\n#include <math.h>',
            self.program.definitions(calls),
            calls,
        ]
        source = "\n\n".join(part for part in parts if part)
        digest = hashlib.sha256(source.encode()).hexdigest()[:16]
        about = [*self.about, f"Written by fuzzy2 {__version__}; {digest} is its hash."]
        return CCode(
            self.name,
            self.precision,
            self._header(about, heads),
            f"/* {self.name}.c: see {self.name}.h. Hash {digest}. */\n{source}",
            tuple(self.functions),
            digest,
        )

    def _header(self, about: list[str], heads: list[str]) -> str:
        guard = f"{self.name.upper()}_H"
        told = [line for part in about for line in [*_wrapped(part), ""]][:-1]
        text = ["/*", *(f" * {line}".rstrip() for line in told), " */"]
        text += [f"#ifndef {guard}", f"#define {guard}", ""]
        text += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
        states = {
            argument.name: argument
            for function in self.functions
            for argument in function.arguments
            if argument.role == "state"
        }
        if states:
            text.append("/* What is remembered between two calls. */")
            text.append("typedef struct {")
            text += [
                f"    {'int' if state.is_whole else self.precision.type} "
                f"{state.name}[{state.size}]; /* {comment(state.about)} */"
                for state in states.values()
            ]
            text += [f"}} {self.name}_state;", ""]
        for function, head in zip(self.functions, heads, strict=True):
            told = [function.does, *(f"{a.name}: {a.about}" for a in function.visible)]
            if function.result:
                told.append(f"returns: {function.result}")
            text.append("/*")
            text += [f" * {line}" for part in told for line in _wrapped(part)]
            text += [" */", f"{head};", ""]
        text += ["#ifdef __cplusplus", "}", "#endif", "", "#endif"]
        return "\n".join(text) + "\n"


def _wrapped(text: str) -> list[str]:
    """Return the lines of a comment, wrapped."""
    lines = [textwrap.wrap(line, 92, subsequent_indent="  ") for line in comment(text).split("\n")]
    return [line for one in lines for line in one or [""]]

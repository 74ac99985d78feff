"""Loops of exported C code, and whether what ends them is known when the code is written.

Whole numbers of the code are literals, entries of constant tables, sizes of arrays, counters, and
sums and products of these. A number is *bounded* from above or below if all that it is ever made
of is: by every assignment, by every call of the function whose argument it is. What is added to
itself is bounded where that happens in loops whose passes are. Numbers that come from run-time
numbers, or count in a loop that does not, are not; a loop that they end needs a reason in words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

FUNCTION = re.compile(r"^((?:static )?[\w ]+[ *])(\w+)\(([^;{}]*)\)\n\{\n(.*?)^\}", re.M | re.S)
FOR = re.compile(r"\s*for \((\w+) = (.*); \1 ([<>]) (.*); \1(\+\+|--| [+-]= \d+)\) \{$")
ASSIGNED = re.compile(r"\s*(?:\} else )?([A-Za-z_]\w*) = (.*);$")
RETURNED = re.compile(r"\s*return (.*);$")
DECLARED = re.compile(r"^    ((?:const )?\w+) \*?(\w+)(?:\[\d+\])?;$", re.M)
TOKEN = re.compile(
    r"\s*(\d+\.?\d*(?:e[+-]?\d+)?f?|\w+|&&|\|\||[<>=!]=|[-+*/%<>!?:,;.()\[\]{}&=])", re.I
)
COMMENT = re.compile(r"/\*.*?\*/", re.S)


class Ends(NamedTuple):
    """Whether a number has a bound from below, and from above."""

    below: bool
    above: bool

    def __and__(self, other: Ends) -> Ends:  # type: ignore[override]
        return Ends(self.below and other.below, self.above and other.above)


BOTH, NONE = Ends(True, True), Ends(False, False)


class Loop(NamedTuple):
    """A loop: the function that it is in, its head, and whether its passes have a bound."""

    function: str
    head: str
    is_bounded: bool


@dataclass
class Function:
    """A function: its parameters, their types and those of its variables, and its lines."""

    name: str
    parameters: list[str]
    types: dict[str, str]
    lines: list[str]
    assigned: dict[str, list[tuple[int, str]]] = field(default_factory=dict)
    returned: list[str] = field(default_factory=list)
    counted: list[tuple[str, str, str, str]] = field(default_factory=list)


class Code:
    """The functions of a file, and which of its whole numbers are bounded.

    Parameters
    ----------
    source : str
        The file.
    """

    def __init__(self, source: str) -> None:
        text = COMMENT.sub("", source)
        self.whole = set(re.findall(r"^static const int (\w+)\[", text, re.M))
        self.real = set(re.findall(r"^static const (?:double|float) (\w+)\[", text, re.M))
        self.functions = {name: _function(name, *rest) for name, *rest in _functions(text)}
        self.known: dict[tuple[str, str], Ends] = {}
        self.results: dict[str, Ends] = {}
        self._solve()

    def calls(self) -> dict[str, set[str]]:
        """Return the functions of the file that each function calls."""
        return {
            name: set(re.findall(r"\b(\w+)\(", "\n".join(one.lines))) & self.functions.keys()
            for name, one in self.functions.items()
        }

    def loops(self) -> Iterator[Loop]:
        """Yield all loops."""
        for one in self.functions.values():
            for number, line in enumerate(one.lines):
                if re.search(r"\b(?:while|do|goto)\b", line):
                    yield Loop(one.name, line.strip(), False)
                elif re.search(r"\bfor\b", line):
                    yield Loop(one.name, line.strip(), self._ends(one, number))

    def _ends(self, one: Function, number: int) -> bool:
        """Tell whether a loop counts between ends that are known, and nothing else moves it."""
        match = FOR.match(one.lines[number])
        if match is None:
            return False
        counter, start, sign, stop, step = match.groups()
        space = re.match(r"\s*", one.lines[number])
        assert space is not None
        end = one.lines.index(f"{space[0]}}}", number)
        inside = "\n".join(one.lines[number + 1 : end])
        names = {counter, *re.findall(r"[A-Za-z_]\w*", stop)}
        if any(re.search(rf"^\s*{name} = |\bfor \({name} = ", inside, re.M) for name in names):
            return False
        first, last = self.ends(one, start), self.ends(one, stop)
        if sign == "<":
            return "-" not in step and first.below and last.above
        return "+" not in step and first.above and last.below

    def _solve(self) -> None:
        """Find what is bounded: nothing at first, and more as long as there is more."""
        before: dict[Any, Ends] = {"nothing": NONE}
        while before != self.known | self.results:
            before = self.known | self.results
            for one in self.functions.values():
                self._of_function(one)
            for name, given in self._arguments().items():
                self.known[name] = self._all(given)

    def _of_function(self, one: Function) -> None:
        for name, codes in one.assigned.items():
            if one.types.get(name) == "int" and name not in one.parameters:
                counted = [row for row in one.counted if row[0] == name]
                ends = self._all(self._assigned(one, name, *code) for code in codes)
                self.known[one.name, name] = self._all(
                    [ends, *(self._counter(one, *row) for row in counted)]
                )
        for name, *_ in one.counted:
            if name not in one.assigned:
                self.known[one.name, name] = self._all(
                    self._counter(one, *row) for row in one.counted if row[0] == name
                )
        self.results[one.name] = self._all(self.ends(one, code) for code in one.returned)

    def _counter(self, one: Function, _: str, start: str, sign: str, stop: str) -> Ends:
        first, last = self.ends(one, start), self.ends(one, stop)
        if sign == "<":
            return Ends(first.below, first.above and last.above)
        return Ends(first.below and last.below, first.above)

    def _assigned(self, one: Function, name: str, number: int, code: str) -> Ends:
        """Return what an assignment leaves of the bounds of a number."""
        added = re.fullmatch(rf"{name} ([+-]) (\w+|\(.*\))", code)
        if added is None:
            return self.ends(one, code)
        if self.ends(one, added[2]) == BOTH and self._is_passed_a_few_times(one, number):
            return BOTH
        if added[2].isdigit():
            return Ends(True, False) if added[1] == "+" else Ends(False, True)
        return NONE

    def passes(self, one: Function, number: int) -> list[int]:
        """Return the passes of the loops around a line, whose ends are written down."""
        found = []
        for around in _around(one, number):
            match = FOR.match(one.lines[around])
            assert match is not None
            found.append(abs(int(match[4]) - int(match[2])))
        return found

    def _is_passed_a_few_times(self, one: Function, number: int) -> bool:
        """Tell whether a line is only in loops whose passes have a bound."""
        return all(self._ends(one, around) for around in _around(one, number))

    def _arguments(self) -> dict[tuple[str, str], list[Ends]]:
        """Return bounds of all that is handed over for each whole parameter."""
        found: dict[tuple[str, str], list[Ends]] = {}
        for one in self.functions.values():
            for line in one.lines:
                for name, codes in _calls_in(line, self.functions):
                    called = self.functions[name]
                    for parameter, code in zip(called.parameters, codes, strict=True):
                        if called.types[parameter] == "int":
                            own = called.assigned.get(parameter, [])
                            given = [self.ends(one, code)]
                            given += [self._assigned(called, parameter, *other) for other in own]
                            found.setdefault((name, parameter), []).extend(given)
        return found

    def _all(self, ends: Iterator[Ends] | list[Ends]) -> Ends:
        whole = BOTH
        for one in ends:
            whole = whole & one
        return whole

    def ends(self, one: Function, code: str) -> Ends:
        """Return the bounds of an expression in a function."""
        return _Expression(self, one, code).ternary()

    def of_name(self, one: Function, name: str) -> Ends:
        """Return the bounds of a variable."""
        return self.known.get((one.name, name), NONE)


class _Expression:
    """An expression of C on its way to its bounds."""

    def __init__(self, code: Code, function: Function, text: str) -> None:
        self.code, self.function = code, function
        self.tokens, self.at = TOKEN.findall(text), 0

    def _peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def _take(self) -> str:
        self.at += 1
        return str(self.tokens[self.at - 1])

    def ternary(self) -> Ends:
        first = self._chain(self._both, ("||",), _truth)
        if self._peek() != "?":
            return first
        self._take()
        then = self.ternary()
        self._take()
        return then & self.ternary()

    def _both(self) -> Ends:
        return self._chain(self._compared, ("&&",), _truth)

    def _compared(self) -> Ends:
        return self._chain(self._sum, ("==", "!=", "<", ">", "<=", ">="), _truth)

    def _sum(self) -> Ends:
        return self._chain(self._product, ("+", "-"), _added)

    def _product(self) -> Ends:
        return self._chain(self._single, ("*", "/", "%"), _multiplied)

    def _chain(
        self,
        part: Callable[[], Ends],
        signs: tuple[str, ...],
        together: Callable[[str, Ends, Ends], Ends],
    ) -> Ends:
        ends = part()
        while self._peek() in signs:
            sign = self._take()
            ends = together(sign, ends, part())
        return ends

    def _single(self) -> Ends:
        token = self._take()
        if token == "!":
            self._single()
            return BOTH
        if token == "-":
            below, above = self._single()
            return Ends(above, below)
        if token in ("&", "*"):
            self._single()
            return NONE
        if token == "(":
            return self._in_brackets()
        if token[0].isdigit():
            return BOTH
        return self._named(token)

    def _in_brackets(self) -> Ends:
        """Return the bounds of what stands in brackets, or of what a type in them is put before."""
        if self.tokens[self.at + 1 : self.at + 3] == [")", "{"]:
            self.at += 3
            self._list("}")
            return NONE
        if self._peek() in ("int", "double", "float"):
            self.at += 2
            return self._single()
        ends = self.ternary()
        self._take()
        return self._behind(ends)

    def _named(self, name: str) -> Ends:
        if self._peek() == "(":
            self._take()
            return self._called(name, self._list(")"))
        ends = self.code.of_name(self.function, name)
        if self._peek() == "[" and name in self.code.whole | self.code.real:
            ends = BOTH
            self._take()
            self._list("]")
            return ends
        kind = self.function.types.get(name, "")
        return self._behind(ends, kind)

    def _behind(self, ends: Ends, kind: str = "") -> Ends:
        """Return the bounds of a field or an entry."""
        while self._peek() in (".", "["):
            if self._take() == "[":
                self._list("]")
                # Only tables that nobody writes are constant, and what they hold is written down.
                ends = BOTH if kind.endswith("whole_table") else NONE
            else:
                # Parts of arrays are no larger than these, whose sizes are written down.
                ends = BOTH if self._take() in ("n", "m") else NONE
        return ends

    def _list(self, end: str) -> list[Ends]:
        found = []
        while self._peek() != end:
            found.append(self.ternary())
            if self._peek() == ",":
                self._take()
        self._take()
        return found

    def _called(self, name: str, given: list[Ends]) -> Ends:
        base = name.partition("_")[2]
        if base == "min_int":
            return Ends(all(e.below for e in given), any(e.above for e in given))
        if base == "max_int":
            return Ends(any(e.below for e in given), all(e.above for e in given))
        if base in ("quotient", "remainder"):
            return BOTH if all(given[base == "remainder"]) else NONE
        return self.code.results.get(name, NONE)


def _around(one: Function, number: int) -> Iterator[int]:
    """Yield the lines of the loops around a line."""
    depth = _depth(one.lines[number])
    for before in range(number - 1, -1, -1):
        line = one.lines[before]
        if line.strip() and _depth(line) < depth:
            depth = _depth(line)
            if re.search(r"\b(?:while|for)\b", line):
                yield before


def _depth(line: str) -> int:
    return len(line) - len(line.lstrip())


def _truth(_: str, one: Ends, other: Ends) -> Ends:
    return BOTH


def _added(sign: str, one: Ends, other: Ends) -> Ends:
    return one & (other if sign == "+" else Ends(other.above, other.below))


def _multiplied(sign: str, one: Ends, other: Ends) -> Ends:
    return BOTH if all(one) and all(other) else NONE


def _functions(text: str) -> list[tuple[str, str, str]]:
    return [(name, given, body) for _, name, given, body in FUNCTION.findall(text)]


def _function(name: str, given: str, body: str) -> Function:
    types, parameters = {}, []
    for part in given.split(", "):
        match = re.fullmatch(r"(.*?)[ *](\w+)(\[\d+\])?", part)
        if match:
            kind = "array" if match[3] or "*" in part else match[1]
            parameters.append(match[2])
            types[match[2]] = kind
    types |= {variable: kind for kind, variable in DECLARED.findall(body)}
    one = Function(name, parameters, types, body.splitlines())
    for number, line in enumerate(one.lines):
        if match := FOR.match(line):
            one.counted.append((match[1], match[2], match[3], match[4]))
        elif match := ASSIGNED.match(line):
            one.assigned.setdefault(match[1], []).append((number, match[2]))
        elif match := RETURNED.match(line):
            one.returned.append(match[1])
    return one


def _calls_in(line: str, functions: dict[str, Function]) -> Iterator[tuple[str, list[str]]]:
    """Yield name and arguments of the calls in a line."""
    for match in re.finditer(r"\b(\w+)\(", line):
        if match[1] in functions:
            yield match[1], _split(line, match.end())


def _split(line: str, start: int) -> list[str]:
    """Return the arguments between a bracket and the one that closes it."""
    depth, parts, last = 0, [], start
    for at in range(start, len(line)):
        if depth == 0 and line[at] in "),":
            parts.append(line[last:at].strip())
            last = at + 1
            if line[at] == ")":
                break
        depth += (line[at] in "([{") - (line[at] in ")]}")
    return [part for part in parts if part]

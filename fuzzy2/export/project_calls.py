"""The functions of C code by number, for programs that do not know the functions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fuzzy2.export.c_code import Argument, CCode, CFunction


@dataclass(frozen=True)
class Call:
    """A function as a call that reads and writes rows of numbers.

    The return value of the function is the first number that is written.
    """

    function: CFunction

    @property
    def read(self) -> list[Argument]:
        """Arguments that are read."""
        return [a for a in self.function.visible if a.role == "in"]

    @property
    def written(self) -> list[Argument]:
        """Arguments that are written."""
        return [a for a in self.function.visible if a.role == "out"]

    @property
    def reads(self) -> int:
        """Number of values that are read."""
        return sum(size_of(a) for a in self.read)

    @property
    def writes(self) -> int:
        """Number of values that are written."""
        return bool(self.function.result) + sum(size_of(a) for a in self.written)

    @property
    def begins(self) -> bool:
        """Whether it only resets the state."""
        return self.function.has_state and self.reads == 0 and self.writes == 0


def size_of(argument: Argument) -> int:
    """Return the number of values of an argument."""
    return 1 if argument.size is None else argument.size


def calls_of(code: CCode) -> list[Call]:
    """Return all functions, by number."""
    return [Call(function) for function in code.functions]


def short_name(code: CCode, function: CFunction) -> str:
    """Return the name of a function without the prefix."""
    return function.name.removeprefix(f"{code.name}_")


def header(code: CCode) -> str:
    """Return ``calls.h``."""
    calls = calls_of(code)
    return f"""\
/* The functions of {code.name}.h by number, on rows of numbers; for main.c and test.c. */
#ifndef CALLS_H
#define CALLS_H

typedef {code.precision.type} calls_number;

enum {{
    CALLS_FUNCTIONS = {len(calls)},
    CALLS_MOST_READ = {max(call.reads for call in calls)},
    CALLS_MOST_WRITTEN = {max(call.writes for call in calls)},
    CALLS_DIGITS = {17 if code.precision.name == "double" else 9} /* of a number, to the last bit */
}};

/* A function: how many numbers it reads and writes (its return value is the first of these), and
 * whether it only resets the state. */
typedef struct {{
    const char *name;
    int reads;
    int writes;
    int begins;
}} calls_function;

extern const calls_function calls_functions[CALLS_FUNCTIONS];

/* Call a function. The state between two calls is in one struct. */
void calls_call(int function, const calls_number *reads, calls_number *writes);

#endif
"""


def source(code: CCode) -> str:
    """Return ``calls.c``."""
    calls = calls_of(code)
    rows = ",\n".join(
        f'    {{"{short_name(code, call.function)}", {call.reads}, {call.writes}, '
        f"{int(call.begins)}}}"
        for call in calls
    )
    cases = "\n".join(line for number, call in enumerate(calls) for line in _case(number, call))
    has_state = any(call.function.has_state for call in calls)
    state = f"static {code.name}_state state;\n\n" if has_state else ""
    idle = "".join(
        f"    (void){name};\n"
        for name, used in (
            ("reads", any(call.reads for call in calls)),
            ("writes", any(call.writes for call in calls)),
        )
        if not used
    )
    return f"""\
/* calls.c: see calls.h. */
#include "calls.h"

#include "{code.name}.h"

const calls_function calls_functions[CALLS_FUNCTIONS] = {{
{rows}
}};

{state}void calls_call(int function, const calls_number *reads, calls_number *writes)
{{
{idle}    switch (function) {{
{cases}
    default:
        break;
    }}
}}
"""


def _case(number: int, call: Call) -> Iterator[str]:
    """Yield the lines of the case for a call."""
    function, read, written = call.function, 0, int(bool(call.function.result))
    codes = ["&state"] if function.has_state else []
    for argument in function.visible:
        row, at = ("reads", read) if argument.role == "in" else ("writes", written)
        codes.append(f"{row}[{at}]" if argument.size is None else f"{row} + {at}")
        if argument.role == "in":
            read += size_of(argument)
        else:
            written += size_of(argument)
    said = f"{function.name}({', '.join(codes)});"
    yield f"    case {number}:"
    yield f"        writes[0] = (calls_number){said}" if function.result else f"        {said}"
    yield "        break;"

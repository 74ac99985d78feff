"""The README of a folder with C code."""

from __future__ import annotations

from fuzzy2.errors import printable
from fuzzy2.export.c_code import Argument, CCode
from fuzzy2.export.project_calls import Call, calls_of, short_name, size_of
from fuzzy2.export.project_cases import CASES, TOLERANCES

HEADINGS = "| function | reads | writes |\n|---|---|---|"


def readme(code: CCode) -> str:
    """Return the README: the files, their use, and the arguments of the functions."""
    rows = "\n".join(_row(code, call) for call in calls_of(code))
    first = next((call for call in calls_of(code) if call.reads), calls_of(code)[0])
    tolerance = TOLERANCES[code.precision.name]
    return f"""\
# {code.name}

C99 in {code.precision.name} precision. A program only needs `{code.name}.c` and `{code.name}.h`.
They allocate no memory, need nothing but `math.h`, and all loops are bounded. `{code.name}.h`
describes the origin of the code, units, orders and codes.

| command | what it does |
|---|---|
| `make` | builds the program `main`, which reads lines of numbers and writes a line for each |
| `make test` | calls all functions in {CASES} cases and compares the results with Python's |
| `make arm` | size and greatest use of the stack on a Cortex-M; `CPU="-mcpu=..."` names another |

## Functions

{HEADINGS}
{rows}

The lines that `main` reads and writes hold the numbers in this order; a return value comes first.
`./main NAME`, or the name at the beginning of a line, chooses a function:

    echo {" ".join(["0"] * first.reads)} | ./main {short_name(code, first.function)}

## In a program

```c
{_use(code, first)}
```
{_state(code)}
Compile with `-ffp-contract=off` to get Python's numbers bit for bit, if the C library rounds as
Python's does; the test allows differences of {tolerance:g} of their usual size. Never use
`-ffast-math`, because NaN marks missing results.
"""


def _row(code: CCode, call: Call) -> str:
    written = [f"returns {call.function.result}"] if call.function.result else []
    written += [_said(argument) for argument in call.written]
    read = [_said(argument) for argument in call.read]
    name = f"`{short_name(code, call.function)}`: {_in_cell(call.function.does)}"
    return f"| {name} | {'<br>'.join(read)} | {'<br>'.join(written)} |".replace("\n", " ")


def _said(argument: Argument) -> str:
    count = "" if argument.size is None else f"[{argument.size}]"
    return f"`{argument.name}{count}`: {_in_cell(argument.about)}"


def _in_cell(text: str) -> str:
    """Return a text for a Markdown cell, which it can neither end nor fill with HTML."""
    return printable(text).replace("&", "&amp;").replace("<", "&lt;").replace("|", "\\|")


def _use(code: CCode, call: Call) -> str:
    item, function = code.precision.type, call.function
    lines = [f'#include "{code.name}.h"', ""]
    begins = [one.function.name for one in calls_of(code) if one.begins]
    if function.has_state:
        lines.append(f"static {code.name}_state state;")
    names = ["&state"] if function.has_state else []
    for argument in function.visible:
        size = "" if argument.size is None else f"[{size_of(argument)}]"
        lines.append(f"{item} {argument.name}{size};")
        names.append(argument.name)
    lines += ["", *(f"{name}(&state); /* once */" for name in begins)]
    return "\n".join([*lines, f"{function.name}({', '.join(names)});"])


def _state(code: CCode) -> str:
    if not any(call.function.has_state for call in calls_of(code)):
        return "\nFunctions remember nothing, and may be called from anywhere at any time.\n"
    return f"""
What is remembered between two calls is in `{code.name}_state`: one for each robot and each thread.
"""

"""No loop of exported C is without a bound, and no function calls itself: of all that is exported.

What ends a loop is derived from the code, see :mod:`tests.c_loops`; where it cannot be, the reason
stands here or in the tests of the translator.
"""

from __future__ import annotations

import functools
import math
import re
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

import psp3
from fuzzy2.errors import ApproximationWarning
from fuzzy2.export.c_code import CCode
from fuzzy2.export.project_calls import short_name
from fuzzy2.export.systems import c_code_of
from psp3.description.parts import ROBOTS
from psp3.export.face import c_code
from tests.c_loops import Code
from tests.fuzzy2.export.kinds import KINDS as SYSTEMS
from tests.fuzzy2.export.kinds import SLOW
from tests.fuzzy2.export.test_translator import WHILE
from tests.psp3.export.controllers_of_all_kinds import (
    CLASSICAL,
    KINDS,
    made,
    robot_of,
)
from tests.psp3.export.robots_of_all_kinds import MAKERS, some_frames

pytestmark = pytest.mark.filterwarnings("ignore::fuzzy2.ApproximationWarning")

REASONS = WHILE | {
    "average": "k comes from end_of_interval, which keeps it between 1 and one less than the rules",
    "directly": "pieces comes from pieces_of, which stops at the pieces that there is room for",
    "bisector_of_union": "count comes from _nodes_of: the kinks, and the cuts of each set and end",
    "end_of": "pieces comes from pieces_of, which stops at the pieces that there is room for",
}
"""Functions with loops whose ends are not derived, and why these end all the same."""


def _code_of_controller(kind: str, name: str) -> CCode:
    return c_code(made(kind, name), robot=robot_of(name))


def _controllers() -> dict[str, Callable[[], CCode]]:
    """Return the code of a controller of each kind, on two robots."""
    return {
        f"{kind} of {name}": functools.partial(_code_of_controller, kind, name)
        for kind, one in KINDS.items()
        for name in one.robots[: 2 if kind in CLASSICAL else 1]
    }


CONTROLLERS = _controllers()


@functools.cache
def code_of(kind: str, name: str) -> CCode:
    """Return the code of a thing, written once for all tests."""
    with warnings.catch_warnings(), tempfile.TemporaryDirectory() as folder:
        warnings.simplefilter("ignore", ApproximationWarning)
        if kind == "system":
            return c_code_of((SYSTEMS | SLOW)[name]())
        if kind == "controller":
            return CONTROLLERS[name]()
        robot = psp3.load(name) if name in ROBOTS else MAKERS[name](Path(folder))
        frames = None if name == "psp3" else some_frames(robot)
        return c_code(robot, name="tried", frames=frames)


@functools.cache
def read(kind: str, name: str) -> Code:
    """Return what is read in the code of a thing."""
    return Code(code_of(kind, name).source)


THINGS = [
    *(("robot", name) for name in dict.fromkeys([*ROBOTS, *MAKERS])),
    *(("controller", name) for name in CONTROLLERS),
    *(("system", name) for name in SYSTEMS | SLOW),
]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), THINGS)
def test_every_loop_has_a_bound(kind: str, name: str) -> None:
    code = read(kind, name)
    loops = list(code.loops())
    for loop in loops:
        base = re.sub(r"^[^_]*_|_\d+$", "", loop.function)
        assert loop.is_bounded or base in REASONS, f"{loop.function}: {loop.head}"
        # Loops of robots count to what is in their tables, without an exception.
        assert loop.is_bounded or kind != "robot"
    assert kind == "controller" or loops


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), THINGS)
def test_functions_call_only_those_before_them(kind: str, name: str) -> None:
    """So the graph of calls has no cycle."""
    calls, before = read(kind, name).calls(), set()
    for function, called in calls.items():
        assert called <= before
        before.add(function)
    assert sum(map(len, calls.values())) > 0


def _steps(code: Code) -> dict[str, int]:
    """Return the most steps of Newton's method that a call of each function takes.

    Of loops around them the passes are written down.
    """
    steps: dict[str, int] = {}
    for name, function in code.functions.items():
        total = 0
        for number, line in enumerate(function.lines):
            is_step = name.endswith("_newton") and "_solved(" in line
            is_step = is_step or "_tip_step(" in line
            called = [one for one in re.findall(r"\b(\w+)\(", line) if steps.get(one)]
            passes = math.prod(code.passes(function, number)) if is_step or called else 0
            total += passes * (is_step + sum(steps[one] for one in called))
        steps[name] = total
    return steps


NEWTON = ("delta", "gough_stewart", "gripper", "biped", "planar_4rrr", "standing", "hexa")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *(("robot", name) for name in NEWTON),
        *(("controller", name) for name in CONTROLLERS if name.endswith(" of delta")),
    ],
)
def test_headers_state_the_most_steps_of_newtons_method(kind: str, name: str) -> None:
    code = code_of(kind, name)
    stated = re.search(r"no call takes more than (\d+) of them", code.header)
    most, steps = 0 if stated is None else int(stated[1]), _steps(read(kind, name))
    found = {short_name(code, one): steps[one.name] for one in code.functions}
    # It closes the loops of the same pose once more, where nothing has to move.
    assert found.pop("actuator_forces", 2 * most) == 2 * most
    assert max(found.values()) == most
    assert (stated is None) == name.startswith(("PD of", "PID of"))


@pytest.mark.slow
def test_the_header_of_the_closed_form_states_the_most_steps() -> None:
    code = code_of("robot", "psp3")
    stated = re.search(r"no call takes\s+more than (\d+) steps", code.header.replace("\n *", "\n"))
    assert stated is not None
    assert int(stated[1]) == max(_steps(read("robot", "psp3")).values())


def test_reasons_are_of_loops_whose_ends_are_not_derived() -> None:
    found = {
        re.sub(r"^[^_]*_|_\d+$", "", loop.function)
        for name in SYSTEMS | SLOW
        for loop in read("system", name).loops()
        if not loop.is_bounded
    }
    assert found == REASONS.keys()


TOY = """\
typedef struct {{ const int *p; int n; }} a_whole_table;
static const int a_places[3] = {{
    1, 2, 3
}};

static int a_other(int m, double x)
{{
    int i;
    for (i = 0; i < m; i++) {{
        if (x > 0.5) {{
            return i;
        }}
    }}
    return m + 1;
}}

int a_run(int left, const double x[2], double out[2])
{{
    int i;
    int k;
    int end;
    int sum;
    double y;
    i = 0;
    k = 1;
    sum = 0;
{lines}
    return 0;
}}
"""

BOUNDED = {
    "a literal": "for (i = 0; i < 5; i++) {",
    "down": "for (i = 5; i > -1; i--) {",
    "an entry of a table": "end = 2 * a_places[i];\n    for (i = 0; i < end; i++) {",
    "what another function says": "end = a_other(7, x[0]);\n    for (i = 0; i < end; i++) {",
    "the counter of a loop that ended": "for (k = 0; k < 5; k++) {\n    }\n"
    "    end = k;\n    for (i = 0; i < end; i++) {",
    "a sum of what is known": "for (k = 0; k < 5; k++) {\n        sum = sum + (2 * k);\n    }\n"
    "    for (i = 0; i < sum; i++) {",
    "what was counted up is a beginning": "while (x[k] > 0.0) {\n        k = k + 1;\n    }\n"
    "    for (i = k; i < 9; i++) {",
}
UNBOUNDED = {
    "a number of the call": "for (i = 0; i < left; i++) {",
    "a number that is rounded": "end = (int)x[0];\n    for (i = 0; i < end; i++) {",
    "what another function says of it": "end = a_other((int)x[0], x[0]);\n"
    "    for (i = 0; i < end; i++) {",
    "a beginning without a bound": "k = (int)x[0];\n    for (i = k; i < 9; i++) {",
    "the wrong way": "for (i = 0; i < 9; i--) {",
    "a counter that is set back": "for (i = 0; i < 9; i++) {\n        i = 0;",
    "an end that moves": "end = 9;\n    for (i = 0; i < end; i++) {\n        end = 9 + i;",
    "what was counted up": "while (x[k] > 0.0) {\n        k = k + 1;\n    }\n"
    "    for (i = 0; i < k; i++) {",
    "what doubles": "for (k = 0; k < 9; k++) {\n        sum = sum + sum;\n    }\n"
    "    for (i = 0; i < sum; i++) {",
    "another loop": "while (x[0] > 0.0) {",
}


@pytest.mark.parametrize("what", BOUNDED | UNBOUNDED)
def test_ends_are_derived_where_they_can_be(what: str) -> None:
    """The last loop of each piece of code is what is asked about."""
    lines = (BOUNDED | UNBOUNDED)[what]
    code = Code(TOY.format(lines=f"    {lines}\n        out[0] = 1.0;\n    }}"))
    loop = [one for one in code.loops() if one.function == "a_run"][-1]
    assert loop.is_bounded == (what in BOUNDED)

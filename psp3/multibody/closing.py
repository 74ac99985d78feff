"""Move the independent joints with all loops closed, compiled.

Newton's method from a predicted pose, one group of loops after the other. A step that Newton's
method must correct by much, or that turns the sign of the group's determinant, could lead to
another assembly mode: it is done again in halves.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar
from psp3.multibody.least_squares import factor, orientation, reflect, solve
from psp3.multibody.loops import jacobian, residual_of
from psp3.multibody.placement import move, place
from psp3.multibody.tree import (
    AT_ACROSS,
    AT_BEFORE,
    AT_BEFORE_REFLECTIONS,
    AT_CLOSED,
    AT_CONFIGURATION,
    AT_DEPENDENT_V,
    AT_DRIVEN,
    AT_DRIVERS,
    AT_ENDS,
    AT_FACTORS,
    AT_GROUPS,
    AT_INDEPENDENT_Q,
    AT_MOVED,
    AT_ORIGIN,
    AT_REFLECTIONS,
    AT_REPORT,
    AT_RESIDUAL,
    AT_RIGHT,
    AT_SIGNS,
    AT_SPEED,
    AT_TARGET,
    AT_TOLERANCES,
    COORDINATES,
    DRIVEN_AT,
    ELEMENTS,
    FACTOR_AT,
    FIRST_DRIVER,
    FIRST_MEMBER,
    GROUP_COLUMN,
    GROUP_COLUMNS,
    GROUP_DRIVERS,
    GROUP_INTEGERS,
    GROUP_NUMBERS,
    GROUP_ROW,
    GROUP_ROWS,
    GROUPS,
    IS_SQUARE,
    MEMBERS,
    MISMATCH_AT,
    POSITIONS,
    WEAKEST_AT,
)

CLOSED, OPEN, SINGULAR = range(3)
"""What became of a group: closed; stopped on the way; the independent joints do not determine the
others.
"""

LARGEST_PREDICTED_STEP = 0.3
"""No joint is moved by more than this between two closures [m, rad]."""

LARGEST_CORRECTION = 0.3
"""Newton's method may move a predicted configuration by this share of the predicted step; more
could be another assembly mode.
"""

SMALLEST_CORRECTION = 1e-9
"""A correction by less than this is rounding, however short the step was [m, rad]."""

LARGEST_REPAIR = 1.0
"""A guess that closes the loops only after its joints have moved by more than this is none [m,
rad].
"""

LARGEST_BEND = 0.1
"""Near a singular pose no step may change the speeds along the way by more than this share: behind
one, branches lie so close to each other that Newton's method may take either, but they part in
different directions.
"""

MOST_ATTEMPTS = 10_000
"""A motion is given up after so many steps, good or not: of 0.3 each they are a way of 3 km, or
500 turns.
"""

ALL_OF_THE_WAY = 1.0 - 1e-12
"""A step to a larger share of the way goes all of it."""

SMALLEST_STEP = 1e-6
"""A motion is given up where this share of the way is still too long a step."""

ENOUGH = 0.03
"""A correction that leaves a smaller share of the residual is followed by one with the same
Jacobian.
"""

ALL_BUT_ROUNDING = 0.5
"""A correction that leaves a larger share of a small residual corrects rounding: also where m roots
coincide Newton's method leaves only (1 − 1/m)^m of it, less than 1/e.
"""

GUESSED = 100.0
"""A guess counts as closed with a residual so many times larger than what is asked of a motion: a
correction by rounding could lead past a singular pose nearby.
"""

NEARBY = 3e-3
"""If Newton's method may move joints by more than this, every step has a Jacobian of its own, whose
sign is looked at: near a singular pose a step may lead to another branch with the old sign [m,
rad].
"""

MANY = 8
"""Of a group with fewer dependent joints a new Jacobian costs less than one more correction."""

STILL = 1e-9
"""Equations that contradict each other are closed where the step of a joint, below this, has become
as small as rounding lets it [m, rad].
"""

MOST_ITERATIONS = 25
"""Newton's method doubles the digits: more steps than this are the sign of a pose that does not
exist.
"""


@scalar
def solved(tree, memory, group):
    """Replace the right side by the group's dependent speeds that give it, by least squares."""
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    solve(
        tree,
        memory,
        tree[AT_ENDS] + tree[g + GROUP_COLUMN],
        tree[AT_FACTORS] + tree[g + FACTOR_AT],
        tree[AT_REFLECTIONS] + tree[g + GROUP_COLUMN],
        tree[g + GROUP_ROWS],
        tree[g + GROUP_COLUMNS],
        tree[AT_RIGHT],
    )


@scalar
def factored(tree, numbers, memory, group):
    """Write and factor the Jacobian of a group; return its smallest pivot, with a sign, or 0."""
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    jacobian(tree, numbers, memory, group)
    return factor(
        tree,
        memory,
        tree[AT_ENDS] + tree[g + GROUP_COLUMN],
        tree[AT_FACTORS] + tree[g + FACTOR_AT],
        tree[AT_REFLECTIONS] + tree[g + GROUP_COLUMN],
        tree[g + GROUP_ROWS],
        tree[g + GROUP_COLUMNS],
    )


@scalar
def _rests(step, before, size, mismatch):
    """Tell whether a residual that equations leave by their rounding cannot become smaller."""
    return size <= mismatch and step <= STILL and step >= 0.5 * before


@scalar
def newton(tree, numbers, memory, group, most, enough, sign):
    """Close a group's loops with its dependent joints.

    Leave its Jacobian factored there. Return what became of it; it is closed where the residual is
    at most ``enough``, or, where equations contradict each other by rounding, where the step is,
    and open where a joint has moved by more than ``most``, or the determinant's
    sign was not ``sign`` somewhere on the way, unless that is 0.
    """
    configuration = tree[AT_CONFIGURATION]
    moved = tree[AT_MOVED]
    gaps = tree[AT_RESIDUAL]
    right = tree[AT_RIGHT]
    signs = tree[AT_SIGNS]
    tolerances = tree[AT_TOLERANCES]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    first, last = tree[g + FIRST_MEMBER], tree[g + GROUP_INTEGERS + FIRST_MEMBER]
    rows, columns = tree[g + GROUP_ROWS], tree[g + GROUP_COLUMNS]
    row, column = tree[g + GROUP_ROW], tree[g + GROUP_COLUMN]
    largest = numbers[tolerances + GROUP_NUMBERS * group]
    mismatch = numbers[tolerances + GROUP_NUMBERS * group + MISMATCH_AT]
    weakest = numbers[tolerances + GROUP_NUMBERS * group + WEAKEST_AT]
    for k in range(columns):
        memory[moved + column + k] = 0.0
    before, last_step, is_fresh = math.inf, math.inf, False
    for _ in range(MOST_ITERATIONS):
        place(tree, numbers, memory, first, last)
        size = residual_of(tree, numbers, memory, group)
        if not size < math.inf:
            return OPEN
        # Near a singular pose rounding may be all that a step corrects.
        rounding = before * (ALL_BUT_ROUNDING if is_fresh else 1.0)
        is_closed = size <= enough or (size >= rounding and size <= largest)
        # The Jacobian of a pose before is good for a correction where it has led far.
        is_fresh = columns < MANY or most > NEARBY or size > ENOUGH * before or is_closed
        if is_fresh:
            memory[signs + group] = factored(tree, numbers, memory, group)
            if abs(memory[signs + group]) <= weakest:
                return SINGULAR
            if memory[signs + group] * sign < 0.0:
                return OPEN
            if is_closed:
                return CLOSED
        before = size
        for i in range(rows):
            memory[right + i] = -memory[gaps + row + i]
        solved(tree, memory, group)
        step, farthest = 0.0, 0.0
        for k in range(columns):
            memory[moved + column + k] += memory[right + k]
            step = max(step, abs(memory[right + k]))
            farthest = max(farthest, abs(memory[moved + column + k]))
        if is_fresh and (step <= enough or _rests(step, last_step, size, mismatch)):
            return CLOSED if size <= max(largest, mismatch) else OPEN
        last_step = step
        if not farthest <= most:
            return OPEN
        move(tree, memory, first, last, configuration, right, column, 1.0)
    return OPEN


@scalar
def _is_turned(tree, memory, group):
    """Tell whether a group's closure equations have turned over since the pose before.

    Where they are more than the dependent speeds, the sign of the motion between the spaces of
    their columns says it.
    """
    across = tree[AT_ACROSS]
    before = tree[AT_BEFORE]
    before_reflections = tree[AT_BEFORE_REFLECTIONS]
    right = tree[AT_RIGHT]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    rows, columns = tree[g + GROUP_ROWS], tree[g + GROUP_COLUMNS]
    at, into = tree[AT_FACTORS] + tree[g + FACTOR_AT], tree[AT_REFLECTIONS] + tree[g + GROUP_COLUMN]
    ends = tree[AT_ENDS] + tree[g + GROUP_COLUMN]
    before += tree[g + FACTOR_AT]
    before_reflections += tree[g + GROUP_COLUMN]
    for j in range(columns):
        # Column j of the new Jacobian, from its factors.
        for i in range(rows):
            memory[right + i] = memory[at + rows * j + i] if i <= j else 0.0
        for k in range(columns - 1, -1, -1):
            reflect(tree, memory, ends, at, into, rows, k, right)
        solve(tree, memory, ends, before, before_reflections, rows, columns, right)
        for i in range(columns):
            memory[across + columns * j + i] = memory[right + i]
    return not orientation(memory, across, columns) > 0.0


@scalar
def _remember(tree, memory, group):
    """Keep the pose of a group as the one from which the next is looked for."""
    before = tree[AT_BEFORE]
    before_reflections = tree[AT_BEFORE_REFLECTIONS]
    closed = tree[AT_CLOSED]
    configuration = tree[AT_CONFIGURATION]
    factors = tree[AT_FACTORS]
    reflections = tree[AT_REFLECTIONS]
    for i in range(tree[COORDINATES]):
        memory[closed + i] = memory[configuration + i]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    if not tree[g + IS_SQUARE]:
        for i in range(tree[g + FACTOR_AT], tree[g + GROUP_INTEGERS + FACTOR_AT]):
            memory[before + i] = memory[factors + i]
        for i in range(tree[g + GROUP_COLUMN], tree[g + GROUP_INTEGERS + GROUP_COLUMN]):
            memory[before_reflections + i] = memory[reflections + i]


@scalar
def _speeds_along(tree, memory, group):
    """Write the dependent speeds of the way to the target; return the largest of any joint."""
    target = tree[AT_TARGET]
    driven = tree[AT_DRIVEN]
    origin = tree[AT_ORIGIN]
    right = tree[AT_RIGHT]
    along = tree[AT_SPEED]
    drivers = tree[AT_DRIVERS]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    rows, columns = tree[g + GROUP_ROWS], tree[g + GROUP_COLUMNS]
    first, column = tree[g + FIRST_DRIVER], tree[g + GROUP_COLUMN]
    fastest = 0.0
    for i in range(rows):
        memory[right + i] = 0.0
    for j in range(tree[g + GROUP_DRIVERS]):
        driver = tree[drivers + first + j]
        way = memory[target + driver] - memory[origin + driver]
        fastest = max(fastest, abs(way))
        d = tree[g + DRIVEN_AT] + rows * j
        for i in range(rows):
            memory[right + i] -= memory[driven + d + i] * way
    solved(tree, memory, group)
    for k in range(columns):
        memory[along + column + k] = memory[right + k]
        fastest = max(fastest, abs(memory[right + k]))
    return fastest


@scalar
def _is_bent(tree, memory, group, fastest):
    """Tell whether the speeds along the way are others than at the pose before; leave those."""
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    column, columns = tree[g + GROUP_COLUMN], tree[g + GROUP_COLUMNS]
    speed, before = tree[AT_SPEED] + column, tree[AT_MOVED] + column
    for k in range(columns):
        memory[before + k] = memory[speed + k]
    fastest = max(fastest, _speeds_along(tree, memory, group))
    bend = 0.0
    for k in range(columns):
        bend = max(bend, abs(memory[speed + k] - memory[before + k]))
        memory[speed + k] = memory[before + k]
    return bend > LARGEST_BEND * fastest


@scalar
def _follow(tree, numbers, memory, group):
    """Move a closed group's independent joints from where they are to the target.

    The report gets the share of the way and the residual where that fails.
    """
    target = tree[AT_TARGET]
    closed = tree[AT_CLOSED]
    configuration = tree[AT_CONFIGURATION]
    origin = tree[AT_ORIGIN]
    signs = tree[AT_SIGNS]
    along = tree[AT_SPEED]
    independent_q = tree[AT_INDEPENDENT_Q]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    first, last = tree[g + FIRST_MEMBER], tree[g + GROUP_INTEGERS + FIRST_MEMBER]
    first_driver = tree[AT_DRIVERS] + tree[g + FIRST_DRIVER]
    column = tree[g + GROUP_COLUMN]
    is_square = tree[g + IS_SQUARE]
    tolerances = tree[AT_TOLERANCES] + GROUP_NUMBERS * group
    near = numbers[tolerances + 2]
    done, step, goal, fastest, pivot, enough, arrived = 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, True
    for _ in range(MOST_ATTEMPTS):
        if arrived:
            fastest = _speeds_along(tree, memory, group)
            if fastest == 0.0:
                return CLOSED
            _remember(tree, memory, group)
            # Beyond a fold, and on the other branch before it, the determinant has the other sign.
            pivot = memory[signs + group]
            # Near a singular pose what is left open moves joints by much: nothing is left but
            # rounding.
            enough = numbers[tolerances + 1] if abs(pivot) >= near else 0.0
        step = min(step, 1.0 - done, LARGEST_PREDICTED_STEP / fastest)
        goal = 1.0 if done + step > ALL_OF_THE_WAY else done + step
        move(tree, memory, first, last, closed, along + column, column, goal - done)
        for j in range(tree[g + GROUP_DRIVERS]):
            driver = tree[first_driver + j]
            start, end = memory[origin + driver], memory[target + driver]
            # Exactly the positions asked for, at the end.
            memory[configuration + tree[independent_q + driver]] = (
                end if goal == 1.0 else start + goal * (end - start)
            )
        most = LARGEST_CORRECTION * (goal - done) * fastest + SMALLEST_CORRECTION
        sign = pivot if is_square else 0.0
        arrived = newton(tree, numbers, memory, group, most, enough, sign) == CLOSED
        if arrived and abs(memory[signs + group]) < near:
            arrived = not _is_bent(tree, memory, group, fastest)
        if arrived and not is_square:
            arrived = not _is_turned(tree, memory, group)
        if arrived:
            if not goal < 1.0:
                return CLOSED
            done, step = goal, 2.0 * (goal - done)
        else:
            step = 0.5 * (goal - done)
            if step < SMALLEST_STEP:
                return _stopped(tree, numbers, memory, group, done)
    return _stopped(tree, numbers, memory, group, done)


@scalar
def _stopped(tree, numbers, memory, group, done):
    """Let only the independent joints of a group go on to the target, which opens its loops.

    Report the share of the way and the residual.
    """
    report = tree[AT_REPORT]
    target = tree[AT_TARGET]
    closed = tree[AT_CLOSED]
    configuration = tree[AT_CONFIGURATION]
    drivers = tree[AT_DRIVERS]
    independent_q = tree[AT_INDEPENDENT_Q]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    for i in range(tree[COORDINATES]):
        memory[configuration + i] = memory[closed + i]
    for j in range(tree[g + GROUP_DRIVERS]):
        driver = tree[drivers + tree[g + FIRST_DRIVER] + j]
        memory[configuration + tree[independent_q + driver]] = memory[target + driver]
    place(
        tree,
        numbers,
        memory,
        tree[g + FIRST_MEMBER],
        tree[g + GROUP_INTEGERS + FIRST_MEMBER],
    )
    memory[report] = done
    memory[report + 1] = residual_of(tree, numbers, memory, group)
    return OPEN


@scalar
def settled(tree, numbers, memory):
    """Close all loops from a guess that is in the configuration, its independent joints fixed.

    Return what became of it; the report gets the share of the way (0), the residual and the group.
    """
    report = tree[AT_REPORT]
    elements = tree[ELEMENTS]
    all_members = tree[MEMBERS] - elements
    place(tree, numbers, memory, all_members, all_members + elements)
    for group in range(tree[GROUPS]):
        enough = GUESSED * numbers[tree[AT_TOLERANCES] + GROUP_NUMBERS * group + 1]
        outcome = newton(tree, numbers, memory, group, LARGEST_REPAIR, enough, 0.0)
        if outcome != CLOSED:
            memory[report], memory[report + 2] = 0.0, float(group)
            memory[report + 1] = residual_of(tree, numbers, memory, group)
            return outcome
    place(tree, numbers, memory, all_members, all_members + elements)
    return CLOSED


@scalar
def moved_to(tree, numbers, memory):
    """Move the independent joints of a closed pose to the target, all loops closed.

    Return what became of it; the report gets the share of the way, the residual and the group where
    that fails.
    """
    report = tree[AT_REPORT]
    target = tree[AT_TARGET]
    configuration = tree[AT_CONFIGURATION]
    origin = tree[AT_ORIGIN]
    independent_q = tree[AT_INDEPENDENT_Q]
    stays = True
    for j in range(tree[POSITIONS]):
        memory[origin + j] = memory[configuration + tree[independent_q + j]]
        stays = stays and memory[origin + j] == memory[target + j]
    if stays:
        return CLOSED
    for group in range(tree[GROUPS]):
        outcome = _follow(tree, numbers, memory, group)
        if outcome != CLOSED:
            memory[report + 2] = float(group)
            return outcome
    # Those that no loop contains have not been moved yet.
    for j in range(tree[POSITIONS]):
        memory[configuration + tree[independent_q + j]] = memory[target + j]
    elements = tree[ELEMENTS]
    all_members = tree[MEMBERS] - elements
    if tree[GROUPS] != 1 or all_members < elements:
        place(tree, numbers, memory, all_members, all_members + elements)
        _frames_again(tree, numbers, memory)
    return CLOSED


@scalar
def _frames_again(tree, numbers, memory):
    """Place the frames of all closures anew, because the bases of their groups have moved."""
    for group in range(tree[GROUPS]):
        residual_of(tree, numbers, memory, group)


@scalar
def spread(tree, memory, group, out):
    """Solve a group's equations, and put the dependent speeds where they belong."""
    right = tree[AT_RIGHT]
    dependent_v = tree[AT_DEPENDENT_V]
    solved(tree, memory, group)
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    column = tree[g + GROUP_COLUMN]
    for k in range(tree[g + GROUP_COLUMNS]):
        memory[out + tree[dependent_v + column + k]] = memory[right + k]

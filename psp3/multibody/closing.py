"""Compiled motion of the independent joints with closed loops.

Each step predicts a pose and corrects it with Newton's method, one group of loops after the other.
A step could lead to another assembly mode if Newton's method must correct it by much, or if the
group's determinant changes sign. Such a step is halved and repeated.
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
"""Outcomes for a group: closed; stopped on the way; the independent joints do not determine the
others.
"""

LARGEST_PREDICTED_STEP = 0.3
"""The largest motion of a joint between two closures [m, rad]."""

LARGEST_CORRECTION = 0.3
"""The largest correction by Newton's method, as a share of the predicted step. A larger one could
lead to another assembly mode.
"""

SMALLEST_CORRECTION = 1e-9
"""A smaller correction counts as rounding, however short the step was [m, rad]."""

LARGEST_REPAIR = 1.0
"""A guess is refused if a joint must move by more than this to close the loops [m, rad]."""

LARGEST_BEND = 0.1
"""The largest change of the speeds along the way in a step near a singular pose, as a share. Behind
a singular pose, branches are so close to each other that Newton's method may find either, but their
directions differ.
"""

MOST_ATTEMPTS = 10_000
"""The largest number of steps of a motion, accepted or not. With steps of 0.3 they cover 3 km, or
500 turns.
"""

ALL_OF_THE_WAY = 1.0 - 1e-12
"""A step that reaches a larger share of the way goes to its end."""

SMALLEST_STEP = 1e-6
"""A motion stops if a step must be shorter than this share of the way."""

ENOUGH = 0.03
"""If a correction reduces the residual to less than this share, the next one uses the same
Jacobian.
"""

ALL_BUT_ROUNDING = 0.5
"""If a correction leaves more than this share of a small residual, the residual is rounding. Even
if m roots coincide, Newton's method leaves only (1 − 1/m)^m of it, less than 1/e.
"""

GUESSED = 100.0
"""The residual of a guess may be this many times the residual of a motion, because a correction of
rounding could lead past a singular pose nearby.
"""

NEARBY = 3e-3
"""If Newton's method may move joints by more than this, each step computes the Jacobian and checks
its sign, because near a singular pose a step may lead to another branch although the last sign was
right [m, rad].
"""

MANY = 8
"""For a group with fewer dependent joints, a new Jacobian takes less time than another correction.
"""

STILL = 1e-9
"""Contradicting equations count as closed if the joint steps are below this and do not decrease
further, because of rounding [m, rad].
"""

MOST_ITERATIONS = 25
"""The largest number of Newton steps. Each step doubles the correct digits, so if more are needed,
the pose does not exist.
"""


@scalar
def solved(tree, memory, group):
    """Replace the right side by the least-squares solution, the group's dependent speeds."""
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
    """Tell whether rounded equations prevent a further reduction of the residual."""
    return size <= mismatch and step <= STILL and step >= 0.5 * before


@scalar
def newton(tree, numbers, memory, group, most, enough, sign):
    """Close a group's loops with its dependent joints.

    The memory then holds the factored Jacobian. Return the outcome. The group is closed if the
    residual is at most ``enough`` or, if rounded equations contradict each other, if the step is.
    It is open if a joint has moved by more than ``most``, or if ``sign`` is not 0 and the
    determinant had another sign on the way.
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
        # Near a singular pose, a step may correct nothing but rounding.
        rounding = before * (ALL_BUT_ROUNDING if is_fresh else 1.0)
        is_closed = size <= enough or (size >= rounding and size <= largest)
        # The old Jacobian is used again if the last correction with it reduced the residual by
        # much.
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
    """Tell whether the orientation of a group's closure equations has changed since the last pose.

    If there are more equations than dependent speeds, it is the sign of the map between the column
    spaces of the two Jacobians.
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
    """Store the pose of a group as the start of the search for the next pose."""
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
    """Write the dependent speeds along the way to the target; return the largest joint speed."""
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
    """Tell whether the speeds along the way have changed since the last pose; restore those."""
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
    """Move a closed group's independent joints to the target.

    If that fails, report the share of the way and the residual.
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
            # The determinant has the other sign beyond a fold, and on the other branch before the
            # fold.
            pivot = memory[signs + group]
            # Near a singular pose even a small residual moves joints by much, so it is reduced to
            # rounding.
            enough = numbers[tolerances + 1] if abs(pivot) >= near else 0.0
        step = min(step, 1.0 - done, LARGEST_PREDICTED_STEP / fastest)
        goal = 1.0 if done + step > ALL_OF_THE_WAY else done + step
        move(tree, memory, first, last, closed, along + column, column, goal - done)
        for j in range(tree[g + GROUP_DRIVERS]):
            driver = tree[first_driver + j]
            start, end = memory[origin + driver], memory[target + driver]
            # The end is copied, so that it has no rounding error.
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
    """Move only the independent joints of a group on to the target, which opens the loops.

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
    """Close all loops from the guess in the configuration, with fixed independent joints.

    Return the outcome; report the share of the way (0), the residual and the group.
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
    """Move the independent joints of a closed pose to the target, with closed loops.

    Return the outcome; if that fails, report the share of the way, the residual and the group.
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
    # Joints that no loop contains have not been moved yet.
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
    """Recompute the frames of all closures, because the bases of their groups have moved."""
    for group in range(tree[GROUPS]):
        residual_of(tree, numbers, memory, group)


@scalar
def spread(tree, memory, group, out):
    """Solve a group's equations, and copy the dependent speeds to their places."""
    right = tree[AT_RIGHT]
    dependent_v = tree[AT_DEPENDENT_V]
    solved(tree, memory, group)
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    column = tree[g + GROUP_COLUMN]
    for k in range(tree[g + GROUP_COLUMNS]):
        memory[out + tree[dependent_v + column + k]] = memory[right + k]

"""The compiled kernels of a tree with loops, with their memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from fuzzy2.support.interpreted import are_few_calls, is_ready, twin_of
from fuzzy2.support.parallel_rows import first_refused_row
from fuzzy2.support.pieces import pieces
from psp3.checks import Array, Indices
from psp3.errors import InvalidValue
from psp3.multibody.closing import CLOSED
from psp3.multibody.first_answers import compile_answers, first_answer
from psp3.multibody.flatten import Springs, flattened
from psp3.multibody.motion import (
    ASSEMBLY,
    BLOCK,
    FORWARD_DYNAMICS,
    INVERSE_DERIVATIVES,
    INVERSE_DYNAMICS,
    answer,
    derivatives,
)
from psp3.multibody.tree import (
    AT_CONFIGURATION,
    AT_DEPENDENT_V,
    AT_DRIVERS,
    AT_ELEMENTS,
    AT_FREE_FALL,
    AT_GROUPS,
    AT_INDEPENDENT_V,
    AT_REPORT,
    AT_SIGNS,
    AT_TOLERANCES,
    ELEMENT_INTEGERS,
    ELEMENTS,
    FIRST_DRIVER,
    FREEDOMS,
    GROUP_COLUMN,
    GROUP_COLUMNS,
    GROUP_DRIVERS,
    GROUP_INTEGERS,
    GROUP_NUMBERS,
    GROUPS,
    INDEPENDENT,
    INDEX_V,
    MISMATCH_AT,
    SIZE,
    VELOCITIES,
    WEAKEST_AT,
)

GRAIN = 1
"""Blocks of rows in one task of a thread, which should take at least 50 µs. A single block takes
100 µs even for the smallest robot.
"""

NEAR_SINGULAR = 0.02
"""A pose is near a singular one if its smallest pivot is below this share of the pivot at the
reference pose.
"""


_ENTRIES = (np.dtype(np.int64), np.dtype(np.float64))


class NoAnswer(Exception):
    """A row has no answer. It stores the row, outcome and place; the robot writes the message."""

    def __init__(self, row: int, outcome: int, share: float, residual: float, q: Array) -> None:
        super().__init__(row, outcome, share, residual, q)
        self.row, self.outcome, self.share, self.residual, self.q = row, outcome, share, residual, q


class Tables(NamedTuple):
    """The arguments of kernels that run without Python: the tree, its numbers, and their memory."""

    tree: Indices
    numbers: Array
    memory: Array


class LastPose:
    """The last pose of a caller, from which the search for the next one starts.

    Calls are faster with it if the robot moves little between them. The answers are the same to
    rounding, as long as no singular pose lies between.

    Get one from ``robot.last_pose()``; it belongs to that robot and to one thread at a time.
    """

    def __init__(self, core: Core) -> None:
        self.core = core
        self.memory = np.empty(core.size)
        self.is_closed = 0

    def forget(self) -> None:
        """Start from the reference again."""
        self.is_closed = 0


class Core:
    """The dynamics of a tree with loops in its independent coordinates.

    It can be shared by threads, pickled and copied, because each call has its own memory.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel
        The loop closures.
    independent_v : (n,) ndarray of int
        Velocity indices of the independent joints.
    guess : (nq,) ndarray
        A configuration that closes the loops, or nearly.
    locked_v : sequence of int
        Velocities that are held at zero.
    springs : mapping, optional
        Stiffness and rest of joints, by name.
    mismatch : float
        Residual that is allowed if rounded equations contradict each other [m, rad].
    weakest : float
        A pose counts as singular if a group's smallest pivot is at most this share of that at the
        guess.

    Raises
    ------
    UnsupportedJoint
        If the kernels do not support a joint.
    NoAnswer
        If the loops cannot be closed near the guess.
    """

    def __init__(
        self,
        model: pin.Model,
        constraint_models: Sequence[Any],
        independent_v: Indices,
        guess: Array,
        locked_v: Sequence[int] = (),
        springs: Springs | None = None,
        mismatch: float = 0.0,
        weakest: float = 0.0,
    ) -> None:
        flat = flattened(model, constraint_models, independent_v, locked_v, springs)
        self.tree, self.numbers = flat.integers, flat.numbers
        self.coordinates, self.joints = model.nq, int(self.tree[INDEPENDENT])
        self._model = model
        # A view, so that a change of the model's gravity takes effect here.
        self._free_fall = model.gravity.linear
        self.size = int(self.tree[SIZE])
        self._spare: list[Array] = []
        # Zeros, because exported code contains all of it, also entries that nothing reads.
        self._reference = np.zeros(self.size)
        for group in range(int(self.tree[GROUPS])):
            at = int(self.tree[AT_TOLERANCES]) + GROUP_NUMBERS * group
            self.numbers[at + MISMATCH_AT] = mismatch
        self._settle(guess, self._reference)
        for group in range(int(self.tree[GROUPS])):
            pivot = abs(self._reference[int(self.tree[AT_SIGNS]) + group])
            # The pivot of a group without dependent joints is infinite, and it is never singular.
            pivot = pivot if np.isfinite(pivot) else 0.0
            at = int(self.tree[AT_TOLERANCES]) + GROUP_NUMBERS * group
            self.numbers[at + 2] = NEAR_SINGULAR * pivot
            self.numbers[at + WEAKEST_AT] = weakest * pivot
        self._partly = _partly_independent(model, {int(v) for v in independent_v})
        self._is_compiled = False

    def _kernels(self, rows: int = 1) -> tuple[Callable[..., int], Callable[..., int]]:
        """Return the kernels of answers and derivatives, uncompiled if few calls are expected."""
        if rows <= BLOCK and are_few_calls() and not is_ready(answer):
            return _answer_of_twin, twin_of(derivatives)
        if not self._is_compiled:
            compile_answers(self.tree, self.numbers)
            self._is_compiled = True
        return answer, derivatives

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_spare": [], "_free_fall": None, "_is_compiled": False}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._free_fall = self._model.gravity.linear

    @property
    def q0(self) -> Array:
        """The reference configuration, closed, (nq,)."""
        at = int(self.tree[AT_CONFIGURATION])
        return self._reference[at : at + self.coordinates].copy()

    def frame(self, joint: int, placement: pin.SE3) -> Array:
        """Return a frame as numbers for the kernels: its element, and its placement there.

        Parameters
        ----------
        joint : int
            Number of the joint that moves the frame; 0 is the base.
        placement : pinocchio.SE3
            Placement of the frame in the joint's axes.
        """
        carrier = -1
        if joint > 0:
            last = self._model.joints[joint].idx_v + self._model.joints[joint].nv - 1
            rows = self.tree[int(self.tree[AT_ELEMENTS]) :][
                : ELEMENT_INTEGERS * int(self.tree[ELEMENTS])
            ].reshape(-1, ELEMENT_INTEGERS)
            first, count = rows[:, INDEX_V], rows[:, FREEDOMS]
            carrier = int(np.flatnonzero((first <= last) & (last < first + count))[0])
        return np.concatenate([[carrier], placement.rotation.reshape(-1), placement.translation])

    def only_drivers(self) -> Indices:
        """Return the only independent speed on which each joint velocity depends, or −1, (nv,)."""
        tree = self.tree
        found = np.full(int(tree[VELOCITIES]), -1)
        found[tree[int(tree[AT_INDEPENDENT_V]) :][: self.joints]] = np.arange(self.joints)
        for group in range(int(tree[GROUPS])):
            row = tree[int(tree[AT_GROUPS]) + GROUP_INTEGERS * group :]
            if row[GROUP_DRIVERS] == 1:
                first, count = int(row[GROUP_COLUMN]), int(row[GROUP_COLUMNS])
                dependent = tree[int(tree[AT_DEPENDENT_V]) + first :][:count]
                found[dependent] = tree[int(tree[AT_DRIVERS]) + int(row[FIRST_DRIVER])]
        return found

    def last_pose(self) -> LastPose:
        """Return the memory of a caller who moves from pose to pose."""
        return LastPose(self)

    def tables(self) -> Tables:
        """Return the tables of a kernel that starts in the reference pose."""
        at = int(self.tree[AT_FREE_FALL])
        self.numbers[at : at + 3] = self._free_fall
        return Tables(self.tree, self.numbers, self._reference.copy())

    def _check(self, last_pose: LastPose) -> None:
        if last_pose.core is not self:
            raise InvalidValue("guess", last_pose, "the last pose of this robot: robot.last_pose()")

    def _settle(self, guess: Array, memory: Array) -> None:
        """Close the loops from a guess, at fixed independent joints; keep the pose in memory."""
        at = int(self.tree[AT_CONFIGURATION])
        memory[at : at + self.coordinates] = guess
        none, tree = np.empty(0), self.tree
        outcome = first_answer(
            ASSEMBLY, 1, 1, 0, tree, self.numbers, none, none, memory, none, none, none, none
        )
        if outcome != CLOSED:
            memory[int(self.tree[AT_REPORT]) + 3] = outcome
            raise self._no_answer(0, memory)

    def _no_answer(self, row: int, memory: Array) -> NoAnswer:
        """Return the error for a row, from the report in the memory."""
        report = memory[int(self.tree[AT_REPORT]) :]
        at = int(self.tree[AT_CONFIGURATION])
        q = memory[at : at + self.coordinates].copy()
        return NoAnswer(row, int(report[3]), float(report[0]), float(report[1]), q)

    def ask_one(
        self,
        question: int,
        positions: Any,
        second: Any,
        third: Any,
        out: Array,
        last_pose: LastPose | None,
    ) -> bool:
        """Write the answer to a question about one state with the least overhead; see :meth:`ask`.

        Parameters
        ----------
        positions, second, third : (n,) ndarray
            Unchecked arguments of the user.

        Returns
        -------
        bool
            Whether there is an answer. If not, or after a TypeError, :meth:`ask` raises the right
            error.
        """
        if last_pose is None:
            try:
                memory = self._spare.pop()
            except IndexError:
                # A check of the length before would leave time for another thread to take the last
                # one.
                memory = np.empty(self.size)
            warm = 0
        else:
            self._check(last_pose)
            memory, warm = last_pose.memory, last_pose.is_closed
            # It is set again when this call has succeeded.
            last_pose.is_closed = 0
        if question >= INVERSE_DERIVATIVES:
            row = self._differentiated(question, warm, memory, positions, second, third, out)
        else:
            ask = answer if self._is_compiled else self._kernels()[0]
            row = ask(
                question,
                1,
                warm,
                0,
                self.tree,
                self.numbers,
                self._free_fall,
                self._reference,
                memory,
                positions,
                second,
                third,
                out,
            )
        if last_pose is None:
            self._spare.append(memory)
        elif row == -1:
            last_pose.is_closed = 1
        return row == -1

    def ask(
        self,
        question: int,
        positions: Array,
        second: Array,
        third: Array,
        out: Array,
        guess: Array | LastPose | None = None,
        is_path: bool = False,
    ) -> None:
        """Write the answers to a question of :mod:`psp3.multibody.motion`.

        Parameters
        ----------
        question : int
            The number of the question.
        positions, second, third : (N, p), (N, n) and (N, n) ndarray
            Independent coordinates; speeds; accelerations or forces.
        out : (N, w) ndarray
            Receives the answers.
        guess : (nq,) ndarray or LastPose, optional
            The pose from which the first row starts; the reference pose by default.
        is_path : bool
            Whether each row starts from the preceding one, at any distance.

        Raises
        ------
        NoAnswer
            At the first row that has none.
        """
        if guess is not None or is_path:
            self._ask_in_turn(question, positions, second, third, out, guess, is_path)
            return
        failed: list[NoAnswer] = []

        def part(first: int, last: int) -> int:
            rows = slice(BLOCK * first, min(BLOCK * last, len(positions)))
            memory = np.empty(self.size)
            row = self._answer(
                question, 0, 0, memory, positions[rows], second[rows], third[rows], out[rows]
            )
            if row < 0:
                return -1
            failed.append(self._no_answer(BLOCK * first + row, memory))
            return row // BLOCK

        if first_refused_row(part, -(-len(positions) // BLOCK), GRAIN) >= 0:
            raise min(failed, key=lambda refused: refused.row)

    def _ask_in_turn(
        self,
        question: int,
        positions: Array,
        second: Array,
        third: Array,
        out: Array,
        guess: Array | LastPose | None,
        is_path: bool,
    ) -> None:
        """Answer the rows one after the other, starting from the pose of the caller."""
        if isinstance(guess, LastPose):
            self._check(guess)
            memory, warm = guess.memory, guess.is_closed
            guess.is_closed = 0
        else:
            memory, warm = np.empty(self.size), int(guess is not None)
            if guess is not None:
                self._settle(guess, memory)
        for rows in pieces(len(positions), BLOCK):
            given = positions[rows], second[rows], third[rows], out[rows]
            row = self._answer(question, warm, int(is_path), memory, *given)
            if row >= 0:
                raise self._no_answer(rows.start + row, memory)
            # The next block continues along the path, or starts from the reference, as each block
            # does.
            warm = int(is_path)
        if isinstance(guess, LastPose):
            guess.is_closed = 1

    def _answer(
        self,
        question: int,
        is_warm: int,
        is_path: int,
        memory: Array,
        positions: Array,
        second: Array,
        third: Array,
        out: Array,
    ) -> int:
        if question >= INVERSE_DERIVATIVES:
            states = zip(*map(np.ascontiguousarray, (positions, second, third)), strict=True)
            for row, (position, speed, other) in enumerate(states):
                warm = is_warm if row == 0 else is_path
                if (
                    self._differentiated(question, warm, memory, position, speed, other, out[row])
                    >= 0
                ):
                    return row
            return -1
        refused: int = self._kernels(len(positions))[0](
            question,
            len(positions),
            is_warm,
            is_path,
            self.tree,
            self.numbers,
            self._free_fall,
            self._reference,
            memory,
            positions.reshape(-1),
            second.reshape(-1),
            third.reshape(-1),
            out.reshape(-1),
        )
        return refused

    def _differentiated(
        self,
        question: int,
        is_warm: int,
        memory: Array,
        positions: Array,
        second: Array,
        third: Array,
        out: Array,
    ) -> int:
        """Write the derivatives of one state; they need the answer itself first."""
        if self._partly:
            raise InvalidValue(
                "coordinates",
                f"some speeds of joint {self._partly!r}",
                "for derivatives, all or none of a joint whose speeds are not coordinate rates: "
                "choose others, coordinates=[...]",
            )
        dynamics = INVERSE_DYNAMICS if question == INVERSE_DERIVATIVES else FORWARD_DYNAMICS
        ask, differentiate = self._kernels()
        row: int = ask(
            dynamics,
            1,
            is_warm,
            0,
            self.tree,
            self.numbers,
            self._free_fall,
            self._reference,
            memory,
            positions,
            second,
            third,
            np.empty(int(self.tree[INDEPENDENT])),
        )
        if row == -1 and differentiate(question, self.tree, self.numbers, memory, out) != CLOSED:
            return 0
        return row


def _answer_of_twin(*arguments: Any) -> int:
    """Run the kernel in Python, but accept only arguments that the compiled kernel accepts."""
    for one in arguments[4:]:
        is_array = type(one) is np.ndarray and one.ndim == 1
        if not is_array or one.dtype not in _ENTRIES or not one.flags.carray:
            raise TypeError(f"no array that kernels take: {type(one).__name__}")
    answered: int = twin_of(answer)(*arguments)
    return answered


def _partly_independent(model: pin.Model, independent_v: set[int]) -> str:
    """Return a joint whose speeds are not coordinate rates and only partly independent; or ''."""
    for index in range(1, model.njoints):
        joint = model.joints[index]
        speeds = set(range(joint.idx_v, joint.idx_v + joint.nv))
        if joint.nq > joint.nv > 1 and speeds & independent_v and speeds - independent_v:
            return str(model.names[index])
    return ""

"""A tree with loops that answers questions: the compiled kernels with their memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.checks import Array, Indices
from psp3.multibody.closing import CLOSED
from psp3.multibody.flatten import Springs, flattened
from psp3.multibody.motion import answer, assemble
from psp3.multibody.tree import (
    AT_CONFIGURATION,
    AT_FREE_FALL,
    AT_REPORT,
    AT_SIGNS,
    AT_TOLERANCES,
    GROUP_NUMBERS,
    GROUPS,
    MISMATCH_AT,
    SIZE,
    WEAKEST_AT,
)

NEAR_SINGULAR = 0.02
"""A pose whose smallest pivot is smaller than this share of the reference pose's is near a singular
one.
"""


class NoAnswer(Exception):
    """A row that has no answer: which, what became of it, and where; the robot says it in words."""

    def __init__(self, row: int, outcome: int, share: float, residual: float, q: Array) -> None:
        super().__init__(row, outcome, share, residual, q)
        self.row, self.outcome, self.share, self.residual, self.q = row, outcome, share, residual, q


class LastPose:
    """The pose in which a caller was last, and from which the next one is looked for.

    A robot that moves little between two questions is asked faster with it. The answers are the
    same, to rounding, as long as no singular pose lies between.

    Get one from ``robot.last_pose()``; it belongs to that robot and to one thread at a time.
    """

    def __init__(self, size: int) -> None:
        self.memory = np.empty(size)
        self.is_closed = False

    def forget(self) -> None:
        """Start from the reference again."""
        self.is_closed = False


class Core:
    """The dynamics of a tree with loops in its independent coordinates.

    It can be shared by threads, pickled and copied: what a call changes belongs to the call.

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
        Residual that may be left where equations contradict each other by rounding [m, rad].
    weakest : float
        Share of a group's smallest pivot at the guess up to which a pose counts as singular.

    Raises
    ------
    UnsupportedJoint
        If a joint is none that the kernels know.
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
        self.coordinates = model.nq
        # A view of the model's own: who changes gravity there changes it here.
        self._free_fall = model.gravity.linear
        self._model = model
        self._size = int(self.tree[SIZE])
        self._spare: list[Array] = []
        self._reference = np.empty(self._size)
        for group in range(int(self.tree[GROUPS])):
            at = int(self.tree[AT_TOLERANCES]) + GROUP_NUMBERS * group
            self.numbers[at + MISMATCH_AT] = mismatch
        self._settle(guess, self._reference)
        for group in range(int(self.tree[GROUPS])):
            pivot = abs(self._reference[int(self.tree[AT_SIGNS]) + group])
            at = int(self.tree[AT_TOLERANCES]) + GROUP_NUMBERS * group
            self.numbers[at + 2] = NEAR_SINGULAR * pivot
            self.numbers[at + WEAKEST_AT] = weakest * pivot

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_spare": [], "_free_fall": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._free_fall = self._model.gravity.linear

    @property
    def q0(self) -> Array:
        """The reference configuration, closed, (nq,)."""
        at = int(self.tree[AT_CONFIGURATION])
        return self._reference[at : at + self.coordinates].copy()

    def last_pose(self) -> LastPose:
        """Return memory for a caller who asks about one pose after the other."""
        return LastPose(self._size)

    def _settle(self, guess: Array, memory: Array) -> None:
        """Close the loops from a guess, independent joints fixed; begin the memory with it."""
        at = int(self.tree[AT_CONFIGURATION])
        memory[at : at + self.coordinates] = guess
        outcome = assemble(self.tree, self.numbers, memory)
        if outcome != CLOSED:
            raise self._no_answer(0, outcome, memory)

    def _no_answer(self, row: int, outcome: int, memory: Array) -> NoAnswer:
        report = memory[int(self.tree[AT_REPORT]) :]
        at = int(self.tree[AT_CONFIGURATION])
        q = memory[at : at + self.coordinates].copy()
        return NoAnswer(row, outcome, float(report[0]), float(report[1]), q)

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
            Which one.
        positions, second, third : (N, p), (N, n) and (N, n) ndarray
            Independent coordinates; speeds; accelerations or forces.
        out : (N, w) ndarray
            Where the answers go.
        guess : (nq,) ndarray or LastPose, optional
            Where the first row starts, instead of the reference.
        is_path : bool
            Whether each row starts from the one before, however far.

        Raises
        ------
        NoAnswer
            At the first row that has none.
        TypeError
            If an argument is no contiguous array of floats that can be written to, of two
            dimensions.
        """
        if type(guess) is LastPose:
            memory, is_warm = guess.memory, guess.is_closed
            # Until this call has gone well.
            guess.is_closed = False
        else:
            memory = self._spare.pop() if self._spare else np.empty(self._size)
            is_warm = guess is not None
            if guess is not None:
                self._settle(guess, memory)
        at = int(self.tree[AT_FREE_FALL])
        self.numbers[at : at + 3] = self._free_fall
        row = answer(
            question,
            self.tree,
            self.numbers,
            self._reference,
            memory,
            1 if is_warm else 0,
            1 if is_path else 0,
            positions,
            second,
            third,
            out,
        )
        if row >= 0:
            outcome = int(memory[int(self.tree[AT_REPORT]) + 3])
            raise self._no_answer(row, outcome, memory)
        if type(guess) is LastPose:
            guess.is_closed = True
        else:
            self._spare.append(memory)

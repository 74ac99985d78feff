r"""Find the rank of closure equations in general position, and how far they contradict each other.

The numbers in a robot file are rounded. A planar loop in space, for example, has redundant
equations, which then differ slightly. Such a loop closes exactly nowhere, and the Jacobian J of the
closure equations barely has full rank. A singular pose lowers the rank, too. Redundancy holds at
all poses and a singular pose does not. A singular value that is due to rounding is no larger than
the residual that rounding leaves.

So the loops are closed with Gauss–Newton steps in which singular values below a threshold count as
zero: at home, and at poses of a random walk along the remaining motions. Thresholds are tried by
decades. A threshold is accepted if the loops come to rest with a small residual :math:`\mu`, and if
the singular values that count as zero are far below the others and at most a few :math:`\mu`. Among
these thresholds, the strictest one is chosen for which all other singular values are well above
those of rounding. (Numbers with few digits often close the loops exactly at home. A strict
threshold then blocks motions that only the rounded numbers block.) The motors are not used, so the
degrees of freedom of a mechanism do not depend on the places of its motors.

Exact loops can be weak, too. An example is a leg that is nearly stretched and held there. Near this
singular pose a loose threshold seems to be explained, because :math:`\mu` grows with the square of
the distance that the joints have moved. But the motion that a loose threshold takes for free opens
the loops more and more as it goes on. The gaps that rounding leaves stay small everywhere. So if a
stricter threshold closes the loops exactly, this motion is followed over a long way, and the loose
threshold is rejected if the loops open.

Position rows and sliding joints are measured in sizes of the robot, so that lengths and angles can
be compared. A loop that is much smaller is also measured in its own size before it counts as weak.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.closure.assembly import by_short_steps, jacobian, nearly_closed, residual
from psp3.closure.ranges import how_far_beyond, within_limits
from psp3.closure.rank import ASSEMBLED_RANK_TOLERANCE
from psp3.errors import LoopsDoNotClose
from psp3.multibody.first_answers import compile_answers
from psp3.multibody.flatten import FlatTree

LARGEST_MISMATCH = 2e-3
"""Loops that stay open by more than this do not close [rad, or sizes of the robot]. Numbers with
four digits leave up to 1e-3.
"""

TOLD_MISMATCH = 1e-6
"""A mismatch of at least this is logged [rad, or sizes of the robot], because a small real error
cannot be distinguished from rounding.
"""

EXACT = 1e-11
"""A mismatch up to this is floating-point rounding, not rounding in the file [rad, or sizes]."""

THRESHOLDS = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
"""Shares of the largest singular value that may count as zero, strictest first."""

GAP = 10.0
"""The last singular value that counts is at least this many times the first that does not."""

EXPLAINED = 30.0
"""A singular value may count as zero if it is at most this many times the mismatch. If rounding
causes both, the observed factor is at most two.
"""

WEAK = 1e-3
"""The strictest threshold is certainly right if all singular values that count are above this."""

SMALL_LOOP = 1e-2
"""It is also right if all are above this with each loop measured in its own size. A small loop in a
large robot is weak in sizes of the robot, and rounding gives less than this in both sizes.
"""

LARGEST_WAY = 1.0
"""If joints must move by more than this to close the loops, it is another pose [rad, or sizes of
the robot].
"""

LARGEST_STEP = 0.3
"""The largest motion of a joint in a Gauss–Newton step [rad, or sizes]."""

MOST_STEPS = 60

STEPS = (0.3, 0.1, 0.03)
"""Distances between the poses at which the equations are examined [rad, or sizes of the robot]; a
smaller one is used if the loops do not close at a larger one.
"""

POSES = 8

REGULAR, SINGULAR = 0.1, 1e-6
"""At a home that was searched for, singular values that count are at least the first share of the
largest that they reach elsewhere; at a neutral pose that closes the loops, the second.
"""

MOST_OTHERS = 20
"""After so many configurations that close the loops, the best of them is taken."""

LONG_WAY = 3
"""Claimed motions are followed for so many of the largest steps to either side."""

MOST_SECONDS, LEAST_SECONDS = 4.0, 1.0
"""After the first time, no more starts are tried for a robot whose loops do not close [s]. The
second time is reserved for other starts, however long the first start took [s].
"""


class Structure(NamedTuple):
    """The structure of closure equations in general position."""

    home: Array
    """The configuration near the given one that closes the loops best, (nq,)."""
    poses: tuple[Array, ...]
    """Configurations that close the loops, home first."""
    motions: tuple[Array, ...]
    """A basis of the velocities that keep the loops closed at each of these poses, (nv, f), in m
    and rad.
    """
    rank: int
    """Number of independent closure equations."""
    values: Array
    """Singular values divided by the largest one; for each, the maximum over the poses."""
    first: float
    """The largest singular value; small where all loops are much smaller than the robot."""
    length: float
    """How far redundant equations contradict each other in position [m]."""
    angle: float
    """And in direction [rad]."""
    size: float
    """Size of the robot [m], in which lengths are measured."""
    worst: int
    """Index of the closure that stays open most; −1 without closures."""
    exact: Structure | None = None
    """The structure by a stricter threshold that closes the same loops exactly, if there is one and
    following the additional motions did not reject this structure; None otherwise.
    """

    @property
    def freedoms(self) -> int:
        """Independent motions."""
        return int(self.motions[0].shape[1])

    @property
    def is_explained(self) -> bool:
        """Tell whether rounding can explain the singular values that count as zero."""
        limit = max(EXACT, EXPLAINED * self.mismatch)
        return self.dropped * min(self.first, 1.0) <= limit

    @property
    def is_stuck(self) -> bool:
        """Tell whether home is a singular pose and no way out of it was found.

        There the loops block a motion in second order only. They close exactly. The singular values
        that count as zero are larger than rounding explains, but too small to count.
        """
        is_small = self.mismatch <= EXACT and self.dropped <= ASSEMBLED_RANK_TOLERANCE
        return is_small and not self.is_explained

    @property
    def mismatch(self) -> float:
        """The larger of length, over the size of the robot, and angle."""
        return max(self.length / self.size, self.angle)

    @property
    def kept(self) -> float:
        """The last singular value that counts."""
        return float(self.values[self.rank - 1]) if self.rank else 1.0

    @property
    def dropped(self) -> float:
        """The first singular value that does not count."""
        return float(self.values[self.rank]) if self.rank < len(self.values) else 0.0

    @property
    def tolerance(self) -> float:
        """Singular values of motions up to this share of the largest one count as zero."""
        return max(ASSEMBLED_RANK_TOLERANCE, 3.0 * self.dropped)


def structure(
    model: pin.Model,
    flat: FlatTree,
    q: Array | None,
    motors: Array,
    names: Sequence[str] = (),
) -> Structure:
    """Return the structure of closure equations near a configuration.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    flat : FlatTree
        The tree and its closures, flattened without motors.
    q : (nq,) ndarray or None
        A configuration that closes the loops, or nearly. Without it, ``neutral`` within the joint
        limits is tried, then other configurations.
    motors : (nv, m) ndarray
        The joint velocities that each motor drives, one column per motor.
    names : sequence of str
        Names of the closures, for the error.

    Returns
    -------
    Structure

    Raises
    ------
    LoopsDoNotClose
        If no configuration closes the loops, not even nearly. The search takes a few seconds at
        most.
    """
    start = q
    if start is None:
        inside = within_limits(model, pin.neutral(model))
        near = by_short_steps(model, flat, inside)
        start = inside if near is None else near
    equations, began = _Equations(model, flat, start), time.process_time()
    found = equations.structure(start)

    def is_home(one: Structure) -> bool:
        if q is not None:
            return True
        # A neutral pose that closes the loops is what people expect, unless it is singular.
        least = SINGULAR if _is_at(model, one.home, inside) else REGULAR
        return _is_good(model, one, motors) and equations.is_regular(one, motors, least)

    if found is not None and is_home(found):
        return found
    took = time.process_time() - began
    # A search needs thousands of answers. They are compiled before the time of the search starts.
    compile_answers(flat.integers, flat.numbers)
    equations.deadline = time.process_time() + max(MOST_SECONDS - took, LEAST_SECONDS)
    tried = 1
    least, worst = equations.openness(start)
    nearest = start
    others = [found] if found is not None else []
    for near in _other_starts(model, flat, start if q is not None else inside, equations.deadline):
        tried += 1
        size, where = equations.openness(near)
        if size < least:
            least, worst, nearest = size, where, near
        found = equations.structure(near)
        if found is not None:
            if is_home(found):
                return found
            others.append(found)
        if time.process_time() > equations.deadline or len(others) == MOST_OTHERS:
            break
    if others:
        # Prefer the start in which the motors command most, then a regular one, then the one least
        # beyond the limits.
        return max(
            others,
            key=lambda one: (
                not one.is_stuck,
                commanded(one, motors),
                equations.is_regular(one, motors, REGULAR),
                -how_far_beyond(model, one.home),
            ),
        )
    loop = names[worst] if 0 <= worst < len(names) else ""
    raise LoopsDoNotClose(start, float(np.abs(residual(flat, nearest)).max()), loop, tried)


def _is_good(model: pin.Model, found: Structure, motors: Array) -> bool:
    """Tell whether a configuration that was found can be home.

    Within the joint limits, and with each motor at work that can be: in the fold of a leg, for
    example, none is. And not at a singular pose that the loops do not leave.
    """
    most = min(motors.shape[1], model.nv - found.rank)
    if found.is_stuck:
        return False
    return how_far_beyond(model, found.home) == 0.0 and commanded(found, motors) == most


def _is_at(model: pin.Model, home: Array, q: Array) -> bool:
    return bool(np.abs(pin.difference(model, q, home)).max(initial=0.0) < 1e-6)


def _other_starts(
    model: pin.Model, flat: FlatTree, start: Array, deadline: float
) -> Iterator[Array]:
    """Yield other starts: first within the joint limits, then anywhere."""
    for near, _ in nearly_closed(model, flat, start, deadline):
        yield near
    rng = np.random.default_rng(1)
    for attempt in range(1, 31):
        way = 0.1 * attempt * rng.uniform(-1.0, 1.0, model.nv)
        yield np.asarray(pin.integrate(model, start, way))


class _Equations:
    """Closure equations in which lengths are measured in sizes of the robot."""

    def __init__(self, model: pin.Model, flat: FlatTree, q: Array) -> None:
        self.model, self.flat, self.size = model, flat, robot_size(model, q)
        self.units = np.where(flat.sliding, self.size, 1.0)
        self.scale = np.where(flat.is_length, self.size, 1.0)
        self.deadline = np.inf
        """When looking ends, in CPU time of the process [s]."""

    def openness(self, q: Array) -> tuple[float, int]:
        """Return the largest residual, and the closure that has it."""
        gaps = np.abs(residual(self.flat, q) / self.scale)
        if not gaps.size:
            return 0.0, -1
        ends = np.cumsum(self.flat.closure_rows)
        place = int(np.searchsorted(ends, int(np.argmax(gaps)), side="right"))
        return float(gaps.max()), self.flat.order[place]

    def decomposed(self, q: Array) -> tuple[Array, Array, Array]:
        """Return the singular value decomposition of J at a configuration."""
        matrix = jacobian(self.flat, q) * self.units / self.scale[:, np.newaxis]
        if not matrix.size:
            return np.zeros((0, 0)), np.zeros(0), np.eye(matrix.shape[1])
        left, values, right = np.linalg.svd(matrix)
        return left, values, right

    def settled(
        self, q: Array, threshold: float, most: int | None = None
    ) -> tuple[Array, Array] | None:
        """Return where Gauss–Newton steps come to rest, and the residual there; None if nowhere.

        No more than ``most`` singular values count.
        """
        way, last = np.zeros(self.model.nv), np.inf
        for _ in range(MOST_STEPS):
            gaps = residual(self.flat, q) / self.scale
            left, values, right = self.decomposed(q)
            rank = _count(values[:most], threshold)
            step = -right[:rank].T @ (left[:, :rank].T @ gaps / values[:rank])
            largest = float(np.abs(step).max(initial=0.0))
            if largest < 1e-13 or (largest < 1e-9 and largest >= 0.5 * last):
                return q, gaps
            if time.process_time() > self.deadline:
                return None
            step *= min(1.0, LARGEST_STEP / largest)
            way += np.abs(step)
            if not way.max() <= LARGEST_WAY:
                return None
            q, last = pin.integrate(self.model, q, self.units * step), largest
        return None

    def explored(self, q: Array, threshold: float) -> Structure | None:
        """Return the structure if singular values below a threshold count as zero.

        Return None if the loops then cannot be closed at home.
        """
        at_home = self.settled(q, threshold)
        if at_home is None or np.abs(at_home[1]).max(initial=0.0) > LARGEST_MISMATCH:
            return None
        here, gaps = at_home
        poses, firsts, spectra, bases = [here], [], [], []
        home, worst, rng = here, np.abs(gaps), np.random.default_rng(0)
        while True:
            _, values, right = self.decomposed(here)
            firsts.append(float(values.max(initial=0.0)))
            spectra.append(values / max(firsts[-1], 1e-300))
            bases.append(right)
            motions = right[_count(values, threshold) :]
            if len(poses) > POSES or not len(motions):
                break
            # A projection, because the basis of the motions may differ from machine to machine.
            way = motions @ rng.normal(size=self.model.nv)
            away = self._away(here, motions.T @ way, threshold)
            if away is None and here is home:
                break
            # If the walk cannot continue, start again from home.
            here = home if away is None else away[0]
            if away is not None:
                worst = np.maximum(worst, np.abs(away[1]))
            poses.append(here)
        largest, first = np.max(spectra, axis=0), max(firsts)
        rank = int(np.count_nonzero(largest > threshold))
        length = self.size * float(worst[self.flat.is_length].max(initial=0.0))
        angle = float(worst[~self.flat.is_length].max(initial=0.0))
        motions_of = tuple(self.units[:, np.newaxis] * right[rank:].T for right in bases)
        return Structure(
            home,
            tuple(poses),
            motions_of,
            rank,
            largest,
            first,
            length,
            angle,
            self.size,
            self.openness(home)[1],
        )

    def _away(self, q: Array, direction: Array, threshold: float) -> tuple[Array, Array] | None:
        """Return a closed pose in a direction and its residual; None if there is none."""
        for step in STEPS:
            way = step / np.abs(direction).max() * self.units * direction
            found = self.settled(pin.integrate(self.model, q, way), threshold)
            if found is not None and np.abs(found[1]).max(initial=0.0) <= LARGEST_MISMATCH:
                return found
        return None

    def opens(self, loose: Structure, strict: Structure) -> bool:
        """Tell whether motions that only the looser of two readings has open the loops.

        They are followed from where the stricter reading closes the loops, with as many equations
        as the looser one has, so that the others may open as far as they do.
        """
        end = strict.rank if strict.rank > loose.rank else self.model.nv
        return any(
            self._opens_along(strict.home, side * direction, loose.rank)
            for direction in self.decomposed(strict.home)[2][loose.rank : end]
            for side in (1.0, -1.0)
        )

    def _opens_along(self, q: Array, direction: Array, rank: int) -> bool:
        for _ in range(LONG_WAY):
            way = STEPS[0] / np.abs(direction).max() * self.units * direction
            found = self.settled(pin.integrate(self.model, q, way), 0.0, rank)
            if found is None:
                return False
            q, gaps = found
            if np.abs(gaps).max(initial=0.0) > LARGEST_MISMATCH:
                return True
            motions = self.decomposed(q)[2][rank:]
            direction = motions.T @ (motions @ direction)
        return False

    def is_regular(self, found: Structure, motors: Array, share: float) -> bool:
        """Tell whether home is near no singular pose, of the equations or of the motors.

        What counts must do so by a share of what it does elsewhere.
        """
        if not found.rank:
            return True
        values = self.decomposed(found.home)[1]
        most = commanded(found, motors)
        works = [np.linalg.svd(motors.T @ one, compute_uv=False)[:most] for one in found.motions]
        least = np.min(works, axis=-1, initial=np.inf) if most else np.ones(len(works))
        is_driven = least[0] >= share * least.max()
        return bool(is_driven and values[found.rank - 1] >= share * found.kept * values[0])

    def is_well(self, found: Structure) -> bool:
        """Tell whether all equations that count are stronger than those that rounding can cause."""
        if found.kept > WEAK:
            return True
        shares = np.max([self._shares_by_loop(q) for q in found.poses], axis=0)
        return bool(shares[found.rank - 1] > SMALL_LOOP)

    def _shares_by_loop(self, q: Array) -> Array:
        """Return singular values over the largest one, with each loop measured in its own size.

        The size of a loop is the longest lever arm of its closure point about a joint.
        """
        matrix, row = jacobian(self.flat, q), 0
        for count in self.flat.closure_rows:
            block = np.arange(row, row + count)[self.flat.is_length[row : row + count]]
            levers = np.linalg.norm(matrix[block][:, ~self.flat.sliding], axis=0)
            matrix[block] /= levers.max(initial=0.0) or self.size
            row += count
        longest = np.linalg.norm(matrix[:, self.flat.sliding], axis=0)
        matrix[:, self.flat.sliding] /= np.where(longest > 0.0, longest, 1.0)
        values = np.linalg.svd(matrix, compute_uv=False)
        return np.asarray(values / max(values.max(initial=0.0), 1e-300))

    def structure(self, q: Array) -> Structure | None:
        """Return the structure by the rule of this module; None if no threshold is accepted."""
        accepted: list[Structure] = []
        stuck: Structure | None = None
        for threshold in THRESHOLDS:
            found = self.explored(q, threshold)
            if found is None or any(found.rank == other.rank for other in accepted):
                continue
            if found.kept < GAP * found.dropped:
                continue
            if not found.is_explained:
                stuck = found if found.is_stuck and stuck is None else stuck
                continue
            if found.dropped > EXACT:
                # Start again from the given configuration, with a threshold in the middle of the
                # gap, because a threshold that is too strict may have led far away.
                again = self.explored(q, max(1e-9, float(np.sqrt(found.kept * found.dropped))))
                if again is None or again.rank != found.rank:
                    continue
                if again.kept < GAP * again.dropped:
                    continue
                found = again
                strict = next((one for one in (*accepted, stuck) if one is not None), None)
                if strict is not None and strict.mismatch <= EXACT:
                    if self.opens(found, strict):
                        continue
                    found = found._replace(exact=strict)
            accepted.append(found)
            if self._moves(found) and self.is_well(found):
                return found
        if not accepted:
            return stuck
        # One that moves; of these those that leave home where it was; of these the strictest.
        moved = [np.abs(pin.difference(self.model, q, one.home)).max() for one in accepted]
        near = [one < 10.0 * min(moved) + 1e-6 for one in moved]
        return accepted[
            max(range(len(accepted)), key=lambda k: (self._moves(accepted[k]), near[k], -k))
        ]

    def _moves(self, found: Structure) -> bool:
        return bool(found.rank < self.model.nv)


def commanded(found: Structure, motors: Array) -> int:
    """Return the number of motors that command independent motions, in a pose away from home."""
    return rank_of_motions(motors.T @ found.motions[-1], found.tolerance)


def rank_of_motions(rows: Array, tolerance: float) -> int:
    """Return how many rows of a basis of motions are independent."""
    return int(np.linalg.matrix_rank(rows, tol=tolerance)) if rows.size else 0


def robot_size(model: pin.Model, q: Array) -> float:
    """Return the largest distance between the joints of a robot [m]; 1 if all are at one place."""
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    places = np.array([data.oMi[index].translation for index in range(1, model.njoints)])
    return (float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0) or 1.0


def _count(values: Array, threshold: float) -> int:
    return int(np.count_nonzero(values > threshold * max(values.max(initial=0.0), 1e-300)))


def closure_names(constraints: Sequence[Any]) -> list[str]:
    """Return the names of closures in messages."""
    return [str(getattr(one, "name", "")) or f"loop {k}" for k, one in enumerate(constraints, 1)]

r"""Choose independent coordinates of a mechanism, and what is held if no motor commands a motion.

The motions that the loops allow are given by a basis N of velocities at each of several poses. A
coordinate is a row w of joint velocities, and it measures :math:`w N` of these motions. The motion
that it measures is removed from the basis before the next coordinate is chosen, so the coordinates
are independent of each other.

Coordinates are chosen in this order. First come the wanted coordinates. Then come the motors in the
order of the file, if they measure something new; motors that do so at every pose are chosen before
the others. If motions remain, one free joint is chosen for each. The candidates are the joints
that, in the pose that is worst for them, measure at least a tenth of what the best one measures. A
joint with a spring is preferred, then a joint of one degree of freedom to the spin of a ball joint,
then the first in the file. A floating base always keeps its own coordinates, which come last. A
base in a loop is a dependent joint, and its remaining motions are kept, too
(:mod:`psp3.robots.simple_joints`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array, Indices
from psp3.closure.rank import null_space
from psp3.closure.structure import Structure
from psp3.errors import DependentCoordinates, UnknownName
from psp3.multibody.equations import Coupling, Spin

NOTHING = 1e-6
"""A coordinate counts as measuring nothing if it measures less than this of the remaining motions.
"""

WELL = 0.01
"""A motor measures well if it measures at least this of the remaining motions at every pose."""

STILL = 1e-6
"""Other rows measure at most this of a motion that is independent of them."""

GOOD_SHARE = 0.1
"""A joint is good enough if it measures this share of what the best one measures."""


class Locked(NamedTuple):
    """A free motion that is held: the locked joint, and all joints that could move with it."""

    joint: str
    moving: tuple[str, ...]
    spin: Spin | None
    """For a ball joint, the axis about which it does not rotate."""

    def __str__(self) -> str:
        what = f"the spin of {self.joint}" if self.spin is not None else self.joint
        others = [name for name in self.moving if name != self.joint]
        return what + (f" (would move {', '.join(others)})" if others else "")


class Coordinates(NamedTuple):
    """Independent coordinates of a mechanism."""

    names: tuple[str, ...]
    """Joints, in the order of the coordinates; a floating base is last."""
    positions: Indices
    """Places of the coordinates in a configuration, (p,)."""
    speeds: Indices
    """Places of their speeds in the velocities, (n,)."""
    locked: tuple[Locked, ...]
    """Free motions that are held, or would be if free motions were locked."""
    held: tuple[int, ...]
    """Velocities that are held at zero."""

    @property
    def spins(self) -> list[Spin]:
        """The axes about which ball joints do not rotate."""
        return [one.spin for one in self.locked if one.spin is not None]


def chosen_coordinates(
    model: pin.Model,
    found: Structure,
    closures: Sequence[Any],
    motors: Array,
    free: str,
    wanted: Sequence[str] | None = None,
    springs: Mapping[str, Any] | None = None,
    kept: Sequence[str] = (),
) -> Coordinates:
    """Return the coordinates of a mechanism, by the rule of this module.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    found : Structure
        The structure of its closures.
    closures : sequence
        The closures.
    motors : (nv, m) ndarray
        The joint velocities that each motor drives, one column per motor.
    free : str
        ``"keep"``: free motions of joints of one degree of freedom get coordinates. Otherwise they
        are listed in ``locked``, as the spin of a ball joint always is.
    wanted : sequence of str, optional
        Joints of one degree of freedom that come first.
    springs : mapping, optional
        The joints that have a spring, as keys.
    kept : sequence of str
        Joints of one degree of freedom that come after the motors, and are never locked.

    Raises
    ------
    UnknownName
        If a wanted joint does not exist.
    DependentCoordinates
        If a wanted joint cannot be a coordinate in addition to those before it.
    """
    choice = _Choice(model, found)
    base = floating_base(model, closures)
    if base is not None:
        choice.take(range(base.idx_v, base.idx_v + base.nv))
    velocities = [*choice.wanted(wanted or ()), *choice.driven(motors)]
    own = [model.joints[model.getJointId(name)].idx_v for name in kept]
    velocities += choice.driven(np.eye(model.nv)[:, own])
    commanded = len(velocities)
    locked: list[Locked] = []
    held: list[int] = []
    rows = [np.eye(model.nv)[v] for v in velocities]
    while choice.left:
        row, spin = choice.best(springs or {}, found.home)
        rows.append(row)
        choice.remove(row)
        velocity = int(np.argmax(np.abs(row)))
        if spin is None and free == "keep":
            velocities.append(velocity)
        elif spin is None:
            held.append(velocity)
        locked.append(Locked(choice.names[velocity], (), spin))
    of_base = [] if base is None else list(np.eye(model.nv)[base.idx_v : base.idx_v + base.nv])
    moving = _moving(model, found, rows[commanded:], [*rows[:commanded], *of_base])
    locked = [one._replace(moving=names) for one, names in zip(locked, moving, strict=True)]
    if free == "keep":
        locked = [one for one in locked if one.spin is not None]
    of_velocity = {joint.idx_v: joint for joint in list(model.joints)[1:]}
    positions = [choice.places[v] for v in velocities]
    names = [choice.names[v] for v in velocities]
    if base is not None:
        velocities += range(base.idx_v, base.idx_v + base.nv)
        positions += range(base.idx_q, base.idx_q + base.nq)
        names.append(str(model.names[of_velocity[base.idx_v].id]))
    return Coordinates(
        tuple(names),
        np.array(positions, dtype=np.int64),
        np.array(velocities, dtype=np.int64),
        tuple(locked),
        tuple(held),
    )


def is_ball(joint: Any) -> bool:
    """Tell whether a joint rotates about a point."""
    return (joint.nq, joint.nv) == (4, 3) and "Spherical" in joint.shortname()


class _Choice:
    """The motions that have no coordinate yet, at every pose."""

    def __init__(self, model: pin.Model, found: Structure) -> None:
        self.model, self.least = model, max(NOTHING, found.tolerance)
        self.bases = [np.linalg.qr(motions)[0] for motions in found.motions]
        self.names, self.places = {}, {}
        for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
            for k in range(joint.nv):
                self.names[joint.idx_v + k] = str(name)
                self.places[joint.idx_v + k] = joint.idx_q + min(k, joint.nq - 1)

    @property
    def left(self) -> int:
        """Number of remaining motions."""
        return int(min((basis.shape[1] for basis in self.bases), default=0))

    def measured(self, row: Array) -> float:
        """Return how much a row of velocities measures in its best pose."""
        return float(max(np.linalg.norm(row @ basis) for basis in self.bases))

    def measures(self, velocity: int) -> float:
        """Return how much one velocity measures in its best pose."""
        return float(max(np.linalg.norm(basis[velocity]) for basis in self.bases))

    def wanted(self, names: Sequence[str]) -> list[int]:
        """Choose the wanted coordinates; return their velocities."""
        taken: list[int] = []
        for name in names:
            if not self.model.existJointName(name) or name == self.model.names[0]:
                raise UnknownName("coordinate", name, tuple(self.model.names)[1:])
            joint = self.model.joints[self.model.getJointId(name)]
            if joint.nv != 1 or not self.measures(joint.idx_v) > self.least:
                raise DependentCoordinates(name, [self.names[v] for v in taken])
            self.take([joint.idx_v])
            taken.append(joint.idx_v)
        return taken

    def driven(self, motors: Array) -> list[int]:
        """Choose a coordinate of each motor that commands an independent motion.

        Motors that measure well at every pose come first, so that home is not a dead point; then
        those that measure something at some pose.
        """
        taken: dict[int, int] = {}
        for measure, least in ((self.worst, WELL), (self.measured, self.least)):
            for number, column in enumerate(motors.T):
                if number in taken or not self.left:
                    continue
                if not measure(column / np.linalg.norm(column)) > least:
                    continue
                for velocity in map(int, np.flatnonzero(column)):
                    if measure(np.eye(self.model.nv)[velocity]) > least:
                        self.take([velocity])
                        taken[number] = velocity
                        break
        return [taken[number] for number in sorted(taken)]

    def worst(self, row: Array) -> float:
        """Return how much a row measures in its worst pose."""
        return float(min(np.linalg.norm(row @ basis) for basis in self.bases))

    def take(self, velocities: Sequence[int]) -> None:
        """Remove the motions that joint velocities measure."""
        for velocity in velocities:
            self.remove(np.eye(self.model.nv)[velocity])

    def remove(self, row: Array) -> None:
        """Remove the motion that a row measures, and poses at which it measures nothing."""
        able = [basis for basis in self.bases if np.linalg.norm(row @ basis) > self.least]
        self.bases = [_without(basis, row @ basis) for basis in able]

    def best(self, springs: Mapping[str, Any], home: Array) -> tuple[Array, Spin | None]:
        """Return the next row by the rule of this module; for a ball joint, also its spin."""
        found: list[tuple[float, int, int | Array, Spin | None]] = []
        worst = np.min([np.linalg.norm(basis, axis=1) for basis in self.bases], axis=0)
        for index in range(1, self.model.njoints):
            joint, name = self.model.joints[index], str(self.model.names[index])
            if is_ball(joint):
                own = slice(joint.idx_v, joint.idx_v + 3)
                axis = np.linalg.svd(self.bases[0][own])[0][:, 0]
                row = np.zeros(self.model.nv)
                row[own] = axis
                quaternion = np.array(home[joint.idx_q : joint.idx_q + 4])
                found.append((self.worst(row), 2, row, Spin(name, index, axis, quaternion)))
            elif joint.nq == joint.nv or joint.nv == 1:
                for velocity in range(joint.idx_v, joint.idx_v + joint.nv):
                    rank = 0 if name in springs else 1
                    found.append((float(worst[velocity]), rank, velocity, None))
        best = max((one[0] for one in found), default=0.0)
        if not best > self.least:
            raise DependentCoordinates("", [])
        good = [one for one in found if one[0] >= GOOD_SHARE * best]
        # The first one in the file if several are equal.
        _, _, which, spin = min(good, key=lambda one: one[1])
        return np.eye(self.model.nv)[which] if isinstance(which, int) else which, spin


def bases(model: pin.Model) -> list[Any]:
    """Return the floating and planar joints; those on the world come first."""
    found = [
        joint
        for joint in list(model.joints)[1:]
        if (joint.nq, joint.nv) == (7, 6) or "Planar" in joint.shortname()
    ]
    return sorted(found, key=lambda joint: bool(model.parents[joint.id] != 0))


def floating_base(model: pin.Model, closures: Sequence[Any]) -> Any:
    """Return the first floating or planar joint that no loop contains, or None."""
    loops = [one for one in closures if not isinstance(one, Coupling | Spin)]
    for joint in bases(model):
        ends = [
            [joint.id in list(model.supports[end]) for end in (one.joint1_id, one.joint2_id)]
            for one in loops
        ]
        if all(first == second for first, second in ends):
            return joint
    return None


def _without(basis: Array, measured: Array) -> Array:
    """Remove the direction that a row measures from a basis, with a Householder reflection.

    The reflection maps that direction to the first column, which is dropped.
    """
    mirror = measured.copy()
    mirror[0] += np.copysign(np.linalg.norm(measured), measured[0])
    turned: Array = basis - np.outer(basis @ mirror, 2.0 / (mirror @ mirror) * mirror)
    return np.ascontiguousarray(turned[:, 1:])


def _moving(
    model: pin.Model, found: Structure, rows: Sequence[Array], others: Sequence[Array]
) -> list[tuple[str, ...]]:
    """Return, for each row, the joints that move when this row moves and all other rows rest."""
    if not rows:
        return []
    moves = np.zeros((len(rows), model.nv), dtype=bool)
    every = np.array([*rows, *others])
    for motions in found.motions:
        basis = np.linalg.qr(motions)[0]
        for number, left in enumerate(_alone(every @ basis, len(rows))):
            share = np.abs(every[number] @ basis @ left).max(initial=0.0)
            if share > NOTHING:
                limit = 1e-5 + 10.0 * found.mismatch
                moves[number] |= np.abs(basis @ left).max(axis=1) > limit
    joints = list(zip(list(model.names)[1:], list(model.joints)[1:], strict=True))
    return [
        tuple(
            str(name) for name, joint in joints if own[joint.idx_v : joint.idx_v + joint.nv].any()
        )
        for own in moves
    ]


def _alone(measured: Array, count: int) -> Iterator[Array]:
    """Yield, for each of the first rows, the motions that no other row measures.

    With as many independent rows as motions, these are columns of the inverse.
    """
    is_square = measured.shape[0] == measured.shape[1]
    if is_square and np.linalg.svd(measured, compute_uv=False)[-1] > STILL:
        inverse = np.linalg.inv(measured)[:, :count]
        yield from (inverse / np.linalg.norm(inverse, axis=0)).T[..., np.newaxis]
        return
    for number in range(count):
        yield null_space(np.delete(measured, number, axis=0), STILL, 1.0)

"""The forces in the loops and joints of a robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.closure.assembly import jacobian
from psp3.closure.rank import RANK_TOLERANCE
from psp3.closure.structure import closure_names
from psp3.multibody.equations import Coupling, Spin
from psp3.multibody.flatten import NO_MOTORS, flattened


class LoopForce(NamedTuple):
    """Force of a loop on the body of its second frame; the first body gets the opposite force."""

    name: str
    force: Array
    """Force in axes of the first frame, (3,) [N]."""
    torque: Array
    """Torque about its origin, (3,) [N m]; zero if the loop joins only a point."""


class JointReaction(NamedTuple):
    """Force of a joint on the body that it carries."""

    name: str
    force: Array
    """Force in axes of the body's joint frame, (3,) [N]."""
    torque: Array
    """Torque about its origin, (3,) [N m], including that of the motor."""


class ClosureForces(NamedTuple):
    """The forces in every loop and in every joint."""

    loops: tuple[LoopForce, ...]
    joints: tuple[JointReaction, ...]


def forces_of_motion(
    model: pin.Model,
    closures: Sequence[Any],
    held: Sequence[int],
    motion: tuple[Array, Array, Array],
    acting: Array,
) -> ClosureForces:
    r"""Return the forces in loops and joints during a motion.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    closures : sequence
        The closures of the tree.
    held : sequence of int
        Velocities that are held at zero.
    motion : tuple of ndarray
        Configuration (nq,), velocities and accelerations (nv,) of all joints.
    acting : (nv,) ndarray
        Forces along the joints: those of motors, springs, damping and friction.

    Returns
    -------
    ClosureForces
        The forces; the shortest ones if loops are redundant.
    """
    data, flat = model.createData(), flattened(model, closures, NO_MOTORS)
    left = np.array(pin.rnea(model, data, *motion)) - acting
    unlocked = np.setdiff1d(np.arange(model.nv), held)
    slope = jacobian(flat, motion[0])[:, unlocked]
    solution = np.linalg.lstsq(slope.T, left[unlocked], rcond=RANK_TOLERANCE)[0]
    ends = np.cumsum([0, *flat.closure_rows])
    names, found = closure_names(closures), {}
    for place, number in enumerate(flat.order):
        if not isinstance(closures[number], Coupling | Spin):
            rows = np.array(solution[ends[place] : ends[place + 1]], dtype=np.float64)
            found[number] = _loop_force(names[number], rows)
    outer = pin.StdVec_Force([pin.Force.Zero() for _ in range(model.njoints)])
    pin.forwardKinematics(model, data, motion[0])
    for number, one in found.items():
        loop = closures[number]
        wrench = (data.oMi[loop.joint1_id] * loop.joint1_placement).act(
            pin.Force(one.force, one.torque)
        )
        outer[loop.joint2_id] += data.oMi[loop.joint2_id].actInv(wrench)
        outer[loop.joint1_id] -= data.oMi[loop.joint1_id].actInv(wrench)
    pin.rnea(model, data, *motion, outer)
    joints = tuple(
        JointReaction(
            str(model.names[index]),
            np.array(data.f[index].linear),
            np.array(data.f[index].angular),
        )
        for index in range(1, model.njoints)
    )
    return ClosureForces(tuple(found[number] for number in sorted(found)), joints)


def _loop_force(name: str, rows: Array) -> LoopForce:
    """Return the force of a loop from those of its equations."""
    torque = np.zeros(3)
    if len(rows) == 5:
        # The rows are those of the second frame's z axis, which moves with ω × e_z.
        torque[:2] = -rows[4], rows[3]
    elif len(rows) == 6:
        torque[:] = rows[3:]
    return LoopForce(name, np.array(rows[:3]), torque)

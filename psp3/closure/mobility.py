r"""Mobility of a tree with loops: degrees of freedom by rank, compared with the motors.

With :math:`\Phi` the Jacobian of all closures and N a basis of its null space, split in the rows of
the actuated joints :math:`N_a` and the others,

.. math:: f = n_v - \operatorname{rank} \Phi

degrees of freedom remain. The motors command :math:`\operatorname{rank} N_a` of them. The rest of f
moves freely (under-actuation), and motors beyond that rank work against each other
(over-actuation). Counting equations, as in the formula of Chebyshev, Grübler and Kutzbach, gives
:math:`n_v - m`, which is too small wherever closures are redundant.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, one_row
from psp3.closure.rank import null_space
from psp3.closure.structure import Structure, closure_names, rank_of_motions, structure
from psp3.errors import UnknownName
from psp3.multibody.flatten import NO_MOTORS, FlatTree, flattened
from psp3.multibody.tree import ROWS


class Mobility(NamedTuple):
    """Degrees of freedom of a mechanism, and how many of them its motors command."""

    degrees_of_freedom: int
    """Degrees of freedom of the mechanism in general position."""
    actuators: int
    """Number of actuated joints."""
    commanded: int
    """Degrees of freedom that the actuators command."""
    joint_velocities: int
    """Degrees of freedom of the tree with open loops."""
    closure_equations: int
    """Closure equations: three or six for every closure."""
    rank: int
    """Independent closure equations."""
    free_joints: tuple[str, ...]
    """Joints that can still move with every actuator locked."""
    dependent_actuators: tuple[str, ...]
    """Actuators whose motion the actuators before them determine; so it depends on the order."""

    @property
    def redundant_equations(self) -> int:
        """Closure equations that follow from others."""
        return self.closure_equations - self.rank

    @property
    def by_counting(self) -> int:
        """Degrees of freedom after Chebyshev, Grübler and Kutzbach.

        The formula counts equations, not their rank.
        """
        return self.joint_velocities - self.closure_equations

    @property
    def under_actuation(self) -> int:
        """Degrees of freedom that no actuator commands."""
        return self.degrees_of_freedom - self.commanded

    @property
    def over_actuation(self) -> int:
        """Actuators beyond the necessary number."""
        return self.actuators - self.commanded

    def __str__(self) -> str:
        parts = [
            f"{_many(self.degrees_of_freedom, 'degree')} of freedom ({self.joint_velocities} "
            f"joint velocities less {self.rank} independent of {self.closure_equations} closure "
            f"equations) and {_many(self.actuators, 'actuated joint')}"
        ]
        if self.under_actuation:
            parts.append(
                f"under-actuated: with all of these locked, {', '.join(self.free_joints)} can "
                "still move"
            )
        if self.over_actuation:
            parts.append(
                f"over-actuated: the others determine {', '.join(self.dependent_actuators)}"
            )
        return "; ".join(parts)


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def mobility(
    model: pin.Model,
    constraint_models: Sequence[Any],
    actuated: Sequence[str],
    q: ArrayLike | None = None,
) -> Mobility:
    """Return the mobility of a tree with loops.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel
        The loop closures.
    actuated : sequence of str
        Names of the actuated joints.
    q : (nq,) array_like, optional
        A configuration that closes the loops, or nearly; ``neutral`` by default.

    Returns
    -------
    Mobility
        Degrees of freedom, rank and actuators. ``str`` gives a sentence.

    Raises
    ------
    UnknownName
        If the model has no joint of a given name.
    ClosureFailed
        If no configuration near ``q`` closes the loops.
    """
    for name in actuated:
        if not model.existJointName(name) or name == model.names[0]:
            raise UnknownName("actuated joint", name, tuple(model.names)[1:])
    motors = np.zeros((model.nv, len(actuated)))
    for column, name in enumerate(actuated):
        motors[model.joints[model.getJointId(name)].idx_v, column] = 1.0
    flat = flattened(model, constraint_models, NO_MOTORS)
    start = None if q is None else one_row("q", q, model.nq)
    found = structure(model, flat, start, motors, closure_names(constraint_models))
    return mobility_of(model, flat, found, motors, actuated)


def mobility_of(
    model: pin.Model, flat: FlatTree, found: Structure, motors: Array, actuated: Sequence[str]
) -> Mobility:
    """Return the mobility of a structure with the motors of a matrix (nv, m)."""
    motions, rank = found.motions[-1], found.rank
    names = list(model.names)
    # Motors cannot command joints of several degrees of freedom; the robot's constructor refuses
    # them.
    driven = motors.T @ motions
    commanded = rank_of_motions(driven, found.tolerance)
    return Mobility(
        degrees_of_freedom=model.nv - rank,
        actuators=len(actuated),
        commanded=commanded,
        joint_velocities=model.nv,
        closure_equations=int(flat.integers[ROWS]),
        rank=rank,
        free_joints=_moving(model, names, motions, driven, found.tolerance),
        dependent_actuators=_dependent(driven, list(actuated), found.tolerance),
    )


def _moving(
    model: pin.Model, names: list[str], motions: Array, driven: Array, tolerance: float
) -> tuple[str, ...]:
    """Return the joints that can move while no motor moves."""
    if not motions.shape[1]:
        return ()
    free = motions @ null_space(driven, tolerance, 1.0)
    return tuple(
        str(names[index])
        for index in range(1, model.njoints)
        if np.abs(
            free[model.joints[index].idx_v : model.joints[index].idx_v + model.joints[index].nv]
        ).max(initial=0.0)
        > max(1e-6, tolerance)
    )


def _dependent(driven: Array, actuated: list[str], tolerance: float) -> tuple[str, ...]:
    """Return the actuated joints whose motion the actuated joints before them determine."""
    names, rank = [], 0
    for count, name in enumerate(actuated, start=1):
        more = rank_of_motions(driven[:count], tolerance)
        if more == rank:
            names.append(name)
        rank = more
    return tuple(names)

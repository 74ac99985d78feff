r"""The unknowns of an identification: the numbers of a robot that are estimated.

They can be all standard parameters of its bodies, those of equal bodies once, or those of Table
3.1.

The standard parameters depend linearly on the unknowns :math:`\pi`, :math:`\theta = S\, \pi +
\theta_0`, where :math:`\theta_0` holds the known part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_kind, checked_names, checked_robot, one_row
from psp3.errors import InvalidValue, UnknownName
from psp3.identification.regressor import (
    PARAMETERS_OF_A_BODY,
    parameter_names,
    regressor,
    standard_parameters,
)
from psp3.robots.closed_loop_robot import ClosedLoopRobot


@dataclass(frozen=True, eq=False)
class Unknowns:
    r"""Numbers :math:`\pi` to identify, with the values in the robot's model.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    names : (p,) tuple of str
        Names of the unknowns.
    expansion : (10 B, p) ndarray
        The matrix S, see :func:`psp3.identification.regressor.standard_parameters`.
    believed : (p,) ndarray
        The values in the model.
    known : (10 B,) ndarray
        The part :math:`\theta_0` of the standard parameters that is known.
    """

    robot: ClosedLoopRobot
    names: tuple[str, ...]
    expansion: Array
    believed: Array
    known: Array

    def forces_of(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> tuple[Array, Array]:
        r"""Return the matrix :math:`Y S` (..., n, p) and :math:`Y \theta_0` (..., n).

        The first maps unknowns to actuator forces; the second is the forces of the known part.

        Arguments and errors are those of :func:`psp3.identification.regressor.regressor`.
        """
        full = regressor(self.robot, positions, speeds, accelerations)
        return full @ self.expansion, full @ self.known

    def expand(self, values: ArrayLike) -> Array:
        """Return the standard parameters (10 B,) that belong to values (p,) of the unknowns."""
        standard: Array = self.expansion @ one_row("values", values, len(self.names)) + self.known
        return standard

    def without(self, names: Sequence[str]) -> Unknowns:
        """Return the unknowns without some, which keep their values in the model.

        A parameter that feasible motions hardly determine is better taken from a drawing, because
        it would only make the other estimates less accurate.

        Raises
        ------
        UnknownName
            If there is no unknown of that name.
        """
        for name in checked_names("names", names):
            if name not in self.names:
                raise UnknownName("unknown", name, self.names)
        known = np.isin(self.names, list(names))
        left = tuple(name for name in self.names if name not in names)
        added = self.expansion[:, known] @ self.believed[known]
        return Unknowns(
            self.robot, left, self.expansion[:, ~known], self.believed[~known], self.known + added
        )


def all_parameters(robot: ClosedLoopRobot) -> Unknowns:
    """Return all ten standard parameters of every body as unknowns, masses last.

    Because masses are last, a mass that acts like a point mass on a moment joins the combination of
    that moment, and not the other way round.
    """
    names = parameter_names(robot)
    return _masses_last(
        Unknowns(robot, names, np.eye(len(names)), standard_parameters(robot), np.zeros(len(names)))
    )


def equal_bodies(robot: ClosedLoopRobot, groups: Sequence[Sequence[str]]) -> Unknowns:
    """Return the standard parameters of every body as unknowns, those of equal bodies once.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    groups : sequence of sequence of str
        Joints whose bodies are equal in the joints' own axes, for instance
        ``[("a1", "a2", "a3")]``.

    Returns
    -------
    Unknowns
        Named after the first body of each group, masses last; the model's values are the means over
        the groups.

    Raises
    ------
    UnknownName
        If the model has no such joint.
    InvalidValue
        If a joint is named twice, or a group is empty.
    """
    checked_robot(robot)
    checked_kind("groups", groups, (list, tuple), 'a list of groups, [("a1", "a2", "a3")]')
    groups = [checked_names("groups", group) for group in groups]
    joints = list(robot.model.names)[1:]
    named = [name for group in groups for name in group]
    for name in named:
        if name not in joints:
            raise UnknownName("joint", name, joints)
    if len(set(named)) != len(named) or not all(len(group) for group in groups):
        raise InvalidValue(
            "groups", groups, "groups of at least one joint, each joint in one of them"
        )
    first = {name: group[0] for group in groups for name in group}
    kept = list(dict.fromkeys(first.get(name, name) for name in joints))
    ties = np.array(
        [[first.get(name, name) == other for other in kept] for name in joints], dtype=np.float64
    )
    expansion = np.asarray(np.kron(ties, np.eye(10)), dtype=np.float64)
    believed = (expansion / expansion.sum(axis=0)).T @ standard_parameters(robot)
    names = tuple(f"{kind}({joint})" for joint in kept for kind in PARAMETERS_OF_A_BODY)
    return _masses_last(Unknowns(robot, names, expansion, believed, np.zeros(len(expansion))))


def _masses_last(unknowns: Unknowns) -> Unknowns:
    """Return ten unknowns for each body with the masses moved to the end."""
    order = np.argsort(
        np.arange(len(unknowns.names)) % len(PARAMETERS_OF_A_BODY) == 0, kind="stable"
    )
    names = tuple(unknowns.names[j] for j in order)
    return Unknowns(
        unknowns.robot,
        names,
        unknowns.expansion[:, order],
        unknowns.believed[order],
        unknowns.known,
    )

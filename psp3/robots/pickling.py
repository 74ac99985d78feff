"""Loop closures as plain numbers and back: Pinocchio pickles a tree, but not its constraints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import pinocchio as pin


class PlainClosure(NamedTuple):
    """The contents of a Pinocchio constraint model."""

    name: str
    kind: Any
    joints: tuple[int, int]
    placements: tuple[pin.SE3, pin.SE3]
    axes: Any
    gains: tuple[Any, Any]
    """Baumgarte gains for position and velocity."""


def plain(constraint_models: Iterable[Any]) -> list[PlainClosure]:
    """Return loop closures in a form that can be pickled.

    Parameters
    ----------
    constraint_models : iterable of pinocchio.RigidConstraintModel
        The loop closures.
    """
    return [
        PlainClosure(
            str(loop.name),
            loop.type,
            (int(loop.joint1_id), int(loop.joint2_id)),
            (loop.joint1_placement.copy(), loop.joint2_placement.copy()),
            loop.reference_frame,
            (loop.m_baumgarte_parameters.Kp, loop.m_baumgarte_parameters.Kd),
        )
        for loop in constraint_models
    ]


def constraints(model: pin.Model, closures: Iterable[PlainClosure]) -> Any:
    """Return loop closures as Pinocchio constraint models.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    closures : iterable of PlainClosure
        The result of :func:`plain`.

    Returns
    -------
    pinocchio.StdVec_RigidConstraintModel
    """
    models = pin.StdVec_RigidConstraintModel()
    for closure in closures:
        (one, other), (first, second) = closure.joints, closure.placements
        loop = pin.RigidConstraintModel(
            closure.kind, model, one, first, other, second, closure.axes
        )
        loop.name = closure.name
        loop.m_baumgarte_parameters.Kp, loop.m_baumgarte_parameters.Kd = closure.gains
        models.append(loop)
    return models

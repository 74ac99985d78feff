"""Turn a tree with closures into a robot: choose independent, held and dependent motions.

The loops are examined in the pose that closes them best. If a motion is to be kept and no joint of
the tree has it as its own, simple joints replace others, and the tree is examined again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from psp3.checks import Array, Indices
from psp3.closure.coordinates import Coordinates, chosen_coordinates
from psp3.closure.mobility import Mobility, mobility_of
from psp3.closure.ranges import Beyond, freed
from psp3.closure.structure import Structure, closure_names, structure
from psp3.errors import DependentCoordinates, MobilityMismatch
from psp3.multibody.flatten import NO_MOTORS, flattened
from psp3.robots.construction import motor_matrix
from psp3.robots.mismatch import refuse
from psp3.robots.simple_joints import (
    SimpleTree,
    base_in_loop,
    can_spin,
    of_several,
    parts_of_base,
    with_simple_joints,
)


class Assembly(NamedTuple):
    """A tree whose coordinates are chosen.

    ``motors`` (nv, m) are the joint velocities that each motor drives, and ``names`` are those of
    the closures. ``found`` holds the free motions and the pose that closes the loops, ``mobility``
    tells how many of the motions motors command, ``chosen`` holds the coordinates, and
    ``without_limits`` lists the joints that are out of range in this pose.
    """

    tree: SimpleTree
    motors: Array
    names: list[str]
    found: Structure
    mobility: Mobility
    chosen: Coordinates
    without_limits: tuple[Beyond, ...]

    @property
    def given(self) -> Array:
        """The given home, or the home that was found, (nq,)."""
        return self.found.home if self.tree.home is None else self.tree.home

    @property
    def dependent(self) -> Indices:
        """Velocities that depend on the coordinates."""
        nv = self.tree.model.nv
        return np.setdiff1d(np.arange(nv), [*self.chosen.speeds, *self.chosen.held])


def assembled(
    tree: SimpleTree,
    actuated: Sequence[str],
    options: Mapping[str, Any],
    kept: Sequence[str] = (),
) -> Assembly:
    """Choose the coordinates of a tree with its closures.

    Parameters
    ----------
    tree : SimpleTree
        The tree, its closures, and its home.
    actuated : sequence of str
        Names of the motors.
    options : mapping
        ``free``, ``coordinates``, ``springs`` and ``tendons`` of the robot.
    kept : sequence of str
        Joints that replace a base and become coordinates if possible.

    Raises
    ------
    UnknownName, InvalidValue, RoundedLoops, MobilityMismatch, DependentCoordinates
        See :class:`psp3.ClosedLoopRobot`.
    """
    model, free = tree.model, options["free"]
    motors = motor_matrix(model, actuated, options["tendons"] or {})
    every = [*tree.constraint_models, *tree.equations]
    names = closure_names(every)
    flat = flattened(model, every, NO_MOTORS)
    found = structure(model, flat, tree.home, motors, names)
    mobility = mobility_of(model, flat, found, motors, actuated)
    refuse(found, mobility, actuated, names)
    model, without_limits = freed(model, found.home)
    tree = tree._replace(model=model)
    base: int | None = None
    spins: list[Any] = []
    chains: list[int] = []
    try:
        chosen = chosen_coordinates(
            *(model, found, every, motors, free),
            *(options["coordinates"], options["springs"], kept),
        )
    except DependentCoordinates as error:
        base = base_in_loop(model, every)
        if error.joint or base is None:
            raise
    else:
        spins = [one for one in chosen.spins if free == "keep" and can_spin(model, one)]
        chains = of_several(model, chosen.speeds.tolist(), chosen.held)
    if spins or chains or base is not None:
        kept = kept if base is None else [*kept, *parts_of_base(model, base)]
        simple = with_simple_joints(tree._replace(home=found.home), spins, base, chains)
        return assembled(simple, actuated, options, kept)
    # A floating base is always kept.
    if not chosen.names or (free == "refuse" and chosen.locked):
        raise MobilityMismatch(mobility, actuated)
    return Assembly(tree, motors, names, found, mobility, chosen, without_limits)

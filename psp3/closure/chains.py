"""Links, their connections, and the chains from the base to the end effector.

The terms are those of section 2.2.13 of the thesis. A joint of several degrees of freedom counts as
a chain of joints with one each. Bodies that a loop file welds together are one link.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.closure.mobility import mobility
from psp3.errors import InvalidValue
from psp3.multibody.named_frames import frame_number

Link: TypeAlias = tuple[str, ...]
"""A link, represented by the names of the joints that carry it; ``universe`` carries the base.
Several joints carry a link of several welded bodies.
"""


def connection_degrees(model: pin.Model, constraint_models: Sequence[Any]) -> dict[Link, int]:
    """Return the connection degree of every link (section 2.2.13).

    It is the number of other links that joints attach to it: 2 along a chain, 1 at its free end,
    and 3 or more where chains meet.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel
        The loop closures: three equations are a ball joint, six are a weld.

    Returns
    -------
    dict
        The degrees by link, the base first.
    """
    neighbors = _neighbors(model, constraint_models)
    return {_named(model, link): len(others) for link, others in neighbors.items()}


def kinematic_chains(
    model: pin.Model, constraint_models: Sequence[Any], frame: str = "tip"
) -> tuple[Link, ...]:
    """Return the independent kinematic chains between the base and the end effector.

    Two chains are independent if they share only the base and the end effector. Branches that meet
    again, such as the two rods of a parallelogram, are one chain.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel
        The loop closures.
    frame : str
        A frame of the end effector.

    Returns
    -------
    tuple of tuple of str
        For every chain, the names of the joints that carry its links, except the end effector;
        empty for a chain of a single joint.

    Raises
    ------
    UnknownName
        If the model has no such frame.
    InvalidValue
        If the frame is fixed to the base.
    """
    neighbors = _neighbors(model, constraint_models)
    joint = model.frames[frame_number(model, frame)].parentJoint
    base, end = (next(link for link in neighbors if index in link) for index in (0, joint))
    if base == end:
        raise InvalidValue("frame", frame, "one that moves; this one is fixed to the base")
    chains: list[Link] = [()] if end in neighbors[base] else []
    waiting = [link for link in neighbors if link not in (base, end)]
    while waiting:
        chain, reached = {waiting[0]}, [waiting[0]]
        while reached:
            for other in neighbors[reached.pop()] - {base, end} - chain:
                chain.add(other)
                reached.append(other)
        waiting = [link for link in waiting if link not in chain]
        if all(neighbors[meeting] & chain for meeting in (base, end)):
            chains.append(_named(model, tuple(sorted(index for link in chain for index in link))))
    return tuple(chains)


def is_fully_parallel(
    model: pin.Model,
    constraint_models: Sequence[Any],
    actuated: Sequence[str],
    frame: str = "tip",
    q: ArrayLike | None = None,
) -> bool:
    """Return whether a robot is fully parallel (section 2.2.13).

    A robot is fully parallel if two or more independent chains carry the end effector, and if the
    number of chains equals its degrees of freedom and the number of motors, which command all of
    them.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel
        The loop closures.
    actuated : sequence of str
        Names of the actuated joints.
    frame : str
        A frame of the end effector.
    q : (nq,) array_like, optional
        A configuration that closes the loops, or nearly; ``neutral`` by default.

    Returns
    -------
    bool

    Raises
    ------
    UnknownName, InvalidValue
        See :func:`kinematic_chains`; also if the model has no joint of a given name.
    ClosureFailed
        If no configuration near ``q`` closes the loops.
    """
    chains = len(kinematic_chains(model, constraint_models, frame))
    found = mobility(model, constraint_models, actuated, q)
    return chains >= 2 and chains == found.degrees_of_freedom == found.actuators == found.commanded


def _neighbors(
    model: pin.Model, constraint_models: Sequence[Any]
) -> dict[tuple[int, ...], set[tuple[int, ...]]]:
    """Return the neighbors of each link; links are numbered as their joints."""
    welded = {index: {index} for index in range(model.njoints)}
    joined = [(index, model.parents[index]) for index in range(1, model.njoints)]
    for loop in constraint_models:
        ends = (loop.joint1_id, loop.joint2_id)
        if loop.type == pin.ContactType.CONTACT_6D:
            together = welded[ends[0]] | welded[ends[1]]
            welded |= dict.fromkeys(together, together)
        else:
            joined.append(ends)
    link_of = {index: tuple(sorted(together)) for index, together in welded.items()}
    neighbors: dict[tuple[int, ...], set[tuple[int, ...]]] = {
        link_of[index]: set() for index in range(model.njoints)
    }
    for one, other in joined:
        if link_of[one] != link_of[other]:
            neighbors[link_of[one]].add(link_of[other])
            neighbors[link_of[other]].add(link_of[one])
    return neighbors


def _named(model: pin.Model, link: tuple[int, ...]) -> Link:
    return tuple(str(model.names[index]) for index in link)

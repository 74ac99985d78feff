"""Select the pairs of links that can collide.

These are all pairs except those that touch where they are joined, and those that the SRDF excludes.

A pair of links is left out if:

* the links belong to one rigid body: fixed to each other, or joined by a 6D loop;
* a joint connects their bodies, or a loop connects them at a point;
* the SRDF excludes it: ``<disable_collisions link1="a" link2="b" reason="..."/>``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pinocchio as pin

from psp3.description.srdf import Exclusion
from psp3.errors import UnknownName
from psp3.robots.robot import Robot


def pairs_to_check(
    robot: Robot,
    links: Sequence[str],
    joints: Sequence[int],
    excluded: Iterable[Exclusion] = (),
) -> tuple[list[tuple[int, int]], list[Exclusion]]:
    """Return the pairs of shapes that can collide, and the pairs of links that were left out.

    Parameters
    ----------
    robot : Robot
        The robot.
    links : sequence of str
        The link of every shape.
    joints : sequence of int
        The joint that carries it, by its Pinocchio index; 0 is the base.
    excluded : iterable of Exclusion, optional
        Pairs of links to leave out in addition to those of the rule.

    Returns
    -------
    pairs : list of (int, int)
        Indices of shapes.
    exclusions : list of Exclusion

    Raises
    ------
    UnknownName
        If an excluded link does not exist.
    """
    known = [frame.name for frame in robot.model.frames if frame.type == pin.FrameType.BODY]
    others = {}
    for exclusion in excluded:
        for link in exclusion[:2]:
            if link not in known and link not in links:
                raise UnknownName("link", link, known)
        others[frozenset(exclusion[:2])] = exclusion
    joined = _Joined(robot)
    pairs: list[tuple[int, int]] = []
    exclusions: dict[frozenset[str], Exclusion] = {}
    for i, first in enumerate(links):
        for j, second in enumerate(links[i + 1 :], start=i + 1):
            both = frozenset((first, second))
            reason = joined.reason(joints[i], joints[j])
            if reason is not None:
                if first != second:
                    exclusions[both] = Exclusion(first, second, reason)
            elif both in others:
                exclusions[both] = others[both]
            else:
                pairs.append((i, j))
    return pairs, list(exclusions.values())


class _Joined:
    """The connections between the bodies of a robot."""

    def __init__(self, robot: Robot) -> None:
        model = robot.model
        self._body = list(range(model.njoints))
        point_loops = []
        for loop in robot.constraint_models:
            if loop.type == pin.ContactType.CONTACT_6D:
                one, other = self._body[loop.joint1_id], self._body[loop.joint2_id]
                self._body = [one if body == other else body for body in self._body]
            else:
                point_loops.append((loop.joint1_id, loop.joint2_id))
        self._reasons: dict[frozenset[int], str] = {}
        for one, other in point_loops:
            self._reasons[self._bodies(one, other)] = "joined at a point by a loop"
        for joint in range(1, model.njoints):
            self._reasons[self._bodies(model.parents[joint], joint)] = (
                f"joined by joint {model.names[joint]!r}"
            )

    def _bodies(self, *joints: int) -> frozenset[int]:
        return frozenset(self._body[joint] for joint in joints)

    def reason(self, one: int, other: int) -> str | None:
        """Return why the bodies on two joints always touch, or None if they do not."""
        bodies = self._bodies(one, other)
        return "one rigid body" if len(bodies) == 1 else self._reasons.get(bodies)

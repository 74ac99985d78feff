"""Loops of a Pinocchio tree as :mod:`psp3.closure.kernels` takes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.checks import Array, Indices
from psp3.closure.kernels import BALL, FREE, SCREW, UNBOUNDED, Table
from psp3.errors import UnsupportedJoint

CLOSURE_TOLERANCE = 1e-13
"""Residual at which loops count as closed, per meter of robot [m, rad]; Newton's method usually
ends at 1e-16.
"""


NO_MOTORS = np.zeros(0, dtype=np.int64)
"""For :func:`flattened`, where every joint counts as un-actuated."""


def flattened(model: pin.Model, constraint_models: Sequence[Any], actuated_v: Indices) -> Table:
    """Return the loops of a tree as the compiled kernels take them.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel
        The loop closures.
    actuated_v : (n,) ndarray of int
        Velocity indices of the actuated joints, in the order of the actuated coordinates.

    Returns
    -------
    Table
        Elements and closures, in groups that share no un-actuated joint.

    Raises
    ------
    UnsupportedJoint
        If a joint is not a chain of screws, a ball joint or a free flyer (mimic and planar joints
        are not).
    """
    elements, of_joint = _elements(model)
    closures = [_Closure(model, elements, of_joint, constraint) for constraint in constraint_models]
    motor = {int(v): number for number, v in enumerate(actuated_v)}
    groups = _groups(elements, closures, motor)
    return _table(elements, closures, groups, motor, _configuration_indices(model, actuated_v))


class _Element:
    """One joint, or one screw of a joint that is a chain of them."""

    def __init__(
        self, kind: int, parent: int, index_q: int, index_v: int, placement: pin.SE3, screw: Array
    ) -> None:
        self.kind, self.parent, self.index_q, self.index_v = kind, parent, index_q, index_v
        self.placement, self.screw = placement, screw

    @property
    def velocities(self) -> range:
        return range(self.index_v, self.index_v + {BALL: 3, FREE: 6}.get(self.kind, 1))

    @property
    def coordinates(self) -> range:
        return range(
            self.index_q, self.index_q + {UNBOUNDED: 2, BALL: 4, FREE: 7}.get(self.kind, 1)
        )


def _elements(model: pin.Model) -> tuple[list[_Element], list[int]]:
    """Return the elements of a tree, parents first, and the last element of joints.

    For every joint; −1 is the universe.
    """
    data, neutral = model.createData(), pin.neutral(model)
    pin.computeJointJacobians(model, data, neutral)
    elements: list[_Element] = []
    of_joint = [-1]
    for index in range(1, model.njoints):
        joint, name = model.joints[index], str(model.names[index])
        parent = of_joint[model.parents[index]]
        fixed = data.oMi[model.parents[index]].actInv(data.oMi[index])
        # Of a model with a single degree of freedom Pinocchio returns a vector.
        whole = pin.getJointJacobian(model, data, index, pin.ReferenceFrame.LOCAL).reshape(
            6, model.nv
        )
        axes = whole[:, joint.idx_v : joint.idx_v + joint.nv]
        if (joint.nq, joint.nv) == (4, 3) and "Spherical" in joint.shortname():
            elements.append(_Element(BALL, parent, joint.idx_q, joint.idx_v, fixed, np.zeros(6)))
        elif (joint.nq, joint.nv) == (7, 6) and "FreeFlyer" in joint.shortname():
            elements.append(_Element(FREE, parent, joint.idx_q, joint.idx_v, fixed, np.zeros(6)))
        elif (joint.nq, joint.nv) == (2, 1):
            elements.append(
                _Element(UNBOUNDED, parent, joint.idx_q, joint.idx_v, fixed, axes[:, 0].copy())
            )
        elif joint.nq == joint.nv and joint.nv > 0:
            # A chain of screws, each seen from the end of the chain, which lets the first carry the
            # whole fixed placement.
            for k in range(joint.nv):
                placement = fixed if k == 0 else pin.SE3.Identity()
                elements.append(
                    _Element(
                        SCREW,
                        parent,
                        joint.idx_q + k,
                        joint.idx_v + k,
                        placement,
                        axes[:, k].copy(),
                    )
                )
                parent = len(elements) - 1
        else:
            raise UnsupportedJoint(name, joint.shortname())
        of_joint.append(len(elements) - 1)
    _compare(model, elements, of_joint)
    return elements, of_joint


def _compare(model: pin.Model, elements: list[_Element], of_joint: list[int]) -> None:
    """Refuse a joint whose elements do not move as Pinocchio moves it."""
    data, rng = model.createData(), np.random.default_rng(0)
    q = pin.integrate(model, pin.neutral(model), rng.uniform(-0.5, 0.5, model.nv))
    pin.forwardKinematics(model, data, q)
    placements: list[pin.SE3] = []
    for element in elements:
        at = element.index_q
        if element.kind in (BALL, FREE):
            joint = pin.XYZQUATToSE3(
                np.concatenate([np.zeros(3), q[at : at + 4]])
                if element.kind == BALL
                else q[at : at + 7]
            )
        else:
            joint = pin.exp6(
                element.screw * (q[at] if element.kind == SCREW else np.arctan2(q[at + 1], q[at]))
            )
        parent = placements[element.parent] if element.parent >= 0 else pin.SE3.Identity()
        placements.append(parent * element.placement * joint)
    for index in range(1, model.njoints):
        ours, theirs = placements[of_joint[index]], data.oMi[index]
        # Every parent agrees, so the first joint that differs is the one that is not understood.
        if not np.allclose(
            ours.homogeneous,
            theirs.homogeneous,
            rtol=0.0,
            atol=1e-9 * (1.0 + np.abs(theirs.translation).max()),
        ):
            raise UnsupportedJoint(str(model.names[index]), model.joints[index].shortname())


class _Closure:
    """One closure: the two elements it joins.

    Its frames in them, and the elements on either side.
    """

    def __init__(
        self, model: pin.Model, elements: list[_Element], of_joint: list[int], constraint: Any
    ) -> None:
        self.ends = of_joint[constraint.joint1_id], of_joint[constraint.joint2_id]
        self.placements = constraint.joint1_placement, constraint.joint2_placement
        self.rows = 6 if constraint.type == pin.ContactType.CONTACT_6D else 3
        ways = [_way(elements, end) for end in self.ends]
        common = set(ways[0]) & set(ways[1])
        self.sides = {
            e: sign for way, sign in zip(ways, (-1, 1), strict=True) for e in way if e not in common
        }


def _way(elements: list[_Element], end: int) -> list[int]:
    """Return the elements from one to the root."""
    way = []
    while end >= 0:
        way.append(end)
        end = elements[end].parent
    return way


def _groups(
    elements: list[_Element], closures: list[_Closure], motor: dict[int, int]
) -> list[list[int]]:
    """Return the closures in groups that share un-actuated elements."""
    groups: list[tuple[set[int], list[int]]] = []
    for number, closure in enumerate(closures):
        passive = {e for e in closure.sides if elements[e].index_v not in motor}
        mine = [number]
        apart = []
        for others, members in groups:
            if passive & others:
                passive |= others
                mine = members + mine
            else:
                apart.append((others, members))
        groups = [*apart, (passive, mine)]
    return [sorted(members) for _, members in groups]


def _configuration_indices(model: pin.Model, velocities: Indices) -> Indices:
    joints = {joint.idx_v: joint.idx_q for joint in list(model.joints)[1:]}
    return np.array([joints[int(v)] for v in velocities], dtype=np.int64)


def _flat(placement: pin.SE3) -> Array:
    return np.concatenate([placement.rotation.ravel(), placement.translation])


def _table(
    elements: list[_Element],
    closures: list[_Closure],
    groups: list[list[int]],
    motor: dict[int, int],
    actuated_q: Indices,
) -> Table:
    ends: dict[str, list[int]] = {
        "elements": [0],
        "closures": [0],
        "columns": [0],
        "actuated": [0],
        "coordinates": [0],
    }
    columns: list[int] = []
    actuated: list[int] = []
    places: list[int] = []
    coordinates: list[int] = []
    rows: list[tuple[int, int, int, int, int]] = []
    placements, screws, joined, heights, frames, sides, tolerances = [], [], [], [], [], [], []
    for members in groups:
        own = sorted({e for number in members for e in closures[number].sides})
        local = {e: place for place, e in enumerate(own)}
        first_column, first_actuated, first_coordinate = (
            len(columns),
            len(actuated),
            len(coordinates),
        )
        size = 1.0
        for e in own:
            element = elements[e]
            place = len(coordinates) - first_coordinate
            coordinates.extend(element.coordinates)
            if element.index_v in motor:
                places.append(place)
                column = -1 - (len(actuated) - first_actuated)
                actuated.append(motor[element.index_v])
            else:
                column = len(columns) - first_column
                columns.extend(element.velocities)
            rows.append(
                (element.kind, local.get(element.parent, -1), place, element.index_v, column)
            )
            placements.append(_flat(element.placement))
            screws.append(element.screw)
            size += float(np.linalg.norm(element.placement.translation))
        for number in members:
            closure = closures[number]
            joined.append([local.get(end, -1) for end in closure.ends])
            heights.append(closure.rows)
            frames.append([_flat(placement) for placement in closure.placements])
            sides.append([closure.sides.get(e, 0) for e in own])
        tolerances.append(CLOSURE_TOLERANCE * size)
        for key, values in (
            ("elements", rows),
            ("closures", joined),
            ("columns", columns),
            ("actuated", actuated),
            ("coordinates", coordinates),
        ):
            ends[key].append(len(values))
    widest = max((len(side) for side in sides), default=0)
    side_table = np.zeros((len(sides), widest), dtype=np.int64)
    for side_row, side in zip(side_table, sides, strict=True):
        side_row[: len(side)] = side
    numbers = np.array(rows, dtype=np.int64).reshape(-1, 5)
    return Table(
        np.array(ends["elements"], dtype=np.int64),
        np.array(ends["closures"], dtype=np.int64),
        np.array(ends["columns"], dtype=np.int64),
        np.array(ends["actuated"], dtype=np.int64),
        np.array(ends["coordinates"], dtype=np.int64),
        np.array(columns, dtype=np.int64),
        np.array(actuated, dtype=np.int64),
        np.array(places, dtype=np.int64),
        np.array(coordinates, dtype=np.int64),
        actuated_q,
        np.ascontiguousarray(numbers[:, 0]),
        np.ascontiguousarray(numbers[:, 1]),
        np.ascontiguousarray(numbers[:, 2]),
        np.ascontiguousarray(numbers[:, 3]),
        np.ascontiguousarray(numbers[:, 4]),
        np.array(placements, dtype=float).reshape(-1, 12),
        np.array(screws, dtype=float).reshape(-1, 6),
        np.array(joined, dtype=np.int64).reshape(-1, 2),
        np.array(heights, dtype=np.int64),
        np.array(frames, dtype=float).reshape(-1, 2, 12),
        side_table,
        np.array(tolerances, dtype=float),
    )

"""Convert a Pinocchio tree with closures to the flat arrays of :mod:`psp3.multibody.tree`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from psp3.checks import Array, Indices, checked_kind, one_row
from psp3.errors import InvalidValue, UnsupportedJoint
from psp3.multibody.equations import Coupling, Hinge, Spin
from psp3.multibody.tree import (
    ARMATURE,
    BALL,
    CLOSURE_NUMBERS,
    CLOSURES,
    COORDINATES,
    COUPLING,
    DAMPING,
    DEPENDENT,
    DRIVEN,
    ELEMENT_NUMBERS,
    ELEMENTS,
    FACTORS,
    FRAME,
    FREE,
    FRICTION,
    GROUPS,
    HEADER,
    HINGE,
    INDEPENDENT,
    JOINT_NUMBERS,
    LARGEST_DEGREE,
    LOCKED,
    MEMORY_PARTS,
    PLANAR,
    POINT,
    POSITIONS,
    ROWS,
    ROWS_OF_KIND,
    SCREW,
    SPIN,
    STIFFNESS,
    UNBOUNDED,
    VELOCITIES,
)

CLOSURE_TOLERANCE = 1e-15
"""Residual at which loops count as closed, per meter of robot [m, rad]: a few rounding errors. A
value ten times larger would save at most a twentieth of a call, and cost two digits of the 3-RRR's
dynamics.
"""

LARGEST_RESIDUAL = 1e-11
"""Residual that loops may keep if Newton's method cannot reduce it, per meter of robot [m, rad]."""


Springs = Mapping[str, tuple[float, float]]
"""Stiffness and rest of joints of one degree of freedom, by name [N/m, m or N m, rad]."""

NO_MOTORS = np.zeros(0, dtype=np.int64)
"""An argument of :func:`flattened`: no joint is independent."""


Flags = NDArray[np.bool_]


class FlatTree(NamedTuple):
    """The arrays of a tree, and Python functions that read them."""

    integers: Indices
    numbers: Array
    closure_rows: list[int]
    """Equations of each closure, in the order of the groups."""
    order: list[int]
    """The index of each closure among the given ones."""
    is_length: Flags
    """For each equation, whether it is a length [m] and not an angle."""
    sliding: Flags
    """For each velocity, whether it is a length per time."""


class _Element:
    """One joint, or one screw of a joint that is a chain of them."""

    def __init__(
        self, kind: int, parent: int, index_q: int, index_v: int, placement: pin.SE3, screw: Array
    ) -> None:
        self.kind, self.parent, self.index_q, self.index_v = kind, parent, index_q, index_v
        self.placement, self.screw = placement, screw
        self.inertia: pin.Inertia | None = None

    @property
    def freedoms(self) -> int:
        return {BALL: 3, PLANAR: 3, FREE: 6}.get(self.kind, 1)

    @property
    def velocities(self) -> range:
        return range(self.index_v, self.index_v + self.freedoms)


CLOSING = (pin.RigidConstraintModel, Hinge, Coupling, Spin)
"""Kinds of closures."""


class _Closure:
    """One closure: its ends, its numbers, and the elements on either side."""

    def __init__(self, elements: list[_Element], of_joint: list[int], constraint: Any) -> None:
        self.numbers = np.zeros(CLOSURE_NUMBERS)
        self.speed = 0
        if isinstance(constraint, Coupling):
            self._couple(elements, of_joint, constraint)
            return
        if isinstance(constraint, Spin):
            self._hold(elements, of_joint, constraint)
            return
        if isinstance(constraint, Hinge):
            self.kind = HINGE
        else:
            self.kind = FRAME if constraint.type == pin.ContactType.CONTACT_6D else POINT
        self.is_length = [True] * 3 + [False] * (ROWS_OF_KIND[self.kind] - 3)
        self.ends = of_joint[constraint.joint1_id], of_joint[constraint.joint2_id]
        self.numbers[:12] = _flat(constraint.joint1_placement)
        self.numbers[12:] = _flat(constraint.joint2_placement)
        ways = [_way(elements, end) for end in self.ends]
        common = set(ways[0]) & set(ways[1])
        self.sides = {
            e: sign for way, sign in zip(ways, (-1, 1), strict=True) for e in way if e not in common
        }

    def _couple(self, elements: list[_Element], of_joint: list[int], coupling: Coupling) -> None:
        follows, leads = of_joint[coupling.y], of_joint[coupling.x]
        self.kind, self.ends = COUPLING, (elements[follows].index_q, elements[leads].index_q)
        self.speed = elements[leads].index_v
        self.numbers[: len(coupling.coefficients)] = coupling.coefficients
        assert len(coupling.coefficients) <= LARGEST_DEGREE + 1
        self.is_length = [not elements[follows].screw[3:].any()]
        # A coupling that holds a joint names that joint twice, and the later entry counts.
        self.sides = {leads: -1, follows: 1}

    def _hold(self, elements: list[_Element], of_joint: list[int], spin: Spin) -> None:
        ball = of_joint[spin.joint]
        self.kind, self.ends = SPIN, (elements[ball].index_q, 0)
        self.speed = elements[ball].index_v
        self.numbers[:3], self.numbers[3:7] = spin.axis, spin.quaternion
        self.is_length = [False]
        self.sides = {ball: 1}


def flattened(
    model: pin.Model,
    constraint_models: Sequence[Any],
    independent_v: Indices,
    locked_v: Sequence[int] = (),
    springs: Springs | None = None,
) -> FlatTree:
    """Return a tree with loops as arrays for the compiled kernels.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel, Hinge, Coupling or Spin
        The loop closures.
    independent_v : (n,) ndarray of int
        Velocity indices of the independent joints, in the order of the independent coordinates:
        first those of joints of one degree of freedom.
    locked_v : sequence of int
        Velocities that are held at zero.
    springs : mapping of str to (float, float), optional
        Stiffness and rest of joints [N/m, m or N m, rad].

    Returns
    -------
    FlatTree
        Elements and closures, in groups that share no dependent joint.

    Raises
    ------
    UnsupportedJoint
        If a joint is not a chain of screws, a ball joint, a planar joint or a free flyer.
    """
    checked_kind("model", model, pin.Model, "a pinocchio.Model")
    vector = pin.StdVec_RigidConstraintModel
    checked_kind("constraint_models", constraint_models, (list, tuple, vector), "a list of loops")
    for loop in constraint_models:
        checked_kind("constraint_models", loop, CLOSING, "RigidConstraintModels and the like")
    checked_kind("springs", springs, (Mapping, type(None)), "stiffness and rest by joints")
    for name, numbers in (springs or {}).items():
        one_row(f"springs[{name!r}]", numbers, 2)
    chosen = _checked_places("independent_v", independent_v, model.nv)
    held = set(_checked_places("locked_v", locked_v, model.nv))
    elements, of_joint = _elements(model)
    closures = [_Closure(elements, of_joint, constraint) for constraint in constraint_models]
    independent = {v: number for number, v in enumerate(chosen)}
    groups = _groups(elements, closures, independent, held)
    return _packed(model, elements, closures, groups, independent, held, springs or {})


def _checked_places(name: str, places: Any, count: int) -> list[int]:
    """Return places among velocities; raise :class:`InvalidValue` if they are not valid."""
    found = places.tolist() if type(places) is np.ndarray else places
    wanted = f"whole numbers below {count}"
    checked_kind(name, found, (list, tuple), wanted)
    for place in found:
        if isinstance(place, bool) or not isinstance(place, int | np.integer):
            raise InvalidValue(name, place, wanted)
        if not 0 <= place < count:
            raise InvalidValue(name, place, wanted)
    return [int(place) for place in found]


def _elements(model: pin.Model) -> tuple[list[_Element], list[int]]:
    """Return the elements of a tree, parents first, and the last element of joints.

    The latter is listed for every joint; −1 is the universe.
    """
    data, neutral = model.createData(), pin.neutral(model)
    pin.computeJointJacobians(model, data, neutral)
    elements: list[_Element] = []
    of_joint = [-1]
    for index in range(1, model.njoints):
        joint, name = model.joints[index], str(model.names[index])
        parent = of_joint[model.parents[index]]
        fixed = data.oMi[model.parents[index]].actInv(data.oMi[index])
        # For a model with a single degree of freedom Pinocchio returns a vector.
        whole = pin.getJointJacobian(model, data, index, pin.ReferenceFrame.LOCAL).reshape(
            6, model.nv
        )
        axes = whole[:, joint.idx_v : joint.idx_v + joint.nv]
        kind = _kind(joint)
        if kind in (BALL, FREE, PLANAR):
            elements.append(_Element(kind, parent, joint.idx_q, joint.idx_v, fixed, np.zeros(6)))
        elif kind == UNBOUNDED:
            elements.append(
                _Element(UNBOUNDED, parent, joint.idx_q, joint.idx_v, fixed, axes[:, 0].copy())
            )
        elif joint.nq == joint.nv and joint.nv > 0:
            # A chain of screws, each in the axes at the end of the chain, so that the first can
            # hold the whole fixed placement.
            for k in range(joint.nv):
                placement = fixed if k == 0 else pin.SE3.Identity()
                at = joint.idx_q + k, joint.idx_v + k
                elements.append(_Element(SCREW, parent, *at, placement, axes[:, k].copy()))
                parent = len(elements) - 1
        else:
            raise UnsupportedJoint(name, joint.shortname())
        elements[-1].inertia = model.inertias[index]
        of_joint.append(len(elements) - 1)
    _compare(model, elements, of_joint)
    return elements, of_joint


def _kind(joint: Any) -> int:
    """Return the kind of a joint's element, or ``SCREW``."""
    if (joint.nq, joint.nv) == (4, 3) and "Spherical" in joint.shortname():
        return BALL
    if (joint.nq, joint.nv) == (7, 6) and "FreeFlyer" in joint.shortname():
        return FREE
    if (joint.nq, joint.nv) == (4, 3) and "Planar" in joint.shortname():
        return PLANAR
    return UNBOUNDED if (joint.nq, joint.nv) == (2, 1) else SCREW


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
        elif element.kind == PLANAR:
            turn = pin.exp3(np.array([0.0, 0.0, np.arctan2(q[at + 3], q[at + 2])]))
            joint = pin.SE3(turn, np.array([q[at], q[at + 1], 0.0]))
        else:
            joint = pin.exp6(
                element.screw * (q[at] if element.kind == SCREW else np.arctan2(q[at + 1], q[at]))
            )
        parent = placements[element.parent] if element.parent >= 0 else pin.SE3.Identity()
        placements.append(parent * element.placement * joint)
    for index in range(1, model.njoints):
        ours, theirs = placements[of_joint[index]], data.oMi[index]
        turn = np.linalg.norm(elements[of_joint[index]].screw[3:])
        # All parents agree, so the first joint that differs is the unsupported one. Kernels assume
        # that the rotation of a screw has unit length.
        if min(turn, abs(turn - 1.0)) > 1e-12 or not np.allclose(
            ours.homogeneous,
            theirs.homogeneous,
            rtol=0.0,
            atol=1e-9 * (1.0 + np.abs(theirs.translation).max()),
        ):
            raise UnsupportedJoint(str(model.names[index]), model.joints[index].shortname())


def _way(elements: list[_Element], end: int) -> list[int]:
    """Return the elements from a given one to the root."""
    way = []
    while end >= 0:
        way.append(end)
        end = elements[end].parent
    return way


def _groups(
    elements: list[_Element],
    closures: list[_Closure],
    independent: dict[int, int],
    held: set[int],
) -> list[list[int]]:
    """Return the closures in groups that share dependent elements."""
    groups: list[tuple[set[int], list[int]]] = []
    for number, closure in enumerate(closures):
        passive = {
            e
            for e in closure.sides
            if elements[e].index_v not in independent and elements[e].index_v not in held
        }
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


def _flat(placement: pin.SE3) -> Array:
    return np.concatenate([placement.rotation.ravel(), placement.translation])


def _body(element: _Element) -> tuple[bool, Array]:
    """Return whether an element has mass, and its numbers."""
    numbers = np.zeros(ELEMENT_NUMBERS)
    numbers[:12], numbers[12:18] = _flat(element.placement), element.screw
    if element.inertia is not None:
        moments = element.inertia.inertia
        numbers[18], numbers[19:22] = element.inertia.mass, element.inertia.lever
        numbers[22:] = moments[np.triu_indices(3)]
    return bool(numbers[18:].any()), numbers


class _Group:
    """The arrays of one group."""

    def __init__(
        self, elements: list[_Element], closures: list[_Closure], members: list[int]
    ) -> None:
        self.closures = members
        shares: dict[int, int] = {}
        for number in members:
            for e in closures[number].sides:
                shares[e] = shares.get(e, 0) + 1
        self.elements = sorted(shares)
        # Elements that many closures share come last, so that the reflections of one leg do not
        # change the columns of the others.
        first = {
            e: min(k for k, number in enumerate(members) if e in closures[number].sides)
            for e in self.elements
        }
        self.order = sorted(self.elements, key=lambda e: (shares[e], first[e], e))


def _packed(
    model: pin.Model,
    elements: list[_Element],
    closures: list[_Closure],
    groups: list[list[int]],
    independent: dict[int, int],
    held: set[int],
    springs: Springs,
) -> FlatTree:
    """Return the arrays of a tree from its parts."""
    order = [number for members in groups for number in members]
    columns = np.full(model.nv, LOCKED, dtype=np.int64)
    for v, number in independent.items():
        columns[v] = -1 - number
    dependent: list[int] = []
    members_list: list[int] = []
    paths: list[tuple[int, ...]] = []
    drivers: list[int] = []
    table: list[list[int]] = []
    closure_rows: dict[int, int] = {}
    tolerances: list[float] = []
    ends: list[int] = []
    row = factor_at = driven_at = 0
    for members in groups:
        group = _Group(elements, closures, members)
        own = [v for e in group.elements for v in elements[e].velocities if v in independent]
        driver = {v: place for place, v in enumerate(own)}
        first = len(dependent)
        for e in group.order:
            for v in elements[e].velocities:
                if v not in independent and v not in held:
                    columns[v] = len(dependent)
                    dependent.append(v)
        rows = 0
        entry = [len(members_list), len(closure_rows), len(paths), len(drivers), row, first]
        for number in members:
            closure_rows[number] = rows
            for e, sign in sorted(closures[number].sides.items()):
                for v in elements[e].velocities:
                    if v in held:
                        continue
                    column = -1 - driver[v] if v in driver else int(columns[v]) - first
                    paths.append((order.index(number), v, sign, column, e))
            rows += ROWS_OF_KIND[closures[number].kind]
        count = len(dependent) - first
        ends += _ends(
            rows,
            count,
            {
                (closure_rows[order[path[0]]] + i, path[3])
                for path in paths[entry[2] :]
                if path[3] >= 0
                for i in range(ROWS_OF_KIND[closures[order[path[0]]].kind])
            },
        )
        entry += [rows, count, len(own), factor_at, driven_at, int(rows == count)]
        table.append(entry)
        members_list += group.elements
        drivers += [independent[v] for v in own]
        row, factor_at, driven_at = (
            row + rows,
            factor_at + rows * count,
            driven_at + rows * len(own),
        )
        size = 1.0 + sum(
            float(np.linalg.norm(elements[e].placement.translation)) for e in group.elements
        )
        tolerances += [LARGEST_RESIDUAL * size, CLOSURE_TOLERANCE * size, 0.0, 0.0, 0.0]
    last = [len(members_list), len(closures), len(paths), len(drivers), row, len(dependent)]
    table.append([*last, 0, 0, 0, factor_at, driven_at, 0])
    # The list of members ends with all elements.
    members_list += range(len(elements))
    bodies = [_body(element) for element in elements]
    places = [place for v in independent for place in _coordinates(elements, v)]
    element_rows = [(e.kind, e.parent, e.index_q, e.index_v, e.freedoms) for e in elements]
    joined = [
        (closures[k].kind, *closures[k].ends, closure_rows[k], closures[k].speed) for k in order
    ]
    massive = [e for e, (has_mass, _) in enumerate(bodies) if has_mass]
    counts = [
        len(elements),
        len(massive),
        len(closures),
        len(groups),
        len(members_list),
        len(paths),
    ]
    counts += [len(drivers), model.nq, model.nv, len(independent), len(dependent), row]
    counts += [factor_at, driven_at, len(places), _floating(elements)]
    integers = [
        np.reshape(element_rows, -1),
        massive,
        np.reshape(joined, -1),
        np.reshape(table, -1),
        members_list,
        np.reshape(paths, -1),
        drivers,
        columns,
        places,
        list(independent),
        dependent,
        ends,
    ]
    joints = np.zeros((model.nv, JOINT_NUMBERS))
    joints[:, ARMATURE], joints[:, DAMPING] = model.armature, model.damping
    joints[:, FRICTION] = model.upperDryFrictionLimit
    rests = np.zeros(model.nq)
    for name, (stiffness, rest) in springs.items():
        joint = model.joints[model.getJointId(name)]
        joints[joint.idx_v, STIFFNESS], rests[joint.idx_q] = stiffness, rest
    numbers = [
        [number for _, row_numbers in bodies for number in row_numbers],
        [number for k in order for number in closures[k].numbers],
        tolerances,
        joints.ravel(),
        rests,
        _limits(model, independent).ravel(),
        model.gravity.linear,
    ]
    offsets = [*_begins(integers, HEADER), *_begins(numbers, 0), *_memory_begins(counts)]
    return FlatTree(
        np.concatenate([np.asarray(part, dtype=np.int64) for part in (counts, offsets, *integers)]),
        np.concatenate([np.asarray(part, dtype=np.float64) for part in numbers]),
        [ROWS_OF_KIND[closures[k].kind] for k in order],
        order,
        np.array([length for k in order for length in closures[k].is_length], dtype=bool),
        _sliding(model, elements),
    )


def _floating(elements: list[_Element]) -> int:
    """Return the element of a floating base, or −1."""
    for e, element in enumerate(elements):
        if element.parent < 0 and element.kind in (FREE, PLANAR):
            return e
    return -1


def _coordinates(elements: list[_Element], velocity: int) -> list[int]:
    """Return the places of the coordinates that belong to an independent velocity.

    All coordinates of a free flyer or a planar joint belong to its first velocity.
    """
    for element in elements:
        if velocity in element.velocities:
            if element.kind in (FREE, PLANAR):
                at, count = element.index_q, 7 if element.kind == FREE else 4
                return list(range(at, at + count)) if velocity == element.index_v else []
            return [element.index_q]
    raise IndexError(velocity)


def _sliding(model: pin.Model, elements: list[_Element]) -> Flags:
    """Return for each velocity whether it is a length per time."""
    sliding = np.zeros(model.nv, dtype=bool)
    for element in elements:
        if element.kind == FREE:
            sliding[element.index_v : element.index_v + 3] = True
        elif element.kind == PLANAR:
            sliding[element.index_v : element.index_v + 2] = True
        elif element.kind == SCREW:
            sliding[element.index_v] = not element.screw[3:].any()
    return sliding


def _ends(rows: int, columns: int, entries: set[tuple[int, int]]) -> list[int]:
    """Return the row below the last entry of each column of a group's factored Jacobian.

    A reflection fills all rows that it combines.
    """
    filled = np.zeros((rows, columns), dtype=bool)
    for row, column in entries:
        filled[row, column] = True
    ends = []
    for k in range(columns):
        below = np.flatnonzero(filled[k:, k])
        end = k + 1 + (int(below[-1]) if len(below) else 0)
        ends.append(max(end, k + 1))
        touched = filled[k:end, k + 1 :].any(axis=0)
        filled[k:end, k + 1 :] |= touched
    return ends


def _limits(model: pin.Model, independent: dict[int, int]) -> Array:
    """Return the lowest and highest value of every coordinate, (nq, 2).

    Trajectories and the simulation check the limits of independent joints.
    """
    limits = np.tile([-np.inf, np.inf], (model.nq, 1))
    for joint in list(model.joints)[1:]:
        if joint.nq == 1 and joint.idx_v not in independent:
            limits[joint.idx_q] = (
                model.lowerPositionLimit[joint.idx_q],
                model.upperPositionLimit[joint.idx_q],
            )
    return limits


def _begins(parts: Sequence[Any], first: int) -> list[int]:
    """Return where each part begins if the parts follow each other, starting at ``first``."""
    return [first + sum(len(part) for part in parts[:number]) for number in range(len(parts))]


def _memory_begins(counts: list[int]) -> list[int]:
    """Return where each part of the memory begins, and its size."""
    elements, closures, groups, dependent = (
        counts[ELEMENTS],
        counts[CLOSURES],
        counts[GROUPS],
        counts[DEPENDENT],
    )
    n, nq, nv, rows = counts[INDEPENDENT], counts[COORDINATES], counts[VELOCITIES], counts[ROWS]
    positions = counts[POSITIONS]
    factors, driven, twists = counts[FACTORS], counts[DRIVEN], 6 * (elements + 1)
    sizes = [nq, 3, 12 * elements, 6 * nv, 24 * closures, factors, dependent, driven, groups]
    sizes += [
        factors,
        dependent,
        nq,
        positions,
        positions,
        rows,
        max(rows, dependent),
        dependent,
        dependent,
        9,
    ]
    sizes += [
        dependent * dependent,
        nv,
        nv,
        nv,
        10 * elements,
        twists,
        twists,
        twists,
        n * twists,
        n * twists,
    ]
    sizes += [n * nv, n * nv, n * n, 8 * n, 4]
    sizes += [twists, twists, 12 * elements, twists, 6 * closures, nv, n * n, n * n, 42]
    assert len(sizes) == MEMORY_PARTS
    return [sum(sizes[:number]) for number in range(len(sizes) + 1)]

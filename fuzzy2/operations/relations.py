r"""Fuzzy relations on discrete universes: Cartesian products and compositions (eq. 1.61, 1.62).

A relation on U x V is an array over both universes, and a set on U is an array over one. The
entries determine the kind of a set or relation:

=================  ===================  =======================================================
kind               relation             entries
=================  ===================  =======================================================
type-1             (U, V)               grades in [0, 1]
interval type-2    (U, V, 2)            lower and upper grades
general type-2     (U, V) of objects    secondary memberships, `Type1Set`; nested lists will do
=================  ===================  =======================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.operations.join_meet import TConormLike, TNormLike, join, meet, negation
from fuzzy2.operations.t_norms import TNorm
from fuzzy2.operations.t_norms import t_conorm as as_t_conorm
from fuzzy2.operations.t_norms import t_norm as as_t_norm
from fuzzy2.sets.shapes import Interval
from fuzzy2.sets.type1 import Singleton, Type1Set
from fuzzy2.support.checks import Array, reals

Kind: TypeAlias = Literal["type-1", "interval", "general"]
Relation: TypeAlias = NDArray[Any]
RelationLike: TypeAlias = ArrayLike | Sequence[Type1Set] | Sequence[Sequence[Type1Set]]

_ORDER: tuple[Kind, ...] = ("type-1", "interval", "general")
# Triples (u, v, w) that are combined at once: 32 MiB.
_CHUNK = 1 << 22


def _objects(value: RelationLike) -> Relation:
    """Return sets in an array of objects.

    A set that has a length must not be taken for a row of numbers.
    """
    if isinstance(value, np.ndarray):
        return value

    def shape_of(level: Any) -> tuple[int, ...]:
        if isinstance(level, Type1Set):
            return ()
        lengths = {shape_of(item) for item in level}
        if len(lengths) != 1:
            raise InvalidValue(
                "a relation", value, "rows of the same number of secondary memberships"
            )
        return (len(level), *lengths.pop())

    result = np.empty(shape_of(value), dtype=object)
    for index in np.ndindex(result.shape):
        item: Any = value
        for k in index:
            item = item[k]
        result[index] = item
    return result


def _holds_sets(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.dtype == object and all(isinstance(item, Type1Set) for item in value.ravel())
    if isinstance(value, Type1Set):
        return True
    return (
        isinstance(value, list | tuple)
        and len(value) > 0
        and all(_holds_sets(item) for item in value)
    )


def _checked(name: str, value: RelationLike, universes: int) -> tuple[Kind, Relation]:
    """Return the kind of a set (one universe) or a relation, and its array."""
    shape = {1: "(U,)", 2: "(U, V)"}[universes]
    requirement = (
        f"grades in [0, 1] of shape {shape}, intervals of shape {shape[:-1].rstrip(',')}, 2), or "
        f"secondary memberships {shape}"
    )
    if _holds_sets(value):
        secondaries = _objects(value)
        if secondaries.ndim != universes or secondaries.size == 0:
            raise InvalidValue(name, secondaries.shape, requirement)
        return "general", secondaries
    try:
        grades = reals("a relation", cast("ArrayLike", value))
    except (TypeError, ValueError) as error:
        raise InvalidValue(name, value, requirement) from error
    kind: Kind = "type-1" if grades.ndim == universes else "interval"
    if (
        grades.size == 0
        or grades.ndim not in (universes, universes + 1)
        or (kind == "interval" and grades.shape[-1] != 2)
    ):
        raise InvalidValue(name, grades.shape, requirement)
    if not ((grades >= 0.0) & (grades <= 1.0)).all() or (
        kind == "interval" and (grades[..., 0] > grades[..., 1]).any()
    ):
        raise InvalidValue(name, grades, requirement)
    return kind, grades


def _dimensions(value: RelationLike) -> int:
    try:
        return (
            _objects(value).ndim
            if _holds_sets(value)
            else reals("a relation", cast("ArrayLike", value)).ndim
        )
    except (TypeError, ValueError) as error:
        raise InvalidValue("R", value, "numbers, or secondary memberships") from error


def _promoted(kind: Kind, value: Relation, to: Kind) -> Relation:
    """Return a set or relation converted to a more general kind."""
    if kind == "type-1" and to == "interval":
        return np.stack([value, value], axis=-1)
    if kind == to:
        return value
    shape = value.shape if kind == "type-1" else value.shape[:-1]
    result = np.empty(shape, dtype=object)
    for index in np.ndindex(shape):
        result[index] = (
            Singleton(float(value[index]))
            if kind == "type-1"
            else Interval(*(float(end) for end in value[index]))
        )
    return result


def _in_order(kind: Kind, value: Relation) -> Relation:
    """Return the array with all ends in order, which rounding may have swapped."""
    return np.sort(value, axis=-1) if kind == "interval" else value


def _same_kind(operands: Sequence[tuple[Kind, Relation]]) -> tuple[Kind, list[Relation]]:
    kind = max((kind for kind, _ in operands), key=_ORDER.index)
    return kind, [_promoted(own, value, kind) for own, value in operands]


def cartesian_product(
    *sets: RelationLike, t_norm: TNormLike = "min", grade_t_norm: TNormLike | None = None
) -> Relation:
    r"""Return the Cartesian product of sets on discrete universes.

    .. math:: \mu_{F_1 \times \cdots \times F_n}(x_1, \ldots, x_n)
              = \mu_{F_1}(x_1) \sqcap \cdots \sqcap \mu_{F_n}(x_n)

    Parameters
    ----------
    *sets : (U_i,) or (U_i, 2) array_like, or sequence of U_i Type1Set
        Sets of any of the three kinds. The product has the most general kind among them.
    t_norm, grade_t_norm : str, TNorm or callable
        As in `fuzzy2.meet`; the second is used for general type-2 sets only.

    Returns
    -------
    (U_1, ..., U_n) or (U_1, ..., U_n, 2) array
        Grades, intervals or secondary memberships.

    Raises
    ------
    InvalidValue
        If a set is not of one of the three kinds.
    """
    if not sets:
        raise InvalidValue("sets", sets, "at least one set")
    as_t_norm(t_norm if grade_t_norm is None else grade_t_norm)
    kind, operands = _same_kind([_checked("a set", one, 1) for one in sets])
    shape = tuple(operand.shape[0] for operand in operands)
    if kind == "general":
        result = np.empty(shape, dtype=object)
        for index in np.ndindex(shape):
            slices = [operand[k] for operand, k in zip(operands, index, strict=True)]
            result[index] = meet(*slices, t_norm=t_norm, grade_t_norm=grade_t_norm)
        return result
    norm, n = as_t_norm(t_norm), len(operands)
    aligned = [
        operand.reshape(*(shape[k] if k == j else 1 for j in range(n)), *operand.shape[1:])
        for k, operand in enumerate(operands)
    ]
    return _in_order(kind, norm(*np.broadcast_arrays(*aligned)))


def _sup_star(R: Array, S: Array, norm: TNorm) -> Array:
    """Return the sup-star composition of (U, V) and (V, W) grades, in blocks of rows."""
    step = max(1, _CHUNK // S.size)
    blocks = [
        norm(R[k : k + step, :, None], S[None]).max(axis=1) for k in range(0, R.shape[0], step)
    ]
    return np.concatenate(blocks)


def compose(
    R: RelationLike,
    S: RelationLike,
    t_norm: TNormLike = "min",
    grade_t_norm: TNormLike | None = None,
) -> Relation:
    r"""Return the composition of two relations, or of a set with a relation.

    The universes are discrete. Relations follow eq. 1.61 and 1.62, a set with a relation follows
    eq. 1.65.

    .. math::
        \mu_{R \circ S}(u, w) = \sup_{v \in V} \left[\mu_R(u, v) * \mu_S(v, w)\right], \qquad
        \mu_{\tilde R \circ \tilde S}(u, w) = \bigsqcup_{v \in V}
        \left[\mu_{\tilde R}(u, v) \sqcap \mu_{\tilde S}(v, w)\right]

    These are the sup-star composition of type-1 relations, and its extension to type-2 relations.
    For interval relations the extension is the sup-star composition of the lower and of the upper
    grades (1.29).

    Parameters
    ----------
    R : (U, V) or (U, V, 2) array_like, or (U, V) of Type1Set
        The first relation; without its first axis a set on V.
    S : (V, W) or (V, W, 2) array_like, or (V, W) of Type1Set
        The second relation, of the same kind as the first.
    t_norm, grade_t_norm : str, TNorm or callable
        As in `fuzzy2.meet` and `fuzzy2.join`; the second is used for general type-2 relations only.

    Returns
    -------
    (U, W) or (U, W, 2) array
        The composed relation. If R is a set, the result is a set on W, without the first axis.

    Raises
    ------
    InvalidValue
        If an argument is not of one of the three kinds, if the two kinds differ, or if the
        universes V differ in size.
    """
    as_t_norm(t_norm if grade_t_norm is None else grade_t_norm)
    kind, second = _checked("S", S, 2)
    is_set = _dimensions(R) == second.ndim - 1
    first_kind, first = _checked("R", R, 1 if is_set else 2)
    if first_kind != kind:
        raise InvalidValue("R and S", (first_kind, kind), "of the same kind")
    if is_set:
        first = first[None]
    if first.shape[1] != second.shape[0]:
        raise InvalidValue(
            "R and S", (first.shape, second.shape), "over universes (U, V) and (V, W) that share V"
        )
    if kind == "type-1":
        result: Relation = _sup_star(first, second, as_t_norm(t_norm))
    elif kind == "interval":
        norm = as_t_norm(t_norm)
        result = _in_order(
            kind,
            np.stack(
                [_sup_star(first[..., end], second[..., end], norm) for end in (0, 1)], axis=-1
            ),
        )
    else:
        result = np.empty((first.shape[0], second.shape[1]), dtype=object)
        for u, w in np.ndindex(result.shape):
            meets = [
                meet(first[u, v], second[v, w], t_norm=t_norm, grade_t_norm=grade_t_norm)
                for v in range(second.shape[0])
            ]
            result[u, w] = join(*meets, t_norm=t_norm, grade_t_norm=grade_t_norm)
    return result[0] if is_set else result


def relation_union(
    *relations: RelationLike,
    t_norm: TNormLike = "min",
    grade_t_norm: TNormLike | None = None,
    t_conorm: TConormLike = "max",
) -> Relation:
    r"""Return the union of relations on the same universes.

    It is :math:`\mu_{R \cup S}(u, v) = \mu_R(u, v) \sqcup \mu_S(u, v)`.

    Parameters
    ----------
    *relations : (U, V) or (U, V, 2) array_like, or (U, V) of Type1Set
        Relations of any of the three kinds. The union has the most general kind among them.
    t_norm, grade_t_norm, t_conorm : str, norm or callable
        As in `fuzzy2.join`.

    Returns
    -------
    (U, V) or (U, V, 2) array
        The union.

    Raises
    ------
    InvalidValue
        If a relation is not of one of the three kinds, or if the universes differ in size.
    """
    kind, operands = _on_the_same_universes(relations)
    if kind != "general":
        return _in_order(kind, as_t_conorm(t_conorm)(*operands))
    return _entry_by_entry(
        operands,
        lambda *slices: join(*slices, t_norm=t_norm, grade_t_norm=grade_t_norm, t_conorm=t_conorm),
    )


def relation_intersection(
    *relations: RelationLike, t_norm: TNormLike = "min", grade_t_norm: TNormLike | None = None
) -> Relation:
    r"""Return the intersection of relations on the same universes.

    It is :math:`\mu_{R \cap S}(u, v) = \mu_R(u, v) \sqcap \mu_S(u, v)`.

    Parameters
    ----------
    *relations : (U, V) or (U, V, 2) array_like, or (U, V) of Type1Set
        Relations of any of the three kinds. The intersection has the most general kind among them.
    t_norm, grade_t_norm : str, TNorm or callable
        As in `fuzzy2.meet`.

    Returns
    -------
    (U, V) or (U, V, 2) array
        The intersection.

    Raises
    ------
    InvalidValue
        If a relation is not of one of the three kinds, or if the universes differ in size.
    """
    kind, operands = _on_the_same_universes(relations)
    if kind != "general":
        return _in_order(kind, as_t_norm(t_norm)(*operands))
    return _entry_by_entry(
        operands, lambda *slices: meet(*slices, t_norm=t_norm, grade_t_norm=grade_t_norm)
    )


def relation_complement(R: RelationLike) -> Relation:
    r"""Return the complement of a relation, :math:`\mu_{\overline R}(u, v) = \neg \mu_R(u, v)`.

    Parameters
    ----------
    R : (U, V) or (U, V, 2) array_like, or (U, V) of Type1Set
        The relation.

    Returns
    -------
    (U, V) or (U, V, 2) array
        The complement.

    Raises
    ------
    InvalidValue
        If the relation is not of one of the three kinds.
    """
    kind, relation = _checked("R", R, 2)
    if kind == "general":
        return _entry_by_entry([relation], negation)
    return 1.0 - relation if kind == "type-1" else 1.0 - relation[..., ::-1]


def _on_the_same_universes(relations: Sequence[RelationLike]) -> tuple[Kind, list[Relation]]:
    if not relations:
        raise InvalidValue("relations", relations, "at least one relation")
    kind, operands = _same_kind([_checked("a relation", relation, 2) for relation in relations])
    if len({operand.shape for operand in operands}) > 1:
        raise InvalidValue(
            "relations", [operand.shape[:2] for operand in operands], "on the same universes"
        )
    return kind, operands


def _entry_by_entry(operands: Sequence[Relation], combine: Any) -> Relation:
    result = np.empty(operands[0].shape, dtype=object)
    for index in np.ndindex(result.shape):
        result[index] = combine(*(operand[index] for operand in operands))
    return result

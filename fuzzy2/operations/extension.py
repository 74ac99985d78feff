r"""Zadeh's extension principle.

It extends a function of numbers to a function of fuzzy sets (eq. 1.8, 1.43-1.45).

.. math:: \mu_B(y) = \sup_{f(x_1, \ldots, x_n) = y} \mu_1(x_1) * \cdots * \mu_n(x_n)

`SampledSet` and `Singleton` are discrete sets here. For discrete sets the image is exact, because
all combinations are enumerated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations.t_norms import T_NORMS, BinaryFunction, TNorm
from fuzzy2.operations.t_norms import t_norm as as_t_norm
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.support.checks import Array, function

# Combinations that are held in memory at once: 32 MiB per array.
CHUNK = 1 << 22

# This cut replaces the support of sets with unbounded support; for a Gaussian it ends at 5.26
# standard deviations.
LOWEST_LEVEL_OF_UNBOUNDED_SETS = 1e-6

_LEVELS = 257
_SEARCH_STEPS = 30
_GRID = 1 << 20
_CELLS = 256


def is_discrete(operand: Type1Set) -> bool:
    """Return whether joins, meets and extensions treat the set as discrete."""
    return isinstance(operand, SampledSet | Singleton)


def discrete_points(operand: Type1Set) -> tuple[Array, Array]:
    """Return points and grades, both (N,), of a discrete set."""
    if isinstance(operand, SampledSet):
        return operand.points, operand.grades
    if isinstance(operand, Singleton):
        return np.array([operand.point]), np.ones(1)
    raise NotApplicable(
        "enumeration",
        f"{operand!r} is not discrete; sample it first, for instance "
        f"{type(operand).__name__}.sample(points)",
    )


def require_sets(sets: Sequence[object]) -> None:
    """Raise InvalidValue unless there is at least one set and all sets are type-1 sets."""
    if not sets:
        raise InvalidValue("sets", sets, "at least one type-1 set")
    for operand in sets:
        if not isinstance(operand, Type1Set):
            raise InvalidValue("sets", operand, "type-1 sets (give t-norms by keyword)")


def extend(
    f: Callable[..., NDArray[np.generic]],
    *sets: Type1Set,
    t_norm: str | TNorm | BinaryFunction = "min",
) -> SampledSet:
    r"""Return the image of type-1 sets under a function of any number of arguments (eq. 1.8, 1.44).

    .. math:: f(F_1, \ldots, F_n) = \int_{\theta_1} \cdots \int_{\theta_n}
        \mu_{F_1}(\theta_1) * \cdots * \mu_{F_n}(\theta_n) \,/\, f(\theta_1, \ldots, \theta_n)

    Discrete sets are enumerated; images within 1e-12 of each other are merged into one point with
    the greatest of their grades. For other sets f must be continuous on the supports. Under the
    minimum, the α-cuts of convex sets are mapped: the ends of the image of each box of cuts are
    searched on a grid that closes in on them, which is exact if f is monotone in each argument. In
    all other cases the sets are sampled, and in each of 256 cells only the image with the greatest
    grade is kept, so the grades are lower bounds.

    Parameters
    ----------
    f : callable
        Takes one array per set, all of one shape, and returns an array of that shape.
    *sets : Type1Set
        The arguments. A set with unbounded support is cut off where its membership is 1e-6.
    t_norm : str, TNorm or callable
        How the grades of the arguments are combined.

    Returns
    -------
    SampledSet
        The image. For discrete sets it is a discrete set; otherwise its linear interpolation is the
        membership.

    Raises
    ------
    InvalidValue
        If f does not return finite values of the shape of its arguments.
    NotApplicable
        If a set is unbounded even at the membership 1e-6.
    """
    require_sets(sets)
    function("f", f)
    norm = as_t_norm(t_norm)
    if all(is_discrete(operand) for operand in sets):
        return enumerated(f, [discrete_points(operand) for operand in sets], norm)
    bounds = [bounded_support(operand, "the extension principle") for operand in sets]
    if norm is T_NORMS["min"] and all(
        operand.is_convex() and operand.maxima is not None for operand in sets
    ):
        return _mapped_cuts(f, sets, bounds)
    return _mapped_samples(f, sets, bounds, norm)


def bounded_support(operand: Type1Set, what: str) -> tuple[float, float]:
    """Return the support of a set, or its cut at 1e-6 of the height if the support is unbounded.

    The cut requires a convex set.
    """
    left, right = operand.support
    if math.isfinite(left) and math.isfinite(right):
        return left, right
    if not operand.is_convex():
        raise NotApplicable(what, f"{operand!r} is neither bounded nor convex; sample it first")
    low, high = operand.alpha_cut(LOWEST_LEVEL_OF_UNBOUNDED_SETS * operand.height)
    left, right = max(left, float(low)), min(right, float(high))
    if not (math.isfinite(left) and math.isfinite(right)):
        raise NotApplicable(
            what, f"{operand!r} does not fall to 0 on both sides; cut it off or sample it first"
        )
    return left, right


def enumerated(
    f: Callable[..., NDArray[np.generic]], operands: Sequence[tuple[Array, Array]], norm: TNorm
) -> SampledSet:
    """Return the exact image of discrete sets that are given as points and grades."""
    images, grades = [], []
    for points, levels in _combinations(operands):
        images.append(_image(f, points).ravel())
        grades.append(norm(*levels).ravel())
        if len(images) > 1 and sum(image.size for image in images) > CHUNK:
            merged = SampledSet(np.concatenate(images), np.concatenate(grades))
            images, grades = [merged.points], [merged.grades]
    return SampledSet(np.concatenate(images), np.concatenate(grades))


def _combinations(
    operands: Sequence[tuple[Array, Array]],
) -> Iterator[tuple[list[Array], list[Array]]]:
    """Yield all combinations of points with their grades, in blocks.

    Blocks have at most `CHUNK` points and are split along the first set.
    """
    rest = math.prod(points.size for points, _ in operands[1:])
    first_points, first_grades = operands[0]
    step = max(1, CHUNK // rest)
    for start in range(0, first_points.size, step):
        block = [
            (first_points[start : start + step], first_grades[start : start + step]),
            *operands[1:],
        ]
        yield (
            list(np.meshgrid(*(points for points, _ in block), indexing="ij")),
            list(np.meshgrid(*(grades for _, grades in block), indexing="ij")),
        )


def _image(f: Callable[..., NDArray[np.generic]], arguments: Sequence[Array]) -> Array:
    with np.errstate(all="ignore"):  # the values it returns are checked below
        image = np.asarray(f(*arguments), dtype=float)
    if image.shape != arguments[0].shape:
        raise InvalidValue(
            "f", image.shape, f"a function of arrays that returns their shape, {arguments[0].shape}"
        )
    if not np.isfinite(image).all():
        where = tuple(float(argument[~np.isfinite(image)][0]) for argument in arguments)
        raise InvalidValue(
            f"f{where}", float(image[~np.isfinite(image)][0]), "finite on the supports of the sets"
        )
    return image


def _mapped_cuts(
    f: Callable[..., NDArray[np.generic]],
    sets: Sequence[Type1Set],
    bounds: Sequence[tuple[float, float]],
) -> SampledSet:
    """Return the image of convex sets under the minimum.

    A cut of the image is the image of the cuts.
    """
    height = min(operand.height for operand in sets)
    # Levels are dense near 0 and near the height, where the cuts of smooth sets move fastest.
    levels = height * 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, _LEVELS)))
    boxes = []
    for operand, (first, last) in zip(sets, bounds, strict=True):
        left, right = operand.alpha_cut(levels)
        boxes.append((np.clip(left, first, last), np.clip(right, first, last)))
    left = -_greatest(lambda *x: -_image(f, x), boxes)
    right = _greatest(lambda *x: _image(f, x), boxes)
    # A search can miss an end by its tolerance. Cuts are nested, so every lower cut includes what a
    # higher cut reaches.
    left, right = np.minimum.accumulate(left[::-1])[::-1], np.maximum.accumulate(right[::-1])[::-1]
    return SampledSet(np.concatenate([left, right]), np.concatenate([levels, levels]))


def _greatest(f: Callable[..., Array], boxes: Sequence[tuple[Array, Array]]) -> Array:
    """Return the greatest values (L,) of f over L boxes at once.

    A grid closes in on the best point of each box.
    """
    # odd, so that the best point of a step stays on the grid of the next
    per_axis = max(5, round(4096 ** (1.0 / len(boxes)))) | 1
    centers = [0.5 * (left + right) for left, right in boxes]
    reach = [0.5 * (right - left) for left, right in boxes]
    best = np.full(centers[0].shape, -np.inf)
    for _ in range(_SEARCH_STEPS):
        axes = [
            np.clip(
                center[:, None] + size[:, None] * np.linspace(-1.0, 1.0, per_axis),
                left[:, None],
                right[:, None],
            )
            for center, size, (left, right) in zip(centers, reach, boxes, strict=True)
        ]
        grid = np.broadcast_arrays(*_outer(axes))
        values = f(*grid).reshape(best.size, -1)
        where = values.argmax(axis=1)
        rows = np.arange(best.size)
        best = np.maximum(best, values[rows, where])
        centers = [axis.reshape(best.size, -1)[rows, where] for axis in grid]
        # The grid spans twice the spacing, because the greatest value may lie between the best
        # point and its neighbors.
        reach = [np.minimum(0.5 * size, 4.0 * size / (per_axis - 1)) for size in reach]
        per_axis = 5 if len(boxes) < 4 else 3
    return best


def _outer(axes: Sequence[Array]) -> list[Array]:
    """Return axes (L, P) reshaped so that they broadcast to (L, P, ..., P)."""
    n = len(axes)
    return [
        axis.reshape(axis.shape[0], *(axis.shape[1] if k == j else 1 for j in range(n)))
        for k, axis in enumerate(axes)
    ]


def _mapped_samples(
    f: Callable[..., NDArray[np.generic]],
    sets: Sequence[Type1Set],
    bounds: Sequence[tuple[float, float]],
    norm: TNorm,
) -> SampledSet:
    """Return the sampled image with the greatest grade in each of a number of equal cells.

    The grades are attained by samples, so they are lower bounds.
    """
    per_axis = max(5, int(_GRID ** (1.0 / len(sets))))
    operands = []
    for operand, (left, right) in zip(sets, bounds, strict=True):
        landmarks = operand.landmarks
        points = np.union1d(
            np.linspace(left, right, per_axis),
            landmarks[(landmarks >= left) & (landmarks <= right)],
        )
        if is_discrete(operand):
            points = discrete_points(operand)[0]
        operands.append((points, operand.membership(points)))
    cells = [
        (_image(f, points).ravel(), norm(*grades).ravel())
        for points, grades in _combinations(operands)
    ]
    images, grades = (np.concatenate(parts) for parts in zip(*cells, strict=True))
    first, last = images.min(), images.max()
    cell = np.minimum(
        ((images - first) * (_CELLS / max(last - first, np.finfo(float).tiny))).astype(np.int64),
        _CELLS - 1,
    )
    order = np.lexsort((grades, cell))
    best = order[np.flatnonzero(np.diff(cell[order], append=_CELLS))]
    # The ends of the image are kept as well, so that the image keeps its full width.
    best = np.union1d(best, [images.argmin(), images.argmax()])
    return SampledSet(images[best], grades[best])

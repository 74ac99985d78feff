r"""Sets with shapes of fuzzylite and of the Fuzzy Control Language that have no class of their own.

With :math:`h` the height, :math:`s, e` start and end, :math:`c` a center and :math:`w` a width:

====================  ===============================================================  ==========
name                  membership                                                       parameters
====================  ===============================================================  ==========
"arc"                 :math:`h\sqrt{r^2 - (x - e)^2}/|r|`, :math:`r = e - s`; from      s, e
                      the end on h, before the start 0
"bell"                :math:`h/(1 + |(x - c)/w|^{2 b})`                                  c, w, b
"binary"              h from the start on, to the right if the direction is greater    s, direction
                      than the start, else to the left
"concave"             :math:`h (e - i)/(2 e - i - x)` before the end, h from it on       i, e
"constant"            k everywhere                                                     k
"cosine"              :math:`h (1 + \cos(2 \pi (x - c)/w))/2` for                       c, w
                      :math:`|x - c| \le w/2`, else 0
"discrete"            linear between points, beyond the first and the last their       x, y, x, y...
                      grade
"gaussian_product"    h times a Gaussian left of the first mean, times another one     m, s, m, s
                      right of the second mean
"semi_ellipse"        :math:`h\sqrt{r^2 - (x - c)^2}/r` between the ends                 s, e
"sigmoid"             :math:`h/(1 + \exp(-a (x - i)))`                                  i, a
"sigmoid_difference"  h times the distance of two sigmoids                             i, a, b, j
"sigmoid_product"     h times the product of two sigmoids                              i, a, b, j
"spike"               :math:`h \exp(-|10 (x - c)/w|)`                                   c, w
====================  ===============================================================  ==========

Source: the documentation of fuzzylite's terms, and for "discrete" IEC 61131-7, 4.2.3. Ramps,
rectangles, triangles, trapezoids, S, Z and Pi are :class:`fuzzy2.Trapezoidal` and the like.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.type1 import Type1Set, set_fields
from fuzzy2.support.checks import Array, known_name, listed, maybe_infinite, real

_Numbers = tuple[float, ...]


class _Shape(NamedTuple):
    """A shape of height 1: its grades, its landmarks, and the conditions on its parameters."""

    grades: Callable[[Array, _Numbers], Array]
    support: Callable[[_Numbers], tuple[float, float]]
    landmarks: Callable[[_Numbers], Sequence[float]]
    valid: Callable[[_Numbers], bool]
    requirement: str


def _everywhere(_: _Numbers) -> tuple[float, float]:
    return -math.inf, math.inf


def _arc(x: Array, p: _Numbers) -> Array:
    start, end = p
    radius, rising = end - start, start < end
    inside = (x >= min(p)) & (x <= max(p))
    with np.errstate(invalid="ignore"):
        curve = np.sqrt(np.maximum(radius**2 - np.square(x - end), 0.0)) / abs(radius)
    return np.where(inside, curve, np.where(x > end, rising, not rising))


def _shoulder(p: _Numbers) -> tuple[float, float]:
    return (p[0], math.inf) if p[1] > p[0] else (-math.inf, p[0])


def _bell(x: Array, p: _Numbers) -> Array:
    center, width, slope = p
    with np.errstate(over="ignore", divide="ignore"):
        return np.asarray(1.0 / (1.0 + np.power(np.abs((x - center) / width), 2.0 * slope)))


def _binary(x: Array, p: _Numbers) -> Array:
    start, direction = p
    return np.where(x >= start if direction > start else x <= start, 1.0, 0.0)


def _concave(x: Array, p: _Numbers) -> Array:
    inflection, end = p
    before = x < end if inflection <= end else x > end
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(before, (end - inflection) / (2.0 * end - inflection - x), 1.0)


def _cosine(x: Array, p: _Numbers) -> Array:
    center, width = p
    within = np.abs(x - center) <= 0.5 * width
    with np.errstate(invalid="ignore"):
        return np.where(within, 0.5 * (1.0 + np.cos(2.0 / width * np.pi * (x - center))), 0.0)


def _discrete(x: Array, p: _Numbers) -> Array:
    return np.interp(x, p[::2], p[1::2])


def _gaussian(x: Array, mean: float, sigma: float) -> Array:
    return np.asarray(np.exp(-np.square(x - mean) / (2.0 * sigma**2)))


def _gaussian_product(x: Array, p: _Numbers) -> Array:
    left = np.where(x < p[0], _gaussian(x, p[0], p[1]), 1.0)
    return left * np.where(x > p[2], _gaussian(x, p[2], p[3]), 1.0)


def _semi_ellipse(x: Array, p: _Numbers) -> Array:
    radius, center = 0.5 * abs(p[1] - p[0]), 0.5 * (p[0] + p[1])
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.maximum(radius**2 - np.square(x - center), 0.0)) / radius


def _sigmoid(x: Array, inflection: float, slope: float) -> Array:
    with np.errstate(over="ignore"):
        return np.asarray(1.0 / (1.0 + np.exp(-slope * (x - inflection))))


def _difference(x: Array, p: _Numbers) -> Array:
    return np.abs(_sigmoid(x, p[0], p[1]) - _sigmoid(x, p[3], p[2]))


def _spike(x: Array, p: _Numbers) -> Array:
    return np.asarray(np.exp(-np.abs(10.0 / p[1] * (x - p[0]))))


def _around(inflection: float, slope: float) -> list[float]:
    """Return the inflection point of a sigmoid, and points where it is nearly flat."""
    reach = 10.0 / abs(slope)
    return [inflection - reach, inflection, inflection + reach]


_ENDS = "two different finite ends"
_SHAPES: dict[str, _Shape] = {
    "arc": _Shape(_arc, _shoulder, list, lambda p: len(p) == 2 and p[0] != p[1], _ENDS),
    "bell": _Shape(
        _bell,
        _everywhere,
        lambda p: [p[0] + s * p[1] for s in (-5.0, -1.0, 0.0, 1.0, 5.0)],
        lambda p: len(p) == 3 and p[1] != 0.0,
        "center, a width that is not 0, and slope",
    ),
    "binary": _Shape(
        _binary,
        _shoulder,
        lambda p: [p[0] - 1.0, p[0], p[0] + 1.0],
        lambda p: len(p) == 2 and p[0] != p[1],
        "a start, and a direction that is not the start",
    ),
    "concave": _Shape(
        _concave,
        _everywhere,
        lambda p: [p[1] - 10.0 * (p[1] - p[0]), p[0], p[1]],
        lambda p: len(p) == 2 and p[0] != p[1],
        "inflection and end, which differ",
    ),
    "constant": _Shape(
        lambda x, p: np.full_like(x, p[0]),
        _everywhere,
        lambda p: [0.0, 1.0],
        lambda p: len(p) == 1 and 0.0 <= p[0] <= 1.0,
        "a grade in [0, 1]",
    ),
    "cosine": _Shape(
        _cosine,
        lambda p: (p[0] - 0.5 * p[1], p[0] + 0.5 * p[1]),
        lambda p: [p[0] - 0.5 * p[1], p[0], p[0] + 0.5 * p[1]],
        lambda p: len(p) == 2 and p[1] > 0.0,
        "center, and a width above 0",
    ),
    "discrete": _Shape(
        _discrete,
        _everywhere,
        lambda p: [*p[::2], *([] if p[0] < p[-2] else [p[0] - 1.0, p[0] + 1.0])],
        lambda p: (
            len(p) >= 2
            and len(p) % 2 == 0
            and bool((np.diff(p[::2]) >= 0.0).all())
            and all(0.0 <= grade <= 1.0 for grade in p[1::2])
        ),
        "ascending points, each followed by a grade in [0, 1]",
    ),
    "gaussian_product": _Shape(
        _gaussian_product,
        _everywhere,
        lambda p: [p[0] - 3.0 * abs(p[1]), p[0], p[2], p[2] + 3.0 * abs(p[3])],
        lambda p: len(p) == 4 and p[1] != 0.0 and p[3] != 0.0,
        "two means, each followed by a standard deviation that is not 0",
    ),
    "semi_ellipse": _Shape(
        _semi_ellipse,
        lambda p: (min(p), max(p)),
        lambda p: sorted(p),
        lambda p: len(p) == 2 and p[0] != p[1],
        _ENDS,
    ),
    "sigmoid": _Shape(
        lambda x, p: _sigmoid(x, p[0], p[1]),
        _everywhere,
        lambda p: _around(p[0], p[1]),
        lambda p: len(p) == 2 and p[1] != 0.0,
        "inflection, and a slope that is not 0",
    ),
    "sigmoid_difference": _Shape(
        _difference,
        _everywhere,
        lambda p: [*_around(p[0], p[1]), *_around(p[3], p[2])],
        lambda p: len(p) == 4 and p[1] != 0.0 and p[2] != 0.0,
        "left inflection, its slope, the slope of the right one and it; slopes are not 0",
    ),
    "sigmoid_product": _Shape(
        lambda x, p: _sigmoid(x, p[0], p[1]) * _sigmoid(x, p[3], p[2]),
        _everywhere,
        lambda p: [*_around(p[0], p[1]), *_around(p[3], p[2])],
        lambda p: len(p) == 4 and p[1] != 0.0 and p[2] != 0.0,
        "left inflection, its slope, the slope of the right one and it; slopes are not 0",
    ),
    "spike": _Shape(
        _spike,
        _everywhere,
        lambda p: [p[0] - abs(p[1]), p[0], p[0] + abs(p[1])],
        lambda p: len(p) == 2 and p[1] != 0.0,
        "center, and a width that is not 0",
    ),
}

SHAPES = tuple(_SHAPES)
"""Names of the shapes."""


@dataclass(frozen=True)
class NamedShape(Type1Set):
    """Set whose shape is given by a name.

    Parameters
    ----------
    shape : str
        One of the names in :mod:`fuzzy2.sets.named_shape`.
    parameters : sequence of float
        The parameters listed for the shape in :mod:`fuzzy2.sets.named_shape`.
    scale : float
        Factor of the membership, above 0 and at most 1.

    Raises
    ------
    UnknownName
        If there is no such shape.
    InvalidValue
        If the parameters are not those of the shape.
    """

    shape: str
    parameters: tuple[float, ...]
    scale: float = 1.0

    def __post_init__(self) -> None:
        known_name("shape", self.shape, SHAPES)
        # Only the direction of "binary" may be infinite.
        check = maybe_infinite if self.shape == "binary" else real
        numbers = tuple(
            check("parameters", one)
            for one in listed("parameters", self.parameters, "a list of numbers")
        )
        kind = _SHAPES[self.shape]
        if not numbers or not kind.valid(numbers) or not math.isfinite(numbers[0]):
            raise InvalidValue(f"the parameters of {self.shape}", numbers, kind.requirement)
        scale = real("scale", self.scale)
        if not 0.0 < scale <= 1.0:
            raise InvalidValue("scale", self.scale, "above 0, at most 1")
        set_fields(self, parameters=numbers, scale=scale)

    @cached_property
    def _whole(self) -> FunctionalSet:
        kind = _SHAPES[self.shape]
        knots = tuple(sorted(float(point) for point in kind.landmarks(self.parameters)))
        return FunctionalSet(self._scaled, *kind.support(self.parameters), knots)

    def _scaled(self, x: Array) -> Array:
        return np.asarray(self.scale * _SHAPES[self.shape].grades(x, self.parameters))

    @property
    def height(self) -> float:
        """Supremum of the membership; for some shapes it is sampled."""
        if self.shape in ("discrete", "constant"):
            grades = self.parameters[1::2] if self.shape == "discrete" else self.parameters
            return self.scale * max(grades)
        if self.shape in ("gaussian_product", "sigmoid_difference", "sigmoid_product"):
            return self._whole.height
        return self.scale

    def _grades(self, x: Array) -> Array:
        return self._whole._grades(x)

    def _support(self) -> tuple[float, float]:
        return self._whole._support()

    def _maxima(self) -> tuple[float, float] | None:
        if self.shape == "sigmoid":
            return None
        return self._whole._maxima()

    def _landmarks(self) -> Array:
        return self._whole._landmarks()

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return self._whole._cut(alpha)

    def is_convex(self) -> bool:
        """Return whether the sampled membership rises to its maximum and then falls."""
        return self._whole.is_convex()

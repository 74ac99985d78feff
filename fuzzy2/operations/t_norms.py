"""T-norms and t-conorms, which combine grades by *and* and by *or*.

A t-norm is commutative, associative, non-decreasing in both grades, and has 1 as its identity; its
dual t-conorm is ``S(a, b) = 1 - T(1 - a, 1 - b)``. Compiled kernels identify the two t-norms of the
thesis by the codes `MINIMUM` and `PRODUCT`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable, UnknownName
from fuzzy2.support.checks import Array

BinaryFunction = Callable[[Array, Array], Array]

MINIMUM: Final = 0
PRODUCT: Final = 1

# A t-norm given as a function is checked on these grades. 1/3 and 2/3 are deliberately not on the
# even grid.
_TRIAL_GRADES = np.unique(np.concatenate([np.linspace(0.0, 1.0, 11), [1.0 / 3.0, 2.0 / 3.0]]))
_TRIAL_TOLERANCE = 1e-9


class _Norm:
    """Base of t-norms and t-conorms.

    It has a name and a function of two grades, and it can be called with any number of arrays of
    grades.
    """

    name: str
    function: BinaryFunction

    def __call__(self, *grades: ArrayLike) -> Array:
        """Combine grades whose shapes broadcast, from left to right; NaN gives NaN."""
        if not grades:
            raise InvalidValue("grades", grades, "at least one array")
        combined = np.asarray(grades[0], dtype=float)
        for other in grades[1:]:
            combined = np.asarray(
                self.function(combined, np.asarray(other, dtype=float)), dtype=float
            )
        return combined

    def reduce(self, grades: ArrayLike, axis: int = -1) -> Array:
        """Combine the grades along one axis, for instance over the antecedents of each rule."""
        moved = np.moveaxis(np.asarray(grades, dtype=float), axis, 0)
        if moved.shape[0] == 0:
            raise InvalidValue("grades", moved, "at least one along the axis")
        return self(*moved)


@dataclass(frozen=True)
class TNorm(_Norm):
    """A t-norm :math:`T(a, b)`, written :math:`a * b` in the thesis.

    Parameters
    ----------
    name : str
        Name that is shown.
    function : callable
        Takes two arrays of grades and returns an array.
    continuous : bool
        Whether it is a continuous function of both grades. The interval theorem (1.29) and the
        operations on sets over a continuous domain require that.
    """

    name: str
    function: BinaryFunction
    continuous: bool = True

    @property
    def code(self) -> int:
        """Number that identifies this t-norm in compiled kernels.

        Raises
        ------
        NotApplicable
            If it is neither the minimum nor the product.
        """
        if self is T_NORMS["min"]:
            return MINIMUM
        if self is T_NORMS["product"]:
            return PRODUCT
        raise NotApplicable(
            f"a compiled kernel with the t-norm {self.name}",
            'kernels know "min" and "product" only',
        )


@dataclass(frozen=True)
class TConorm(_Norm):
    r"""A t-conorm :math:`S(a, b)`, written :math:`a \vee b` in the thesis.

    Parameters
    ----------
    name : str
        Name that is shown.
    function : callable
        Takes two arrays of grades and returns an array.
    dual : TNorm
        The t-norm with :math:`S(a, b) = 1 - T(1 - a, 1 - b)`.
    """

    name: str
    function: BinaryFunction
    dual: TNorm


def _product(a: Array, b: Array) -> Array:
    return a * b


def _lukasiewicz(a: Array, b: Array) -> Array:
    # a + b - 1 may be rounded up past min(a, b): for b = 1 and a tiny a it would not return a.
    return np.where(b == 1.0, a, np.where(a == 1.0, b, np.maximum(a + b - 1.0, 0.0)))


def _drastic(a: Array, b: Array) -> Array:
    return np.where(np.maximum(a, b) < 1.0, 0.0, np.minimum(a, b))


def _nilpotent(a: Array, b: Array) -> Array:
    # a + b would lose a tiny grade by rounding; 1 - max(a, b) is exact wherever it matters.
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.where(low <= 1.0 - high, 0.0, low)


def _hamacher(a: Array, b: Array) -> Array:
    # At a = b = 0 the quotient 0/0 is replaced by its limit 0. The product of two tiny grades
    # underflows, but the result is at least half of the smaller one.
    low, high = np.minimum(a, b), np.maximum(a, b)
    denominator = high + low * (1.0 - high)
    return low * (high / np.where(high == 0.0, 1.0, denominator))


def _einstein(a: Array, b: Array) -> Array:
    return a * b / (1.0 + (1.0 - a) * (1.0 - b))


def _probabilistic(a: Array, b: Array) -> Array:
    # This form is symmetric in a and b and never exceeds 1.
    low, high = np.minimum(a, b), np.maximum(a, b)
    return high + low * (1.0 - high)


def _bounded_sum(a: Array, b: Array) -> Array:
    return np.minimum(a + b, 1.0)


def _drastic_sum(a: Array, b: Array) -> Array:
    return np.where(np.minimum(a, b) > 0.0, 1.0, np.maximum(a, b))


def _nilpotent_maximum(a: Array, b: Array) -> Array:
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.where(low >= 1.0 - high, 1.0, high)


def _hamacher_sum(a: Array, b: Array) -> Array:
    # (a + b - 2ab) / (1 - ab), written so that 1 with any grade is exactly 1.
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.where(
        high == 1.0,
        1.0,
        high + low * (1.0 - high) ** 2 / np.where(high == 1.0, 1.0, 1.0 - low * high),
    )


def _einstein_sum(a: Array, b: Array) -> Array:
    # (a + b) / (1 + ab), written in the same way.
    low, high = np.minimum(a, b), np.maximum(a, b)
    return high + low * (1.0 - high) * (1.0 + high) / (1.0 + low * high)


def _keeping_nan(function: BinaryFunction) -> BinaryFunction:
    """Propagate NaN through the branches of ``np.where``, where comparisons with NaN are false."""

    def combined(a: Array, b: Array) -> Array:
        return np.where(np.isnan(a) | np.isnan(b), np.nan, function(a, b))

    return combined


T_NORMS = MappingProxyType(
    {
        norm.name: norm
        for norm in (
            TNorm("min", np.minimum),
            TNorm("product", _product),
            TNorm("lukasiewicz", _keeping_nan(_lukasiewicz)),
            TNorm("drastic", _keeping_nan(_drastic), continuous=False),
            TNorm("nilpotent", _keeping_nan(_nilpotent), continuous=False),
            TNorm("hamacher", _keeping_nan(_hamacher)),
            TNorm("einstein", _einstein),
        )
    }
)

T_CONORMS = MappingProxyType(
    {
        norm.name: norm
        for norm in (
            TConorm("max", np.maximum, T_NORMS["min"]),
            TConorm("probabilistic", _probabilistic, T_NORMS["product"]),
            TConorm("lukasiewicz", _bounded_sum, T_NORMS["lukasiewicz"]),
            TConorm("drastic", _keeping_nan(_drastic_sum), T_NORMS["drastic"]),
            TConorm("nilpotent", _keeping_nan(_nilpotent_maximum), T_NORMS["nilpotent"]),
            TConorm("hamacher", _keeping_nan(_hamacher_sum), T_NORMS["hamacher"]),
            TConorm("einstein", _einstein_sum, T_NORMS["einstein"]),
        )
    }
)


ALIASES = MappingProxyType({"prod": "product", "probor": "probabilistic"})
"""MATLAB's names of t-norms and t-conorms."""


def _violated_law(function: BinaryFunction, identity: float) -> str | None:
    """Return the law of t-norms or t-conorms that fails on the test grades, or None.

    The identity is 1 for t-norms and 0 for t-conorms.
    """
    a, b = _TRIAL_GRADES[:, None], _TRIAL_GRADES[None, :]
    table = np.asarray(function(*np.broadcast_arrays(a, b)), dtype=float)
    if table.shape != (a.size, b.size):
        return (
            f"a function of arrays, which returns the shape of its arguments (not {table.shape} "
            f"for {(a.size, b.size)})"
        )
    with_identity = table[:, -1 if identity == 1.0 else 0]
    laws = {
        f"a function that returns a for (a, {identity:g})": np.abs(with_identity - _TRIAL_GRADES),
        "commutative": np.abs(table - table.T),
        "non-decreasing in both grades": -np.diff(table, axis=0),
        "associative": np.abs(
            np.asarray(function(*np.broadcast_arrays(table[:, :, None], b)))
            - np.asarray(function(*np.broadcast_arrays(a[:, :, None], table[None, :, :])))
        ),
    }
    # The test is not `violation > tolerance`, because a function that returns NaN must fail as
    # well.
    return next(
        (law for law, violation in laws.items() if not violation.max() <= _TRIAL_TOLERANCE), None
    )


def t_norm(name: str | TNorm | BinaryFunction) -> TNorm:
    r"""Return a t-norm by its name, or make one from a function.

    =============  =======================================================
    name           :math:`T(a, b)`
    =============  =======================================================
    "min"          :math:`\min(a, b)`
    "product"      :math:`a b`
    "lukasiewicz"  :math:`\max(a + b - 1, 0)`
    "drastic"      :math:`\min(a, b)` if :math:`\max(a, b) = 1`, else 0
    "nilpotent"    :math:`\min(a, b)` if :math:`a + b > 1`, else 0
    "hamacher"     :math:`a b / (a + b - a b)`
    "einstein"     :math:`a b / (1 + (1 - a)(1 - b))`
    =============  =======================================================

    MATLAB's name ``"prod"`` is accepted, too.

    Parameters
    ----------
    name : str, TNorm or callable
        A function takes two arrays of grades in [0, 1] and is assumed to be continuous. If it is
        not, pass a `TNorm` with ``continuous=False``.

    Returns
    -------
    TNorm
        The t-norm, to be called with two or more arrays of grades whose shapes broadcast.

    Raises
    ------
    UnknownName
        If there is no such t-norm.
    InvalidValue
        If a function breaks one of the four laws of t-norms on a grid of 13 grades.

    Notes
    -----
    Klement, Mesiar and Pap, *Triangular Norms* (2000), chapter 1.
    """
    if isinstance(name, TNorm):
        return name
    if isinstance(name, str):
        known = ALIASES.get(name, name)
        if known not in T_NORMS:
            raise UnknownName("t-norm", name, tuple(T_NORMS))
        return T_NORMS[known]
    if not callable(name):
        raise UnknownName("t-norm", name, tuple(T_NORMS))
    violated = _violated_law(name, identity=1.0)
    if violated:
        raise InvalidValue("t_norm", name, violated)
    return TNorm(getattr(name, "__name__", repr(name)), name)


def t_conorm(name: str | TConorm | BinaryFunction) -> TConorm:
    r"""Return a t-conorm by its name, or make one from a function.

    ===============  =======================================================
    name             :math:`S(a, b)`
    ===============  =======================================================
    "max"            :math:`\max(a, b)`
    "probabilistic"  :math:`a + b - a b`
    "lukasiewicz"    :math:`\min(a + b, 1)`
    "drastic"        :math:`\max(a, b)` if :math:`\min(a, b) = 0`, else 1
    "nilpotent"      :math:`\max(a, b)` if :math:`a + b < 1`, else 1
    "hamacher"       :math:`(a + b - 2 a b) / (1 - a b)`
    "einstein"       :math:`(a + b) / (1 + a b)`
    ===============  =======================================================

    MATLAB's name ``"probor"`` is accepted for "probabilistic".

    Parameters
    ----------
    name : str, TConorm or callable
        A function takes two arrays of grades in [0, 1].

    Returns
    -------
    TConorm
        The t-conorm, to be called with two or more arrays of grades whose shapes broadcast;
        ``.dual`` is its dual t-norm.

    Raises
    ------
    UnknownName
        If there is no such t-conorm.
    InvalidValue
        If a function breaks one of the four laws of t-conorms on a grid of 13 grades.

    Notes
    -----
    Klement, Mesiar and Pap, *Triangular Norms* (2000), chapter 1.
    """
    if isinstance(name, TConorm):
        return name
    if isinstance(name, str):
        known = ALIASES.get(name, name)
        if known not in T_CONORMS:
            raise UnknownName("t-conorm", name, tuple(T_CONORMS))
        return T_CONORMS[known]
    if not callable(name):
        raise UnknownName("t-conorm", name, tuple(T_CONORMS))
    violated = _violated_law(name, identity=0.0)
    if violated:
        raise InvalidValue("t_conorm", name, violated)
    conorm = name

    def dual(a: Array, b: Array) -> Array:
        return 1.0 - conorm(1.0 - a, 1.0 - b)

    shown = getattr(name, "__name__", repr(name))
    return TConorm(shown, name, TNorm(f"dual of {shown}", dual))

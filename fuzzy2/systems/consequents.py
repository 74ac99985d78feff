"""Consequents of rules: numbers, sets, and functions of the inputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.support.checks import Array, reals
from fuzzy2.support.described import Described
from fuzzy2.support.formula import Formula
from fuzzy2.systems.terms import AnySet


class FunctionsOfInputs(ABC):
    """Consequents that are functions of the inputs, with one row for each rule."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, int]:
        """Number of rules and of outputs."""

    @abstractmethod
    def at(self, X: Array) -> Array:
        """Return the consequents (n, R, m, 2) at inputs (n, p)."""

    @abstractmethod
    def said(self, r: int, j: int) -> Any:
        """Return a value that identifies a consequent; it is equal for equal functions."""


class Linear(Described, FunctionsOfInputs):
    r"""Linear consequents of Takagi, Sugeno and Kang.

    :math:`z_{rj}(x) = c_{rj0} + \sum_i c_{rji} x_i`, with a spread if they are intervals.

    Parameters
    ----------
    coefficients : (R, m, p + 1) array_like
        Constant term first, then the slopes.
    spreads : (R, m, p + 1) array_like, optional
        Half-widths of the coefficients; then :math:`z` is an interval of half-width
        :math:`s_{rj0} + \sum_i s_{rji} |x_i|`.
    """

    def __init__(self, coefficients: ArrayLike, spreads: ArrayLike | None = None) -> None:
        self.coefficients = np.array(reals("coefficients", coefficients))
        self.spreads = np.array(
            np.zeros_like(self.coefficients) if spreads is None else reals("spreads", spreads)
        )
        # The arrays are read-only, because a system that uses them must not change.
        self.coefficients.flags.writeable = self.spreads.flags.writeable = False
        if self.coefficients.ndim != 3 or not np.isfinite(self.coefficients).all():
            raise InvalidValue(
                "coefficients", self.coefficients, "finite numbers of shape (R, m, p + 1)"
            )
        if (
            self.spreads.shape != self.coefficients.shape
            or not (self.spreads >= 0.0).all()
            or not np.isfinite(self.spreads).all()
        ):
            raise InvalidValue(
                "spreads", self.spreads, "finite, not negative, of the shape of the coefficients"
            )

    def _facts(self) -> dict[str, Any]:
        rules, outputs, coefficients = self.coefficients.shape
        return {
            "rules": rules,
            "outputs": outputs,
            "inputs": coefficients - 1,
            "spreads": bool(self.spreads.any()),
        }

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rules and of outputs."""
        return self.coefficients.shape[0], self.coefficients.shape[1]

    def said(self, r: int, j: int) -> tuple[bytes, bytes]:
        """Return the bytes of the coefficients of a rule, and of their spreads."""
        return self.coefficients[r, j].tobytes(), self.spreads[r, j].tobytes()

    def by_input(self) -> tuple[Array, Array]:
        """Return constants (m, R, 2) and slopes (m, R, 2 p), of middles and then of spreads."""
        middle, spread = (np.moveaxis(part, 0, 1) for part in (self.coefficients, self.spreads))
        constants = np.stack([middle[..., 0], spread[..., 0]], axis=-1)
        return constants, np.concatenate([middle[..., 1:], spread[..., 1:]], axis=-1)

    def at(self, X: Array) -> Array:
        """Return the consequents (n, R, m, 2) at inputs (n, p)."""
        with_constant = np.concatenate([np.ones((len(X), 1)), X], axis=1)
        middle = np.einsum("rmi,ni->nrm", self.coefficients, with_constant)
        spread = np.einsum("rmi,ni->nrm", self.spreads, np.abs(with_constant))
        return np.stack([middle - spread, middle + spread], axis=-1)


class OutputOf(NamedTuple):
    """Output of another system with the same inputs, by its number, for use in a formula."""

    system: Any
    output: int

    def __call__(self, X: Array) -> Array:
        """Return the output (n,) at inputs (n, p); NaN where none of its rules fires."""
        return np.asarray(self.system(X)[:, self.output])


class Formulas(FunctionsOfInputs):
    r"""Consequents that are formulas of the inputs, :math:`z_{rj}(x) = f_{rj}(x)`.

    Parameters
    ----------
    formulas : (R, m) nested sequence of str
        The formulas; see :mod:`fuzzy2.support.formula`.
    names : sequence of p str
        Names of the inputs in the formulas, in order.
    others : mapping of str to OutputOf, optional
        Outputs of other systems with the same inputs, by the names that the formulas use.

    Raises
    ------
    InvalidValue
        If a text is not a formula, or uses an unknown name.
    """

    def __init__(
        self,
        formulas: Sequence[Sequence[str]],
        names: Sequence[str],
        others: Mapping[str, OutputOf] | None = None,
    ) -> None:
        self._formulas = tuple(tuple(Formula(one) for one in row) for row in formulas)
        self.formulas = tuple(tuple(one.text for one in row) for row in self._formulas)
        self.names, self.others = tuple(names), dict(others or {})
        if len({len(row) for row in self.formulas}) != 1 or not self.formulas[0]:
            raise InvalidValue("formulas", formulas, "rows with a formula for each output")
        known = (*self.names, *self.others)
        for one in (one for row in self._formulas for one in row):
            for name in sorted(one.names.difference(known)):
                raise InvalidValue("a name in a formula", name, f"one of {', '.join(known)}")
        asked = {name for row in self._formulas for one in row for name in one.names}
        self.asked = {name: other for name, other in self.others.items() if name in asked}
        """The members of ``others`` that a formula uses."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rules and of outputs."""
        return len(self.formulas), len(self.formulas[0])

    def said(self, r: int, j: int) -> str:
        """Return the text of a formula."""
        return self.formulas[r][j]

    def programs(self) -> tuple[Array, NDArray[np.int64], int]:
        """Return the programs of the formulas (:mod:`fuzzy2.support.formula_kernels`), by output.

        The result is their steps, the place where each program begins (m R + 1,), and the depth of
        the stack.
        """
        each = [row[j].program(self.names) for j in range(self.shape[1]) for row in self._formulas]
        steps = [step for program, _ in each for step in program]
        places = np.cumsum([0, *(len(program) for program, _ in each)])
        return np.array(steps), places, max(deepest for _, deepest in each)

    def at(self, X: Array) -> Array:
        """Return the consequents (n, R, m, 2) at inputs (n, p); NaN where one is undefined."""
        values = {name: X[:, i] for i, name in enumerate(self.names)}
        values |= {name: other(X) for name, other in self.asked.items()}
        found = np.empty((len(X), *self.shape))
        for r, row in enumerate(self._formulas):
            for j, one in enumerate(row):
                found[:, r, j] = one.at(values)
        return np.stack([found, found], axis=-1)


def as_sets(consequents: Any) -> list[list[Any]] | None:
    """Return sets as a list of lists, or None if the values are not sets."""
    if isinstance(consequents, np.ndarray) and consequents.dtype.kind != "O":
        return None
    try:
        rows = [
            [row] if isinstance(row, AnySet) or row is None else list(row) for row in consequents
        ]
    except TypeError:
        return None
    if not any(isinstance(item, AnySet) for row in rows for item in row):
        return None
    return rows


def centroid_interval(item: Any) -> tuple[float, float]:
    """Centroid of a consequent, which is cached.

    For a general type-2 set it is the centroid of the lowest α-plane.
    """
    ends = np.ravel(
        item.alpha_plane(1.0).centroid() if isinstance(item, GeneralType2Set) else item.centroid()
    )
    return float(ends[0]), float(ends[-1])

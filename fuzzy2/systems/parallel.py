"""Parallel systems with the same inputs, for outputs with different operators.

A system uses the same operators for all its outputs. Files of fuzzylite and IEC 61131-7 may have,
for instance, a Mamdani and a Takagi-Sugeno output. Then each output gets its own system.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, ReadOnly
from fuzzy2.support.checks import Array, listed
from fuzzy2.support.markup import Markup, joined
from fuzzy2.systems.named_inputs import like_inputs
from fuzzy2.systems.system import FuzzySystem


class ParallelSystem:
    """Parallel systems with the same inputs, each with its own operators.

    Parameters
    ----------
    systems : sequence of systems
        Systems whose inputs have the same names, and whose outputs have different names.

    Raises
    ------
    InvalidValue
        If there are no systems, or if the names do not satisfy these conditions.
    """

    def __init__(self, systems: Sequence[FuzzySystem]) -> None:
        self.systems = listed("systems", systems, "at least one system")
        if not self.systems or not all(isinstance(one, FuzzySystem) for one in self.systems):
            raise InvalidValue("systems", systems, "at least one system")
        self.input_names = self.systems[0].input_names
        for one in self.systems:
            if one.input_names != self.input_names:
                raise InvalidValue(
                    "systems", one.input_names, f"systems with the inputs {self.input_names}"
                )
        self.output_names = tuple(name for one in self.systems for name in one.output_names)
        if len(set(self.output_names)) < len(self.output_names):
            raise InvalidValue("systems", self.output_names, "systems with different outputs")

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self.__dict__:
            raise ReadOnly("a ParallelSystem", name)
        object.__setattr__(self, name, value)

    @property
    def n_outputs(self) -> int:
        """Number of outputs."""
        return len(self.output_names)

    def __repr__(self) -> str:
        return f"ParallelSystem({list(self.systems)!r})"

    def _repr_html_(self) -> Markup:
        """Return the HTML that a notebook shows: the systems one below the other."""
        return joined(one._repr_html_() for one in self.systems)

    def __call__(self, X: Any = None, /, **named: ArrayLike) -> Array:
        """Return the crisp outputs (..., m) of inputs (..., p), or of inputs by name.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs.
        **named
            Inputs as keyword arguments instead of ``X``.

        Returns
        -------
        (..., m) ndarray
            Outputs of the systems in their order; NaN where no rule fires. For a DataFrame or
            Series of pandas, the same type is returned, see :class:`fuzzy2.FuzzySystem`.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        given = () if X is None else (X,)
        values = [np.asarray(one(*given, **named)) for one in self.systems]
        outputs: Array = like_inputs(np.concatenate(values, axis=-1), X, self.output_names)
        return outputs

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals (..., m, 2) of inputs (..., p).

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., m, 2) ndarray
            Left and right ends; NaN where no rule fires.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        return np.concatenate([one.type_reduced(X) for one in self.systems], axis=-2)

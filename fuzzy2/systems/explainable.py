"""Interface that explanations need of a system, so that they do not import systems."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from numpy.typing import ArrayLike, NDArray

from fuzzy2.operations.t_norms import TConorm, TNorm
from fuzzy2.support.checks import Array


class Explainable(Protocol):
    """The part of :class:`fuzzy2.FuzzySystem` that explanations use."""

    inputs: tuple[tuple[Any, ...], ...]
    rules: Any
    consequents: Any
    consequent_sets: tuple[tuple[Any, ...], ...] | None
    consequent_intervals: Array
    consequent_names: tuple[tuple[str, ...], ...] | None
    silent: NDArray[Any] | None
    weights: Array | None
    n_outputs: int
    input_names: tuple[str, ...]
    term_names: tuple[tuple[str, ...], ...]
    output_names: tuple[str, ...]
    output_ranges: tuple[tuple[float, float], ...] | None
    type_reduction: str
    method: str
    shares: tuple[float, float]
    implication: TNorm
    t_conorm: TConorm

    @property
    def explained_by(self) -> Sequence[tuple[float, Explainable]]:
        """Systems whose weighted sum is the output, with their weights."""

    def __call__(self, X: Any = None, /, **named: ArrayLike) -> Array:
        """Return the crisp outputs."""

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals."""

    def firing(self, X: ArrayLike) -> Array:
        """Return the firing intervals of the rules."""

    def one_row(self, x: ArrayLike) -> Array:
        """Return one input as an array (1, p)."""

    def log_firing(self, rows: Array) -> tuple[Array, NDArray[Any]]:
        """Return the logarithms of firing intervals, and where the intervals underflow."""

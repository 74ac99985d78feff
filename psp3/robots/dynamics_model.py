"""What a controller needs of a model of the robot's dynamics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.errors import InvalidValue


class DynamicsModel(Protocol):
    """What a model-based controller needs of a model."""

    def equation_of_motion(
        self, heights: ArrayLike, speeds: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Return mass matrix, Coriolis matrix and gravity vector of a state."""
        ...


def equation_of_motion_of(
    model: DynamicsModel,
) -> Callable[[ArrayLike, ArrayLike], tuple[Array, Array, Array]]:
    """How to get M, C and G of a model: in one call, or from its three methods."""
    whole = getattr(model, "equation_of_motion", None)
    if whole is not None:
        equation: Callable[[ArrayLike, ArrayLike], tuple[Array, Array, Array]] = whole
        return equation
    if all(hasattr(model, name) for name in ("mass_matrix", "coriolis_matrix", "gravity")):
        return lambda a, v: (
            model.mass_matrix(a),  # type: ignore[attr-defined]
            model.coriolis_matrix(a, v),  # type: ignore[attr-defined]
            model.gravity(a),  # type: ignore[attr-defined]
        )
    raise InvalidValue(
        "model",
        model,
        "a model with equation_of_motion, or with mass_matrix, coriolis_matrix and gravity",
    )

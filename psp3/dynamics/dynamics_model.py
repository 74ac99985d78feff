"""What a controller needs of a model of the robot's dynamics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.errors import InvalidValue


@runtime_checkable
class DynamicsModel(Protocol):
    """The equation of motion in actuated coordinates (eq. 3.1).

    A robot is one, and so is each of ``robot.dynamics(name)``: closed form, core, Pinocchio,
    natural orthogonal complement.
    """

    def equation_of_motion(
        self, positions: ArrayLike, speeds: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Return mass matrix and Coriolis matrix, (..., n, n) each, and gravity vector (..., n)."""
        ...

    def actuator_forces(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        """Return the forces of the motors for a motion, (..., n) [N], of hinges [N m]."""
        ...


def equation_of_motion_of(
    model: DynamicsModel,
) -> Callable[[ArrayLike, ArrayLike], tuple[Array, Array, Array]]:
    """Return how to get M, C and G of a model: in one call, or from its three methods."""
    whole = getattr(model, "equation_of_motion", None)
    if whole is not None:
        equation: Callable[[ArrayLike, ArrayLike], tuple[Array, Array, Array]] = whole
        return equation
    if all(hasattr(model, name) for name in ("mass_matrix", "coriolis_matrix", "gravity")):
        return lambda a, v: (model.mass_matrix(a), model.coriolis_matrix(a, v), model.gravity(a))  # type: ignore[attr-defined]
    raise InvalidValue(
        "model",
        model,
        "a model with equation_of_motion, or with mass_matrix, coriolis_matrix and gravity",
    )

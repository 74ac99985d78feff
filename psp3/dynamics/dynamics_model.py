"""The interface of a dynamics model for controllers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.errors import InvalidValue


@runtime_checkable
class DynamicsModel(Protocol):
    """The equation of motion in actuated coordinates (eq. 3.1).

    A robot is such a model, and so is each result of ``robot.dynamics(name)``: closed form, core,
    Pinocchio, natural orthogonal complement.
    """

    def equation_of_motion(
        self, positions: ArrayLike, speeds: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Return mass matrix and Coriolis matrix, (..., n, n) each, and gravity vector (..., n)."""
        ...

    def actuator_forces(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        """Return the forces of the motors for a motion, (..., n) [N], or [N m] for hinges."""
        ...


class StateAfterState:
    """Calls of a model for one state after the other.

    If the model has loops and a ``last_pose``, the loops are closed from the pose of the preceding
    state. Threads may share the object: each has its own pose during a call.

    Parameters
    ----------
    model : object
        A robot, or any other model.
    """

    def __init__(self, model: Any) -> None:
        new_pose = getattr(model, "last_pose", None)
        pose = None if new_pose is None else new_pose()
        self._new_pose: Callable[[], Any] | None = None if pose is None else new_pose
        self._poses = [pose]

    def ask(self, question: Callable[..., Any], *arguments: ArrayLike) -> Any:
        """Return the result of a method of the model, which gets the pose as its ``guess``."""
        if self._new_pose is None:
            return question(*arguments)
        try:
            pose = self._poses.pop()
        except IndexError:
            pose = self._new_pose()
        try:
            return question(*arguments, guess=pose)
        finally:
            self._poses.append(pose)

    def forget(self) -> None:
        """Start from the reference again."""
        self._poses.clear()


class ForcesOfMotions(StateAfterState):
    """The motor forces of one motion after the other.

    They are the model's ``actuator_forces``, or M a + C v + G if a user's model lacks that method.

    Parameters
    ----------
    model : DynamicsModel
        A robot, one of ``robot.dynamics(name)``, or any other.

    Raises
    ------
    InvalidValue
        If the model offers neither.
    """

    def __init__(self, model: DynamicsModel) -> None:
        super().__init__(model)
        self._forces: Any = getattr(model, "actuator_forces", None)
        self._equation = None if self._forces is not None else equation_of_motion_of(model)

    def __call__(self, positions: Array, speeds: Array, accelerations: Array) -> Array:
        """Return the motor forces for a state's accelerations (n,), or for the first ones (k,)."""
        if self._equation is None:
            forces: Array = self.ask(self._forces, positions, speeds, accelerations)
            return forces
        M, C, G = self.ask(self._equation, positions, speeds)
        assembled: Array = M @ accelerations + C @ speeds + G
        return assembled


def checked_model(model: Any) -> None:
    """Raise :class:`InvalidValue` if an object is not a model of a robot's dynamics."""
    if not hasattr(model, "actuator_forces"):
        equation_of_motion_of(model)


def equation_of_motion_of(
    model: DynamicsModel,
) -> Callable[[ArrayLike, ArrayLike], tuple[Array, Array, Array]]:
    """Return a function for M, C and G of a model, which calls one method or three."""
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

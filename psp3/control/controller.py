"""The interface that a simulation needs from a controller."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, TypeGuard

from fuzzy2.support.compiled import chosen_by_table
from psp3.checks import Array
from psp3.trajectories.motion import Motion


class Controller(Protocol):
    """The interface that the simulation needs from a controller."""

    def reset(self) -> None:
        """Forget everything about earlier runs."""
        ...

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the screw forces for the next control period."""
        ...


class Stateless:
    """A controller whose torque depends only on the present."""

    def reset(self) -> None:
        """Do nothing, because this controller has no memory."""


class SaysNothing:
    """A controller that reports nothing except the forces."""

    numbers_said = 0

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Return no reports of the steps of a compiled loop."""
        return {}


class Widths(NamedTuple):
    """The sizes of a controller's inputs and outputs."""

    commanded: int
    """Number of coordinates with a desired motion, k; they come first."""
    positions: int
    """Number of positions of all coordinates, p."""
    speeds: int
    """Number of speeds of all coordinates, n."""
    motors: int
    """Forces, m."""

    @classmethod
    def of_motors(cls, count: int) -> Widths:
        """Return the sizes for a robot whose coordinates are its motors."""
        return cls(count, count, count, count)


def widths_of(robot: Any) -> Widths:
    """Return the sizes of the inputs and outputs of a robot's controller."""
    positions, speeds = len(robot.reference), len(robot.coordinates_v)
    return Widths(robot.commanded, positions, speeds, len(robot.actuated))


def may_be_compiled(controller: Any) -> TypeGuard[CompiledController]:
    """Tell whether a controller is made for the compiled loop.

    An attribute ``table`` alone does not show it: a controller of a user's may keep a table of
    numbers.
    """
    methods = (getattr(controller, name, None) for name in ("table", "take"))
    return all(map(callable, methods)) and hasattr(controller, "numbers_said")


class CompiledController(Controller, Protocol):
    """A controller that can also run in the compiled loop."""

    numbers_said: int
    """Number of reports that a step writes after the m forces."""

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for :func:`steer`, or None if it cannot be compiled.

        ``robot`` is the controlled robot's table, or None if it has none. A controller without a
        model uses it as its model, so the loop need not be compiled for another model type.
        """
        ...

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Take the state after the last step, and return the reports of all steps.

        The steps are the numbers that :func:`steer` wrote, (N, m + numbers_said).
        """
        ...


@chosen_by_table
def steer(
    controller: Any,
    sample: int,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Write a step's numbers, the forces first; return whether these are finite.

    ``desired`` are positions, speeds and accelerations (3k,) of the commanded coordinates.
    """
    raise NotImplementedError

"""What a simulation needs of a controller."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from fuzzy2.support.compiled import chosen_by_table
from psp3.checks import Array
from psp3.trajectories.motion import Motion


class Controller(Protocol):
    """What the simulation needs of a controller."""

    def reset(self) -> None:
        """Forget everything about earlier runs."""
        ...

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the screw forces for the next control period."""
        ...


class Stateless:
    """A controller whose torque depends on the present only."""

    def reset(self) -> None:
        """Forget nothing: this controller remembers nothing."""


class SaysNothing:
    """A controller that says nothing of its steps but the forces."""

    numbers_said = 0

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Return what is reported of the steps of a compiled loop: nothing."""
        return {}


class Widths(NamedTuple):
    """How many numbers a controller is given, and gives."""

    commanded: int
    """Coordinates of which a motion is desired, k; they are the first ones."""
    positions: int
    """Positions of all coordinates, p."""
    speeds: int
    """Speeds of all coordinates, n."""
    motors: int
    """Forces, m."""

    @classmethod
    def of_motors(cls, count: int) -> Widths:
        """Return those of a robot whose coordinates are its motors."""
        return cls(count, count, count, count)


def widths_of(robot: Any) -> Widths:
    """Return what a controller of a robot is given, and gives."""
    positions, speeds = len(robot.reference), len(robot.coordinates_v)
    return Widths(robot.commanded, positions, speeds, len(robot.actuated))


class CompiledController(Controller, Protocol):
    """A controller that the compiled loop takes, too."""

    numbers_said: int
    """Numbers that a step writes after the m forces: what the controller says of the step."""

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller as :func:`steer` takes it, or None where it cannot be compiled.

        ``robot`` is a table of what is steered, or None if it has none, for a controller without a
        model of its own: the loop is then not compiled for yet another model.
        """
        ...

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Be as after the last of the steps, and return what is reported of all.

        The steps are what :func:`steer` wrote, (N, m + numbers_said).
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

    ``desired`` are positions, speeds and accelerations (3k,) of the coordinates that are commanded.
    """
    raise NotImplementedError

"""What a simulation needs of a controller."""

from __future__ import annotations

from typing import Protocol

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

"""Controllers that keep what they were given."""

from __future__ import annotations

import numpy as np

from psp3.trajectories import Motion


class Recording:
    """A controller that writes down what it was given and asks for fixed forces."""

    def __init__(self, torque: object = (80.0, 85.0, 90.0), bad_from: float = np.inf) -> None:
        self.torque_given, self.bad_from = torque, bad_from
        self.calls: list[tuple[float, np.ndarray, np.ndarray, Motion]] = []
        self.resets = 0

    def reset(self) -> None:
        """Count the calls."""
        self.resets += 1

    def torque(self, t: float, heights: np.ndarray, speeds: np.ndarray, desired: Motion) -> object:
        """Write the arguments down and spoil them."""
        self.calls.append((t, heights.copy(), speeds.copy(), desired))
        # what a controller does to its arguments must change nothing
        heights[:] = speeds[:] = np.nan
        return (
            self.torque_given if t >= self.bad_from or self.bad_from == np.inf else np.full(3, 87.0)
        )

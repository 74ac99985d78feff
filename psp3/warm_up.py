"""Compile every kernel once, so that the first user of a fresh installation does not wait: ``python -m psp3.warm_up``."""

from __future__ import annotations

import numpy as np


def warm_up() -> None:
    """Call every compiled function; with a writable cache directory, later processes load what this one compiled."""
    from psp3.controllers import ComputedTorque
    from psp3.loading import load
    from psp3.simulation import simulate
    from psp3.trajectories import Helix

    robot = load("psp3")
    rest = np.zeros(3)
    robot.configuration(rest)
    robot.tip_jacobian(rest)
    robot.inverse_dynamics(rest, rest, rest)
    robot.forward_dynamics(rest, rest, rest)
    robot.kinetic_energy(rest, rest)
    simulate(robot, ComputedTorque(robot), Helix(robot=robot), 0.01)


if __name__ == "__main__":
    warm_up()

"""What the exported functions of a controller do: a step and a reset, around the kernels of loops.

They are plain Python that is translated, and never compiled: what they call is.
"""

from __future__ import annotations

import numpy as np

from psp3.control.controller import steer


def step(controller, t, positions, speeds, desired, torque):
    """Write the torque of a step; return 1, or 0 where it is not finite."""
    return 1 if steer(controller, 0, t, positions, speeds, desired, torque) else 0


def learned_step(controller, t, positions, speeds, desired, torque, interval, flags):
    """Write the torque of a step of a learned controller, and what is known of it.

    Return 1, or 0 where the torque is not finite.
    """
    n = torque.size
    out = np.empty(3 * n + 2)
    done = steer(controller, 0, t, positions, speeds, desired, out)
    for i in range(n):
        torque[i] = out[i]
    for i in range(2 * n):
        interval[i] = out[n + i]
    flags[0], flags[1] = out[3 * n], out[3 * n + 1]
    return 1 if done else 0


def copied(source, target):
    """Copy numbers."""
    for i in range(source.size):
        target[i] = source[i]


def zeroed(target):
    """Write zeros."""
    for i in range(target.size):
        target[i] = 0.0


def reset_classical(controller, reference):
    """Forget the integral, and start in the reference pose where a model has loops to close."""
    for row in range(controller.memory.shape[0]):
        zeroed(controller.memory[row])
    zeroed(controller.clock)
    if reference.size > 0:
        copied(reference, controller.model.memory)


def reset_learned(controller, reference):
    """Start in the reference pose where the exact model has loops to close."""
    if reference.size > 0:
        copied(reference, controller.model.memory)

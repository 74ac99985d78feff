"""Plants to compare, and what they do in a while."""

from __future__ import annotations

from typing import Any

import numpy as np


def after(
    plant: Any, heights: Any, speeds: Any, forces: Any, duration: float, periods: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Return the state of a plant after some time under constant forces."""
    plant.start(np.array(heights, dtype=float), np.array(speeds, dtype=float))
    state = None
    for _ in range(periods):
        state = plant.advance(np.array(forces, dtype=float), duration / periods)
        assert state is not None
    assert state is not None
    return state[0].copy(), state[1].copy()

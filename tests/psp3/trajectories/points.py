"""Points to move between, and files of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

HOME = np.array([0.0, 0.0, 0.07])

NEAR = np.array([0.01, -0.012, 0.10])


def spline_file(path: Path, columns: str = "t,x,y,z") -> Path:
    times = np.linspace(0.0, 2.0, 21)
    table = np.column_stack(
        [times, 0.01 * np.sin(times), 0.01 * np.cos(times), 0.08 + 0.01 * times]
    )
    path.write_text(
        columns
        + "\n"
        + "\n".join(",".join(f"{value:.12g}" for value in row) for row in table)
        + "\n"
    )
    return path


NAMES = [
    "helix",
    "circle",
    "line",
    "point to point",
    "hold",
    "waypoints",
    "tip file",
    "heights file",
    "joints",
    "joint waypoints",
    "joint hold",
]

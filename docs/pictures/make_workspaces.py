"""Draw the map in the guide to workspaces and singularities anew.

Run by ``make pictures``, or ``python docs/pictures/make_workspaces.py``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import psp3
from fuzzy2.plots.style import style
from psp3.kinematics.workspace import Workspace
from psp3.plots.workspace import figure_of_map


def main() -> None:
    """Write ``workspace_five_bar.png``."""
    space = Workspace(psp3.load("five_bar"), "tip", ("x", "z"))
    poses = space.map({"x": np.linspace(-0.42, 0.42, 85), "z": np.linspace(-0.5, 0.3, 81)})
    with style():
        figure = figure_of_map(poses, space.boundary(poses))[0].figure
        figure.savefig(
            Path(__file__).parent / "workspace_five_bar.png", dpi=90, metadata={"Software": None}
        )


if __name__ == "__main__":
    main()

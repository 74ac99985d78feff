"""Figures with matplotlib: of runs, tubes, controllers, studies and workspaces.

Those of the thesis are in ``psp3.thesis.figures``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.plots.bounds import figure_of_tube as figure_of_tube
    from psp3.plots.control import figure_of_differences as figure_of_differences
    from psp3.plots.control import figure_of_tracking as figure_of_tracking
    from psp3.plots.joints import figure_of_joint_forces as figure_of_joint_forces
    from psp3.plots.joints import figure_of_joint_tracking as figure_of_joint_tracking
    from psp3.plots.study import figure_of_sweep as figure_of_sweep
    from psp3.plots.three_psp import figure_of_torques as figure_of_torques
    from psp3.plots.three_psp import figure_of_workspace as figure_of_workspace

__all__, __getattr__, __dir__ = lazy_names(__name__)

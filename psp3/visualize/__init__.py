"""The robot in the browser.

:class:`Scene` for files and notebooks, :class:`Viewer` for a live view, on MeshCat.

.. code-block:: python

    robot = psp3.load("psp3")
    result = psp3.simulate(robot, psp3.PD(), psp3.trajectories.Helix(robot=robot), duration=4.0)
    Scene(robot).animate(result).write_html("pd.html")
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.visualize.scene import Scene as Scene
    from psp3.visualize.scene import write_animation as write_animation
    from psp3.visualize.viewer import Viewer as Viewer

__all__, __getattr__, __dir__ = lazy_names(__name__)

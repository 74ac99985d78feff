"""See the robot in the browser: :class:`Scene` for files and notebooks, :class:`Viewer` for a live view, on MeshCat.

.. code-block:: python

    robot = psp3.load("psp3")
    result = psp3.simulate(robot, psp3.PD(), psp3.trajectories.Helix(robot=robot), duration=4.0)
    Scene(robot).animate(result).write_html("pd.html")
"""

from psp3.scene import Scene, write_animation
from psp3.viewer import Viewer

__all__ = ["Scene", "Viewer", "write_animation"]

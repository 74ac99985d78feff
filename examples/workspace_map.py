"""The workspace of a five-bar linkage: reachable positions of the tip, and singularities."""

import numpy as np

import psp3
from psp3.kinematics.pose_map import Status
from psp3.plots.workspace import figure_of_map

robot = psp3.load("five_bar")
space = psp3.Workspace(robot, "tip", ("x", "z"))
poses = space.map({"x": np.linspace(-0.42, 0.42, 29), "z": np.linspace(-0.5, 0.3, 33)})
for status in Status:
    print(f"{status.name:12s} {100 * np.mean(poses.status == status):3.0f} %")

figure_of_map(poses)[0].figure.savefig("five_bar.png", dpi=120)
print("five_bar.png")

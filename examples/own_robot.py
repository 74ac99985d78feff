"""A robot of your own: load a URDF and a loop file, compute its dynamics, and animate it."""

from pathlib import Path

import numpy as np

import psp3
from psp3.visualize import Scene

# four_bar.yaml beside it says which frames coincide, and which joint has the motor.
robot = psp3.load(Path(__file__).parent / "four_bar.urdf")
print(robot.mobility)

angles = np.linspace(-3.0, 3.0, 7)[:, None]  # one motor: (samples, 1) [rad]
speeds, accelerations = np.full_like(angles, 5.0), np.zeros_like(angles)
tips = robot.tip(angles)
torques = robot.inverse_dynamics(angles, speeds, accelerations)
for angle, tip, torque in zip(angles, tips, torques, strict=True):
    print(f"crank {angle[0]:5.1f} rad: tip at {tip[[0, 2]].round(3)} m, {torque[0]:6.3f} N m")

motion = psp3.trajectories.Sway(robot=robot)
Scene(robot).animate(motion, 4.0).write_html("four_bar.html")
print("open four_bar.html in a browser")

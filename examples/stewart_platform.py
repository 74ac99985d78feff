"""A Gough-Stewart platform: its pose from six legs, and the forces that hold it."""

import numpy as np

import psp3

robot = psp3.load("gough_stewart")
rest = np.zeros(6)
poses = {
    "home": robot.reference,
    "20 mm up": robot.reference + 0.02,
    "tilted": robot.reference + 0.02 * np.array([1, 1, 0, 0, -1, -1]),
}
for name, lengths in poses.items():
    placement = robot.frame_placement(lengths, "tip")
    tilt = np.degrees(np.arctan2(np.hypot(*placement[:2, 2]), placement[2, 2]))
    forces = robot.inverse_dynamics(lengths, rest, rest)  # gravity alone [N]
    print(f"{name}: at {placement[:3, 3].round(3) + 0.0} m, tilted by {tilt:.1f} degrees")
    print("  legs push by", forces.round(1), "N")

# A push of 100 N to the side at the tip: the legs' share of it is J^T f.
jacobian = robot.frame_jacobian(robot.reference, "tip")  # linear, then angular velocity
print("100 N along x:", (jacobian.T @ [100, 0, 0, 0, 0, 0]).round(1), "N")

"""Inverse dynamics of a Delta robot: torque and power of its motors at increasing speed."""

import numpy as np

import psp3

robot = psp3.load("delta")
time = np.linspace(0.0, 1.0, 101)
for period in (1.0, 0.5, 0.25):
    motion = psp3.trajectories.Sway(period=period, robot=robot)(time)
    # All samples at once: (101, 3) in, (101, 3) out [N m].
    torques = robot.inverse_dynamics(motion.positions, motion.speeds, motion.accelerations)
    power = torques * motion.speeds
    way = np.linalg.norm(np.diff(motion.tip, axis=0), axis=1).sum()
    print(
        f"tip {way:.2f} m in a second: at most {np.abs(torques).max():.2f} N m "
        f"and {power.max():.1f} W a motor"
    )
np.savetxt("delta_torques.csv", np.column_stack([time, torques]), delimiter=",")
print("delta_torques.csv has the torques of the fastest")

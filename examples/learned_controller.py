"""A fuzzy controller that learns the robot's dynamics, compared with PD and the exact model."""

import numpy as np

import psp3
from psp3.visualize import write_animation

robot = psp3.load("psp3")
helix = psp3.trajectories.Helix(radius=0.020, period=2.0, rise=0.010)
learned = psp3.FuzzyComputedTorque("it2", robot, learner="average", snr_db=20.0)
learned.fit(helix, rng=np.random.default_rng(0))
learned.save("learned.json")
print(learned, "is in learned.json")

controllers = {"pd": psp3.PD(), "learned": learned, "exact": psp3.ComputedTorque(robot)}
results = {}
for name, controller in controllers.items():
    results[name] = psp3.simulate(robot, controller, helix, duration=4.0)
    error = 1e3 * np.linalg.norm(results[name].tip - results[name].desired.tip, axis=1)
    print(f"{name:8s} tip off by {error[-1]:6.2f} mm at the end, {error.mean():6.2f} mm on average")

write_animation(robot, results, "controllers.html")
print("open controllers.html in a browser")

"""Work that would take minutes, to be interrupted: every compiled loop, batch, search and learner.

Each function prepares one kind, and returns what does it again and again. Sizes are such that one
call takes seconds, of which none may pass without a look at Ctrl-C.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import fuzzy2
import psp3
from psp3.identification.base_parameters import base_parameters
from psp3.identification.unknowns import all_parameters
from psp3.simulation.runge_kutta import RungeKutta

Work = Callable[[], object]


def rows(*shape: int) -> NDArray[np.float64]:
    return np.random.default_rng(3).uniform(0.0, 1.0, shape)


def system(
    terms: int = 5, t2: bool = False, gt2: bool = False, sets: bool = False, **more: Any
) -> Any:
    means = np.linspace(0.0, 1.0, terms)
    width = 0.5 / terms
    one: list[Any]
    kind: Any
    if gt2:
        one = [fuzzy2.GaussianType2Set(fuzzy2.Gaussian(m, width), 0.05) for m in means]
        kind = fuzzy2.GeneralType2System
    elif t2:
        one = [fuzzy2.GaussianUncertainMean((m - 0.02, m + 0.02), width) for m in means]
        kind = fuzzy2.IntervalType2System
    else:
        one = [fuzzy2.Gaussian(m, width) for m in means]
        kind = fuzzy2.Type1System
    rules = np.array(list(itertools.product(range(terms), repeat=2)))
    if sets:
        more["type_reduction"] = "centroid"
        return kind([one, one], rules, [[one[a]] for a, _ in rules], **more)
    return kind([one, one], rules, rows(len(rules), 1), **more)


def around(robot: Any, count: int, spread: float = 0.05) -> NDArray[np.float64]:
    n = len(robot.reference)
    moved: NDArray[np.float64] = robot.reference + spread * (2.0 * rows(count, n) - 1.0)
    return moved


def still(robot: Any) -> psp3.trajectories.PointToPoint:
    return psp3.trajectories.PointToPoint(robot.reference, robot.reference + 0.01, 1.0, robot)


def again(call: Work) -> Work:
    """Return what does something without end."""

    def work() -> None:
        while True:
            call()

    return work


# fuzzy2: batches; systems of all ways from rules to outputs; learners.


def evaluated(count: int, **kind: Any) -> Work:
    s, x = system(**kind), rows(count, 2)
    return again(lambda: s(x))


def type_reduced() -> Work:
    s, x = system(t2=True), rows(4_000_000, 2)
    return again(lambda: s.type_reduced(x))


def firing() -> Work:
    s, x = system(t2=True, terms=15), rows(300_000, 2)
    return again(lambda: s.firing(x))


def alpha_cuts() -> Work:
    s, x = system(gt2=True), rows(1_000_000, 2)
    return again(lambda: s.alpha_cuts(x))


def adaptation() -> Work:
    s, x = fuzzy2.AdaptiveConsequents(system(terms=9)), rows(200_000, 2)
    return again(lambda: s.update(x, x[:, :1]))


def fine_tuning() -> Work:
    s, x, rng = system(t2=True, terms=7), rows(300_000, 2), np.random.default_rng(3)
    return again(lambda: fuzzy2.fine_tune(s, x, x[:, 0], rng))


def anfis() -> Work:
    x, learner = rows(30_000, 2), fuzzy2.ANFIS(n_terms=7)
    return again(lambda: learner.fit(x, np.sin(9.0 * x[:, 0])))


def wang_mendel() -> Work:
    x, learner = rows(300_000, 2), fuzzy2.WangMendel()
    return again(lambda: learner.fit(x, x[:, 0]))


def clusters() -> Work:
    x = rows(100_000, 2)
    return again(lambda: fuzzy2.fuzzy_c_means(x, 40))


def subtractive_clusters() -> Work:
    x = rows(30_000, 2)
    return again(lambda: fuzzy2.subtractive_clustering(x, 0.05))


def centroids() -> Work:
    w = np.sort(rows(100_000, 2, 40), axis=1)
    return again(lambda: fuzzy2.centroid(np.arange(40.0), w[:, 0], w[:, 1]))


def exhaustive_centroid() -> Work:
    z = [fuzzy2.SampledSet(*rows(2, 4)) for _ in range(12)]
    return again(lambda: fuzzy2.exhaustive_generalized_centroid(range(12), z, limit=10**8))


# psp3: batches, paths, simulations, searches, learning, studies.


def inverse_dynamics() -> Work:
    robot = psp3.load("psp3")
    q = around(robot, 3_000_000)
    return again(lambda: robot.inverse_dynamics(q, q, q))


def forward_dynamics() -> Work:
    robot: Any = psp3.load("delta")
    q = around(robot, 2_000_000)
    return again(lambda: robot.forward_dynamics(q, q, q))


def derivatives() -> Work:
    robot: Any = psp3.load("delta")
    q = around(robot, 200_000)
    return again(lambda: psp3.inverse_dynamics_derivatives(robot, q, q, q))


def a_path() -> Work:
    robot: Any = psp3.load("gough_stewart")
    q = around(robot, 1_000_000)
    return again(lambda: robot.configurations_along(q))


def far_poses() -> Work:
    robot: Any = psp3.load("delta")
    q = iter(around(robot, 100_000, 0.9))

    def refused() -> None:
        try:
            robot.configuration(next(q))
        except psp3.PSP3Error:
            return

    return again(refused)


def simulation(name: str, duration: float, plant: Callable[[Any], Any] = lambda _: None) -> Work:
    robot: Any = psp3.load(name)
    controller, way, there = psp3.ComputedTorque(robot, 900, 60), still(robot), plant(robot)
    more = {} if there is None else {"plant": there}
    return again(lambda: psp3.simulate(robot, controller, way, duration, **more))


def workspace() -> Work:
    robot: Any = psp3.load("delta")
    grid = {k: np.linspace(-0.1, 0.1, 90) - 0.6 * (k == "z") for k in "xyz"}
    return again(lambda: psp3.Workspace(robot, "tip", ("x", "y", "z")).map(grid))


def identification() -> Work:
    robot = psp3.load("psp3")
    base = base_parameters(all_parameters(robot))
    t = np.linspace(0.0, 1.0, 100_000)
    q = robot.reference + 0.01 * np.sin(2 * np.pi * t[:, None] + np.arange(3))
    forces = robot.inverse_dynamics(q, q, q)
    return again(lambda: psp3.identify(base, t, q, forces, 1.0))


def exciting_motion() -> Work:
    base = base_parameters(all_parameters(psp3.load("psp3")))
    return again(lambda: psp3.exciting_motion(base, 1.0, 3, draws=10**6))


def conformal_intervals() -> Work:
    y = rows(1_000_000, 3)
    intervals = np.stack([y - 0.1, y + 0.1], -1)
    return again(lambda: psp3.ConformalIntervals(y, intervals))


def training() -> Work:
    robot = psp3.load("psp3")
    controller = psp3.FuzzyComputedTorque("gt2", robot)
    return again(lambda: controller.fit(psp3.trajectories.Circle(robot=robot), 4000.0))


def a_study() -> Work:
    runs = psp3.grid(controller=["it2"], snr_db=[20.0], seed=range(10_000))
    study = psp3.Study("runs.sqlite", runs)
    return again(lambda: study.run(1))


LONG_WORK: dict[str, Callable[[], Work]] = {
    "system": lambda: evaluated(3_000_000),
    "type-reduced": type_reduced,
    "firing": firing,
    "alpha-cuts": alpha_cuts,
    "general type 2": lambda: evaluated(2_000_000, gt2=True),
    "corollary": lambda: evaluated(9_000_000, gt2=True, reduction="gaussian"),
    "centroid of unions": lambda: evaluated(2_000_000, t2=True, sets=True),
    "adaptation": adaptation,
    "fine tuning": fine_tuning,
    "anfis": anfis,
    "wang-mendel": wang_mendel,
    "clusters": clusters,
    "subtractive clusters": subtractive_clusters,
    "centroids": centroids,
    "exhaustive centroid": exhaustive_centroid,
    "inverse dynamics": inverse_dynamics,
    "forward dynamics": forward_dynamics,
    "derivatives": derivatives,
    "a path": a_path,
    "far poses": far_poses,
    "simulation": lambda: simulation("psp3", 4000.0),
    "simulation of many steps": lambda: simulation(
        "delta", 100.0, lambda robot: RungeKutta(robot, 10_000)
    ),
    "simulation in MuJoCo": lambda: simulation(
        "delta", 100.0, lambda robot: psp3.MuJoCo(robot, 10_000)
    ),
    "workspace": workspace,
    "identification": identification,
    "exciting motion": exciting_motion,
    "conformal intervals": conformal_intervals,
    "training": training,
    "a study in one process": a_study,
}
"""What prepares each kind of work, by name."""

"""Ctrl-C ends whatever takes long within a second of computing.

Each of these would take minutes. The time is that of the process, so that a busy machine is no
failure; where two threads compute, both count.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.processes import ENVIRONMENT

MOST = 1.0
"""Seconds of computing of one thread after the signal."""

LONG_WORK = {
    # fuzzy2: batches; systems of all ways from rules to outputs; learners.
    "system": """
s = system()
X = rows(3_000_000, 2)
work = lambda: [s(X) for _ in forever]
""",
    "type-reduced": """
s = system(t2=True)
X = rows(4_000_000, 2)
work = lambda: [s.type_reduced(X) for _ in forever]
""",
    "firing": """
s = system(t2=True, terms=15)
X = rows(300_000, 2)
work = lambda: [s.firing(X) for _ in forever]
""",
    "alpha-cuts": """
s = system(gt2=True)
X = rows(1_000_000, 2)
work = lambda: [s.alpha_cuts(X) for _ in forever]
""",
    "general type 2": """
s = system(gt2=True)
X = rows(2_000_000, 2)
work = lambda: [s(X) for _ in forever]
""",
    "corollary": """
s = system(gt2=True, reduction='gaussian')
X = rows(9_000_000, 2)
work = lambda: [s(X) for _ in forever]
""",
    "centroid of unions": """
s = system(t2=True, sets=True)
X = rows(2_000_000, 2)
work = lambda: [s(X) for _ in forever]
""",
    "adaptation": """
s = fuzzy2.AdaptiveConsequents(system(terms=9))
X = rows(200_000, 2)
work = lambda: [s.update(X, X[:, :1]) for _ in forever]
""",
    "fine tuning": """
s = system(t2=True, terms=7)
X = rows(300_000, 2)
work = lambda: [fuzzy2.fine_tune(s, X, X[:, 0], rng) for _ in forever]
""",
    "anfis": """
X = rows(30_000, 2)
a = fuzzy2.ANFIS(n_terms=7)
work = lambda: [a.fit(X, np.sin(9 * X[:, 0])) for _ in forever]
""",
    "wang-mendel": """
X = rows(300_000, 2)
a = fuzzy2.WangMendel()
work = lambda: [a.fit(X, X[:, 0]) for _ in forever]
""",
    "clusters": """
X = rows(100_000, 2)
work = lambda: [fuzzy2.fuzzy_c_means(X, 40) for _ in forever]
""",
    "subtractive clusters": """
X = rows(30_000, 2)
work = lambda: [fuzzy2.subtractive_clustering(X, 0.05) for _ in forever]
""",
    "centroids": """
w = np.sort(rows(100_000, 2, 40))
w.sort(axis=1)
work = lambda: [fuzzy2.centroid(np.arange(40.), w[:, 0], w[:, 1]) for _ in forever]
""",
    "exhaustive centroid": """
z = [fuzzy2.SampledSet(rows(4), rows(4)) for _ in range(12)]
work = lambda: [fuzzy2.exhaustive_generalized_centroid(range(12), z, limit=10**8) for _ in forever]
""",
    # psp3: batches, paths, simulations, searches, learning, studies.
    "inverse dynamics": """
r = psp3.load('psp3')
q = around(r, 3_000_000)
work = lambda: [r.inverse_dynamics(q, q, q) for _ in forever]
""",
    "forward dynamics": """
r = psp3.load('delta')
q = around(r, 2_000_000)
work = lambda: [r.forward_dynamics(q, q, q) for _ in forever]
""",
    "derivatives": """
r = psp3.load('delta')
q = around(r, 200_000)
work = lambda: [psp3.inverse_dynamics_derivatives(r, q, q, q) for _ in forever]
""",
    "a path": """
r = psp3.load('gough_stewart')
q = around(r, 1_000_000)
work = lambda: [r.configurations_along(q) for _ in forever]
""",
    "far poses": """
r = psp3.load('delta')
q = around(r, 100_000, 0.9)
work = lambda: [refused(lambda: r.configuration(row)) for row in q]
""",
    "simulation": """
r = psp3.load('psp3')
c = psp3.ComputedTorque(r, 900, 60)
work = lambda: [psp3.simulate(r, c, still(r), 4000.0) for _ in forever]
""",
    "simulation of many steps": """
r = psp3.load('delta')
c = psp3.ComputedTorque(r, 900, 60)
plant = psp3.simulation.runge_kutta.RungeKutta(r, 10_000)
work = lambda: [psp3.simulate(r, c, still(r), 100.0, plant=plant) for _ in forever]
""",
    "simulation in MuJoCo": """
r = psp3.load('delta')
c = psp3.ComputedTorque(r, 900, 60)
work = lambda: [psp3.simulate(r, c, still(r), 100.0, plant=psp3.MuJoCo(r, 10_000)) for _ in forever]
""",
    "workspace": """
r = psp3.load('delta')
grid = {k: np.linspace(-0.1, 0.1, 90) - 0.6 * (k == 'z') for k in 'xyz'}
work = lambda: [psp3.Workspace(r, 'tip', ('x', 'y', 'z')).map(grid) for _ in forever]
""",
    "identification": """
from psp3.identification.base_parameters import base_parameters
from psp3.identification.unknowns import all_parameters
r = psp3.load('psp3')
b = base_parameters(all_parameters(r))
t = np.linspace(0.0, 1.0, 100_000)
q = r.reference + 0.01 * np.sin(2 * np.pi * t[:, None] + np.arange(3))
f = r.inverse_dynamics(q, q, q)
work = lambda: [psp3.identify(b, t, q, f, 1.0) for _ in forever]
""",
    "exciting motion": """
from psp3.identification.base_parameters import base_parameters
from psp3.identification.unknowns import all_parameters
b = base_parameters(all_parameters(psp3.load('psp3')))
work = lambda: [psp3.exciting_motion(b, 1.0, 3.0, draws=10**6) for _ in forever]
""",
    "conformal intervals": """
y = rows(1_000_000, 3)
i = np.stack([y - 0.1, y + 0.1], -1)
work = lambda: [psp3.ConformalIntervals(y, i) for _ in forever]
""",
    "training": """
r = psp3.load('psp3')
c = psp3.FuzzyComputedTorque('gt2', r)
work = lambda: [c.fit(psp3.trajectories.Circle(robot=r), 4000.0) for _ in forever]
""",
    "a study in one process": """
s = psp3.Study('runs.sqlite', psp3.grid(controller=['it2'], snr_db=[20.0], seed=range(10_000)))
work = lambda: s.run(1)
""",
}

PREPARED = """
import itertools, sys, time
import numpy as np
import fuzzy2, psp3, psp3.errors
forever = itertools.count()
rng = np.random.default_rng(3)

def rows(*shape):
    return rng.uniform(0.0, 1.0, shape)

def system(terms=5, t2=False, gt2=False, sets=False, **more):
    means = np.linspace(0.0, 1.0, terms)
    width = 0.5 / terms
    if gt2:
        one = [fuzzy2.GaussianType2Set(fuzzy2.Gaussian(m, width), 0.05) for m in means]
    elif t2:
        one = [fuzzy2.GaussianUncertainMean((m - 0.02, m + 0.02), width) for m in means]
    else:
        one = [fuzzy2.Gaussian(m, width) for m in means]
    rules = np.array(list(itertools.product(range(terms), repeat=2)))
    kind = fuzzy2.IntervalType2System if t2 else fuzzy2.Type1System
    kind = fuzzy2.GeneralType2System if gt2 else kind
    if sets:
        more['type_reduction'] = 'centroid'
        return kind([one, one], rules, [[one[a]] for a, _ in rules], **more)
    return kind([one, one], rules, rows(len(rules), 1), **more)

def around(robot, count, spread=0.05):
    return robot.reference + rng.uniform(-spread, spread, (count, len(robot.reference)))

def still(robot):
    return psp3.trajectories.PointToPoint(robot.reference, robot.reference + 0.01, 1.0, robot)

def refused(call):
    try:
        call()
    except psp3.PSP3Error:
        pass
"""

ENDED = """
try:
    print("begun", flush=True)
    work()
    print("done")
except (KeyboardInterrupt, psp3.errors.StudyInterrupted):
    print("ended", time.process_time())
"""


def computed(process: int) -> float:
    """Return the seconds that a process has computed."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.slow
@pytest.mark.parametrize("name", LONG_WORK)
def test_ctrl_c_ends_long_work_within_a_second(name: str, tmp_path: Path) -> None:
    code = PREPARED + LONG_WORK[name] + ENDED
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, **ENVIRONMENT},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler) and None,
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    # What is called for the first time may still be loaded; the same moments each time.
    wait = np.random.default_rng(len(name)).uniform(0.5, 2.0)
    before = computed(process.pid)
    while line and computed(process.pid) < before + wait and process.poll() is None:
        time.sleep(0.02)
    before = computed(process.pid)
    process.send_signal(signal.SIGINT)
    out, error = process.communicate()
    assert line + out, error
    assert out.startswith("ended"), (line, out, error)
    assert float(out.split()[1]) - before < MOST * len(os.sched_getaffinity(0))

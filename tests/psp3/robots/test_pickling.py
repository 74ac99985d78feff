"""Robots that are pickled, copied and forked answer as before, to the bit."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_array_equal

import psp3
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.pickling import constraints, plain
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, ROBOTS_WITH_LOOPS
from tests.processes import ENVIRONMENT

WAYS = {
    "pickle": lambda robot: pickle.loads(pickle.dumps(robot)),
    "deepcopy": copy.deepcopy,
    "copy": copy.copy,
}


def answers(robot: Any) -> list[Any]:
    """Return what each implementation, Pinocchio's data and the loops say of one state."""
    n = len(robot.coordinates_v)
    x, v, a = robot.reference.copy(), np.full(n, 0.3), np.full(n, -0.2)
    # A floating base, which is last, stays where it is.
    x[: n if len(x) == n else -7] += 0.01
    frame = robot.model.frames[-1].name
    return [
        robot.inverse_dynamics(x, v, a),
        robot.forward_dynamics(x, v, a),
        *robot.equation_of_motion(x, v),
        robot.kinetic_energy(x, v),
        robot.frame_jacobian(x, frame),
        robot.constraint_jacobian(robot.configuration(x)),
        robot.dynamics("core").inverse_dynamics(x, v, a),
        *robot.limits,
    ]


def assert_same(robot: Any, other: Any) -> None:
    for one, two in zip(answers(robot), answers(other), strict=True):
        assert_array_equal(one, two)
    assert str(robot.mobility) == str(other.mobility)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    "name", ["psp3", "five_bar", "delta", "agile_eye", "hexa", "gripper", "biped"]
)
def test_copies_of_shipped_robots_answer_as_the_robot(name: str, way: str) -> None:
    robot: Any = psp3.load(name)
    other = WAYS[way](robot)
    assert type(other) is type(robot)
    assert_same(robot, other)
    assert (other.title, other.urdf, other.srdf) == (robot.title, robot.urdf, robot.srdf)
    assert other.visual_model.ngeoms == robot.visual_model.ngeoms


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("builder", ROBOTS_WITH_LOOPS + ROBOTS_WITH_LIE_GROUPS)
def test_copies_of_robots_with_every_joint(builder: Any, way: str) -> None:
    parts = builder()
    robot = ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
    assert_same(robot, WAYS[way](robot))


@pytest.mark.parametrize("way", ["pickle", "deepcopy"])
def test_a_deep_copy_has_a_model_of_its_own(way: str) -> None:
    """Gravity of the one is not gravity of the other, and each core reads its own model's."""
    robot: Any = psp3.load("delta")
    other = WAYS[way](robot)
    rest, x = np.zeros(3), robot.reference
    before = robot.inverse_dynamics(x, rest, rest)
    other.model.gravity = pin.Motion.Zero()
    assert_array_equal(robot.inverse_dynamics(x, rest, rest), before)
    assert np.abs(other.inverse_dynamics(x, rest, rest)).max() < 1e-12
    assert np.abs(other.gravity(x)).max() < 1e-12


def test_closures_come_back_as_they_were() -> None:
    """With names and Baumgarte's gains, which users set."""
    for name in ("delta", "psp3"):
        robot: Any = psp3.load(name)
        robot.constraint_models[0].m_baumgarte_parameters.Kp = 3.0
        again = constraints(robot.model, pickle.loads(pickle.dumps(plain(robot.constraint_models))))
        assert len(again) == len(robot.constraint_models)
        for one, two in zip(robot.constraint_models, again, strict=True):
            assert one == two
            assert (one.name, one.type) == (two.name, two.type)
        assert again[0].m_baumgarte_parameters.Kp == 3.0


READ = """
import pickle, sys
import numpy as np
robot = pickle.loads(open(sys.argv[1], "rb").read())
n = len(robot.actuated)
print(robot.inverse_dynamics(robot.reference + 0.01, np.ones(n), np.ones(n)).tobytes().hex())
# Numbers of another kind must not be compiled for anew.
from psp3.multibody.motion import answer
robot.inverse_dynamics([0] * n, [0] * n, np.zeros(n, dtype=np.int64))
assert len(answer.signatures) == 1
"""

FORK = """
import os
import numpy as np
import psp3
robot = psp3.load("delta")
before = robot.inverse_dynamics(robot.reference + 0.01, np.ones(3), np.ones(3))
rows = robot.reference + 0.01 * np.ones((200, 3))
child = os.fork()
if child == 0:
    again = robot.inverse_dynamics(robot.reference + 0.01, np.ones(3), np.ones(3))
    many = robot.inverse_dynamics(rows, np.ones(3), np.ones(3))
    os._exit(0 if (again == before).all() and abs(many - before).max() < 1e-9 else 1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
"""


@pytest.mark.slow
def test_another_process_reads_a_pickled_robot(tmp_path: Path) -> None:
    robot: Any = psp3.load("delta")
    file = tmp_path / "robot.pickle"
    file.write_bytes(pickle.dumps(robot))
    command = [sys.executable, "-c", READ, str(file)]
    done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, check=True)
    expected = robot.inverse_dynamics(robot.reference + 0.01, np.ones(3), np.ones(3))
    assert done.stdout.strip() == expected.tobytes().hex()


@pytest.mark.slow
def test_a_fork_answers_as_its_parent() -> None:
    command = [sys.executable, "-c", FORK]
    subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, check=True)

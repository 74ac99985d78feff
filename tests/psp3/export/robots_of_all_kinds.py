"""Robots that are written in C: those that come with the package, and other kinds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import psp3
from psp3.description.parts import ROBOTS
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array
from tests.mujoco_null_space import biped, five_bar, rod

LEGS = ("l_hip", "l_motor", "r_hip", "r_motor")


def _from_text(text: str, folder: Path, **options: Any) -> ClosedLoopRobot:
    file = folder / "robot.xml"
    file.write_text(text, encoding="utf-8")
    return ClosedLoopRobot.from_mjcf(file, **options)


def rounded() -> ClosedLoopRobot:
    """Return the five-bar, one end of whose loop is 1e-5 m off its plane."""
    exact = psp3.load("five_bar")
    loop = pin.RigidConstraintModel(exact.constraint_models[0])
    loop.joint1_placement = loop.joint1_placement * pin.SE3(np.eye(3), np.array([0.0, 1e-5, 0.0]))
    return ClosedLoopRobot(exact.model, [loop], exact.actuated, exact.q0)


def arm() -> ClosedLoopRobot:
    """Return an arm without loops, whose second motor has damping, friction and armature."""
    model, body = pin.Model(), pin.Inertia(1.0, np.array([0.1, 0.02, 0.3]), 0.01 * np.eye(3))
    for k, joint in enumerate((pin.JointModelRZ(), pin.JointModelPX(), pin.JointModelRX())):
        at = pin.SE3(np.eye(3), np.array([0.1, 0.2, 0.3]))
        model.appendBodyToJoint(model.addJoint(k, joint, at, f"j{k}"), body, pin.SE3.Identity())
    model.armature, model.damping = np.array([0.0, 0.2, 0.1]), np.array([0.0, 0.3, 0.0])
    model.upperDryFrictionLimit = np.array([0.0, 0.5, 0.0])
    hand = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.1]))
    model.addFrame(pin.Frame("hand", 3, 0, hand, pin.FrameType.OP_FRAME))
    return ClosedLoopRobot(model, [], ["j0", "j1", "j2"])


def _in_core(name: str) -> Callable[[Path], Any]:
    return lambda _: psp3.load("psp3").dynamics("core") if name == "psp3" else psp3.load(name)


MAKERS: dict[str, Callable[[Path], Any]] = {
    **{name: _in_core(name) for name in ROBOTS},
    "walker": lambda folder: _from_text(biped(*LEGS), folder, free="keep"),
    "standing": lambda folder: _from_text(
        biped(*LEGS), folder, closures=[("l_shank", "world", "6d"), ("r_shank", "world", "6d")]
    ),
    "over_actuated": lambda folder: _from_text(five_bar("m1", "m2", "p1"), folder),
    "rod": lambda folder: _from_text(rod(), folder, free="keep"),
    "rounded": lambda _: rounded(),
    "arm": lambda _: arm(),
}
"""How each is made in a folder for files; the 3-PSP without its closed form."""


def some_frames(robot: Any) -> list[str]:
    """Return a frame of the base, the tip or the last body, and a joint."""
    names = [frame.name for frame in robot.model.frames]
    return [names[0], "tip" if "tip" in names else names[-1]]


class States:
    """States of a robot, near and far, among them some that nobody should ask for."""

    def __init__(self, robot: Any, seed: int = 0) -> None:
        self.robot, self.rng, self.count = robot, np.random.default_rng(seed), 0
        self.p, self.n = len(robot.coordinates_q), len(robot.coordinates_v)
        last = robot.model.joints[robot.model.getJointId(robot.coordinates[-1])]
        self._turn = {7: 3, 4: 2}.get(last.nq, 0) if last.nq > last.nv else 0
        self._base = last.nq if self._turn else 0

    def next(self) -> tuple[Array, Array, Array]:
        """Return positions, speeds and accelerations."""
        rng, count = self.rng, self.count
        self.count += 1
        scale = rng.choice([1e-4, 0.02, 0.2, 2.0], p=[0.3, 0.4, 0.25, 0.05])
        q = self.robot.reference + scale * rng.normal(size=self.p)
        v, a = 3.0 * rng.normal(size=self.n), 10.0 * rng.normal(size=self.n)
        if count % 97 == 25:
            q = self.robot.reference + 1e5 * rng.normal(size=self.p)
        if count % 11 == 7:
            v[:] = 0.0
        if self._turn:
            # A quaternion, or cosine and sine, of unit length.
            part = slice(self.p - self._base + self._turn, self.p)
            q[part] /= np.linalg.norm(q[part])
        if count % 97 == 5:
            q[rng.integers(self.p)] = np.nan
        if count % 97 == 15:
            v[rng.integers(self.n)] = np.inf
        return q, v, a

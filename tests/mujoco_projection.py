"""M, C v and G of a shipped robot from MuJoCo.

Its mass matrix, bias, Jacobians and their rates, projected with numpy alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
import yaml

from psp3.description.parts import ROBOT_FILES
from tests.helpers import Array

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

ROWS = {"3d": 3, "6d": 6}


def engine(name: str) -> Any:
    """MuJoCo's model of a shipped URDF as it is, but that frames stay bodies of their own.

    So closures find them by name. The printed nut inertia of the 3-PSP violates the triangle
    inequality, which MuJoCo accepts only with balanceinertia, as its file says; the other robots
    do without.
    """
    return mujoco.MjModel.from_xml_string(text_with_frames(name))


def text_with_frames(name: str) -> str:
    """Return a shipped URDF that tells MuJoCo to keep frames as bodies."""
    text = (ROBOT_FILES / f"{name}.urdf").read_text(encoding="utf-8")
    settings = 'discardvisual="true" fusestatic="false"'
    if name == "psp3":
        assert text.count("<mujoco><compiler ") == 1
        return text.replace("<mujoco><compiler ", f"<mujoco><compiler {settings} ")
    assert text.count(f'<robot name="{name}">') == 1
    tag = f"<mujoco><compiler {settings}/></mujoco>"
    return text.replace(f'<robot name="{name}">', f'<robot name="{name}">{tag}')


class State(NamedTuple):
    """Projected dynamics at one state, and what MuJoCo finds of the loops there.

    ``gap`` is the largest distance of joined frames.
    """

    mass: Array
    coriolis: Array
    gravity: Array
    gap: float


class Projection:
    """Closures and actuated joints of a robot in an engine's numbering, from its loop file."""

    def __init__(self, name: str, model: Any) -> None:
        loops = yaml.safe_load((ROBOT_FILES / f"{name}.yaml").read_text(encoding="utf-8"))
        self.model, self.data = model, mujoco.MjData(model)
        self._closures = [
            (
                *(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, frame) for frame in pair),
                ROWS[kind],
            )
            for pair, kind in zip(loops["closed_loop"], loops["type"], strict=True)
        ]
        assert all(body > 0 for closure in self._closures for body in closure[:2])
        self._actuated = [model.jnt_dofadr[self._joint(joint)] for joint in loops["name_mot"]]
        self._dependent = [i for i in range(model.nv) if i not in self._actuated]

    def _joint(self, name: str) -> int:
        index: int = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, name)
        assert index >= 0
        return index

    def _rows(self, function: Any) -> Array:
        """Twists of the second frame of each loop relative to the first.

        Per unit of joint velocity; or their rates.
        """
        rows = []
        for first, second, count in self._closures:
            parts = []
            for body in (first, second):
                linear, angular = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
                function(self.model, self.data, linear, angular, self.data.xpos[first], body)
                parts.append(np.concatenate([linear, angular]))
            rows.append((parts[1] - parts[0])[:count])
        return np.concatenate(rows)

    def at(self, coordinates: dict[str, float], speeds: Array) -> State:
        """Return the dynamics at joint coordinates, given by name, and actuated speeds.

        The pseudo-inverse of the columns of the other joints is their inverse where no row is
        redundant, and solves them all the same where one is.
        """
        model, data = self.model, self.data
        data.qvel[:] = 0.0
        for joint, value in coordinates.items():
            data.qpos[model.jnt_qposadr[self._joint(joint)]] = value
        mujoco.mj_forward(model, data)
        gap = max(
            float(np.linalg.norm(data.xpos[first] - data.xpos[second]))
            for first, second, _ in self._closures
        )
        gravity, jacobian = np.array(data.qfrc_bias), self._rows(mujoco.mj_jac)
        solve = np.linalg.pinv(jacobian[:, self._dependent], rcond=1e-10)
        complement = np.zeros((model.nv, len(self._actuated)))
        complement[self._actuated] = np.eye(len(self._actuated))
        complement[self._dependent] = -solve @ jacobian[:, self._actuated]
        assert np.abs(jacobian @ complement).max() < 1e-9 * np.abs(complement).max()
        data.qvel[:] = complement @ speeds
        mujoco.mj_forward(model, data)
        drift = np.zeros(model.nv)
        drift[self._dependent] = -solve @ self._rows(mujoco.mj_jacDot) @ data.qvel
        mass = np.empty((model.nv, model.nv))
        # Column by column: the storage of the whole matrix differs between versions of MuJoCo.
        for row, unit in zip(mass, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        velocity_forces = np.array(data.qfrc_bias) - gravity
        return State(
            complement.T @ mass @ complement,
            complement.T @ (velocity_forces + mass @ drift),
            complement.T @ gravity,
            gap,
        )

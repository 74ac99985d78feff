"""Dynamics and control of the 3-PSP parallel robot on Pinocchio.

``psp3.load("psp3")`` returns the robot. Names are imported when they are first used, so ``import psp3`` costs little more than
``import pinocchio``.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from psp3 import statistics, trajectories
    from psp3.adaptive_control import AdaptiveFuzzyComputedTorque
    from psp3.closed_loop_robot import ClosedLoopRobot
    from psp3.controllers import PD, PID, ComputedTorque, FeedForward, GravityCompensatedPD
    from psp3.derivatives import forward_dynamics_derivatives, inverse_dynamics_derivatives
    from psp3.drives import Drive
    from psp3.errors import PSP3Error
    from psp3.excitation import exciting_motion
    from psp3.fuzzy_computed_torque import FuzzyComputedTorque
    from psp3.identification import identify
    from psp3.linear_quadratic_regulator import LinearQuadraticRegulator, TimeVaryingLinearQuadraticRegulator
    from psp3.linearization import linearize
    from psp3.loading import load
    from psp3.mjcf import to_mjcf
    from psp3.mujoco_plant import MuJoCo
    from psp3.natural_orthogonal_complement import NaturalOrthogonalComplement
    from psp3.parameters import PARAMETER_SETS, Parameters
    from psp3.payloads import with_payload
    from psp3.robot import PSP3, Pose
    from psp3.runs import Run
    from psp3.simulation import Result, load_result, simulate
    from psp3.singularities import SingularityAnalysis
    from psp3.study import Study, grid
    from psp3.task_space_control import TaskSpaceComputedTorque
    from psp3.torque_monitor import Monitor
    from psp3.workspace_maps import Workspace

_HOMES = {
    "AdaptiveFuzzyComputedTorque": "adaptive_control",
    "ClosedLoopRobot": "closed_loop_robot",
    "ComputedTorque": "controllers",
    "Drive": "drives",
    "FeedForward": "controllers",
    "FuzzyComputedTorque": "fuzzy_computed_torque",
    "GravityCompensatedPD": "controllers",
    "LinearQuadraticRegulator": "linear_quadratic_regulator",
    "Monitor": "torque_monitor",
    "MuJoCo": "mujoco_plant",
    "NaturalOrthogonalComplement": "natural_orthogonal_complement",
    "PARAMETER_SETS": "parameters",
    "PD": "controllers",
    "PID": "controllers",
    "PSP3": "robot",
    "PSP3Error": "errors",
    "Parameters": "parameters",
    "Pose": "robot",
    "Result": "simulation",
    "Run": "runs",
    "SingularityAnalysis": "singularities",
    "Study": "study",
    "TaskSpaceComputedTorque": "task_space_control",
    "TimeVaryingLinearQuadraticRegulator": "linear_quadratic_regulator",
    "Workspace": "workspace_maps",
    "exciting_motion": "excitation",
    "forward_dynamics_derivatives": "derivatives",
    "grid": "study",
    "identify": "identification",
    "inverse_dynamics_derivatives": "derivatives",
    "linearize": "linearization",
    "load": "loading",
    "load_result": "simulation",
    "simulate": "simulation",
    "to_mjcf": "mjcf",
    "with_payload": "payloads",
}

__all__ = [
    "PARAMETER_SETS",
    "PD",
    "PID",
    "PSP3",
    "AdaptiveFuzzyComputedTorque",
    "ClosedLoopRobot",
    "ComputedTorque",
    "Drive",
    "FeedForward",
    "FuzzyComputedTorque",
    "GravityCompensatedPD",
    "LinearQuadraticRegulator",
    "Monitor",
    "MuJoCo",
    "NaturalOrthogonalComplement",
    "PSP3Error",
    "Parameters",
    "Pose",
    "Result",
    "Run",
    "SingularityAnalysis",
    "Study",
    "TaskSpaceComputedTorque",
    "TimeVaryingLinearQuadraticRegulator",
    "Workspace",
    "exciting_motion",
    "forward_dynamics_derivatives",
    "grid",
    "identify",
    "inverse_dynamics_derivatives",
    "linearize",
    "load",
    "load_result",
    "simulate",
    "statistics",
    "to_mjcf",
    "trajectories",
    "with_payload",
]

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    if name in ("statistics", "trajectories"):
        return importlib.import_module(f"psp3.{name}")
    if name in _HOMES:
        return getattr(importlib.import_module(f"psp3.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'psp3' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)

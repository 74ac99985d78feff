"""Dynamics and control of the 3-PSP parallel robot on Pinocchio.

``psp3.load("psp3")`` returns the robot. Names are imported when they are first used, so
``import psp3`` costs little more than ``import pinocchio``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names
from psp3.version import __version__ as __version__

if TYPE_CHECKING:
    from psp3 import symbolic as symbolic
    from psp3 import trajectories as trajectories
    from psp3.bounds.torque_intervals import ConformalIntervals as ConformalIntervals
    from psp3.bounds.tracking_tube import TrackingTube as TrackingTube
    from psp3.control.classical import PD as PD
    from psp3.control.classical import PID as PID
    from psp3.control.classical import ComputedTorque as ComputedTorque
    from psp3.control.classical import FeedForward as FeedForward
    from psp3.control.classical import GravityCompensatedPD as GravityCompensatedPD
    from psp3.control.linear_quadratic_regulator import (
        LinearQuadraticRegulator as LinearQuadraticRegulator,
    )
    from psp3.control.linear_quadratic_regulator import (
        TimeVaryingLinearQuadraticRegulator as TimeVaryingLinearQuadraticRegulator,
    )
    from psp3.control.task_space import TaskSpaceComputedTorque as TaskSpaceComputedTorque
    from psp3.drives.drive import Drive as Drive
    from psp3.dynamics.derivatives import (
        forward_dynamics_derivatives as forward_dynamics_derivatives,
    )
    from psp3.dynamics.derivatives import (
        inverse_dynamics_derivatives as inverse_dynamics_derivatives,
    )
    from psp3.dynamics.linearization import linearize as linearize
    from psp3.dynamics.natural_orthogonal_complement import (
        NaturalOrthogonalComplement as NaturalOrthogonalComplement,
    )
    from psp3.errors import PSP3Error as PSP3Error
    from psp3.export.face import export_c as export_c
    from psp3.export.fmu import export_fmu as export_fmu
    from psp3.fuzzy_control.adaptive import (
        AdaptiveFuzzyComputedTorque as AdaptiveFuzzyComputedTorque,
    )
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque as FuzzyComputedTorque
    from psp3.fuzzy_control.monitor import Monitor as Monitor
    from psp3.identification.excitation import exciting_motion as exciting_motion
    from psp3.identification.least_squares import identify as identify
    from psp3.kinematics.singularities import SingularityAnalysis as SingularityAnalysis
    from psp3.kinematics.workspace import Workspace as Workspace
    from psp3.loading import load as load
    from psp3.robots.closed_loop_robot import ClosedLoopRobot as ClosedLoopRobot
    from psp3.robots.mjcf_export import to_mjcf as to_mjcf
    from psp3.robots.payloads import with_payload as with_payload
    from psp3.simulation.mujoco import MuJoCo as MuJoCo
    from psp3.simulation.result import Result as Result
    from psp3.simulation.result import load_result as load_result
    from psp3.simulation.tracking import simulate as simulate
    from psp3.study import statistics as statistics
    from psp3.study.grids import grid as grid
    from psp3.study.run import Run as Run
    from psp3.study.study import Study as Study
    from psp3.three_psp.parameters import PARAMETER_SETS as PARAMETER_SETS
    from psp3.three_psp.parameters import Parameters as Parameters
    from psp3.three_psp.robot import PSP3 as PSP3
    from psp3.three_psp.robot import Pose as Pose

__all__, __getattr__, __dir__ = lazy_names(__name__)

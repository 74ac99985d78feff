"""MuJoCo as a plant.

In :func:`psp3.simulate` a controller then controls the exported robot in another engine.

MuJoCo computes everything. The loops, the ends of the joints and dry friction are its constraints,
and the motors with their force limits are MuJoCo's, too. This needs the extra ``mujoco``: ``pip
install 'psp3[mujoco]'``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from psp3.checks import (
    Array,
    as_floats,
    checked_positive,
    checked_robot,
    checked_steps,
    one_row,
)
from psp3.drives.drive import NO_DRIVE, Drive, drive_table
from psp3.errors import InvalidValue, MissingPackage
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.mjcf_export import HARD, UNLIMITED, mujoco_state, to_mjcf

LARGEST_GAP = 1e-3
"""A loop that is open by more than this counts as torn [m; for a 6D closure also the sine of half
an angle].
"""


class MuJoCo(Described):
    r"""A robot in MuJoCo, integrated with its classical Runge–Kutta steps.

    Closures, ends of joints and dry friction are MuJoCo's constraints: critically damped springs
    with a time constant of two steps :math:`h`. Their violation falls with :math:`h^2`;
    ``docs/engines.md`` has numbers.

    Parameters
    ----------
    robot : ClosedLoopRobot
        Any robot, with or without loops, also a floating one.
    steps : int
        Number of MuJoCo's steps in a control period.
    drive : Drive or sequence of Drive
        Friction and motors of the actuated joints, one for all or one for each.
    limits : pair of (m,) array_like, optional
        Positions of the stops of the actuated joints, lowest and highest [m or rad]; by default the
        limits of the model. The simulation ends when a nut of the 3-PSP leaves its screw, so stops
        must lie within the stroke to have an effect. All other joints keep the limits of the model.
    torque_limit : float or (m,) array_like, optional
        Largest absolute forces of the motors [N or N m]; by default the effort limits of the model.
        The ``torque`` of a result is the controller's, before this limit.

    Raises
    ------
    MissingPackage
        If MuJoCo is not installed.
    InvalidValue
        If an argument is malformed.
    PSP3Error
        If the robot cannot be exported, see :func:`psp3.robots.mjcf_export.to_mjcf`.
    """

    def __init__(
        self,
        robot: ClosedLoopRobot,
        steps: int = 1,
        *,
        drive: Drive | Sequence[Drive] = NO_DRIVE,
        limits: tuple[ArrayLike, ArrayLike] | None = None,
        torque_limit: ArrayLike | None = None,
    ) -> None:
        checked_robot(robot)
        self._engine = mujoco = _mujoco()
        self._robot, self._steps = robot, checked_steps(steps)
        m = len(robot.actuated)
        table = drive_table(drive, m)
        self.model = model = mujoco.MjModel.from_xml_string(to_mjcf(robot))
        self.data = mujoco.MjData(model)
        self._base, names = _floating_base(robot)
        coordinates = [self._joint(name) for name in names]
        self._positions, self._speeds = (
            model.jnt_qposadr[coordinates],
            model.jnt_dofadr[coordinates],
        )
        tendons = robot.options["tendons"] or {}
        joints = [self._joint(name) for name in robot.actuated if name not in tendons]
        driven = model.jnt_dofadr[joints]
        if tendons and (limits is not None or table.any()):
            raise InvalidValue(
                "limits or drive of MuJoCo",
                f"some of {robot.title}",
                f"none, because {', '.join(tendons)} moves several joints: give these joints "
                "ranges, armature, damping and frictionloss in the robot's file",
            )
        if limits is not None:
            model.jnt_range[joints], model.jnt_limited[joints] = _stops(limits, m), 1
            model.jnt_solref[joints], model.jnt_solimp[joints] = HARD
        if torque_limit is not None:
            largest = _largest(torque_limit, m)
            model.actuator_ctrlrange[:], model.actuator_ctrllimited[:] = (
                np.stack([-largest, largest], axis=1),
                1,
            )
            model.jnt_actfrclimited[joints] = 0
        if not tendons:
            model.dof_armature[driven] += table[:, 0]
            model.dof_damping[driven] += table[:, 1]
            model.dof_frictionloss[driven] += table[:, 2]
        model.dof_solref[driven], model.dof_solimp[driven] = HARD
        # A state that MuJoCo finds bad ends the simulation; by default MuJoCo would reset instead.
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        # The model holds values that follow from inertia; they are updated now to include the
        # motors.
        mujoco.mj_setConst(model, self.data)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_engine": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._engine = _mujoco()

    @property
    def gap(self) -> float:
        """The greatest opening of a loop in the last step [m].

        For a 6D closure also the sine of half an angle.
        """
        return float(np.abs(self.data.efc_pos[: self.data.ne]).max(initial=0.0))

    def _facts(self) -> dict[str, Any]:
        return {"robot": self._robot, "steps": self._steps}

    def start(self, positions: Array, speeds: Array) -> None:
        """Set the state; positions (p,) and speeds (n,) of the coordinates."""
        q, v = self._robot.configuration(positions), self._robot.velocity(positions, speeds)
        self._engine.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = mujoco_state(self._robot, q, v)

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions (p,) and speeds (n,) of the coordinates after ``duration`` [s].

        The forces of the motors (m,) are constant. None is returned if MuJoCo warns of a bad state,
        or if a loop is torn.
        """
        forces = one_row("forces", forces, self.model.nu)
        duration, warnings = checked_positive("duration", duration), list[str]()
        self.model.opt.timestep = duration / self._steps
        # MuJoCo ignores a force beyond this, with a warning.
        self.data.ctrl[:] = np.clip(forces, -UNLIMITED, UNLIMITED)
        # Otherwise warnings are printed, and written to a file in the working directory.
        handler = self._engine.get_mju_user_warning()
        self._engine.set_mju_user_warning(warnings.append)
        try:
            self._engine.mj_step(self.model, self.data, self._steps)
        finally:
            self._engine.set_mju_user_warning(handler)
        if warnings or not np.isfinite(self.data.qvel).all() or self.gap > LARGEST_GAP:
            return None
        positions, speeds = self.data.qpos[self._positions], self.data.qvel[self._speeds]
        if self._base is None:
            return positions, speeds
        where, how = self._state_of_base(self._base)
        return np.concatenate([positions, where]), np.concatenate([speeds, how])

    def _joint(self, name: str) -> int:
        """Return the number of a joint of one degree of freedom, or a base, in MuJoCo."""
        number = int(self._engine.mj_name2id(self.model, self._engine.mjtObj.mjOBJ_JOINT, name))
        if number < 0:
            raise InvalidValue(
                "robot of MuJoCo",
                f"{self._robot.title}, with the coordinate {name}",
                "one whose coordinates and motors are at joints that MuJoCo has as one; RungeKutta "
                "takes any",
            )
        return number

    def _state_of_base(self, base: str) -> tuple[Array, Array]:
        """Return position and quaternion (7,) of the floating base, and its twist in its axes (6,).

        MuJoCo gives the position relative to the world, and the linear velocity in the world's
        axes.
        """
        number = self._joint(base)
        at, first = self.model.jnt_qposadr[number], self.model.jnt_dofadr[number]
        position, (w, x, y, z) = self.data.qpos[at : at + 3], self.data.qpos[at + 3 : at + 7]
        where = pin.XYZQUATToSE3(np.array([*position, x, y, z, w]))
        speeds = self.data.qvel[first : first + 6]
        home = self._robot.model.jointPlacements[self._robot.model.getJointId(base)]
        twist = np.concatenate([where.rotation.T @ speeds[:3], speeds[3:]])
        return np.asarray(pin.SE3ToXYZQUAT(home.actInv(where))), twist


def _floating_base(robot: ClosedLoopRobot) -> tuple[str | None, tuple[str, ...]]:
    """Return the floating base of a robot, or None, and its other coordinates."""
    if len(robot.reference) == len(robot.coordinates_v):
        return None, robot.coordinates
    base = robot.coordinates[-1]
    joint = robot.model.getJointId(base)
    if robot.model.joints[joint].nq != 7 or robot.model.parents[joint] != 0:
        raise InvalidValue(
            "robot of MuJoCo",
            f"{robot.title}, with the base {base}",
            "one whose base is fixed or floats freely in the world; RungeKutta takes any",
        )
    return base, robot.coordinates[:-1]


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError as error:
        raise MissingPackage("mujoco", "mujoco", error) from error
    return mujoco


def _stops(limits: Any, joints: int) -> Array:
    """Return lowest and highest positions side by side, (n, 2)."""
    array = as_floats("limits", limits, f"(2, {joints})")
    if (
        array.shape != (2, joints)
        or not np.isfinite(array).all()
        or not (array[0] < array[1]).all()
    ):
        raise InvalidValue(
            "limits",
            limits,
            f"{joints} lowest and {joints} highest positions, each highest above its lowest",
        )
    return array.T


def _largest(torque_limit: ArrayLike, joints: int) -> Array:
    array = as_floats("torque_limit", torque_limit, f"() or ({joints},)")
    if (
        np.shape(torque_limit) not in ((), (joints,))
        or not (array > 0.0).all()
        or not np.isfinite(array).all()
    ):
        raise InvalidValue("torque_limit", torque_limit, f"one positive number or {joints}")
    return np.array(np.broadcast_to(array, joints))

"""A robot as C99 code: kinematics and dynamics, loops closed in a bounded number of steps.

The results equal those of ``robot.inverse_dynamics(..., guess=last_pose)`` to the last bit. The
memory between two calls is a struct of the caller, which begins in the reference pose and then
holds the pose of the last call. A robot in closed form needs no struct, see
:mod:`psp3.export.closed_form`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known
from psp3.checks import checked_count, checked_kind
from psp3.export import closed_form, robot_kernels, robot_memory, robot_text, single
from psp3.export.robot_kernels import CoreTables, MotorTables
from psp3.multibody.closing import MOST_ATTEMPTS
from psp3.multibody.tree import AT_BEFORE, AT_SECOND_RATES
from psp3.robots.robot import Robot
from psp3.robots.stepping import DrivenTables
from psp3.three_psp.stepping import ClosedForm

FUNCTIONS = {
    "configuration": robot_memory.POSE,
    "placement": robot_memory.POSE,
    "inverse_dynamics": robot_memory.FORCES,
    "jacobian": robot_memory.COLUMNS,
    "forward_dynamics": robot_memory.COLUMNS,
    "actuator_forces": robot_memory.COLUMNS,
    "mass_matrix": robot_memory.RATES,
    "equation_of_motion": robot_memory.RATES,
}
"""The functions, and the level of memory that each needs."""

CODE = "0; or an error code (see above), and the results are then NaN"


def code_of(thing: Any, **options: Any) -> CCode | None:
    """Return the C code of a robot, see :func:`robot_code`; None if the thing is not a robot."""
    return robot_code(thing, **options) if isinstance(thing, Robot) else None


def robot_code(
    robot: Robot,
    *,
    precision: Literal["double", "single"] = "double",
    name: str | None = None,
    frames: Sequence[str] | None = None,
    functions: Sequence[str] | None = None,
    most_attempts: int = MOST_ATTEMPTS,
) -> CCode:
    """Return the C code of a robot.

    Functions are ``reset``, ``configuration`` of all joints, ``inverse_dynamics``,
    ``forward_dynamics``, ``mass_matrix``, ``equation_of_motion``, for each frame its ``placement``
    and its ``jacobian``, and, if motors are not the coordinates, ``actuator_forces``. Gravity is
    the model's value at this time.

    Parameters
    ----------
    robot : Robot
        The robot.
    precision : {"double", "single"}
        Precision of all numbers.
    name : str, optional
        Prefix of all names; the robot's name by default.
    frames : sequence of str, optional
        Names of frames; by default ``tip``, if there is one.
    functions : sequence of str
        Some of ``FUNCTIONS``; all by default. The struct is as small as they allow.
    most_attempts : int
        Most parts of the way to new positions that are tried for each group of loops; each takes at
        most ``psp3.multibody.closing.MOST_ITERATIONS`` steps of Newton's method.

    Raises
    ------
    NotExportable
        If a class of the robot's own overrides its dynamics, if its closed form lacks a frame, or
        if its loops need more digits than single precision has.
    UnknownName
        If there is no such frame or function.
    """
    table = robot.compiled_table()
    if table is None:
        raise NotExportable(
            f"a robot of class {type(robot).__name__}",
            "it may override the dynamics that the code is made from",
            "a psp3.ClosedLoopRobot of the same parts",
        )
    if name is not None:
        checked_kind("name", name, str, "an identifier of C")
    prefix = robot_text.prefix_of(robot.model.name) if name is None else name
    if isinstance(table, ClosedForm):
        return closed_form.code_of(robot, table, precision, prefix, frames, functions)
    return _Robot(robot, table, precision, frames, functions, most_attempts).code(prefix)


class _Function(NamedTuple):
    """A function of the code: its entry of ``FUNCTIONS``, its name, description and kernel."""

    of: str
    name: str
    does: str
    kernel: Any
    arguments: tuple[Argument, ...]
    more: tuple[Known, ...] = ()


class _Robot:
    """The code of a robot that closes its loops by iteration."""

    def __init__(
        self,
        robot: Any,
        table: Any,
        precision: str,
        frames: Sequence[str] | None,
        functions: Sequence[str] | None,
        most_attempts: int,
    ) -> None:
        self.robot, self.table, self.precision = robot, table, precision
        self.attempts = checked_count("most_attempts", most_attempts)
        self.n, self.p = len(robot.coordinates_v), len(robot.coordinates_q)
        self.positions = Argument("positions", "positions of the coordinates [m, rad]", self.p)
        self.speeds = Argument("speeds", "their speeds [m/s, rad/s]", self.n)
        wanted = robot_text.chosen(functions, FUNCTIONS)
        every = [*self._dynamics(), *self._matrices(), *self._motors()]
        for frame, prefix in robot_text.frames_of(robot, frames).items():
            every += self._frame(frame, prefix)
        self.functions = [one for one in every if one.of in wanted]
        self.asked = max(FUNCTIONS[one] for one in wanted)

    def code(self, name: str) -> CCode:
        """Return the files."""
        table, precision = self.table, self.precision
        numbers = table.numbers
        constants: dict[str, float] = {"MOST_ATTEMPTS": self.attempts}
        if precision == "single":
            numbers = single.numbers_of(table, self.robot.title)
            constants |= single.CONSTANTS
        tree = robot_memory.laid_out(table.tree, self.asked)
        pose = int(tree[AT_BEFORE])
        known = Known("robot", CoreTables(tree, numbers, table.memory[:pose].copy()))
        state = _state(pose, int(tree[AT_SECOND_RATES]))
        about = robot_text.about(self.robot, table, self.attempts)
        writer = CWriter(name, precision, about, constants=constants)
        writer.add(
            "reset",
            "Set the robot to its reference pose. Call this first.",
            robot_kernels.reset,
            [known, *state],
        )
        for one in self.functions:
            arguments: list[Known | Argument] = [known, *one.more, *state, *one.arguments]
            writer.add(one.name, one.does, one.kernel, arguments, CODE)
        return writer.code()

    def _dynamics(self) -> list[_Function]:
        n, positions, speeds = self.n, self.positions, self.speeds
        q = Argument(
            "q",
            "coordinates of all joints [m, rad], in the order above",
            self.robot.model.nq,
            "out",
        )
        accelerations = Argument("accelerations", "their accelerations [m/s², rad/s²]", n)
        forces = Argument("forces", "forces along the coordinates [N, N m]", n)
        return [
            _Function(
                *("configuration",) * 2,
                "Write the coordinates of all joints with closed loops.",
                robot_kernels.configuration,
                (positions, q),
            ),
            _Function(
                *("inverse_dynamics",) * 2,
                "Write the forces along the coordinates for a motion.",
                robot_kernels.inverse_dynamics,
                (positions, speeds, accelerations, replace(forces, role="out")),
            ),
            _Function(
                *("forward_dynamics",) * 2,
                "Write the accelerations under forces along the coordinates.",
                robot_kernels.forward_dynamics,
                (positions, speeds, forces, replace(accelerations, role="out")),
            ),
        ]

    def _matrices(self) -> list[_Function]:
        n = self.n
        M = Argument("M", f"mass matrix, row by row ({n}, {n}) [kg, kg m, kg m²]", n * n, "out")
        C = Argument("C", f"Coriolis matrix, row by row ({n}, {n})", n * n, "out")
        G = Argument("G", "forces of gravity and of springs [N, N m]", n, "out")
        return [
            _Function(
                *("mass_matrix",) * 2,
                "Write the mass matrix M.",
                robot_kernels.mass,
                (self.positions, M),
            ),
            _Function(
                *("equation_of_motion",) * 2,
                "Write M, C and G of M a + C v + G = forces.",
                robot_kernels.equation_of_motion,
                (self.positions, self.speeds, M, C, G),
            ),
        ]

    def _frame(self, frame: str, prefix: str) -> list[_Function]:
        known = (Known(f"frame_{prefix}", np.array(self.robot.frame_table(frame))),)
        placement = Argument(
            "placement", "rotation, row by row (3, 3), and position (3) [m]", 12, "out"
        )
        J = Argument(
            "J",
            f"linear, then angular velocity per speed in base axes, row by row (6, {self.n})",
            6 * self.n,
            "out",
        )
        return [
            _Function(
                "placement",
                f"{prefix}_placement",
                f"Write the placement of the frame {frame} in base axes.",
                robot_kernels.placement,
                (self.positions, placement),
                known,
            ),
            _Function(
                "jacobian",
                f"{prefix}_jacobian",
                f"Write the Jacobian of the frame {frame}.",
                robot_kernels.jacobian,
                (self.positions, J),
                known,
            ),
        ]

    def _motors(self) -> list[_Function]:
        """Return the functions for motors that are not coordinates."""
        table, robot, n = self.table, self.robot, self.n
        if not isinstance(table, DrivenTables):
            return []
        motors = MotorTables(*(getattr(table, field) for field in MotorTables._fields))
        asked, what = n, "accelerations of the coordinates"
        if robot.commanded < n:
            asked = robot.commanded
            what = f"accelerations of the first {asked} coordinates; the others are passive"
        accelerations = Argument("accelerations", f"{what} [m/s², rad/s²]", asked)
        forces = Argument(
            "motor_forces", "forces of the motors [N, N m]", len(robot.actuated), "out"
        )
        return [
            _Function(
                *("actuator_forces",) * 2,
                "Write the motor forces of least norm for a motion.",
                robot_kernels.actuator_forces,
                (self.positions, self.speeds, accelerations, forces),
                (Known("motors", motors),),
            )
        ]


def _state(pose: int, size: int) -> list[Argument]:
    """Return the parts of the struct."""
    return [
        Argument(
            "memory",
            f"the first {pose} are the last pose, the others are scratch space",
            size,
            "state",
        ),
        Argument(
            "report",
            "after a call that returned 1: share of the way it came, residual [m, rad], and the "
            "number of the group of loops",
            robot_kernels.REPORT,
            "state",
        ),
        Argument("closed", "1 if the memory begins with a closed pose", 1, "state", True),
    ]

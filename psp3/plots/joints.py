"""Figures of motions of any robot, one line for each joint that a motor commands."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fuzzy2.plots.names import literal
from psp3.checks import Array, checked_kind, checked_robot
from psp3.kinematics.tasks import rotating
from psp3.plots.panels import Panels, checked_result, checked_title, given_panels
from psp3.robots.robot import Robot
from psp3.simulation.result import Result
from psp3.trajectories.screw_forces import ScrewForces

DASHES = ("-", (0, (6, 2)), (0, (2, 2)))
"""Lines that coincide show through the gaps of those drawn over them."""

NAMED = 8
"""Greatest number of joints in a legend; more would hide the curves."""


def figure_of_joint_tracking(
    robot: Robot, result: Result, title: str, axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw a simulation of any robot: positions beside the desired ones, errors, and forces.

    If a robot's coordinates are not its motors, the figure has the positions of the commanded ones
    and the forces of all motors.

    Parameters
    ----------
    robot : Robot
        The robot that was simulated.
    result : Result
        The simulation.
    title : str
        Title of the figure.
    axes : sequence of 3 Axes, optional
        For the positions, their errors and the forces over time [s]; those of a new figure by
        default.

    Returns
    -------
    tuple of Axes
        The three axes. Positions and errors are in rad and m, forces in N m and N, as the joints
        turn or slide.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    checked_robot(robot)
    checked_result(result)
    checked_title(title)
    panels = given_panels(axes, 3)
    if panels is None:
        figure = Figure(figsize=(9.0, 7.6), layout="constrained")
        figure.suptitle(title)
        panels = tuple(figure.subplots(3, 1, sharex=True))
    positions, errors, forces = panels
    length, force = _units(robot)
    names, reached = _commanded(robot), result.positions[:, : robot.commanded]
    _draw(positions, result.t, reached, names)
    for line, column in zip(positions.lines, result.desired.positions.T, strict=True):
        positions.plot(result.t, column, color=line.get_color(), linestyle=":", linewidth=1.0)
    _draw(errors, result.t, result.desired.positions - reached, names)
    _draw(forces, result.t, result.torque, robot.actuated)
    for panel, name, unit in (
        (positions, "position (desired: dotted)", length),
        (errors, "error", length),
        (forces, "force", force),
    ):
        panel.set(ylabel=_with_unit(name, unit), xlim=(result.t[0], result.t[-1]))
    forces.set_xlabel("time t [s]")
    _name_both(robot, positions, forces)
    return panels


def figure_of_joint_forces(
    robot: Robot, forces: ScrewForces, title: str, axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw a motion of any robot with its forces.

    Parameters
    ----------
    robot : Robot
        The robot that moves.
    forces : ScrewForces
        From :func:`psp3.trajectories.screw_forces.screw_forces`.
    title : str
        Title of the figure.
    axes : sequence of 4 Axes, optional
        For positions, speeds, accelerations and forces over time [s]; those of a new figure by
        default.

    Returns
    -------
    tuple of Axes
        The four axes; units are those of the joints, with rad and N m where they turn.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    checked_robot(robot)
    checked_kind("forces", forces, ScrewForces, "forces along a motion, a ScrewForces")
    checked_title(title)
    panels = given_panels(axes, 4)
    if panels is None:
        figure = Figure(figsize=(9.0, 9.0), layout="constrained")
        figure.suptitle(title)
        panels = tuple(figure.subplots(4, 1, sharex=True))
    length, force = _units(robot)
    motion = forces.motion
    for panel, values, name, unit in zip(
        panels,
        (motion.positions, motion.speeds, motion.accelerations, forces.forces),
        ("position", "speed", "acceleration", "force"),
        (length, f"{length} per s", f"{length} per s²", force),
        strict=True,
    ):
        names = robot.actuated if panel is panels[-1] else _commanded(robot)
        _draw(panel, forces.t, values, names)
        panel.set_ylabel(_with_unit(name, unit))
        if forces.t.size > 1:
            panel.set_xlim(forces.t[0], forces.t[-1])
    panels[-1].set_xlabel("time t [s]")
    _name_both(robot, panels[0], panels[-1])
    return panels


def _commanded(robot: Robot) -> tuple[str, ...]:
    return robot.coordinates[: robot.commanded]


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _draw(panel: Axes, t: Array, values: Array, names: Sequence[str]) -> None:
    for column, name, dashes in zip(values.T, names, cycle(DASHES)):
        panel.plot(t, column, label=literal(name), linestyle=dashes)


def _name(panel: Axes, names: Sequence[str]) -> None:
    if len(names) <= NAMED:
        # Above the axes, so the legend hides nothing.
        panel.legend(
            ncols=min(len(names), 4), loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False
        )


def _name_both(robot: Robot, positions: Axes, forces: Axes) -> None:
    """Name the joints, and the motors if they differ from the joints."""
    _name(positions, _commanded(robot))
    if robot.actuated != _commanded(robot):
        _name(forces, robot.actuated)


def _units(robot: Robot) -> tuple[str, str]:
    """Return the units of positions and of the motors' forces; empty for a tendon."""
    turning = rotating(robot.model)
    length = _joined(turning[robot.coordinates_v[: robot.commanded]], "rad", "m")
    return length, _joined(turning[robot.actuated_v], "N m", "N")


def _joined(turning: NDArray[np.bool_], angular: str, linear: str) -> str:
    both = ((angular, np.any(turning)), (linear, not np.all(turning)))
    return ", ".join(unit for unit, is_there in both if is_there)

"""Plants: the robots that a controller moves in a simulation.

A plant takes forces for a time and returns the resulting state.

Three plants integrate the same robot in independent ways, so each checks the others:

* :class:`RungeKutta`: classical Runge–Kutta steps of the coordinates, compiled; the one to use;
* :class:`DormandPrince`: the coordinates under SciPy's DOP853 with tight tolerances; the reference
  for integration errors;
* :class:`ConstraintDynamics`: the whole tree under Pinocchio's ``constraintDynamics``, loops held
  by Baumgarte stabilization.

The state of the first two is that of the coordinates, so their loops cannot drift apart. They take
any robot, floating ones too, and drives with friction and motor inertia, see :mod:`psp3.drives`.
Integration goes from event to event of the dry friction: a joint comes to rest, or one at rest
starts to move. Two opposite events within one step are missed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from psp3.checks import Array, checked_steps
from psp3.drives.drive import NO_DRIVE, Drive
from psp3.robots.robot import Robot
from psp3.simulation.plant import NO_POSE, DrivenPlant


class RungeKutta:
    """The robot's coordinates, integrated with classical Runge–Kutta steps.

    The steps are compiled, and use the closed form for the 3-PSP.

    Parameters
    ----------
    robot : Robot
        The robot.
    steps : int
        Integration steps in a control period. One step of 2 ms is accurate to 1e-12 m on the
        thesis's helix.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(
        self, robot: Robot, steps: int = 1, drive: Drive | Sequence[Drive] = NO_DRIVE
    ) -> None:
        self.compiled = robot.compiled_steps(steps, drive)
        """The compiled plant, which compiled loops use directly."""

    def start(self, positions: Array, speeds: Array) -> None:
        """Put the robot into a state.

        Positions (p,) [m, rad] and speeds (n,) of the coordinates.
        """
        self.compiled.start(positions, speeds)

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions (p,) and speeds (n,) after ``duration`` [s], or None.

        Under constant forces of the motors (m,).
        """
        state: tuple[Array, Array] | None = self.compiled.advance(forces, duration)
        return state


class FixedSteps(DrivenPlant):
    """Classical Runge–Kutta steps, divided where a joint comes to rest or starts to move.

    The Python counterpart of :func:`psp3.dynamics.driven_steps.advance_driven`. The state is q and
    v; the coordinates are their entries at ``_places`` and ``_rows``.
    """

    def __init__(self, robot: Robot, steps: int, drive: Drive | Sequence[Drive]) -> None:
        super().__init__(robot, drive)
        self._steps = checked_steps(steps)
        self._places, self._rows = np.arange(self._positions), np.arange(self._joints)
        self.q, self.v = np.zeros(self._positions), np.zeros(self._joints)

    def start(self, positions: Array, speeds: Array) -> None:
        """Put the robot into a state.

        Positions (p,) [m, rad] and speeds (n,) of the coordinates.
        """
        self._states.forget()
        self.q, self.v = np.array(positions), np.array(speeds)

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions (p,) and speeds (n,) of the coordinates after ``duration`` [s], or None.

        Under constant forces of the motors (m,).
        """
        try:
            for _ in range(self._steps):
                self._advance(forces, duration / self._steps)
            return (self.q[self._places], self.v[self._rows]) if self._is_pose() else None
        except NO_POSE:
            return None

    def _is_pose(self) -> bool:
        # A bad state is refused when it is reached, not in the next period.
        configuration = self._states.ask(self._robot.configuration, self.q)
        return bool(np.isfinite(configuration).all() and np.isfinite(self.v).all())

    def _step(self, forces: Array, step: float) -> tuple[Array, Array]:
        """Return the state after one step with constant slip."""
        q, v, half, unit = self.q, self.v, 0.5 * step, self._normalized
        r1, a1 = self._rates(q, v), self._accelerations(q, v, forces)
        q2, v2 = unit(q + half * r1), v + half * a1
        r2, a2 = self._rates(q2, v2), self._accelerations(q2, v2, forces)
        q3, v3 = unit(q + half * r2), v + half * a2
        r3, a3 = self._rates(q3, v3), self._accelerations(q3, v3, forces)
        q4, v4 = unit(q + step * r3), v + step * a3
        r4, a4 = self._rates(q4, v4), self._accelerations(q4, v4, forces)
        sixth = step / 6.0
        return (
            unit(q + sixth * (r1 + 2.0 * (r2 + r3) + r4)),
            v + sixth * (a1 + 2.0 * (a2 + a3) + a4),
        )

    def _margin(self, q: Array, v: Array, forces: Array) -> float:
        """Return the margin until a joint comes to rest or starts to move.

        It is a speed or a force [N], and negative after the event.
        """
        margins = (self._slip * v[self._rows])[self._is_dry & (self._slip != 0.0)].tolist()
        sticking = np.flatnonzero(self._slip == 0.0)
        if sticking.size:
            mass, net = self._balance(q, v, forces)
            acceleration = self._joint_accelerations(mass, net)
            margins += [
                self._kernels.spare_friction(mass, net, self._drives, acceleration, i)
                for i in sticking
            ]
        return float(min(margins, default=np.inf))

    def _first_event(self, forces: Array, step: float) -> float:
        """Return a time just after the first event in a step that has one."""
        from scipy.optimize import brentq

        def margin(time: float) -> float:
            return self._margin(*self._step(forces, time), forces)

        # A joint that has just started to move has no margin at first, so the search needs a later
        # time at which it has one.
        late, rounding = step, self._kernels.RESOLUTION * step
        while margin(0.5 * late) < 0.0:
            late *= 0.5
            if late < rounding:
                return late
        time, after = brentq(margin, 0.5 * late, late, xtol=rounding), rounding
        while margin(time) >= 0.0 and time < late:
            time, after = min(time + after, late), 2.0 * after
        return float(time)

    def _advance(self, forces: Array, step: float) -> None:
        """Take one step, divided at its events."""
        left = step
        for event in range(self._kernels.MOST_EVENTS + 1):
            self._choose_slip(self.q, self.v, self.v[self._rows], forces)
            part, state = left, self._step(forces, left)
            if event < self._kernels.MOST_EVENTS and self._margin(*state, forces) < 0.0:
                part = self._first_event(forces, left)
                state = self._step(forces, part)
            self.q, self.v = state
            speeds = self.v[self._rows]
            self._kernels.stop_what_turned_back(self._drives, speeds, self._slip)
            self.v[self._rows] = speeds
            left -= part
            if left <= 0.0:
                return

"""A plant integrated with SciPy's DOP853, the reference for integration errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from psp3.checks import Array, checked_positive
from psp3.drives.drive import NO_DRIVE, Drive
from psp3.robots.robot import Robot
from psp3.simulation.plant import NO_POSE, DrivenPlant


class DormandPrince(DrivenPlant):
    """The robot's coordinates, integrated with SciPy's DOP853.

    Events of the dry friction are found on its dense output.

    Parameters
    ----------
    robot : Robot
        The robot.
    tolerance : float
        Relative and absolute tolerance of the integrator [m, m/s].
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(
        self,
        robot: Robot,
        tolerance: float = 1e-12,
        drive: Drive | Sequence[Drive] = NO_DRIVE,
    ) -> None:
        super().__init__(robot, drive)
        self._tolerance = checked_positive("tolerance", tolerance)
        self._state = np.zeros(self._positions + self._joints)

    def start(self, positions: Array, speeds: Array) -> None:
        """Set the state.

        Positions (p,) [m, rad] and speeds (n,) of the coordinates.
        """
        self._states.forget()
        self._state = np.concatenate([positions, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions (p,) and speeds (n,) after ``duration`` [s], or None.

        The forces of the motors (m,) are constant.
        """
        try:
            return self._parts(self._state) if self._advance(forces, duration) else None
        except NO_POSE:
            return None

    def _parts(self, state: Array) -> tuple[Array, Array]:
        """Return positions, a floating base's quaternion of unit length, and speeds."""
        return self._normalized(state[: self._positions]), state[self._positions :]

    def _advance(self, forces: Array, duration: float) -> bool:
        from scipy.integrate import solve_ivp

        def rates(_: float, state: Array) -> Array:
            q, v = self._parts(state)
            return np.concatenate([self._rates(q, v), self._accelerations(q, v, forces)])

        q, v = self._parts(self._state)
        self._choose_slip(q, v, v, forces)
        now, options = 0.0, {"method": "DOP853", "rtol": self._tolerance, "atol": self._tolerance}
        for _ in range(self._kernels.MOST_EVENTS):
            events = [self._event(int(i), forces) for i in np.flatnonzero(self._is_dry)]
            solution = solve_ivp(rates, (now, duration), self._state, events=events, **options)
            if not solution.success:
                return False
            now, self._state = solution.t[-1], solution.y[:, -1]
            if solution.status == 0:
                return True
            self._switch(
                [
                    event.joint
                    for event, times in zip(events, solution.t_events, strict=True)
                    if len(times)
                ],
                forces,
            )
        return False

    def _event(self, i: int, forces: Array) -> Any:
        """Return an event function of time and state for a change of slip.

        It crosses zero downward when the slip of joint i changes.
        """
        slip = self._slip[i]

        def event(_: float, state: Array) -> float:
            if slip == 0.0:
                holding = abs(self._friction(i, state, forces))
                return float(self._drives[i, self._kernels.DRY] - holding)
            return float(slip * state[self._positions + i])

        event.joint, event.terminal, event.direction = i, True, -1.0  # type: ignore[attr-defined]
        return event

    def _friction(self, i: int, state: Array, forces: Array) -> float:
        """Return the friction that holds joint i."""
        mass, net = self._balance(*self._parts(state), forces)
        return float(net[i] - mass[i] @ self._joint_accelerations(mass, net))

    def _switch(self, joints: list[int], forces: Array) -> None:
        """Stop the joints that came to rest, and release those that friction cannot hold."""
        stopped = [i for i in joints if self._slip[i] != 0.0]
        # At the time of the event friction can just hold the joint, but not a moment later.
        # Therefore the joint is released here, and the general choice of slip is not used.
        directions = {
            i: np.sign(self._friction(i, self._state, forces))
            for i in joints
            if self._slip[i] == 0.0
        }
        q, v = self._parts(self._state)
        v[stopped] = 0.0
        if stopped:
            self._choose_slip(q, v, v, forces)
        for i, direction in directions.items():
            self._slip[i] = direction

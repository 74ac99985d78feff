"""Plants: what the controller steers. They take forces for a while and return the state that results.

Three plants integrate the same robot by independent routes, so that each checks the others:

* :class:`RungeKutta`: actuated coordinates, classical Runge–Kutta steps, compiled for the 3-PSP; the one to use;
* :class:`DormandPrince`: actuated coordinates, SciPy's DOP853 with tight tolerances; the reference for integration errors;
* :class:`ConstraintDynamics`: the whole tree under Pinocchio's ``constraintDynamics``, loops held by Baumgarte stabilization.

The state of the first two is that of the actuated coordinates, so their loops cannot drift apart. All of them take any robot, and drives
with friction and motor inertia, see :mod:`psp3.drives`. Integration goes from event to event of the dry friction: a joint comes to rest,
or one at rest lets go. What happens and is undone within one step is not seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from psp3.arrays import Array, checked_count, checked_not_negative, checked_positive
from psp3.closed_loop_robot import ClosedLoopRobot
from psp3.drives import NO_DRIVE, Drive, drive_table
from psp3.errors import ClosureFailed, InvalidArray, InvalidValue, JointLimitExceeded, SingularConfiguration, UnreachablePose
from psp3.robot import PSP3

NO_POSE = (InvalidArray, InvalidValue, UnreachablePose, ClosureFailed, JointLimitExceeded, SingularConfiguration)
"""What robots raise for a state that is none of theirs, once a state has been accepted."""


class Plant(Protocol):
    """What the simulation needs of a plant."""

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state."""
        ...

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return heights and speeds after some time under constant forces, or None if the robot left the poses it can take."""
        ...


class RungeKutta:
    """Actuated coordinates, integrated with classical Runge–Kutta steps; compiled, in closed form, where the robot is a 3-PSP.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    steps : int
        Integration steps in a control period. One step of 2 ms is exact to 1e-12 m on the thesis's helix.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(self, robot: ClosedLoopRobot, steps: int = 1, drive: Drive | Sequence[Drive] = NO_DRIVE) -> None:
        self._plant: Plant
        self._plant = _ClosedForm(robot, steps, drive) if isinstance(robot, PSP3) else _FixedSteps(robot, steps, drive)

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state; positions [m, rad] and speeds of the actuated joints, each (n,)."""
        self._plant.start(heights, speeds)

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions and speeds after ``duration`` [s] under constant forces, each (n,), or None."""
        return self._plant.advance(forces, duration)


class _ClosedForm:
    """The 3-PSP, compiled."""

    def __init__(self, robot: PSP3, steps: int, drive: Drive | Sequence[Drive]) -> None:
        from psp3 import closed_form, drive_kernels

        self._p, self._scratch, self._steps = robot.parameters.as_array(), np.empty(6), checked_count("steps", steps)
        self._drives = drive_table(drive, 3)
        self._is_driven = bool(self._drives.any())
        self._free, self._driven = closed_form.advance, drive_kernels.advance_driven
        self._state = np.zeros(6)

    def start(self, heights: Array, speeds: Array) -> None:
        self._state = np.concatenate([heights, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        step = duration / self._steps
        if self._is_driven:
            valid = self._driven(self._state, forces, step, self._steps, self._p, self._drives)
        else:
            valid = self._free(self._state, forces, step, self._steps, self._p, self._scratch)
        return (self._state[:3], self._state[3:]) if valid else None


class _Driven:
    """A robot with drives in Python, in actuated coordinates: what is common to the ways to integrate it."""

    def __init__(self, robot: ClosedLoopRobot, drive: Drive | Sequence[Drive]) -> None:
        from psp3 import drive_kernels

        self._robot, self._kernels, self._joints = robot, drive_kernels, len(robot.actuated)
        self._drives = drive_table(drive, self._joints)
        self._is_driven, self._is_dry = bool(self._drives.any()), self._drives[:, drive_kernels.DRY] > 0.0
        self._slip = np.ones(self._joints)

    def _balance(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Return M + J, and what is left of the forces for acceleration and dry friction."""
        inertia, viscous, _ = self._drives.T
        return (
            self._robot.mass_matrix(q) + np.diag(inertia),
            forces - self._robot.inverse_dynamics(q, v, np.zeros_like(v)) - viscous * v,
        )

    def _accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        """Return the derivative of v while the slip of the joints is constant."""
        if self._is_driven:
            return self._joint_accelerations(*self._balance(q, v, forces))
        return self._robot.forward_dynamics(q, v, forces)

    def _joint_accelerations(self, mass: Array, net: Array) -> Array:
        out = np.empty(self._joints)
        self._kernels.accelerations(mass, net, self._drives, self._slip, out)
        return out

    def _choose_slip(self, q: Array, v: Array, speeds: Array, forces: Array) -> None:
        """Find out which joints stick, and which way the others slip."""
        if self._kernels.slip_of(self._drives, speeds, self._slip):
            self._kernels.choose_slip(*self._balance(q, v, forces), self._drives, speeds, self._slip)


class _FixedSteps(_Driven):
    """Classical Runge–Kutta steps, cut where a joint comes to rest or lets go.

    As ``drive_kernels.advance_driven``, which is compiled for one robot. The state are q and v, of which the actuated joints are those at
    ``_places`` and ``_rows``.
    """

    def __init__(self, robot: ClosedLoopRobot, steps: int, drive: Drive | Sequence[Drive]) -> None:
        super().__init__(robot, drive)
        self._steps = checked_count("steps", steps)
        self._places = self._rows = np.arange(self._joints)
        self.q, self.v = np.zeros(self._joints), np.zeros(self._joints)

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state; positions [m, rad] and speeds of the actuated joints, each (n,)."""
        self.q, self.v = np.array(heights), np.array(speeds)

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions and speeds of the actuated joints after ``duration`` [s] under constant forces, each (n,), or None."""
        try:
            for _ in range(self._steps):
                self._advance(forces, duration / self._steps)
            return (self.q[self._places], self.v[self._rows]) if self._is_pose() else None
        except NO_POSE:
            return None

    def _is_pose(self) -> bool:
        # A state is refused where it is reached, not in the next period.
        return bool(np.isfinite(self._robot.configuration(self.q)).all() and np.isfinite(self.v).all())

    def _moved(self, q: Array, way: Array) -> Array:
        """Return q after a way along the velocity."""
        return q + way

    def _step(self, forces: Array, step: float) -> tuple[Array, Array]:
        """Return the state after one step with constant slip."""
        q, v = self.q, self.v
        a1 = self._accelerations(q, v, forces)
        v2 = v + 0.5 * step * a1
        a2 = self._accelerations(self._moved(q, 0.5 * step * v), v2, forces)
        v3 = v + 0.5 * step * a2
        a3 = self._accelerations(self._moved(q, 0.5 * step * v2), v3, forces)
        v4 = v + step * a3
        a4 = self._accelerations(self._moved(q, step * v3), v4, forces)
        return self._moved(q, step / 6.0 * (v + 2.0 * (v2 + v3) + v4)), v + step / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)

    def _margin(self, q: Array, v: Array, forces: Array) -> float:
        """Return what is left until a joint comes to rest or lets go, in its speed or N; negative once it has happened."""
        margins = (self._slip * v[self._rows])[self._is_dry & (self._slip != 0.0)].tolist()
        sticking = np.flatnonzero(self._slip == 0.0)
        if sticking.size:
            mass, net = self._balance(q, v, forces)
            acceleration = self._joint_accelerations(mass, net)
            margins += [self._kernels.spare_friction(mass, net, self._drives, acceleration, i) for i in sticking]
        return float(min(margins, default=np.inf))

    def _first_event(self, forces: Array, step: float) -> float:
        """Return the time of the first event in a step that has one: just after it, to rounding."""
        from scipy.optimize import brentq

        def margin(time: float) -> float:
            return self._margin(*self._step(forces, time), forces)

        # A joint that has just let go has no margin at first, so that a time must be found when it has.
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
        """Take one step, in as many parts as it has events."""
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


class DormandPrince(_Driven):
    """Actuated coordinates, integrated with SciPy's DOP853; events of the dry friction are found on its dense output.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    tolerance : float
        Relative and absolute tolerance of the integrator [m, m/s].
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(self, robot: ClosedLoopRobot, tolerance: float = 1e-12, drive: Drive | Sequence[Drive] = NO_DRIVE) -> None:
        super().__init__(robot, drive)
        self._tolerance = checked_positive("tolerance", tolerance)
        self._state = np.zeros(2 * self._joints)

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state; positions [m, rad] and speeds of the actuated joints, each (n,)."""
        self._state = np.concatenate([heights, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions and speeds after ``duration`` [s] under constant forces, each (n,), or None."""
        try:
            return self._parts(self._state) if self._advance(forces, duration) else None
        except NO_POSE:
            return None

    def _parts(self, state: Array) -> tuple[Array, Array]:
        return state[: self._joints], state[self._joints :]

    def _advance(self, forces: Array, duration: float) -> bool:
        from scipy.integrate import solve_ivp

        def rates(_: float, state: Array) -> Array:
            q, v = self._parts(state)
            return np.concatenate([v, self._accelerations(q, v, forces)])

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
            self._switch([event.joint for event, times in zip(events, solution.t_events, strict=True) if len(times)], forces)
        return False

    def _event(self, i: int, forces: Array) -> Any:
        """Return a function of time and state that passes zero, downward, where the slip of joint i changes."""
        slip = self._slip[i]

        def event(_: float, state: Array) -> float:
            if slip == 0.0:
                return float(self._drives[i, self._kernels.DRY] - abs(self._friction(i, state, forces)))
            return float(slip * state[self._joints + i])

        event.joint, event.terminal, event.direction = i, True, -1.0  # type: ignore[attr-defined]
        return event

    def _friction(self, i: int, state: Array, forces: Array) -> float:
        """Friction that holds joint i."""
        mass, net = self._balance(*self._parts(state), forces)
        return float(net[i] - mass[i] @ self._joint_accelerations(mass, net))

    def _switch(self, joints: list[int], forces: Array) -> None:
        """Stop the joints that came to rest, and let those go that cannot be held any more."""
        stopped = [i for i in joints if self._slip[i] != 0.0]
        # At this very moment friction can still hold the others, and in the next it cannot, so the choice is not asked.
        directions = {i: np.sign(self._friction(i, self._state, forces)) for i in joints if self._slip[i] == 0.0}
        q, v = self._parts(self._state)
        v[stopped] = 0.0
        if stopped:
            self._choose_slip(q, v, v, forces)
        for i, direction in directions.items():
            self._slip[i] = direction


class ConstraintDynamics(_FixedSteps):
    r"""The whole tree under Pinocchio's ``constraintDynamics``, integrated with classical Runge–Kutta steps.

    The loops are constraints on accelerations, so integration errors would open them slowly; Baumgarte's stabilization adds
    :math:`2\omega \dot\phi + \omega^2 \phi` to pull them shut. Motor inertia is Pinocchio's armature, friction a force on the joint.

    Parameters
    ----------
    robot : ClosedLoopRobot
        Any robot with loops.
    frequency : float
        :math:`\omega` [1/s]; critically damped. Zero switches stabilization off.
    steps : int
        Integration steps in a control period.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(self, robot: ClosedLoopRobot, frequency: float = 20.0, steps: int = 1, drive: Drive | Sequence[Drive] = NO_DRIVE) -> None:
        frequency = checked_not_negative("frequency", frequency)
        closures = pin.StdVec_RigidConstraintModel()
        for closure in robot.constraint_models:
            stabilized = pin.RigidConstraintModel(closure)
            stabilized.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(frequency**2, 2.0 * frequency))
            closures.append(stabilized)
        joints = [robot.model.joints[robot.model.getJointId(name)] for name in robot.actuated]
        places, rows = np.array([joint.idx_q for joint in joints]), np.array([joint.idx_v for joint in joints])
        model = robot.model.copy()
        armature = np.array(model.armature)
        armature[rows] += drive_table(drive, len(joints))[:, 0]
        model.armature = armature
        super().__init__(ClosedLoopRobot(model, closures, robot.actuated, robot.q0), steps, drive)
        self._places, self._rows = places, rows
        self.q, self.v = robot.q0, np.zeros(model.nv)

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state; positions and speeds of the actuated joints."""
        self.q = self._robot.configuration(heights)
        self.v = self._robot.velocity(heights, speeds)

    def _is_pose(self) -> bool:
        return bool(np.isfinite(self.q).all() and np.isfinite(self.v).all())

    def _moved(self, q: Array, way: Array) -> Array:
        return np.asarray(pin.integrate(self._robot.model, q, way))

    def _balance(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Return M + J as the inverse of what unit forces do, and the force that would do what the forces do."""

        def rows(force: Array) -> Array:
            return self._robot.constrained_accelerations(q, v, force)[self._rows]

        applied = rows(forces - self._drives[:, self._kernels.VISCOUS] * v[self._rows])
        idle = rows(np.zeros(self._joints))
        mass = np.linalg.inv(np.stack([rows(unit) - idle for unit in np.eye(self._joints)], axis=1))
        return mass, mass @ applied

    def _accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        if self._is_driven:
            _, viscous, dry = self._drives.T
            friction = dry * self._slip
            sticks = self._slip == 0.0
            if sticks.any():
                mass, net = self._balance(q, v, forces)
                friction[sticks] = (net - mass @ self._joint_accelerations(mass, net))[sticks]
            acceleration = self._robot.constrained_accelerations(q, v, forces - viscous * v[self._rows] - friction)
            # What sticks rests to the last bit, not only to rounding.
            acceleration[self._rows[sticks]] = 0.0
            return acceleration
        return self._robot.constrained_accelerations(q, v, forces)

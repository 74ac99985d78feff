"""Plants: what the controller steers. They take forces for a while and return the state that results.

Three plants integrate the same robot by independent routes, so that each checks the others:

* :class:`RungeKutta`: closed form, classical Runge–Kutta steps, compiled; the one to use;
* :class:`DormandPrince`: closed form, SciPy's DOP853 with tight tolerances; the reference for integration errors;
* :class:`ConstraintDynamics`: the whole tree under Pinocchio's ``constraintDynamics``, loops held by Baumgarte stabilization.

The state of the first two is that of the actuated coordinates, so their loops cannot drift apart.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pinocchio as pin

from psp3.arrays import Array, checked_not_negative, checked_positive
from psp3.closed_loop_robot import ClosedLoopRobot
from psp3.errors import InvalidValue
from psp3.robot import PSP3


class Plant(Protocol):
    """What the simulation needs of a plant."""

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state."""
        ...

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return heights and speeds after some time under constant forces, or None if the robot left the poses it can take."""
        ...


def _whole(name: str, value: int) -> int:
    if value < 1 or value != int(value):
        raise InvalidValue(name, value, "a whole number of at least 1")
    return int(value)


class RungeKutta:
    """Closed form, integrated with classical Runge–Kutta steps.

    Parameters
    ----------
    robot : PSP3
        The robot.
    steps : int
        Integration steps in a control period. One step of 2 ms is exact to 1e-12 m on the thesis's helix.
    """

    def __init__(self, robot: PSP3, steps: int = 1) -> None:
        from psp3 import closed_form

        self._advance, self._p, self._scratch = closed_form.advance, robot.parameters.as_array(), np.empty(6)
        self._steps = _whole("steps", steps)
        self._state = np.zeros(6)

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state; heights [m] and speeds [m/s], each (3,)."""
        self._state = np.concatenate([heights, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return heights and speeds after ``duration`` [s] under constant forces [N], each (3,), or None."""
        valid = self._advance(self._state, forces, duration / self._steps, self._steps, self._p, self._scratch)
        return (self._state[:3], self._state[3:]) if valid else None


class DormandPrince:
    """Closed form, integrated with SciPy's DOP853.

    Parameters
    ----------
    robot : PSP3
        The robot.
    tolerance : float
        Relative and absolute tolerance of the integrator [m, m/s].
    """

    def __init__(self, robot: PSP3, tolerance: float = 1e-12) -> None:
        self._robot = robot
        self._tolerance = checked_positive("tolerance", tolerance)
        self._state = np.zeros(6)

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state; heights [m] and speeds [m/s], each (3,)."""
        self._state = np.concatenate([heights, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return heights and speeds after ``duration`` [s] under constant forces [N], each (3,), or None."""
        from scipy.integrate import solve_ivp

        from psp3.errors import InvalidArray, UnreachablePose

        def rates(_: float, state: Array) -> Array:
            return np.concatenate([state[3:], self._robot.forward_dynamics(state[:3], state[3:], forces)])

        try:
            solution = solve_ivp(rates, (0.0, duration), self._state, method="DOP853", rtol=self._tolerance, atol=self._tolerance)
        except (InvalidArray, UnreachablePose):
            return None
        if not solution.success:
            return None
        self._state = solution.y[:, -1]
        return self._state[:3], self._state[3:]


class ConstraintDynamics:
    r"""The whole tree under Pinocchio's ``constraintDynamics``, integrated with classical Runge–Kutta steps.

    The loops are constraints on accelerations, so integration errors would open them slowly; Baumgarte's stabilization adds
    :math:`2\omega \dot\phi + \omega^2 \phi` to pull them shut.

    Parameters
    ----------
    robot : ClosedLoopRobot
        Any robot with loops.
    frequency : float
        :math:`\omega` [1/s]; critically damped. Zero switches stabilization off.
    steps : int
        Integration steps in a control period.
    """

    def __init__(self, robot: ClosedLoopRobot, frequency: float = 20.0, steps: int = 1) -> None:
        frequency = checked_not_negative("frequency", frequency)
        self._steps = _whole("steps", steps)
        closures = pin.StdVec_RigidConstraintModel()
        for closure in robot.constraint_models:
            stabilized = pin.RigidConstraintModel(closure)
            stabilized.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(frequency**2, 2.0 * frequency))
            closures.append(stabilized)
        self._robot = ClosedLoopRobot(robot.model, closures, robot.actuated, robot.q0)
        self._joints = [robot.model.joints[robot.model.getJointId(name)] for name in robot.actuated]
        self.q, self.v = robot.q0, np.zeros(robot.model.nv)

    def start(self, heights: Array, speeds: Array) -> None:
        """Put the robot into a state; positions and speeds of the actuated joints."""
        self.q = self._robot.configuration(heights)
        self.v = self._robot.velocity(heights, speeds)

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions and speeds of the actuated joints after ``duration`` [s] under constant forces, or None."""
        model, robot, step = self._robot.model, self._robot, duration / self._steps
        for _ in range(self._steps):
            q, v = self.q, self.v
            a1 = robot.constrained_accelerations(q, v, forces)
            v2 = v + 0.5 * step * a1
            a2 = robot.constrained_accelerations(pin.integrate(model, q, 0.5 * step * v), v2, forces)
            v3 = v + 0.5 * step * a2
            a3 = robot.constrained_accelerations(pin.integrate(model, q, 0.5 * step * v2), v3, forces)
            v4 = v + step * a3
            a4 = robot.constrained_accelerations(pin.integrate(model, q, step * v3), v4, forces)
            self.q = pin.integrate(model, q, step / 6.0 * (v + 2.0 * (v2 + v3) + v4))
            self.v = v + step / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
            if not (np.isfinite(self.q).all() and np.isfinite(self.v).all()):
                return None
        return (
            np.array([self.q[joint.idx_q] for joint in self._joints]),
            np.array([self.v[joint.idx_v] for joint in self._joints]),
        )

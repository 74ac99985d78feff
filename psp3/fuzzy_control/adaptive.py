r"""Adaptive fuzzy computed torque.

A trained controller of any robot whose rules continue to learn while the robot moves.

There are two adaptation laws. If several rule bases estimate M, C and G, as for all robots except
the 3-PSP, the tracking error drives the consequents by the law of Slotine and Li
(:mod:`psp3.fuzzy_control.slotine_li`): a step costs one product per consequent, and C adapts, too.
If one rule base estimates everything, as for the 3-PSP, the consequents are fitted to the applied
torque by least squares, whose matrix over all consequents is small there. The rest of this page is
about least squares.

The force of the last period and the resulting motion give an equation for the rules that is linear
in their consequents,

.. math:: \tau = \hat M \ddot a + \hat C \dot a + \hat G = Y(a, \dot a, \ddot a)\, c,

and least squares with forgetting (:mod:`fuzzy2.learning.adaptation`) use it to correct the
consequents of M and G. Those of C stay, because its forces are too small here to learn from or to
matter. Three bounds make the adaptation robust. The trained consequents keep a weight that never
fades, so nothing winds up without excitation. The consequents stay in a box around the trained
ones, as the least-squares solution within the box, and the box of M excludes an M that is not
positive definite. If the adapted M is nevertheless less than a share of the trained one, which
disordered rules can cause, the trained rules take over.

**Accelerations.** No acceleration is measured, and none is found by numerical differentiation. The
force is constant over a control period, and the mean acceleration of that period *is* the
difference of two speeds over the period. The other terms of the equation are evaluated at the
middle of the period, which is accurate to second order. Both sides then pass the same first-order
low-pass filter. In the filter's sum the differences of speeds telescope, so measurement noise
enters as in the filtered regressor of Slotine and Li. Their integration by parts does not help
here: fuzzy basis functions depend on speeds, so their derivatives would bring the accelerations
back.

Sources: R. H. Middleton and G. C. Goodwin, "Adaptive computed torque control for rigid link
manipulators", Systems & Control Letters 10(1), 1988, for computed torque with a model from filtered
least squares; J.-J. E. Slotine and W. Li, "On the adaptive control of robot manipulators",
International Journal of Robotics Research 6(3), 1987, and "Composite adaptive control of robot
manipulators", Automatica 25(4), 1989, for the filtered regressor.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.described import Described
from psp3.checks import Array, checked_number, checked_positive, one_row
from psp3.control.controller import Widths
from psp3.errors import InvalidValue
from psp3.fuzzy_control import adaptive_kernels as kernels
from psp3.fuzzy_control import slotine_li, slotine_li_kernels
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.kernels import reported, step_width
from psp3.fuzzy_control.numbers import unpack
from psp3.fuzzy_control.records import INPUT_NAMES
from psp3.trajectories.motion import Motion

UPDATE_PERIOD = 0.02
"""Time between two solutions of the least-squares problem [s]; samples enter it at every control
period.
"""

LEAST_SHARE_OF_MASS = 0.25
"""The adapted M is used while it exceeds this share of the trained one, in the sense that the
difference is positive definite.
"""

MEMORY, TRUST, LAG = 2.0, 1e-4, 0.05
"""Default memory and trust of least squares [s]."""

FADING_TIME = 20.0
"""Default memory of the law of Slotine and Li [s]."""

CRITICAL_TIMES = 4.0
"""Default trust of the law of Slotine and Li, in units of 1/κ: the fastest without overshoot."""

_ROWS = ("positions", "speeds", "desired positions", "desired speeds", "desired accelerations")


class AdaptiveFuzzyComputedTorque(Described):
    r"""Fuzzy computed torque whose rules for M and G adapt while the robot moves.

    It replaces a trained controller.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        The trained controller: type-1 or interval type-2, with ``outside="clamp"``. It is not
        changed. Its gains are used.
    memory : float, optional
        Time after which learned knowledge has faded to 1/e if no new data confirm it [s]. The
        default is 2 for the samples of the 3-PSP, and 20 for the consequents of other robots.
    trust : float, optional
        The weight of the trained consequents, as a time [s]. For the 3-PSP it is the time for which
        the forces of a rule must be wrong by some amount to correct half of that amount, if the
        rule fires alone; the default is 1e-4. Sixteen rules that share the firing take about ten
        times longer. For other robots it is the time constant with which G follows the forces, by
        default :math:`4 / \kappa`, the fastest without overshoot, see
        :mod:`psp3.fuzzy_control.slotine_li`.
    reach : float
        Farthest that the consequents of G may move from the trained ones, as a share of their mean,
        above 0 and below 1: payloads of up to that share of the robot's weight are within reach.
        For the 3-PSP, those of M may move until a quarter of M is left, :math:`\tfrac34
        \lambda_{\min}(\bar M) / 3` in every entry with the average M of the rules. For other
        robots, those of M may move by that share of :math:`\sqrt{\bar M_{ii} \bar M_{jj}}`, those
        of C by that times a rate of the trained motion, and those of G in addition by the forces
        that accelerate the motors.
    lag : float, optional
        Time constant of the low-pass filter, for the 3-PSP only [s]; 0.05 by default. A longer one
        suppresses more measurement noise, but learns later.

    Attributes
    ----------
    base : FuzzyComputedTorque
        The trained controller.
    kp, kv : float
        Its gains.
    rules : Rules
        The trained rules, with the weight and the box of adaptation.
    settings : Settings
        Numbers of the controller, as :mod:`psp3.fuzzy_control.adaptive_kernels` takes them, or
        :mod:`psp3.fuzzy_control.slotine_li_kernels`.

    Raises
    ------
    InvalidValue
        If the controller is not trained, or of another kind, or if a number is out of range or does
        not apply to this robot.

    Notes
    -----
    The 3-PSP learns from the force that the last call returned. An active force limit of the motor,
    and delays, are therefore mistaken for mass and weight. So is dry friction, for any robot. If
    the true consequents are out of reach (:attr:`at_reach`), the servo must correct the rest, and
    soft gains such as those of Table 6.1 may then lose the robot.
    """

    rules: kernels.Rules | slotine_li_kernels.Rules
    settings: kernels.Settings | slotine_li_kernels.Settings
    _table: kernels.Adaptive | slotine_li_kernels.SlotineLi

    def __init__(
        self,
        controller: FuzzyComputedTorque,
        *,
        memory: float | None = None,
        trust: float | None = None,
        reach: float = 0.5,
        lag: float | None = None,
    ) -> None:
        wanted = 'a trained FuzzyComputedTorque, of kind "t1" or "it2" with outside="clamp"'
        if (
            not isinstance(controller, FuzzyComputedTorque)
            or controller.kind not in ("t1", "it2")
            or controller.outside != "clamp"
        ):
            raise InvalidValue("controller", controller, wanted)
        controller.controller  # noqa: B018 # raises NotTrained
        self.base, self.reach = controller, checked_share(reach)
        self.kp, self.kv = controller.kp, controller.kv
        given = {"memory": memory, "trust": trust, "lag": lag}
        times = {
            name: checked_positive(name, value)
            for name, value in given.items()
            if value is not None
        }
        by_least_squares = controller.inputs.names == INPUT_NAMES
        (self._least_squares if by_least_squares else self._slotine_li)(times)
        self.reset()

    def _least_squares(self, times: dict[str, float]) -> None:
        times = {"memory": MEMORY, "trust": TRUST, "lag": LAG} | times
        self._times = times
        self.memory, self.trust, self.lag = times["memory"], times["trust"], times["lag"]
        self.rules = trained_rules(self.base, self.trust, self.reach)
        self.settings = kernels.Settings(
            float(self.kp),
            float(self.kv),
            self.memory,
            self.lag,
            UPDATE_PERIOD,
            LEAST_SHARE_OF_MASS,
        )

    def _slotine_li(self, times: dict[str, float]) -> None:
        if "lag" in times:
            wanted = "left out: this robot's rules learn from the tracking error, without a filter"
            raise InvalidValue("lag", times["lag"], wanted)
        poles = slotine_li.poles_of_servo(self.kp, self.kv)
        times = {"memory": FADING_TIME, "trust": CRITICAL_TIMES / poles.decay} | times
        self._times = times
        self.memory, self.trust = times["memory"], times["trust"]
        self.rules = slotine_li.trained_rules(self.base, self.trust, self.reach)
        self.settings = slotine_li_kernels.Settings(poles.slope, 1.0 / self.memory)

    def _facts(self) -> dict[str, Any]:
        return {**self.base._facts(), **self._times, "reach": self.reach}

    def __repr__(self) -> str:
        times = self._times | {"reach": self.reach}
        order = ("memory", "trust", "reach", "lag")
        said = ", ".join(f"{name}={times[name]:g}" for name in order if name in times)
        return f"{type(self).__name__}({self.base!r}, {said})"

    def reset(self) -> None:
        """Return to the trained rules, and forget everything about earlier runs."""
        rules, settings = self.rules, self.settings
        if isinstance(rules, kernels.Rules) and isinstance(settings, kernels.Settings):
            memory = kernels.new_memory(rules.trained)
            self._table = kernels.Adaptive(settings, rules, memory)
        elif isinstance(rules, slotine_li_kernels.Rules):
            assert isinstance(settings, slotine_li_kernels.Settings)
            orders = slotine_li.first_orders(self.base)
            learned = slotine_li_kernels.new_memory(rules, orders)
            self._table = slotine_li_kernels.SlotineLi(settings, rules, learned)
        self._step = np.full(step_width(self.base.joints), np.nan)

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the torque, of shape (n,) [N or N m], after learning from the last one's effect.

        Parameters
        ----------
        t : float
            Time [s]. Nothing is learned unless it is later than at the last call.
        heights, speeds : (n,) array_like
            Positions [m or rad] and speeds [m/s or rad/s]; for the 3-PSP those of its nuts.
        desired : Motion
            Desired positions, speeds and accelerations, (n,) each.

        Returns
        -------
        (n,) ndarray
            Forces of the motors.

        Raises
        ------
        InvalidValue
            If the time is not a finite number.
        InvalidArray
            If positions, speeds or the desired motion are not n finite numbers each; then nothing
            has been learned.
        """
        n = self.base.joints
        rows = (heights, speeds, desired.positions, desired.speeds, desired.accelerations)
        a, v, *wanted = (one_row(name, row, n) for name, row in zip(_ROWS, rows, strict=True))
        now = checked_number("t", t, "a finite number", -np.finfo(float).max)
        if now == math.inf:
            raise InvalidValue("t", t, "a finite number")
        step = np.empty(step_width(n))
        table, rest = self._table, (0, now, a, v, np.concatenate(wanted), step)
        if isinstance(table, kernels.Adaptive):
            kernels.run_step(table, *rest)
        else:
            slotine_li_kernels.run_step(table, *rest)
        self._step = step
        torque: Array = step[:n].copy()
        return torque

    @property
    def numbers_said(self) -> int:
        """Numbers that a compiled step writes after the n forces."""
        return self.base.numbers_said

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        is_other = type(self) is not AdaptiveFuzzyComputedTorque
        if is_other or widths != Widths.of_motors(self.base.joints):
            return None
        # The table shares this controller's memory, so the knowledge learned in the loop is kept.
        return self._table

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Take the state after the last step, and return the reports of all steps."""
        self._step = steps[-1].copy() if len(steps) else self._step
        return reported(steps)

    @property
    def _memory(self) -> kernels.Memory | slotine_li_kernels.Memory:
        return self._table.memory

    def adapted(self) -> FuzzyComputedTorque:
        """Return a controller with the present rules that does not adapt.

        It can be saved, or serve as the trained controller of another adaptive one.

        Raises
        ------
        UnusableEstimate
            If the average M of the rules is not positive definite, which computed torque needs.
        """
        systems = [
            system.replace(consequents=consequents)
            for system, consequents in zip(self.base.systems_, self._consequents(), strict=True)
        ]
        return self.base.with_systems(systems)

    def _consequents(self) -> list[Array]:
        """Return the present consequents (R, m) of each rule base."""
        row, found, start = self._memory.consequents.ravel(), [], 0
        for system, place in zip(self.base.systems_, self.base.places, strict=True):
            shape = len(place.outputs), 2, len(system.rules)
            end = start + math.prod(shape)
            found.append(row[start:end].reshape(shape)[:, 0].T.copy())
            start = end
        return found

    @property
    def consequents(self) -> Array:
        """The present consequents, (R, m), if there is one rule base.

        Their order is that of :func:`psp3.fuzzy_control.numbers.output_names`; for the 3-PSP that
        of :data:`psp3.fuzzy_control.records.OUTPUT_NAMES`.

        Raises
        ------
        InvalidValue
            If there are several rule bases; :meth:`adapted` has all their consequents.
        """
        found = self._consequents()
        if len(found) > 1:
            wanted = "those of one rule base; take adapted().systems_"
            raise InvalidValue("consequents", len(found), wanted)
        return found[0]

    @property
    def at_reach(self) -> bool:
        """Whether a consequent is as far from the trained one as it may go."""
        return bool((np.abs(self._memory.delta) >= self.rules.reach).any())

    @property
    def torque_interval(self) -> Array:
        """Ends of the torque interval of the last call, (n, 2) [N or N m].

        It belongs to the rules at that call.
        """
        n = self.base.joints
        return self._step[n : 3 * n].reshape(2, n).T.copy()

    @property
    def covered(self) -> bool:
        """Whether the inputs of the last call were within the trained range."""
        return bool(self._step[-2] > 0.0)

    @property
    def fell_back(self) -> bool:
        """Whether the trained rules replaced the adapted ones at the last call.

        They do if the adapted ones give no usable M. For robots other than the 3-PSP, the average
        of the trained rules replaces them if no rule fires.
        """
        return bool(self._step[-1] > 0.0)


def trained_rules(controller: FuzzyComputedTorque, trust: float, reach: float) -> kernels.Rules:
    """Return the trained rules of a 3-PSP's controller, with weight and box of adaptation.

    They are in the form that :mod:`psp3.fuzzy_control.adaptive_kernels` takes.
    """
    system = controller.system_
    assert system.table is not None
    consequents = np.asarray(system.consequents, dtype=float)
    trained = np.ascontiguousarray(np.repeat(consequents.T, 2, axis=0))
    count = len(system.rules)
    mass, weight = consequents[:, [0, 3, 5]].mean(), np.abs(consequents[:, 15:]).mean()
    # Errors of up to this size in every entry reduce the eigenvalues of M by at most three times as
    # much.
    entries = (
        (1.0 - LEAST_SHARE_OF_MASS)
        * float(np.linalg.eigvalsh(unpack(controller.fallback_)[0])[0])
        / 3.0
    )
    # Equal relative errors count equally, in M and in G.
    prior = np.repeat([trust * (weight / mass) ** 2, trust], [6 * count, 3 * count])
    farthest = np.repeat([entries, reach * weight], [6 * count, 3 * count])
    return kernels.Rules(
        system.table, np.ascontiguousarray(controller.ranges_), trained, prior, farthest, -farthest
    )


def checked_share(reach: object) -> float:
    """Return a share as a float; raise :class:`InvalidValue` if it is not above 0 and below 1."""
    share = checked_positive("reach", reach)
    if share >= 1.0:
        raise InvalidValue("reach", reach, "above 0 and below 1")
    return share

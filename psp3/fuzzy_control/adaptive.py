r"""Adaptive fuzzy computed torque.

A trained controller whose rules go on learning from the torque that was applied.

The force of the last period and the motion that it made are an equation for the rules, linear in
their consequents,

.. math:: \tau = \hat M \ddot a + \hat C \dot a + \hat G = Y(a, \dot a, \ddot a)\, c,

and with it the consequents of M and G are corrected by least squares that forget
(:mod:`fuzzy2.learning.adaptation`); those of C stay, because its forces are too small here to learn
from and to matter. Robustness comes from bounds at every place: what was trained keeps a weight
that never fades, so nothing winds up without excitation; consequents stay in a box about what was
trained, as the least squares within it, and that of M leaves no room for an M that is not positive
definite; where the adapted M yet is less than a share of the trained one, as disordered rules can
make it, the trained rules take over.

**Accelerations.** None is measured, and none is found by differentiation. The force is constant
over a control period, so the mean acceleration of that period *is* the difference of two speeds
over the period; the rest of the equation is taken at the middle of the period, which is exact to
the second order. Both sides then pass the same first-order low-pass filter. In its sum the
differences of speeds telescope, so noise of measurement enters as it does in the filtered regressor
of Slotine and Li, whose integration by parts is of no use here: fuzzy basis functions depend on
speeds, and their derivatives would bring the accelerations back.

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

from psp3.checks import Array, checked_number, checked_positive, one_row
from psp3.control.controller import Widths
from psp3.errors import InvalidValue
from psp3.fuzzy_control import adaptive_kernels as kernels
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
"""The adapted M is used while it exceeds this share of the trained one (as matrices do: the
difference is positive definite).
"""

_ROWS = ("positions", "speeds", "desired positions", "desired speeds", "desired accelerations")


class AdaptiveFuzzyComputedTorque:
    r"""Fuzzy computed torque whose rules for M and G adapt to what the robot does.

    It takes the place of a trained controller.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        The trained controller: type-1 or interval type-2, with ``outside="clamp"``. It stays as it
        is. Its gains are used.
    memory : float
        Time after which a sample counts 1/e [s].
    trust : float
        Time for which the forces of a rule must have missed by some amount to move its consequents
        half of the way [s], if that rule fires alone: the weight of what was trained. Sixteen rules
        that share the firing take some ten times longer.
    reach : float
        Farthest that the consequents of G may go from what was trained, as a share of their mean,
        above 0 and below 1: payloads of up to that share of the robot's weight are within reach.
        Those of M may go as far as leaves a quarter of it,
        :math:`\tfrac34 \lambda_{\min}(\bar M) / 3` in every entry with the average M of the rules.
    lag : float
        Time constant of the low-pass filter [s]. Longer suppresses more noise of measurement, and
        learns later.

    Attributes
    ----------
    base : FuzzyComputedTorque
        The trained controller.
    rules : Rules
        What it was trained to, with weight and box of adaptation.
    settings : Settings
        Numbers of the controller, as :mod:`psp3.fuzzy_control.adaptive_kernels` takes them.

    Raises
    ------
    InvalidValue
        If the controller is not trained, or of another kind, or a number is outside of what it can
        be.

    Notes
    -----
    The force that is learned from is the one that was returned by the last call: a force limit of
    the motor, if it acts, and delays are taken for mass and weight. The same is true of dry
    friction. If the truth is out of reach (:attr:`at_reach`), the servo is left with what the rules
    cannot say, and soft gains, as those of Table 6.1, may then lose the robot.
    """

    def __init__(
        self,
        controller: FuzzyComputedTorque,
        *,
        memory: float = 2.0,
        trust: float = 1e-4,
        reach: float = 0.5,
        lag: float = 0.05,
    ) -> None:
        wanted = (
            'a trained FuzzyComputedTorque of the 3-PSP, of kind "t1" or "it2" with outside="clamp"'
        )
        if (
            not isinstance(controller, FuzzyComputedTorque)
            or controller.inputs.names != INPUT_NAMES
            or controller.kind not in ("t1", "it2")
            or controller.outside != "clamp"
        ):
            raise InvalidValue("controller", controller, wanted)
        self.base, self.rules = (
            controller,
            trained_rules(controller, checked_positive("trust", trust), checked_share(reach)),
        )
        self.memory, self.trust, self.reach = (
            checked_positive("memory", memory),
            float(trust),
            float(reach),
        )
        self.lag = checked_positive("lag", lag)
        self.settings = kernels.Settings(
            float(controller.kp),
            float(controller.kv),
            self.memory,
            self.lag,
            UPDATE_PERIOD,
            LEAST_SHARE_OF_MASS,
        )
        self.reset()

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.base!r}, memory={self.memory:g}, trust={self.trust:g}, "
            f"reach={self.reach:g}, lag={self.lag:g})"
        )

    def reset(self) -> None:
        """Go back to what was trained, and forget everything about earlier runs."""
        self._memory = kernels.new_memory(self.rules.trained)
        self._step = np.full(step_width(3), np.nan)

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the torque, of shape (3,) [N], after learning from what the last one did.

        Parameters
        ----------
        t : float
            Time [s]. Nothing is learned if it has not gone on since the last call.
        heights, speeds : (3,) array_like
            Nut heights [m] and speeds [m/s].
        desired : Motion
            Desired heights, speeds and accelerations, (3,) each.

        Returns
        -------
        (3,) ndarray
            Screw forces.

        Raises
        ------
        InvalidValue
            If the time is not a finite number.
        InvalidArray
            If heights, speeds or the desired motion are not three finite numbers each; then nothing
            has been learned.
        """
        rows = (heights, speeds, desired.heights, desired.speeds, desired.accelerations)
        a, v, *wanted = (one_row(name, row, 3) for name, row in zip(_ROWS, rows, strict=True))
        now = checked_number("t", t, "a finite number", -np.finfo(float).max)
        if now == math.inf:
            raise InvalidValue("t", t, "a finite number")
        step = np.empty(step_width(3))
        kernels.adaptive_step(
            self.settings, self.rules, self._memory, now, a, v, np.concatenate(wanted), step
        )
        self._step = step
        torque: Array = step[:3].copy()
        return torque

    numbers_said = step_width(3) - 3

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller as the compiled loop takes it, or None, see :func:`steer`."""
        if type(self) is not AdaptiveFuzzyComputedTorque or widths != Widths.of_motors(3):
            return None
        # The memory is this controller's own: what is learned in the loop stays.
        return kernels.Adaptive(self.settings, self.rules, self._memory)

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Be as after the last of the steps, and return what is reported of all."""
        self._step = steps[-1].copy() if len(steps) else self._step
        return reported(steps)

    @property
    def consequents(self) -> Array:
        """Consequents as they are now, (R, 18).

        Their order is that of :data:`psp3.fuzzy_control.records.OUTPUT_NAMES`.
        """
        return self._memory.consequents[:, 0].T.copy()

    @property
    def at_reach(self) -> bool:
        """Whether a consequent is as far from what was trained as it may go."""
        return bool((np.abs(self._memory.delta) >= self.rules.reach).any())

    @property
    def torque_interval(self) -> Array:
        """Ends of the torque interval of the last call, (3, 2) [N].

        Of the rules as they were then.
        """
        return self._step[3:9].reshape(2, 3).T.copy()

    @property
    def covered(self) -> bool:
        """Whether the inputs of the last call were within the trained range."""
        return bool(self._step[9] > 0.0)

    @property
    def fell_back(self) -> bool:
        """Whether the trained rules took the place of the adapted ones at the last call.

        They do where the adapted ones give no usable M.
        """
        return bool(self._step[10] > 0.0)


def trained_rules(controller: FuzzyComputedTorque, trust: float, reach: float) -> kernels.Rules:
    """Return what a controller was trained to, with weight and box of adaptation.

    It is as :mod:`psp3.fuzzy_control.adaptive_kernels` takes it.
    """
    controller.controller  # noqa: B018 # raises NotTrained
    system = controller.system_
    assert system.table is not None
    consequents = np.asarray(system.consequents, dtype=float)
    trained = np.ascontiguousarray(np.repeat(consequents.T[:, np.newaxis], 2, axis=1))
    count = len(system.rules)
    mass, weight = consequents[:, [0, 3, 5]].mean(), np.abs(consequents[:, 15:]).mean()
    # Entries that are off by no more than this make M smaller by three times as much at most, in
    # the norm of its eigenvalues.
    entries = (
        (1.0 - LEAST_SHARE_OF_MASS)
        * float(np.linalg.eigvalsh(unpack(controller.fallback_)[0])[0])
        / 3.0
    )
    # What is off by the same share counts the same, in M and in G.
    prior = np.repeat([trust * (weight / mass) ** 2, trust], [6 * count, 3 * count])
    farthest = np.repeat([entries, reach * weight], [6 * count, 3 * count])
    return kernels.Rules(
        system.table, np.ascontiguousarray(controller.ranges_), trained, prior, farthest
    )


def checked_share(reach: object) -> float:
    """Return a share as a float; raise :class:`InvalidValue` if it is not above 0 and below 1."""
    share = checked_positive("reach", reach)
    if share >= 1.0:
        raise InvalidValue("reach", reach, "above 0 and below 1")
    return share

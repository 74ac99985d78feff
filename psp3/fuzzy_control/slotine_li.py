r"""The adaptive law of Slotine and Li on the rules of a trained controller, for any robot.

With the error :math:`e = a_d - a` and the sliding variable
:math:`s = \dot e + \lambda e = \dot a_r - \dot a` the forces are

.. math:: \tau = \hat M \ddot a_r + \hat C \dot a_r + \hat G + K s
          = Y(a, \dot a, \dot a_r, \ddot a_r)\, c + K s, \qquad
          \dot c = \Gamma Y^T s - \sigma\,(c - c_0),

where Y is the regressor of :mod:`psp3.fuzzy_control.force_regressor`, in which C multiplies the
reference speeds. Each consequent is clamped to a box around the trained one, :math:`c_0`. No
acceleration is measured, and no M is inverted, so M need not be positive definite.

**Why it is stable.** If some :math:`c^*` in the box gives the robot's forces exactly, and
:math:`\dot M - 2 C` is skew-symmetric, then

.. math:: V = \tfrac12 s^T M s + \tfrac12 (c - c^*)^T \Gamma^{-1} (c - c^*), \qquad
          \dot V \le -s^T K s

without the leak σ, because projection onto a box that contains :math:`c^*` brings c nearer to it.
With the leak, V decreases while the consequents are far from :math:`c^*`, and stays bounded.

**Gains.** λ and κ, with :math:`K = \kappa \bar M` and the average M of the rules, are the two poles
of the trained controller's servo, :math:`x^2 - k_v x + k_p = 0`. If the poles are not real, both
gains are :math:`\sqrt{k_p}`, which is equally stiff and critically damped. Γ is diagonal. In units
in which every motor moves a unit mass, all entries of M adapt alike, and so do those of C and of G.
The rate of an entry depends on its force at the trained accelerations and speeds,

.. math:: \Gamma_{G_i} = \gamma d_i, \quad \Gamma_{M_{ij}} = \gamma d_i d_j / \alpha^2, \quad
          \Gamma_{C_{ij}} = \gamma d_i d_j / \nu^2, \quad
          \alpha^2 = \langle d_i \dot v_i^2 \rangle, \; \nu^2 = \langle d_i v_i^2 \rangle

with :math:`d = \operatorname{diag} \bar M`, the greatest trained speeds v, and the accelerations
:math:`\dot v = v^2 / A` of a motor that swings with speed v and amplitude A, half of its trained
range. With :math:`\gamma = \kappa / (T \langle \sum_r \phi_r^2 \rangle)` G follows within the time
T, and is critically damped, too, if T is :math:`4 / \kappa`.

Source: J.-J. E. Slotine and W. Li, "On the adaptive control of robot manipulators", International
Journal of Robotics Research 6(3), 1987. The leak: P. A. Ioannou and P. V. Kokotović, "Instability
analysis and improvement of robustness of adaptive control", Automatica 20(5), 1984.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fuzzy2.systems.system import FuzzySystem
from psp3.checks import Array
from psp3.errors import InvalidValue
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.numbers import unpack
from psp3.fuzzy_control.rule_bases import principal_terms_of
from psp3.fuzzy_control.slotine_li_kernels import Rules


class Poles(NamedTuple):
    """Slope λ of the sliding variable, and its rate of decay κ [1/s]."""

    slope: float
    decay: float


def poles_of_servo(kp: float, kv: float) -> Poles:
    """Return λ and κ for the gains of computed torque; ``kp`` must be positive.

    Raises
    ------
    InvalidValue
        If ``kp`` is not positive.
    """
    if not kp > 0.0:
        raise InvalidValue("kp", kp, "positive: rules adapt until the positions are right")
    apart = 0.25 * kv**2 - kp
    if not apart > 0.0:
        return Poles(math.sqrt(kp), math.sqrt(kp))
    decay = 0.5 * kv + math.sqrt(apart)
    # The smaller pole comes from the product kp of both, because a difference of two large numbers
    # would lose its digits.
    return Poles(kp / decay, decay)


class Sizes(NamedTuple):
    """Typical sizes that entries are scaled by, in units in which every motor moves a unit mass.

    ``masses`` (n,) are the diagonal of the average M; ``acceleration``, ``speed`` and ``weight``
    are root mean squares over the motors.
    """

    masses: Array
    acceleration: float
    speed: float
    weight: float


def sizes_of(controller: FuzzyComputedTorque) -> Sizes:
    """Return the typical sizes of a trained controller's numbers.

    Raises
    ------
    InvalidValue
        If a motor's position or speed is not an input of the rules.
    """
    n, plus = controller.joints, controller.inputs.plus.tolist()
    if (controller.inputs.minus >= 0).any() or not set(range(2 * n)) <= set(plus):
        wanted = "inputs that are the positions and speeds of all motors"
        raise InvalidValue("controller", ", ".join(controller.inputs.names), wanted)
    order = [plus.index(place) for place in range(2 * n)]
    low, high = controller.ranges_[:, order]
    amplitudes = 0.5 * (high - low)[:n]
    speeds = np.maximum(np.abs(low), np.abs(high))[n:]
    masses = np.diag(unpack(controller.fallback_)[0])
    # G is the last output of the first rule base.
    weights = np.asarray(controller.systems_[0].consequents, dtype=float)[:, -n:]

    def size(values: Array) -> float:
        return float(np.sqrt((values**2).mean()))

    roots = np.sqrt(masses)
    return Sizes(
        masses,
        size(roots * speeds**2 / amplitudes),
        size(roots * speeds),
        size(weights / roots),
    )


def trained_rules(controller: FuzzyComputedTorque, time: float, reach: float) -> Rules:
    """Return the trained rules of a controller, with damping, adaptation gains and box.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        The trained controller, of type-1 or interval type-2.
    time : float
        Time T of the module's docstring [s].
    reach : float
        Farthest that consequents may move, as a share of typical sizes: for M and C their units,
        for G the weight plus the forces that accelerate the motors.
    """
    sizes, decay = sizes_of(controller), poles_of_servo(controller.kp, controller.kv).decay
    scales, farthest = _scales_and_reach(sizes, reach)
    trained, rates, ends = [], [], []
    for system, place in zip(controller.systems_, controller.places, strict=True):
        consequents = np.asarray(system.consequents, dtype=float).T
        trained.append(np.repeat(consequents[:, np.newaxis], 2, axis=1).ravel())
        gain = decay / (time * _shared_firing(system))
        rates.append(np.repeat(gain * scales[place.outputs], consequents.shape[1]))
        ends.append(np.repeat(farthest[place.outputs], consequents.shape[1]))
    damping = decay * unpack(controller.fallback_)[0]
    arrays = (damping, *(np.concatenate(parts) for parts in (trained, rates, ends)))
    return Rules(controller.controller, *(np.ascontiguousarray(a, dtype=float) for a in arrays))


def first_orders(controller: FuzzyComputedTorque) -> np.ndarray:
    """Return an order of the rules for each end of each output, as ``slotine_li_kernels`` does."""
    return np.concatenate(
        [
            np.tile(np.arange(len(system.rules), dtype=np.int64), 2 * len(place.outputs))
            for system, place in zip(controller.systems_, controller.places, strict=True)
        ]
    )


def _scales_and_reach(sizes: Sizes, reach: float) -> tuple[Array, Array]:
    """Return the adaptation gains of all numbers at γ = 1, and their reach, (K,) each."""
    masses = sizes.masses
    n = len(masses)
    products = np.outer(masses, masses)
    upper = products[np.triu_indices(n)]
    rate = sizes.acceleration / sizes.speed
    scales = np.concatenate(
        [upper / sizes.acceleration**2, products.ravel() / sizes.speed**2, masses]
    )
    farthest = np.concatenate(
        [
            np.sqrt(upper),
            rate * np.sqrt(products.ravel()),
            (sizes.weight + sizes.acceleration) * np.sqrt(masses),
        ]
    )
    return scales, reach * farthest


def _shared_firing(system: FuzzySystem) -> float:
    r"""Return the mean of :math:`\sum_r \phi_r^2` where rules fire most; 1 for a single rule."""
    centers, _ = principal_terms_of(system)
    firing = np.asarray(system.firing(centers)).mean(axis=-1)
    phi = firing / firing.sum(axis=1, keepdims=True)
    return float((phi**2).sum(axis=1).mean())

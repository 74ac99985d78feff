r"""The adaptive law of Slotine and Li on the rules of a trained controller, for any robot.

With the error :math:`e = a_d - a` and the sliding variable
:math:`s = \dot e + \lambda e = \dot a_r - \dot a` the forces are

.. math:: \tau = \hat M \ddot a_r + \hat C \dot a_r + \hat G + K s
          = Y(a, \dot a, \dot a_r, \ddot a_r)\, c + K s, \qquad
          \dot c = \Gamma Y^T s - \sigma\,(c - c_0),

where Y is the regressor of :mod:`psp3.fuzzy_control.force_regressor` with the reference speeds in
the place of those that C is multiplied with. Each consequent is put back into a box about the
trained one, :math:`c_0`. No acceleration is measured, and no M is inverted, so that none has to be
positive definite.

**Why it is stable.** If some :math:`c^*` in the box says the robot's forces, and
:math:`\dot M - 2 C` is skew-symmetric, then

.. math:: V = \tfrac12 s^T M s + \tfrac12 (c - c^*)^T \Gamma^{-1} (c - c^*), \qquad
          \dot V \le -s^T K s

without the leak σ: projection onto a box that holds :math:`c^*` brings c nearer to it. With the
leak, V falls wherever the consequents are far from :math:`c^*`, and stays bounded.

**Gains.** λ and κ, with :math:`K = \kappa \bar M` and the average M of the rules, are the two poles
of the trained controller's servo, :math:`x^2 - k_v x + k_p = 0`. Where these are not real, both are
:math:`\sqrt{k_p}`: as stiff, and critically damped. Γ is diagonal. In units in which every motor
moves a unit mass, all entries of M, of C and of G adapt alike, each by the force that it makes at
accelerations and speeds as they are trained,

.. math:: \Gamma_{G_i} = \gamma d_i, \quad \Gamma_{M_{ij}} = \gamma d_i d_j / \alpha^2, \quad
          \Gamma_{C_{ij}} = \gamma d_i d_j / \nu^2, \quad
          \alpha^2 = \langle d_i \dot v_i^2 \rangle, \; \nu^2 = \langle d_i v_i^2 \rangle

with :math:`d = \operatorname{diag} \bar M`, the greatest trained speeds v and, of a motor that
swings that fast over half of its trained range A, the accelerations :math:`\dot v = v^2 / A`.
With :math:`\gamma = \kappa / (T \langle \sum_r \phi_r^2 \rangle)` G follows within the time T,
critically damped, too, where that is :math:`4 / \kappa`.

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
    """Slope λ of the sliding variable, and how fast it falls, κ [1/s]."""

    slope: float
    decay: float


def poles_of_servo(kp: float, kv: float) -> Poles:
    """Return λ and κ for the gains of computed torque; ``kp`` must be positive.

    Raises
    ------
    InvalidValue
        If it is not.
    """
    if not kp > 0.0:
        raise InvalidValue("kp", kp, "positive: rules adapt until the positions are right")
    apart = 0.25 * kv**2 - kp
    if not apart > 0.0:
        return Poles(math.sqrt(kp), math.sqrt(kp))
    decay = 0.5 * kv + math.sqrt(apart)
    # Their product is kp, which the difference of two great numbers would lose.
    return Poles(kp / decay, decay)


class Sizes(NamedTuple):
    """What entries are measured by, in units in which every motor moves a unit mass.

    ``masses`` (n,) are the diagonal of the average M; root mean squares over the motors of the
    ``acceleration``, the ``speed`` and the ``weight``.
    """

    masses: Array
    acceleration: float
    speed: float
    weight: float


def sizes_of(controller: FuzzyComputedTorque) -> Sizes:
    """Return the sizes of a trained controller's numbers.

    Raises
    ------
    InvalidValue
        If a motor's position or speed is no input of the rules.
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
    # G is the last that the first rule base says.
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
    """Return what a controller was trained to, with damping, adaptation gains and box.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        The trained controller, of type-1 or interval type-2.
    time : float
        T above [s].
    reach : float
        Farthest that consequents may go, as a share of what is usual: of M and C of their units, of
        G of the weight and of what accelerates the motors.
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
    """Return the adaptation gains of all numbers at γ = 1, and how far they may go, (K,) each."""
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
    r"""Return the mean of :math:`\sum_r \phi_r^2` where rules fire most: 1 for a single one."""
    centers, _ = principal_terms_of(system)
    firing = np.asarray(system.firing(centers)).mean(axis=-1)
    phi = firing / firing.sum(axis=1, keepdims=True)
    return float((phi**2).sum(axis=1).mean())

"""The law of Slotine and Li on rules: against regressor, estimate, and the function it lessens."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import psp3
from psp3.control.controller import Widths
from psp3.errors import InvalidValue
from psp3.fuzzy_control import force_regressor as regressor
from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.numbers import count_of_numbers, places_of, unpack
from psp3.fuzzy_control.slotine_li import poles_of_servo, sizes_of
from psp3.robots.payloads import with_payload
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories import Motion, Sway

ROBOTS = ("five_bar", "delta", "gough_stewart")
KP, KV = 400.0, 40.0
"""Critically damped, both poles at 20 rad/s."""


@cache
def robot(name: str) -> Any:
    return psp3.load(name)


@cache
def sway(name: str) -> Sway:
    return Sway(robot=robot(name))


@cache
def trained(name: str, kind: str = "t1", **options: Any) -> FuzzyComputedTorque:
    variation = 0.1 if kind == "it2" else None
    controller = FuzzyComputedTorque(
        kind, robot(name), kp=KP, kv=KV, mean_variation=variation, **options
    )
    return controller.fit(sway(name), sway(name).period)


def adapting(name: str, kind: str = "t1", coriolis: str = "rules") -> AdaptiveFuzzyComputedTorque:
    """Return a controller that has learned for half a second with a payload."""
    base = trained(name, kind, coriolis=coriolis, rules=8)
    controller = AdaptiveFuzzyComputedTorque(base)
    psp3.simulate(with_payload(robot(name), 0.1), controller, sway(name), 0.5)
    assert not np.array_equal(controller._memory.consequents, controller.rules.trained)
    return controller


class InPython(RungeKutta):
    """A plant that the compiled loop does not know."""


def states(controller: FuzzyComputedTorque, count: int) -> tuple[np.ndarray, np.ndarray, Any]:
    """Return positions and speeds within the trained ranges, and motions desired there."""
    rng, n = np.random.default_rng(0), controller.joints
    low, high = controller.ranges_
    inner = low + (high - low) * rng.uniform(0.1, 0.9, (count, 2 * n))
    wanted = low + (high - low) * rng.uniform(size=(count, 2 * n))
    rates = 5.0 * (high - low)[n:] * rng.normal(size=(count, n))
    desired = [
        Motion(row[:n], row[n:], rate, row[:n]) for row, rate in zip(wanted, rates, strict=True)
    ]
    return inner[:, :n], inner[:, n:], desired


def errors(controller: Any, a: Any, v: Any, desired: Motion) -> tuple[Any, Any, Any]:
    """Return s, and reference speeds and accelerations."""
    slope = controller.settings.slope
    reference = desired.speeds + slope * (desired.positions - a)
    return reference - v, reference, desired.accelerations + slope * (desired.speeds - v)


def basis(system: Any, x: np.ndarray) -> np.ndarray:
    firing = system.firing(np.atleast_2d(x))[..., 0]
    return np.asarray(firing / firing.sum(axis=1, keepdims=True))


def slopes(system: Any, a: np.ndarray) -> np.ndarray:
    """Return those of basis functions along the positions by central differences."""
    h = 1e-6
    rows = [
        (basis(system, a + h * e) - basis(system, a - h * e)) / (2.0 * h) for e in np.eye(a.size)
    ]
    return np.stack(rows, axis=-1)


def design(base: FuzzyComputedTorque, a: Any, v: Any, reference: Any, rates: Any) -> np.ndarray:
    """Return Y (n, P), its columns in the order of the consequents: by base, output and rule."""
    n, phi = base.joints, basis(base.systems_[0], a)
    mass = regressor.mass_columns(phi, rates[np.newaxis])
    if base.coriolis == "mass":
        along = slopes(base.systems_[0], a)
        mass = mass + regressor.derived_coriolis_columns(
            along, v[np.newaxis], reference[np.newaxis]
        )
    both = np.concatenate([mass, regressor.gravity_columns(phi, n)], axis=-1)
    blocks = [both]
    if base.coriolis == "rules":
        of_coriolis = basis(base.systems_[1], np.concatenate([a, v]))
        blocks.append(regressor.coriolis_columns(of_coriolis, reference[np.newaxis]))
    # (1, n, R, m) to (n, m R)
    return np.concatenate([b[0].swapaxes(1, 2).reshape(n, -1) for b in blocks], axis=1)


@pytest.mark.parametrize("coriolis", ["rules", "mass"])
@pytest.mark.parametrize("name", ROBOTS)
def test_forces_and_gradient_are_those_of_the_regressor(name: str, coriolis: str) -> None:
    """Y c + K s, and Yᵀ s; where Y has slopes by differences, these are right to 1e-8."""
    controller = adapting(name, coriolis=coriolis)
    base, now = controller.base, controller._memory.consequents.copy()
    consequents = np.concatenate([c.T.ravel() for c in controller._consequents()])
    tolerance = 1e-12 if coriolis == "rules" else 1e-7
    for a, v, desired in zip(*states(base, 5), strict=True):
        s, reference, rates = errors(controller, a, v, desired)
        Y = design(base, a, v, reference, rates)
        expected = Y @ consequents + controller.rules.damping @ s
        # At the time of the last call, so that nothing is learned.
        found = controller.torque(float(controller._memory.clock[0]), a, v, desired)
        np.testing.assert_allclose(
            found, expected, rtol=0.0, atol=tolerance * np.abs(expected).max()
        )
        gradient = Y.T @ s
        np.testing.assert_allclose(
            controller._memory.gradient, gradient, rtol=0.0, atol=tolerance * np.abs(gradient).max()
        )
    np.testing.assert_array_equal(controller._memory.consequents, now)


@pytest.mark.parametrize("coriolis", ["rules", "mass"])
@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_forces_are_those_of_the_estimates(kind: str, coriolis: str) -> None:
    """Of M, C and G of the fuzzy systems with the adapted consequents, and so is the interval.

    1e-12 is rounding: sums of some ten numbers in another order.
    """
    controller = adapting("delta", kind, coriolis)
    adapted = controller.adapted()
    for a, v, desired in zip(*states(adapted, 20), strict=True):
        s, reference, rates = errors(controller, a, v, desired)
        M, C, G = adapted.estimate(a, v)
        expected = M @ rates + C @ reference + G + controller.rules.damping @ s
        found = controller.torque(float(controller._memory.clock[0]), a, v, desired)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
        numbers = adapted.estimated_numbers(a, v)
        spreads = [0.5 * np.ptp(number.interval(), axis=-1) for number in numbers]
        width = spreads[0] @ np.abs(rates) + spreads[1] @ np.abs(reference) + spreads[2]
        ends = np.stack([found - width, found + width], axis=1)
        np.testing.assert_allclose(
            controller.torque_interval, ends, rtol=0.0, atol=1e-12 * np.abs(ends).max()
        )
        assert (width > 1e-6 * np.abs(found)).any() == (kind == "it2")


def test_the_gradient_of_type_2_is_the_slope_of_the_estimate() -> None:
    """Of sᵀ τ by each consequent: the weights at the switch points, whose moving changes nothing.

    Central differences of what is linear between switch points, by a millionth of the reach, of
    which rounding takes some 1e-10.
    """
    controller = adapting("five_bar", "it2")
    memory, t = controller._memory, float(controller._memory.clock[0])
    (a,), (v,), (desired,) = states(controller.base, 1)
    s, _, _ = errors(controller, a, v, desired)
    controller.torque(t, a, v, desired)
    gradient, start = memory.gradient.copy(), 0
    for system, place in zip(controller.base.systems_, controller.base.places, strict=True):
        for output in range(len(place.outputs)):
            for rule in (0, 3, 7):
                count = len(system.rules)
                k = start + output * count + rule
                left = 2 * start + 2 * output * count + rule
                power, h = [], 1e-6 * controller.rules.reach[k]
                for step in (h, -h):
                    before = memory.consequents[[left, left + count]].copy()
                    memory.consequents[[left, left + count]] += step
                    power.append(s @ controller.torque(t, a, v, desired))
                    memory.consequents[[left, left + count]] = before
                slope = (power[0] - power[1]) / (2.0 * h)
                assert gradient[k] == pytest.approx(slope, abs=1e-7 * np.abs(gradient).max())
        start += len(place.outputs) * len(system.rules)


# Stability


class OfRules:
    """A plant whose M, C and G are those of rules, by Runge and Kutta's method."""

    def __init__(self, model: FuzzyComputedTorque) -> None:
        self.model = model

    def rates(self, state: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Return speeds and accelerations."""
        n = len(force)
        M, C, G = self.model.estimate(state[:n], state[n:])
        return np.concatenate([state[n:], np.linalg.solve(M, force - C @ state[n:] - G)])

    def step(self, state: np.ndarray, force: np.ndarray, h: float) -> np.ndarray:
        """Return the state after a step of h under a force that is held."""
        k1 = self.rates(state, force)
        k2 = self.rates(state + 0.5 * h * k1, force)
        k3 = self.rates(state + 0.5 * h * k2, force)
        k4 = self.rates(state + h * k3, force)
        return np.asarray(state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))


def moved(base: FuzzyComputedTorque, share: float) -> tuple[FuzzyComputedTorque, np.ndarray]:
    """Return a model with other consequents, by up to a share of the reach, and how far, (P,)."""
    controller = AdaptiveFuzzyComputedTorque(base)
    rng = np.random.default_rng(3)
    off = share * controller.rules.reach * rng.uniform(-1.0, 1.0, controller.rules.reach.size)
    (system,), place = base.systems_, base.places[0]
    more = off.reshape(len(place.outputs), -1).T
    return base.with_systems([system.replace(consequents=system.consequents + more)]), off


def balance(name: str, period: float, duration: float = 0.6) -> tuple[np.ndarray, np.ndarray]:
    """Return V, and V plus what damping took, over a run of a plant of rules."""
    base = trained(name, coriolis="mass", rules=8)
    model, off = moved(base, 0.1)
    controller, plant = AdaptiveFuzzyComputedTorque(base, memory=1e12), OfRules(model)
    desired, n = sway(name)(period * np.arange(round(duration / period))), base.joints
    state = np.concatenate([desired.positions[0], np.zeros(n)])
    values, taken, total = [], [], 0.0
    for k, now in enumerate(map(Motion._make, zip(*desired, strict=True))):
        force = controller.torque(period * k, state[:n], state[n:], now)
        s = errors(controller, state[:n], state[n:], now)[0]
        M = model.estimate(state[:n], state[n:])[0]
        missing = controller._memory.delta - off
        kinetic = 0.5 * s @ M @ s
        values.append(kinetic + 0.5 * (missing**2 / controller.rules.rates).sum())
        taken.append(total)
        total += period * (s @ controller.rules.damping @ s)
        state = plant.step(state, force, period)
    return np.array(values), np.array(values) + np.array(taken)


@pytest.mark.parametrize("name", ["five_bar", "delta"])
def test_what_the_law_lessens_falls_by_what_damping_takes(name: str) -> None:
    r"""V of the module: :math:`V(t) + \int s^T K s\, dt` stays, to the first order of the period.

    The force is held for a period, and the gradient with it: of what damping takes the balance is
    off by less than a percent, and by half as much, or less, at half the period.
    """
    gaps = []
    for period in (1e-3, 5e-4):
        values, kept = balance(name, period)
        gaps.append(np.abs(kept - kept[0]).max() / (kept[-1] - values[-1]))
        assert values[-1] < 0.98 * values[0]
    assert gaps[0] < 0.01
    assert gaps[1] < 0.6 * gaps[0]


def test_a_force_that_is_missed_is_learned_critically_damped() -> None:
    r"""One rule, one motor: :math:`\ddot s + \kappa \dot s + \tfrac14 \kappa^2 s = 0`.

    So :math:`(1 + \kappa t / 2)\, e^{-\kappa t / 2}` of the missed force is left. M and C adapt by
    the square of the error, and the period is a hundredth of :math:`2 / \kappa`: 2 %.
    """
    base = FuzzyComputedTorque("t1", robot("jansen"), kp=KP, kv=KV, rules=1, coriolis="mass")
    base.fit(sway("jansen"), sway("jansen").period)
    (system,), missed, period = base.systems_, 1e-3, 1e-3
    more = missed * np.eye(2)[1]
    plant = OfRules(base.with_systems([system.replace(consequents=system.consequents + more)]))
    controller = AdaptiveFuzzyComputedTorque(base, memory=1e12)
    hold = sway("jansen")(0.0)._replace(speeds=np.zeros(1), accelerations=np.zeros(1))
    state, learned = np.concatenate([hold.positions, np.zeros(1)]), []
    for k in range(600):
        force = controller.torque(period * k, state[:1], state[1:], hold)
        learned.append(controller._memory.delta[1])
        state = plant.step(state, force, period)
    decay = poles_of_servo(KP, KV).decay
    phase = 0.5 * decay * period * np.arange(600)
    expected = missed * (1.0 - (1.0 + phase) * np.exp(-phase))
    np.testing.assert_allclose(learned, expected, rtol=0.0, atol=0.02 * missed)
    assert learned[-1] > 0.9 * missed


@pytest.mark.parametrize(
    ("name", "share"), [("five_bar", 0.4), ("delta", 0.1), ("gough_stewart", 0.1)]
)
@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_a_payload_is_learned(name: str, share: float, kind: str) -> None:
    """A quarter of the robot's mass at its tip, which exact computed torque does not know.

    What is left of that one's error in the second half is at most the share; the five-bar lies
    flat, so that all that it has to learn is M, of which the payload is out of reach.
    """
    total = sum(inertia.mass for inertia in robot(name).model.inertias)
    plant = RungeKutta(with_payload(robot(name), 0.25 * total))
    path, left = sway(name), []
    for controller in (
        psp3.ComputedTorque(robot(name), KP, KV),
        AdaptiveFuzzyComputedTorque(trained(name, kind)),
    ):
        result = psp3.simulate(robot(name), controller, path, 4.0, plant=plant)
        off = (result.desired.positions - result.positions)[len(result.t) // 2 :]
        left.append(np.sqrt((off**2).mean()))
    assert left[1] < share * left[0]


# Loops, bounds, files


@pytest.mark.parametrize("coriolis", ["rules", "mass"])
@pytest.mark.parametrize("kind", ["t1", "it2"])
@pytest.mark.parametrize("name", ROBOTS)
def test_the_compiled_loop_does_as_the_one_in_python(name: str, kind: str, coriolis: str) -> None:
    controller = AdaptiveFuzzyComputedTorque(trained(name, kind, coriolis=coriolis, rules=8))
    table = controller.table(robot(name).compiled_table(), Widths.of_motors(controller.base.joints))
    assert table is not None
    found = []
    for plant in (RungeKutta(robot(name)), InPython(robot(name))):
        options = {"plant": plant, "encoder_resolution": 1e-5, "delay": 1}
        result = psp3.simulate(robot(name), controller, sway(name), 0.2, **options)
        found.append((result, controller._memory.consequents.copy(), controller.torque_interval))
    (one, learned, interval), (other, learned_too, interval_too) = found
    for field in ("positions", "speeds", "torque", "covered", "fell_back", "torque_interval"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field))
    np.testing.assert_array_equal(learned, learned_too)
    np.testing.assert_array_equal(interval, interval_too)
    assert not np.array_equal(learned, controller.rules.trained)


def test_consequents_stay_within_reach() -> None:
    base = trained("delta", rules=8)
    controller = AdaptiveFuzzyComputedTorque(base, reach=0.05)
    total = sum(inertia.mass for inertia in robot("delta").model.inertias)
    psp3.simulate(with_payload(robot("delta"), total), controller, sway("delta"), 1.0)
    assert controller.at_reach
    assert (np.abs(controller._memory.delta) <= controller.rules.reach).all()
    moved = controller._memory.consequents - controller.rules.trained
    assert np.abs(moved).max() <= controller.rules.reach.max() * (1.0 + 1e-12)
    controller.reset()
    assert not controller.at_reach


def test_what_nothing_confirms_fades() -> None:
    """Where there is no error nothing is learned, and what was learned falls to 1/e in 0.3 s."""
    controller = AdaptiveFuzzyComputedTorque(trained("delta", rules=8), memory=0.3)
    psp3.simulate(with_payload(robot("delta"), 0.2), controller, sway("delta"), 0.5)
    t, now = float(controller._memory.clock[0]), sway("delta")(0.5)
    # The first call learns from the one before, the second fades.
    controller.torque(t + 0.002, now.positions, now.speeds, now)
    before = controller._memory.delta.copy()
    assert np.abs(before).max() > 0.0
    controller.torque(t + 0.302, now.positions, now.speeds, now)
    np.testing.assert_allclose(controller._memory.delta, before / math.e, rtol=1e-12)


def test_what_was_learned_can_be_saved_and_adapted_from(tmp_path: Path) -> None:
    controller = adapting("delta")
    adapted = controller.adapted()
    found = FuzzyComputedTorque.load(adapted.save(tmp_path / "adapted.json"), robot("delta"))
    for one, other in zip(found.systems_, adapted.systems_, strict=True):
        np.testing.assert_array_equal(one.consequents, other.consequents)
    again = AdaptiveFuzzyComputedTorque(found)
    np.testing.assert_array_equal(again._memory.consequents, controller._memory.consequents)
    # What was trained stays what it was.
    for system, learned in zip(controller.base.systems_, adapted.systems_, strict=True):
        assert not np.array_equal(system.consequents, learned.consequents)
    assert adapted.robot is controller.base.robot


# Gains and sizes


@pytest.mark.parametrize(
    ("kp", "kv", "slope", "decay"),
    [
        (400.0, 40.0, 20.0, 20.0),
        (6.0, 5.0, 2.0, 3.0),
        (10.0, 1.0, math.sqrt(10.0), math.sqrt(10.0)),
    ],
)
def test_poles_are_those_of_the_servo_or_critically_damped(
    kp: float, kv: float, slope: float, decay: float
) -> None:
    found = poles_of_servo(kp, kv)
    assert found == (pytest.approx(slope, rel=1e-12), pytest.approx(decay, rel=1e-12))


def test_sizes_are_those_of_the_trained_motion() -> None:
    """Of M, speeds and G along the sway itself; ranges are those of the record, a percent more."""
    base = trained("delta")
    sizes, motion = (
        sizes_of(base),
        sway("delta").joints(np.linspace(0.0, sway("delta").period, 500)),
    )
    M, _, G = robot("delta").equation_of_motion(motion[0], motion[1])
    roots = np.sqrt(np.diagonal(M.mean(axis=0)))
    assert np.sqrt(sizes.masses) == pytest.approx(roots, rel=0.02)
    fastest = np.abs(motion[1]).max(axis=0)
    assert sizes.speed == pytest.approx(np.sqrt(((roots * fastest) ** 2).mean()), rel=0.05)
    assert sizes.weight == pytest.approx(np.sqrt(((G / roots) ** 2).mean()), rel=0.1)


def test_rates_and_reach_are_the_same_in_other_units() -> None:
    """Forces of a consequent that moves by its reach, over the square root of its motor's mass.

    Of M they are at the trained acceleration, of C at the trained speed: the same for all entries.
    """
    controller = AdaptiveFuzzyComputedTorque(trained("delta", rules=8))
    sizes, rules, n = sizes_of(controller.base), controller.rules, 3
    numbers = np.full((2, count_of_numbers(n)), np.nan)
    start = 0
    for system, place in zip(controller.base.systems_, controller.base.places, strict=True):
        count = len(system.rules)
        for j, number in enumerate(place.outputs):
            numbers[:, number] = rules.reach[start + j * count], rules.rates[start + j * count]
        start += count * len(place.outputs)
    assert np.isfinite(numbers).all()
    M, C, G = unpack(numbers)
    roots = np.sqrt(sizes.masses)
    both = np.outer(roots, roots)
    np.testing.assert_allclose(M[0] / both, 0.5, rtol=1e-12)
    np.testing.assert_allclose(C[0] * sizes.speed / both, 0.5 * sizes.acceleration, rtol=1e-12)
    usual = sizes.weight + sizes.acceleration
    np.testing.assert_allclose(G[0] / roots, 0.5 * usual, rtol=1e-12)
    share = G[1] / sizes.masses
    np.testing.assert_allclose(share, share[0], rtol=1e-12)
    np.testing.assert_allclose(M[1] * sizes.acceleration**2 / both**2, share[0], rtol=1e-12)
    assert len(places_of("MG", n)) + len(places_of("C", n)) == numbers.shape[1]


def test_what_cannot_be_meant_is_refused() -> None:
    base = trained("delta", rules=8)
    with pytest.raises(InvalidValue, match="left out"):
        AdaptiveFuzzyComputedTorque(base, lag=0.05)
    with pytest.raises(InvalidValue, match=r"adapted\(\)\.systems_"):
        AdaptiveFuzzyComputedTorque(base).consequents  # noqa: B018
    loose = FuzzyComputedTorque("t1", robot("delta"), kp=0.0, kv=1.0)
    loose.with_systems  # noqa: B018
    loose._take(base.systems_, base.ranges_)
    with pytest.raises(InvalidValue, match="until the positions are right"):
        AdaptiveFuzzyComputedTorque(loose)
    assert repr(AdaptiveFuzzyComputedTorque(base)).endswith(
        "8 + 8 rules), memory=20, trust=0.2, reach=0.5)"
    )

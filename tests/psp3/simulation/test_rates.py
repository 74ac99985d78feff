"""Rates of configurations against differences of Pinocchio's integration."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.testing import assert_allclose, assert_array_equal

from psp3.simulation.rates import RatesOfConfiguration
from tests.helpers import derivative


def every_joint() -> pin.Model:
    """Return a chain with every kind of joint whose coordinates are counted in a way of its own."""
    model, last = pin.Model(), 0
    for name, kind in (
        ("base", pin.JointModelFreeFlyer()),
        ("hinge", pin.JointModelRX()),
        ("ball", pin.JointModelSpherical()),
        ("endless", pin.JointModelRUBZ()),
        ("plane", pin.JointModelPlanar()),
        ("slides", pin.JointModelTranslation()),
    ):
        last = model.addJoint(last, kind, pin.SE3.Random(), name)
    return model


def test_rates_are_how_pinocchio_integrates() -> None:
    """By differences, 1e-8; and normalized numbers have unit length."""
    model, rng = every_joint(), np.random.default_rng(0)
    rates = RatesOfConfiguration(model)
    for _ in range(20):
        q = pin.integrate(model, pin.neutral(model), rng.uniform(-2.0, 2.0, model.nv))
        v = rng.normal(size=model.nv)
        expected = derivative(lambda t, q=q, v=v: pin.integrate(model, q, t * v), 1e-2)
        assert_allclose(rates(q, v), expected, rtol=0.0, atol=1e-8)
        stretched = q * rng.uniform(0.9, 1.1)
        assert pin.isNormalized(model, rates.normalized(stretched), 1e-14)


def test_of_hinges_and_slides_rates_are_speeds() -> None:
    model = pin.Model()
    model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "slide")
    rates = RatesOfConfiguration(model)
    q, v = np.array([0.3]), np.array([-0.7])
    assert_array_equal(rates(q, v), v)
    assert rates.normalized(q) is q

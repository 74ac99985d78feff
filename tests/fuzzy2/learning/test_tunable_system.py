"""A system as a vector of parameters.

The analytic gradient against finite differences of the system itself.
"""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2.learning.tunable_system import TunableSystem
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.systems import IntervalType2System
from tests.fuzzy2.learning.tunable import samples, systems


@pytest.mark.parametrize("t_norm", ["product", "min"])
@pytest.mark.parametrize(
    "name",
    [
        "type-1",
        "type-1, intervals",
        "type-1, linear",
        "interval type-2",
        "interval type-2, intervals",
        "interval type-2, linear",
    ],
)
def test_gradient_is_that_of_finite_differences_of_the_system(name: str, t_norm: str) -> None:
    """Central differences of the error of the compiled system, evaluated anew for every parameter.

    With a step of 1e-6 truncation is 1e-12 and rounding 1e-10 of an error of order 1, so 1e-7 is
    generous; the samples are drawn so that none lies within a step of a kink (a change of switch
    point, of the smallest grade or of the nearer mean).
    """
    rng = np.random.default_rng(3)
    system = systems(rng, t_norm)[name]
    X, Y = samples(rng)
    scales = np.array([0.9, 25.0])
    tunable = TunableSystem(system, [4.0, 60.0], scales)

    def error(parameters: np.ndarray) -> float:
        return float(np.mean(((tunable.system(parameters)(X) - Y) / scales) ** 2))

    value, gradient = tunable.objective(tunable.parameters, X, Y)
    assert value == pytest.approx(error(tunable.parameters), rel=1e-12)
    expected = np.empty_like(gradient)
    for k in range(gradient.size):
        step = np.zeros(gradient.size)
        step[k] = 1e-6
        expected[k] = (error(tunable.parameters + step) - error(tunable.parameters - step)) / 2e-6
    np.testing.assert_allclose(gradient, expected, rtol=1e-6, atol=1e-7)
    # Every parameter matters somewhere among the samples, so that a gradient of zeros would not
    # pass.
    assert (np.abs(gradient) > 1e-6).mean() > 0.9


@pytest.mark.parametrize(
    "name", ["type-1", "interval type-2, intervals", "interval type-2, linear"]
)
def test_parameters_there_and_back_are_the_same_system(name: str) -> None:
    """Scales, logarithms and back: a few ulps, 1e-13 relative."""
    system = systems(np.random.default_rng(0), "product")[name]
    tunable = TunableSystem(system, [4.0, 60.0], [2.0, 3.0])
    again = tunable.system(tunable.parameters)
    X, _ = samples(np.random.default_rng(1))
    np.testing.assert_allclose(
        again.type_reduced(X), system.type_reduced(X), rtol=1e-11, atol=1e-13
    )
    assert type(again) is type(system)
    assert again.inputs[0][2].height == system.inputs[0][2].height
    np.testing.assert_array_equal(again.rules, system.rules)


@pytest.mark.parametrize("t_norm", ["product", "min"])
@pytest.mark.parametrize("name", ["type-1", "interval type-2", "interval type-2, linear"])
def test_far_from_all_terms_the_gradient_is_that_of_the_system(name: str, t_norm: str) -> None:
    """Where all grades are 0 as floats: central differences, as above, with the same bounds."""
    rng = np.random.default_rng(8)
    system = systems(rng, t_norm)[name]
    X = np.array([[90.0, -1500.0], [-75.0, 1100.0], [60.0, 2000.0]])
    assert not system.firing(X).any()
    scales = np.abs(system(X)).max(axis=0)
    Y = np.zeros((3, 2))
    tunable = TunableSystem(system, [4.0, 60.0], scales)
    value, gradient = tunable.objective(tunable.parameters, X, Y)
    assert value == pytest.approx(np.mean((system(X) / scales) ** 2), rel=1e-11)
    assert tunable.error(tunable.parameters, X, Y) == value
    for k in range(gradient.size):
        step = np.zeros(gradient.size)
        step[k] = 1e-6
        high, low = (tunable.error(tunable.parameters + s, X, Y) for s in (step, -step))
        assert gradient[k] == pytest.approx((high - low) / 2e-6, rel=1e-4, abs=1e-6)
    assert gradient.any()


def test_crossed_pairs_meet_in_their_middle() -> None:
    system = systems(np.random.default_rng(0), "product")["interval type-2, intervals"]
    tunable = TunableSystem(system, [1.0, 1.0], [1.0, 1.0])
    parameters = tunable.parameters.copy()
    parameters[0], parameters[1] = 0.5, -0.5
    corrected = tunable.admissible(parameters)
    np.testing.assert_array_equal(corrected[:2], [0.0, 0.0])
    np.testing.assert_array_equal(corrected[2:], parameters[2:])
    assert tunable.system(corrected).inputs[0][0].mean == (0.0, 0.0)


def test_a_single_rule_without_lower_firing_has_a_gradient() -> None:
    """The lower membership is 0 as a float 40 sigma from the far mean.

    Both ends are the one consequent, and move with it one to one.
    """
    term = GaussianUncertainMean((0.0, 100.0), 1.0)
    tunable = TunableSystem(IntervalType2System([[term]], [[0]], [[3.0]]), [1.0], [1.0])
    error, gradient = tunable.objective(tunable.parameters, np.array([[50.0]]), np.array([[1.0]]))
    assert error == 4.0
    np.testing.assert_array_equal(gradient, [0.0, 0.0, 0.0, 4.0])

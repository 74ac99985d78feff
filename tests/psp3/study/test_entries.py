"""Estimators of others as controllers: least squares, of which the answer is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidValue
from psp3.fuzzy_control.numbers import pack
from psp3.fuzzy_control.records import NOISE_OF_THE_STUDY, record
from psp3.study.entries import EstimatedComputedTorque, is_estimator
from psp3.study.execution import execute
from psp3.study.run import Run
from psp3.trajectories import Sway


class Linear:
    """Least squares with a constant, and a little ridge."""

    def fit(self, X: Any, Y: Any) -> Linear:
        """Keep what it is given, and the solution."""
        self.X, self.Y = X, Y
        A = np.column_stack([np.ones(len(X)), X])
        self.W = np.linalg.solve(A.T @ A + 1e-3 * np.eye(A.shape[1]), A.T @ Y)
        return self

    def predict(self, X: Any) -> Any:
        """Return what the solution says."""
        return np.column_stack([np.ones(len(X)), X]) @ self.W


class Quadratic(Linear):
    """Least squares of all products of two inputs."""

    def fit(self, X: Any, Y: Any) -> Linear:
        """Fit the products."""
        return super().fit(self._products(X), Y)

    def predict(self, X: Any) -> Any:
        """Predict from the products."""
        return super().predict(self._products(X))

    def _products(self, X: Any) -> Any:
        i, j = np.triu_indices(X.shape[1])
        return np.concatenate([X, X[:, i] * X[:, j]], axis=1)


class Nothing(Linear):
    """An estimator whose M is never positive definite."""

    def predict(self, X: Any) -> Any:
        """Return what is far from everything that was learned."""
        return np.full((len(X), self.Y.shape[1]), -1e6)


def learned(estimator: Any, snr_db: float = np.inf) -> tuple[Any, Any, EstimatedComputedTorque]:
    robot = psp3.load("five_bar")
    recorded = record(robot, Sway(robot=robot), 2.0, kp=100.0, kv=20.0)
    controller = EstimatedComputedTorque(estimator, robot, 100.0, 20.0)
    rng = np.random.default_rng(4)
    return robot, recorded, controller.learn(recorded, 150, snr_db, rng, NOISE_OF_THE_STUDY)


def test_what_is_learned_from_are_scaled_samples_of_the_record() -> None:
    estimator = Linear()
    _, recorded, _ = learned(estimator)
    X, Y = (values[recorded.sample(150)] for values in (recorded.inputs, recorded.outputs))
    for found, given in ((estimator.X, X), (estimator.Y, Y)):
        assert found.shape == given.shape
        np.testing.assert_allclose(found.mean(axis=0), 0.0, atol=1e-10)
        moves = np.ptp(given, axis=0) > 1e-12
        np.testing.assert_allclose(found.std(axis=0)[moves], 1.0, rtol=1e-10)


def test_torque_is_that_of_the_estimate_at_the_nearest_inputs() -> None:
    """M a + C v + G by hand; a state far outside is taken back to the trained range."""
    robot, recorded, controller = learned(Linear())
    middle = recorded.sample(150)[70]
    a, v = recorded.positions[middle], recorded.speeds[middle]
    desired = Sway(robot=robot)(1.0)
    M, C, G = controller.estimate(a, v)
    assert (controller.covered, controller.fell_back) == (True, False)
    servo = desired.accelerations + 20.0 * (desired.speeds - v) + 100.0 * (desired.positions - a)
    np.testing.assert_allclose(controller.torque(0.0, a, v, desired), M @ servo + C @ v + G)
    # Close to the exact ones, for on so small a motion they are nearly linear.
    np.testing.assert_allclose(M, robot.mass_matrix(a), rtol=0.0, atol=0.3 * M.max())
    far = controller.estimate(a + 10.0, v)
    assert not controller.covered
    least, greatest = (end[: len(a)] for end in controller._range)
    np.testing.assert_allclose(far[0], controller.estimate(np.maximum(greatest, least), v)[0])


def test_mean_of_what_was_learned_takes_the_place_of_what_is_no_mass() -> None:
    _, recorded, controller = learned(Nothing())
    found = controller.estimate(recorded.positions[5], recorded.speeds[5])
    assert controller.fell_back
    mean = recorded.outputs[recorded.sample(150)].mean(axis=0)
    np.testing.assert_allclose(pack(*found), mean)


def test_noise_is_that_of_the_generator() -> None:
    one, other = Linear(), Linear()
    learned(one, 20.0)
    learned(other, 20.0)
    np.testing.assert_array_equal(one.Y, other.Y)
    clean = Linear()
    learned(clean)
    assert np.abs(one.Y - clean.Y).max() > 0.01


def test_an_entry_is_named_by_where_it_is() -> None:
    """On the path learned it tracks about as well as exact computed torque does."""
    fields: dict[str, Any] = {"robot": "five_bar", "duration": 1.0}
    found = execute(Run(f"{__name__}:Quadratic", **fields))
    exact = execute(Run("ctc", **fields))
    assert found["diverged"] == 0.0
    assert found["rms_error"] < 3.0 * exact["rms_error"]
    assert 0.5 < found["coverage"] <= 1.0
    noisy = [execute(Run(f"{__name__}:Quadratic", snr_db=20.0, seed=k, **fields)) for k in (0, 1)]
    assert noisy[0]["rms_error"] != noisy[1]["rms_error"]


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("no_such_module:Name", r"that can be imported .* PYTHONPATH"),
        ("psp3:NoSuchName", "that can be imported"),
        ("psp3.version:package_version", "that can be imported"),
    ],
)
def test_what_cannot_be_imported_is_refused(place: str, words: str) -> None:
    with pytest.raises(InvalidValue, match=words):
        execute(Run(place, duration=0.1))


def test_what_is_no_controller_is_refused() -> None:
    with pytest.raises(InvalidValue, match="reset"):
        execute(Run(f"{__name__}:is_estimator", duration=0.1))
    with pytest.raises(InvalidValue, match="which has its own M, C and G"):
        execute(Run(f"{__name__}:Linear", "online", 20.0, duration=0.1))
    with pytest.raises(InvalidValue, match="predict"):
        EstimatedComputedTorque(object(), psp3.load("five_bar"), 1.0, 1.0)
    assert is_estimator(Linear())
    assert not is_estimator(object())

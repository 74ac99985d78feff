"""What motors do: drives of coordinates, least norm, accelerations of some coordinates."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from psp3.dynamics.motors import Motors, least_norm, partly_linearizing
from psp3.errors import UnreachableForces
from tests.helpers import Array


def random_matrices(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Return a mass matrix (4, 4), a bias (4,) and an actuation matrix (4, 3) of full rank."""
    root = rng.normal(size=(4, 4))
    return root @ root.T + np.eye(4), rng.normal(size=4), rng.normal(size=(4, 3))


@pytest.mark.parametrize("k", [1, 2, 3])
def test_the_first_coordinates_are_accelerated_as_wanted(k: int) -> None:
    """And no shorter forces do so: what is found is a combination of the rows, to 1e-9."""
    rng = np.random.default_rng(k)
    for _ in range(20):
        mass, bias, actuation = random_matrices(rng)
        wanted = rng.normal(size=k)
        motors = partly_linearizing(mass, bias, actuation, wanted, "abcd")
        made = np.linalg.solve(mass, actuation @ motors - bias)
        np.testing.assert_allclose(made[:k], wanted, rtol=0.0, atol=1e-9)
        rows = np.linalg.solve(mass, actuation)[:k]
        free = np.linalg.svd(rows)[2][k:]
        np.testing.assert_allclose(free @ motors, 0.0, atol=1e-9 * np.abs(motors).max())


def test_what_is_missed_is_told() -> None:
    matrix = np.array([[1.0, 1.0], [2.0, 2.0]])
    np.testing.assert_allclose(least_norm(matrix, np.array([2.0, 4.0]), "ab"), [1.0, 1.0])
    with pytest.raises(UnreachableForces, match=r"forces of 0\.4 ") as caught:
        least_norm(matrix, np.array([1.0, 0.0]) / 2.0, "ab")
    assert caught.value.coordinates == ("a", "b")
    mass, bias, actuation = random_matrices(np.random.default_rng(0))
    with pytest.raises(UnreachableForces, match=r"accelerations of .* coordinates a, b, c, d"):
        partly_linearizing(mass, bias, actuation, np.ones(4), "abcd")


def test_drives_of_motors_are_at_their_coordinates_or_elsewhere() -> None:
    """Coordinates are x and y; z follows y alone, w both.

    Motors at y, at z, and of a tendon from y by 2 to z; joints with dry friction of their own, of
    which w's is left to the joint.
    """
    model = pin.Model()
    for name in ("x", "y", "z", "w"):
        model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), name)
    model.upperDryFrictionLimit = np.array([0.1, 0.2, 0.3, 0.4])
    matrix = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 2.0], [0.0, 1.0, 1.0], [0.0, 0.0, 0.0]])
    followed = np.array([0, 1, 1, -1])
    motors = Motors(("y", "z", "t"), matrix, np.array([0, 1]), 0, model, followed)
    assert not motors.are_coordinates
    drives = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])
    driven = motors.driven(drives)
    np.testing.assert_allclose(driven.coordinates, [[0.0, 0.0, 0.1], [1.0, 2.0, 3.2]], rtol=1e-15)
    np.testing.assert_array_equal(driven.columns.T, [*matrix.T[1:], [0.0, 0.0, 1.0, 0.0]])
    np.testing.assert_array_equal(driven.elsewhere, [*drives[1:], [0.0, 0.0, 0.3]])
    np.testing.assert_array_equal(driven.follows, [1, 1, 1])
    np.testing.assert_array_equal(driven.joints, [0, 1, 2])
    # A tendon from x to z follows two coordinates, and so does a motor at w.
    matrix = np.array([[1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    motors = Motors(("t", "w"), matrix, np.array([0, 1]), 0, model, followed)
    np.testing.assert_array_equal(motors.driven(drives[:2]).follows, [-1, -1, 1])
    without = motors.without_drives()
    assert not without.coordinates.any()
    assert not without.follows.size
    assert not without.joints.size
    alone = Motors(("x", "y"), np.eye(4)[:, :2], np.array([0, 1]), 0, model, followed)
    assert alone.are_coordinates

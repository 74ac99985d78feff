"""Mass matrix, Christoffel matrix, gravity and energies, against dense formulas and differences."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from psp3.multibody.bodies import weigh
from psp3.multibody.inertia import (
    complement,
    coriolis_matrix,
    factor_positive,
    gravity,
    kinetic_energy,
    mass_matrix,
    potential_energy,
    solve_positive,
)
from psp3.multibody.tree import AT_COMPLEMENT, AT_JOINTS, AT_MASS, AT_RESTS, JOINT_NUMBERS
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative
from tests.psp3.multibody.flat import Flat, dense_complement, flat_of, symmetric
from tests.psp3.multibody.test_forces import moving


def stretched(parts: SimpleNamespace, flat: Flat) -> Array:
    """Give every joint with as many coordinates as freedoms a spring; return stiffness by q."""
    rng = np.random.default_rng(71)
    joints = flat.numbers[flat.at(AT_JOINTS) :][: JOINT_NUMBERS * flat.nv].reshape(
        -1, JOINT_NUMBERS
    )
    rests = flat.numbers[flat.at(AT_RESTS) :][: parts.model.nq]
    stiffness = np.zeros(parts.model.nq)
    for joint in list(parts.model.joints)[1:]:
        if joint.nq == joint.nv:
            for k in range(joint.nv):
                stiffness[joint.idx_q + k] = joints[joint.idx_v + k, 2] = rng.uniform(1.0, 2.0)
    rests[:] = rng.normal(size=parts.model.nq)
    return stiffness


def equation(flat: Flat, q: Array, speeds: Array) -> tuple[Array, Array, Array]:
    """Return M, C and G of a closed pose by the kernels."""
    flat.close(q)
    weigh(*flat.all)
    moving(flat, speeds)
    n, at = flat.n, flat.at(AT_MASS)
    complement(*flat.all, 1.0)
    mass_matrix(*flat.all, at)
    mass = flat.part(AT_MASS, n, n).copy()
    coriolis_matrix(*flat.all, at)
    coriolis = flat.part(AT_MASS, n, n).copy()
    gravity(*flat.all, at)
    return mass, coriolis, flat.part(AT_MASS, n).copy()


def test_complement_with_and_without_rates_is_the_dense_one(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """By NumPy's pseudo-inverse of Pinocchio's Jacobian; 1e-12."""
    flat.close(pose)
    moving(flat, np.ones(flat.n))
    for with_rates in (0.0, 1.0):
        flat.part(AT_COMPLEMENT, flat.n, flat.nv)[:] = np.nan
        complement(*flat.all, with_rates)
        found = flat.part(AT_COMPLEMENT, flat.n, flat.nv).T
        assert_allclose(found, dense_complement(parts, pose), rtol=0.0, atol=1e-12)


def test_mass_matrix_is_pinocchios_projected(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """Lᵀ crba L with motors' inertia, symmetric to the bit; 1e-12."""
    mass, _, _ = equation(flat, pose, np.zeros(flat.n))
    tree = symmetric(pin.crba(parts.model, parts.model.createData(), pose))
    L = dense_complement(parts, pose)
    assert_allclose(mass, L.T @ tree @ L, rtol=0.0, atol=1e-12 * np.abs(mass).max())
    assert (mass == mass.T).all()
    assert np.linalg.eigvalsh(mass)[0] > 0.0


def test_christoffel_matrix_is_that_of_the_mass_matrix(
    parts: SimpleNamespace, robot: ClosedLoopRobot, flat: Flat, pose: Array
) -> None:
    """½ Σ (∂M_ij/∂s_k + ∂M_ik/∂s_j − ∂M_jk/∂s_i) v_k, by differences of M; 1e-8."""
    speeds = np.random.default_rng(72).normal(size=flat.n)
    _, found, _ = equation(flat, pose, speeds)
    path = robot.dynamics("pinocchio")
    position = pose[robot.actuated_q]

    def mass_at(t: float, unit: Array) -> Array:
        q = path.configuration(position + t * unit)  # type: ignore[attr-defined]
        return equation(flat, q, speeds)[0]

    slopes = np.stack(
        [derivative(lambda t, u=unit: mass_at(t, u), 2e-3) for unit in np.eye(flat.n)], axis=-1
    )
    expected = 0.5 * np.einsum(
        "ijk,k->ij", slopes + slopes.transpose(0, 2, 1) - slopes.transpose(2, 1, 0), speeds
    )
    assert_allclose(found, expected, rtol=0.0, atol=1e-8)


def test_christoffel_matrix_of_an_open_tree_is_pinocchios() -> None:
    """Without loops, of joints of one freedom each, both are of Christoffel symbols; 1e-12."""
    rng, model = np.random.default_rng(73), pin.Model()
    for number in range(5):
        kind = pin.JointModelRX() if number % 2 else pin.JointModelPY()
        placement = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
        joint = model.addJoint(number, kind, placement, f"j{number}")
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    parts = SimpleNamespace(
        model=model, constraint_models=[], actuated=tuple(f"j{k}" for k in range(5))
    )
    q, v = rng.normal(size=(2, 5))
    mass, coriolis, weight = equation(flat_of(parts), q, v)
    data = model.createData()
    expected = pin.computeCoriolisMatrix(model, data, q, v)
    assert_allclose(coriolis, expected, rtol=0.0, atol=1e-12)
    assert_allclose(mass, symmetric(pin.crba(model, data, q)), rtol=0.0, atol=1e-12)
    assert_allclose(weight, pin.computeGeneralizedGravity(model, data, q), rtol=0.0, atol=1e-12)


def test_gravity_and_springs_are_projected_forces(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """Pinocchio's gravity and the springs' forces by hand, through L; 1e-12."""
    stiffness = stretched(parts, flat)
    rests = flat.numbers[flat.at(AT_RESTS) :][: parts.model.nq]
    forces = pin.computeGeneralizedGravity(parts.model, parts.model.createData(), pose)
    for joint in list(parts.model.joints)[1:]:
        if joint.nq == joint.nv:
            own = slice(joint.idx_q, joint.idx_q + joint.nq)
            forces[joint.idx_v : joint.idx_v + joint.nv] += stiffness[own] * (
                pose[own] - rests[own]
            )
    _, _, found = equation(flat, pose, np.zeros(flat.n))
    expected = dense_complement(parts, pose).T @ forces
    assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_energies_are_pinocchios_and_the_springs(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """½ k x² of every spring; 1e-13 relative."""
    stiffness = stretched(parts, flat)
    rests = flat.numbers[flat.at(AT_RESTS) :][: parts.model.nq]
    flat.close(pose)
    weigh(*flat.all)
    v = moving(flat, np.random.default_rng(74).normal(size=flat.n))
    data = parts.model.createData()
    # Pinocchio's has the motors' inertia, too.
    kinetic = pin.computeKineticEnergy(parts.model, data, pose, v)
    tree = symmetric(pin.crba(parts.model, data, pose))
    assert_allclose(kinetic_energy(*flat.all), 0.5 * v @ tree @ v, rtol=1e-12)
    assert kinetic <= 0.5 * v @ tree @ v * (1.0 + 1e-12)
    potential = pin.computePotentialEnergy(parts.model, data, pose)
    potential += 0.5 * np.sum(stiffness * (pose - rests) ** 2)
    assert_allclose(potential_energy(*flat.all), potential, rtol=1e-13)


def test_gravity_is_the_gradient_of_the_potential_energy(
    parts: SimpleNamespace, robot: ClosedLoopRobot, flat: Flat, pose: Array
) -> None:
    """By differences along each independent coordinate; 1e-8 of some newtons."""
    stretched(parts, flat)
    path, position = robot.dynamics("pinocchio"), pose[robot.actuated_q]

    def energy(t: float, unit: Array) -> Array:
        q = path.configuration(position + t * unit)  # type: ignore[attr-defined]
        flat.close(q)
        return np.array(potential_energy(*flat.all))

    found = equation(flat, pose, np.zeros(flat.n))[2]
    slopes = [derivative(lambda t, u=unit: energy(t, u), 2e-3) for unit in np.eye(flat.n)]
    assert_allclose(found, slopes, rtol=0.0, atol=1e-8)


@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_positive_definite_systems_are_solved(seed: int, order: int) -> None:
    """Against NumPy's; 1e-10 for condition numbers below 1e4."""
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.normal(size=(order, order)))
    matrix = axes @ np.diag(10.0 ** rng.uniform(-2.0, 2.0, order)) @ axes.T
    right = rng.normal(size=order)
    memory = np.concatenate([matrix.ravel(), right])
    assert factor_positive(memory, 0, order)
    solve_positive(memory, 0, order, order * order)
    solution = memory[order * order :]
    expected = np.linalg.solve(matrix, right)
    assert_allclose(solution, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_a_matrix_that_is_not_positive_definite_is_refused(seed: int, order: int) -> None:
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.normal(size=(order, order)))
    values = rng.uniform(1.0, 2.0, order)
    values[0] = -1.0
    memory = np.concatenate([(axes @ np.diag(values) @ axes.T).ravel(), np.zeros(order)])
    assert not factor_positive(memory, 0, order)
    assert not factor_positive(np.full(order * order + order, np.nan), 0, order)

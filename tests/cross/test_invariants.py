"""What every implementation of this robot must keep, whatever its numbers.

Symmetries, conservation laws, geometry.

A star inertia along the wrong axis passes the energy test but fails the 120 degree symmetry, so
both are here.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import psp3
from psp3.three_psp import closed_form, stepping
from tests.helpers import (
    SCREW_AZIMUTHS,
    Array,
    derivative,
    random_heights,
    random_states,
    relative_error,
    thesis_chain,
)

SETS = tuple(psp3.PARAMETER_SETS)
ONES = np.ones(3)
STEP = 5e-3
"""Eighth-order differences with 5 mm steps: the star's functions are analytic within 0.27 m, so
truncation is below 1e-10.
"""


@pytest.fixture(scope="module", params=SETS)
def robot(request: pytest.FixtureRequest) -> psp3.PSP3:
    return psp3.load("psp3", request.param)


@pytest.fixture(scope="module")
def default() -> psp3.PSP3:
    return psp3.load("psp3")


def states(seed: int, count: int = 300) -> tuple[Array, Array]:
    return random_states(np.random.default_rng(seed), count)


# Mass matrix, Coriolis matrix, gravity


def test_mass_matrix_is_symmetric_and_positive_definite(robot: psp3.PSP3) -> None:
    """Symmetric bit for bit (its lower half is a copy).

    No eigenvalue below that of a bare nut with its ball.
    """
    mass = robot.mass_matrix(states(0)[0])
    assert (mass == mass.swapaxes(-1, -2)).all()
    sliding = robot.parameters.nut_mass + 3 * robot.parameters.ball_mass
    assert np.linalg.eigvalsh(mass).min() > sliding * (1 - 1e-12)


def test_only_differences_of_heights_and_speeds_matter(robot: psp3.PSP3) -> None:
    """Raise all nuts together and let them all move faster.

    1e-11 relative: the common part is up to a thousand times the differences and leaves them with
    that many digits less.
    """
    heights, speeds = states(1)
    shift, drift = np.random.default_rng(2).uniform(-1.0, 1.0, size=(2, len(heights), 1))
    for found, expected in zip(
        robot.equation_of_motion(heights + shift, speeds + drift),
        robot.equation_of_motion(heights, speeds),
        strict=True,
    ):
        assert relative_error(found, expected) < 1e-11


def test_all_nuts_together_carry_the_total_mass(robot: psp3.PSP3) -> None:
    """1'M1 = 26.496 kg and 1'G = 26.496 kg times g; 1e-13 relative is rounding."""
    mass, _, gravity = robot.equation_of_motion(*states(3))
    assert_allclose(ONES @ mass @ ONES, 26.496, rtol=1e-13)
    assert_allclose(gravity @ ONES, 26.496 * robot.parameters.gravity, rtol=1e-13)


def test_gravity_is_g_times_the_row_sums_of_the_mass_matrix(robot: psp3.PSP3) -> None:
    """G = g M 1 exactly, because lifting all nuts together lifts everything.

    1e-13 relative is rounding.
    """
    mass, _, gravity = robot.equation_of_motion(*states(4))
    assert_allclose(gravity, robot.parameters.gravity * mass @ ONES, rtol=1e-13)


def test_gravity_is_the_slope_of_the_potential_energy(robot: psp3.PSP3) -> None:
    """dV/da by differences, below 1e-10 relative; the bar for derivatives is 1e-7."""
    heights, _ = states(5, 100)
    for k, unit in enumerate(np.eye(3)):
        slope = derivative(lambda t, unit=unit: robot.potential_energy(heights + t * unit), STEP)
        assert_allclose(robot.gravity(heights)[:, k], slope, rtol=1e-9)


def test_kinetic_energy_is_half_v_m_v(robot: psp3.PSP3) -> None:
    heights, speeds = states(6)
    expected = 0.5 * np.einsum("ni,nij,nj->n", speeds, robot.mass_matrix(heights), speeds)
    assert_allclose(robot.kinetic_energy(heights, speeds), expected, rtol=1e-13)


def test_common_motion_has_no_coriolis_forces(robot: psp3.PSP3) -> None:
    """C 1 = 0; 1e-13 of C's largest entry."""
    _, coriolis, _ = robot.equation_of_motion(*states(7))
    assert (
        np.abs(coriolis @ ONES).max(axis=-1) < 1e-13 * np.abs(coriolis).max(axis=(-1, -2))
    ).all()


def test_rate_of_the_mass_matrix_minus_twice_c_is_skew(robot: psp3.PSP3) -> None:
    """With dM/dt by differences along the motion; 1e-8 of dM/dt.

    So x'(dM/dt - 2C)x = 0 for every x.
    """
    heights, speeds = states(8, 100)
    rate = derivative(lambda t: robot.mass_matrix(heights + t * speeds), 2e-3)
    difference = rate - 2.0 * robot.coriolis_matrix(heights, speeds)
    assert (
        np.abs(difference + difference.swapaxes(-1, -2)).max(axis=(1, 2))
        < 1e-8 * np.abs(rate).max(axis=(1, 2))
    ).all()


def test_coriolis_matrix_is_that_of_the_christoffel_symbols(robot: psp3.PSP3) -> None:
    """All 27 symbols by differences of M; 1e-7 of C's largest entry."""
    heights, speeds = states(9, 100)
    slopes = np.stack(
        [
            derivative(lambda t, u=unit: robot.mass_matrix(heights + t * u), STEP)
            for unit in np.eye(3)
        ],
        axis=-1,
    )
    symbols = 0.5 * (slopes + slopes.swapaxes(-1, -2) - np.moveaxis(slopes, -1, 1))
    assert (
        relative_error(
            robot.coriolis_matrix(heights, speeds), np.einsum("nijk,nk->nij", symbols, speeds)
        )
        < 1e-7
    )


def test_coriolis_matrix_of_the_complement_is_that_of_the_christoffel_symbols(
    robot: psp3.PSP3,
) -> None:
    """T'M(dT/dt) + T'Omega M T against the polarized quadratic form of the Pinocchio path.

    1e-12 relative.

    On other robots the two differ by a matrix that does no work and gives no force.
    """
    heights, speeds = states(10, 60)
    noc = robot.dynamics("noc").equation_of_motion(heights, speeds)[1]
    assert (
        relative_error(noc, robot.dynamics("pinocchio").equation_of_motion(heights, speeds)[1])
        < 1e-12
    )


def test_column_sums_of_c_are_the_rate_of_the_column_sums_of_m(robot: psp3.PSP3) -> None:
    """1'C = d/dt(1'M): total momentum changes by gravity and screw forces only.

    1e-8 relative, by differences.
    """
    heights, speeds = states(11, 100)
    rate = derivative(lambda t: ONES @ robot.mass_matrix(heights + t * speeds), 2e-3)
    assert relative_error(ONES @ robot.coriolis_matrix(heights, speeds), rate) < 1e-8


def test_coriolis_matrix_is_linear_in_the_speeds(robot: psp3.PSP3) -> None:
    heights, speeds = states(12)
    other = np.random.default_rng(13).normal(size=speeds.shape)
    found = robot.coriolis_matrix(heights, 2.0 * speeds - 3.0 * other)
    expected = 2.0 * robot.coriolis_matrix(heights, speeds) - 3.0 * robot.coriolis_matrix(
        heights, other
    )
    assert relative_error(found, expected) < 1e-11


# Symmetry of the machine


ORDERS = {
    "shift by 120 degrees": [1, 2, 0],
    "shift by 240 degrees": [2, 0, 1],
    "swap of 2 and 3": [0, 2, 1],
    "swap of 1 and 2": [1, 0, 2],
}


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS.keys())
@pytest.mark.parametrize("parameters", ["default", "table_3_1"])
def test_renaming_the_arms_renames_the_answers(parameters: str, order: list[int]) -> None:
    """M, C, G and accelerations of the turned or mirrored machine; 1e-12 relative."""
    robot = psp3.load("psp3", parameters)
    heights, speeds = states(14)
    mass, coriolis, gravity = robot.equation_of_motion(heights, speeds)
    turned_mass, turned_coriolis, turned_gravity = robot.equation_of_motion(
        heights[:, order], speeds[:, order]
    )
    assert relative_error(turned_mass, mass[:, order][:, :, order]) < 1e-12
    assert relative_error(turned_coriolis, coriolis[:, order][:, :, order]) < 1e-12
    assert relative_error(turned_gravity, gravity[:, order]) < 1e-12


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS.keys())
def test_the_star_of_table_5_1_breaks_the_symmetry(order: list[int]) -> None:
    """Its large moment lies in its plane.

    M changes by more than a percent when the arms are renamed.

    Swapping arms 2 and 3 mirrors the star in the plane of arm 1, which is a symmetry of that
    inertia, too.
    """
    robot = psp3.load("psp3", "table_5_1")
    heights, _ = states(15)
    mass, turned = robot.mass_matrix(heights), robot.mass_matrix(heights[:, order])
    error = relative_error(turned, mass[:, order][:, :, order])
    if order == [0, 2, 1]:
        assert error < 1e-12
    else:
        assert error > 1e-2


def test_pose_turns_and_mirrors_with_the_arms(default: psp3.PSP3) -> None:
    """Shifting the nut heights by one screw turns tip and axis by 120 degrees.

    Swapping 2 and 3 mirrors them in y. 1e-15 m.
    """
    heights = random_heights(np.random.default_rng(16), 300)
    pose = default.forward_kinematics(heights)
    c, s = -0.5, np.sqrt(0.75)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    shifted = default.forward_kinematics(np.roll(heights, 1, axis=1))
    assert_allclose(shifted.tip, pose.tip @ turn.T, rtol=0, atol=1e-15)
    assert_allclose(shifted.rotation, turn @ pose.rotation @ turn.T, rtol=0, atol=1e-15)
    mirrored = default.forward_kinematics(heights[:, [0, 2, 1]])
    assert_allclose(mirrored.tip, pose.tip * [1.0, -1.0, 1.0], rtol=0, atol=1e-15)
    assert_allclose(mirrored.arms, pose.arms[:, [0, 2, 1]], rtol=0, atol=1e-15)


# Energy and momentum


def relative_kinetic_energy(robot: psp3.PSP3, heights: Array, speeds: Array) -> Array:
    """Kinetic energy without that of the common motion which carries the momentum 1'M v."""
    momentum = np.einsum("...ij,...j->...i", robot.mass_matrix(heights), speeds).sum(axis=-1)
    common = momentum / robot.parameters.total_mass
    return robot.kinetic_energy(heights, speeds - common[..., np.newaxis])


START_HEIGHTS = np.array(
    [[0.0, 0.0, 0.0], [0.05, -0.05, 0.02], [-0.1, 0.05, 0.08], [0.02, 0.1, -0.03]]
)
START_SPEEDS = np.array(
    [[0.1, -0.1, 0.05], [-0.08, 0.1, -0.02], [0.09, -0.05, -0.06], [0.1, 0.02, -0.1]]
)
"""Four starts with relative speeds of 0.1 m/s and less, slow enough to stay among the poses of the
machine for 2 s.
"""


def test_energy_drift_over_two_seconds_with_the_weight_carried(robot: psp3.PSP3) -> None:
    """With tau = G and RK4 at 1 ms the kinetic energy drifts little.

    That of the relative motion, by less than 1e-9 of its initial value.

    The kernel holds forces constant over a step, while G changes with the pose. G enters the
    equation of motion as tau does, so carrying the weight at every instant is the same as switching
    gravity off: that is what the kernel is given.
    """
    weightless = robot.parameters.as_array()
    weightless[closed_form.GRAVITY] = 0.0
    scratch, forces = np.empty(6), np.zeros(3)
    for heights, speeds in zip(START_HEIGHTS, START_SPEEDS, strict=True):
        start = relative_kinetic_energy(robot, heights, speeds)
        state = np.concatenate([heights, speeds])
        for _ in range(20):
            for _ in range(100):
                stepping.runge_kutta_step(state, forces, 1e-3, weightless, scratch)
            assert abs(relative_kinetic_energy(robot, state[:3], state[3:]) - start) < 1e-9 * start
        # The motion is no straight line: without C the speeds would stay.
        assert np.abs(state[3:] - speeds).max() > 1e-3


def test_an_independent_integrator_keeps_energy_and_momentum_with_gravity_on(
    robot: psp3.PSP3,
) -> None:
    """DOP853 at rtol 1e-12 with the model's own tau = G(a).

    Energy to 1e-9 of the relative motion's, momentum to 1e-11.
    """

    def rate(_: float, y: Array) -> Array:
        return np.concatenate([y[3:], robot.forward_dynamics(y[:3], y[3:], robot.gravity(y[:3]))])

    for heights, speeds in zip(START_HEIGHTS[:2], START_SPEEDS[:2], strict=True):
        path = solve_ivp(
            rate,
            (0.0, 2.0),
            np.concatenate([heights, speeds]),
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
        ).y.T
        energy = relative_kinetic_energy(robot, path[:, :3], path[:, 3:])
        assert np.abs(energy - energy[0]).max() < 1e-9 * energy[0]
        momentum = np.einsum("nij,nj->ni", robot.mass_matrix(path[:, :3]), path[:, 3:]).sum(axis=-1)
        assert_allclose(momentum, momentum[0], rtol=0, atol=1e-11 * robot.parameters.total_mass)


def test_free_motion_is_weightless_motion_that_falls(robot: psp3.PSP3) -> None:
    """Without forces all nuts fall by g t²/2 on top of the motion without gravity.

    RK4 keeps that, to rounding of 1e-12.
    """
    p = robot.parameters.as_array()
    weightless = p.copy()
    weightless[closed_form.GRAVITY] = 0.0
    falling = np.concatenate([START_HEIGHTS[1], START_SPEEDS[1]])
    floating, scratch, forces = falling.copy(), np.empty(6), np.zeros(3)
    for _ in range(500):
        stepping.runge_kutta_step(falling, forces, 1e-3, p, scratch)
        stepping.runge_kutta_step(floating, forces, 1e-3, weightless, scratch)
    g = robot.parameters.gravity
    assert_allclose(falling[:3] - floating[:3], -0.5 * g * 0.5**2, rtol=0, atol=1e-12)
    assert_allclose(falling[3:] - floating[3:], -0.5 * g, rtol=0, atol=1e-12)
    assert np.abs(floating[3:] - START_SPEEDS[1]).max() > 1e-3


def test_total_energy_of_free_motion_is_kept(robot: psp3.PSP3) -> None:
    """T + V over 0.3 s of free fall, DOP853 at rtol 1e-12.

    1e-9 of the energy that is turned over.
    """

    def rate(_: float, y: Array) -> Array:
        return np.concatenate([y[3:], robot.forward_dynamics(y[:3], y[3:], np.zeros(3))])

    start = np.concatenate([START_HEIGHTS[2], START_SPEEDS[2]])
    path = solve_ivp(rate, (0.0, 0.3), start, method="DOP853", rtol=1e-12, atol=1e-13).y.T
    kinetic, potential = (
        robot.kinetic_energy(path[:, :3], path[:, 3:]),
        robot.potential_energy(path[:, :3]),
    )
    turned_over = np.ptp(potential)
    assert turned_over > 10.0
    assert np.abs(kinetic + potential - kinetic[0] - potential[0]).max() < 1e-9 * turned_over


# Geometry


def test_torsion_is_exactly_zero(default: psp3.PSP3) -> None:
    """With the tilt-and-torsion angles R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth).

    The last is 0, to 1e-15 rad.

    For the tree closed by Newton's method the same holds to 1e-11.
    """
    heights = random_heights(np.random.default_rng(17), 500)
    rotation = default.forward_kinematics(heights).rotation
    torsion = np.arctan2(
        rotation[:, 1, 0] - rotation[:, 0, 1], rotation[:, 0, 0] + rotation[:, 1, 1]
    )
    assert np.abs(torsion).max() < 1e-15
    jacobian = default.dynamics("core").frame_jacobian(np.zeros(3), "star1_center")
    assert_allclose(jacobian[5], 0.0, atol=1e-13)


def test_parasitic_motion_is_that_of_the_small_angle_formula(default: psp3.PSP3) -> None:
    """C_x + i C_y = -(d/4) tilt² exp(-2i azimuth), the next term being of fourth order.

    Within tilt² of itself up to 25 degrees.
    """
    tilt, azimuth = np.meshgrid(
        np.radians([0.01, 0.1, 1.0, 5.0, 15.0, 25.0]),
        np.linspace(0.0, 2.0 * np.pi, 25),
        indexing="ij",
    )
    center = default.forward_kinematics(default.inverse_kinematics(0.0, tilt, azimuth)).center
    expected = -0.25 * 0.181 * tilt**2 * np.exp(-2j * azimuth)
    error = np.abs(center[..., 0] + 1j * center[..., 1] - expected)
    # Rounding of the center, 1e-17 m, counts at a hundredth of a degree.
    assert (error <= tilt**2 * np.abs(expected) + 1e-16).all()


def test_parasitic_motion_reaches_11_mm_at_differences_of_150_mm(default: psp3.PSP3) -> None:
    """Largest on the border of |a_i - a_j| <= 0.15 m.

    To half a millimeter, as the statement is rounded.
    """
    s = np.linspace(0.0, 0.15, 61)
    first, second, third = np.meshgrid(s, s, [0.0], indexing="ij")
    heights = np.stack([first, second, third], axis=-1)
    center = default.forward_kinematics(heights).center
    assert_allclose(np.hypot(center[..., 0], center[..., 1]).max(), 0.011, atol=0.0005)


def actuation_matrix(robot: psp3.PSP3, heights: Array) -> tuple[Array, Array]:
    """Star twist (v of the center, omega) to speeds of the arms.

    Across themselves at the nuts, and the nuts' share of those.

    Row pairs per leg: along the star's axis and along the tangent of its plane; along the arm the
    slider gives way.
    """
    pose = robot.forward_kinematics(heights)
    rows, shares = [], []
    for k, alpha in enumerate(SCREW_AZIMUTHS):
        arm = pose.rotation @ [np.cos(alpha), np.sin(alpha), 0.0]
        axis = pose.rotation[:, 2]
        for direction in (axis, np.cross(axis, arm)):
            rows.append(np.concatenate([direction, np.cross(pose.arms[k] * arm, direction)]))
            shares.append(direction[2] * np.eye(3)[k])
    return np.array(rows), np.array(shares)


def test_no_actuation_singularity(default: psp3.PSP3) -> None:
    """The 6x6 determinant is sqrt(3) s A > 0.

    Here s is the sum of the arms and A the area of the nut triangle; 1e-12 relative.

    Solving it gives the star's twist, so that it is the right matrix: the tip's Jacobian comes out,
    to 1e-12.
    """
    for heights in random_heights(np.random.default_rng(18), 100):
        matrix, shares = actuation_matrix(default, heights)
        nuts = np.stack(
            np.broadcast_arrays(
                0.181 * np.cos(SCREW_AZIMUTHS), 0.181 * np.sin(SCREW_AZIMUTHS), heights
            ),
            axis=-1,
        )
        area = 0.5 * np.linalg.norm(np.cross(nuts[1] - nuts[0], nuts[2] - nuts[0]))
        pose = default.forward_kinematics(heights)
        determinant = np.linalg.det(matrix)
        assert_allclose(abs(determinant), np.sqrt(3.0) * pose.arms.sum() * area, rtol=1e-12)
        twist = np.linalg.solve(matrix, shares)
        tip = twist[:3] + np.cross(twist[3:].T, pose.tip - pose.center).T
        assert_allclose(tip, default.tip_jacobian(heights), rtol=0, atol=1e-12)


def grid_of_heights(largest_difference: float, points: int = 5) -> Array:
    """Every way in which two nuts stand above the third, on a grid that includes the extremes."""
    s = np.linspace(0.0, largest_difference, points)
    first, second = np.meshgrid(s, s)
    heights = np.stack([first, second, np.zeros_like(first)], axis=-1).reshape(-1, 3)
    return np.concatenate([heights, heights[:, [1, 2, 0]], heights[:, [2, 0, 1]]])


def test_condition_of_the_closures(default: psp3.PSP3) -> None:
    """cond(Phi_u) is 13.7 at home and grows slowly.

    To 16.0 at |a_i - a_j| = 0.15 m and 25.5 at 0.5 m; digits as given.
    """
    noc = psp3.NaturalOrthogonalComplement(default)
    dependent = [
        joint.idx_v
        for name, joint in zip(default.model.names, default.model.joints, strict=True)
        if name[0] not in "ua"
    ]
    assert len(dependent) == 12
    for difference, expected in ((0.0, 13.7), (0.15, 16.0), (0.5, 25.5)):
        found = np.linalg.cond(
            noc.constraint_jacobian(default.configuration(grid_of_heights(difference)))[
                ..., dependent
            ]
        ).max()
        assert_allclose(found, expected, rtol=0, atol=0.05)


def test_condition_of_the_closures_as_printed(default: psp3.PSP3) -> None:
    """Why the relative logarithm replaces the Cayley form of eq. 3.13.

    That one's cond(Phi_u) is 27 at home, 69 at 0.15 m and 1e3 at 0.5 m.

    The twelve printed constraints (3.14), from the printed chains (3.7 to 3.12), differentiated
    numerically; to the digits given.
    """
    names = [f"{joint}{leg}" for leg in (1, 2, 3) for joint in ("a", "phi", "theta", "lambda", "b")]
    index = np.array([default.model.joints[default.model.getJointId(name)].idx_q for name in names])
    passive = [i for i, name in enumerate(names) if name[0] != "a"]

    def constraints(joints: Array) -> Array:
        chains = [
            thesis_chain(leg, joints[5 * leg : 5 * leg + 5], 0.181, 0.070) for leg in range(3)
        ]
        cayley = [
            np.linalg.solve(np.eye(3) + chain[:3, :3], chain[:3, :3] - np.eye(3))
            for chain in chains
        ]
        position = [chains[1][i, 3] - chains[other][i, 3] for i in range(3) for other in (0, 2)]
        rotation = [
            cayley[0][i, j] - cayley[other][i, j]
            for i, j in ((0, 1), (0, 2), (1, 2))
            for other in (1, 2)
        ]
        return np.array(position + rotation)

    def condition(heights: Array) -> float:
        joints = default.configuration(heights)[index]
        columns = [
            derivative(lambda t, u=unit: constraints(joints + t * u), 1e-3)
            for unit in np.eye(15)[passive]
        ]
        return float(np.linalg.cond(np.stack(columns, axis=-1)))

    assert_allclose(condition(np.zeros(3)), 27.2, atol=0.05)
    assert_allclose(max(condition(heights) for heights in grid_of_heights(0.15, 2)), 69.0, atol=0.5)
    assert 900.0 < max(condition(heights) for heights in grid_of_heights(0.5, 2)) < 1100.0


def test_reach_of_the_tip_at_azimuth_0(default: psp3.PSP3) -> None:
    """sqrt(h² + d²/4) - d/2 = 23.9 mm.

    The largest x that tilting toward arm 1 gives on the branch of home, on a fine grid.
    """
    exact = np.sqrt(0.070**2 + 0.181**2 / 4) - 0.181 / 2
    tips = default.forward_kinematics(
        default.inverse_kinematics(0.0, np.linspace(0.0, np.radians(60), 60001), 0.0)
    ).tip
    assert_allclose(tips[:, 0].max(), exact, rtol=0, atol=1e-10)
    assert_allclose(default.tip_reach(0.0), exact, rtol=0, atol=1e-13)
    assert round(1e3 * exact, 1) == 23.9


def test_energy_of_the_relative_motion_is_kept_under_forces_that_carry_the_weight() -> None:
    """RK4 at 1 ms with tau = G(a) at every stage, relative speeds up to 0.1 m/s, 2 s.

    The drift is below 1e-9 of the kinetic energy of the relative motion, the project's bar; RK4's
    own error is 1e-12 here.
    """
    robot = psp3.load("psp3")

    def rates(state: np.ndarray) -> np.ndarray:
        heights, speeds = state[:3], state[3:]
        return np.concatenate(
            [speeds, robot.forward_dynamics(heights, speeds, robot.gravity(heights))]
        )

    state, step = np.array([0.02, -0.03, 0.05, 0.06, -0.04, -0.02]), 1e-3
    start = float(robot.kinetic_energy(state[:3], state[3:]))
    common = state[3:] @ robot.mass_matrix(state[:3]).sum(axis=0) / robot.parameters.total_mass
    relative = start - 0.5 * robot.parameters.total_mass * common**2
    energies = []
    for _ in range(2000):
        k1 = rates(state)
        k2 = rates(state + 0.5 * step * k1)
        k3 = rates(state + 0.5 * step * k2)
        k4 = rates(state + step * k3)
        state = state + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        energies.append(float(robot.kinetic_energy(state[:3], state[3:])))
    assert np.abs(np.array(energies) - start).max() < 1e-9 * relative
    assert np.ptp(state[:3]) > 0.1, "the nuts must have moved apart"

"""Closed form, Pinocchio path and natural orthogonal complement.

Against each other, and against bare Pinocchio.

The closed form shares its parameters with the other two, and nothing else; these share the tree and
Pinocchio's joints, but neither their closures nor their dynamics. The tests at the end use none of
ours but the answer: loops, projection and constraint forces there are Pinocchio's or written out
with numpy.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from tests.helpers import Array, random_heights, random_states, relative_error

SETS = tuple(psp3.PARAMETER_SETS)

STATES = {"default": 500, "table_3_1": 100, "table_5_1": 100}
"""Random states in which the equation of motion is compared, by the set of parameters."""

BARS = {"M": 1e-13, "C": 6e-12, "G": 1e-13, "forces": 1e-13}
"""Largest differences of any two implementations, relative to the largest entry in that state.

M, G and the forces reach 5e-15; C, which is small where the star hardly tilts, 3e-13. The bars are
some twenty times that.
"""


@pytest.fixture(scope="module")
def robot() -> psp3.PSP3:
    return psp3.load("psp3")


@pytest.fixture(scope="module")
def closures(robot: psp3.PSP3) -> tuple[Array, Array]:
    """1000 random heights, |a_i - a_j| up to 0.3 m, and their configurations.

    Newton's method on the tree's loops finds the configurations.
    """
    heights = random_heights(np.random.default_rng(0), 1000)
    return heights, robot.dynamics("pinocchio").configuration(heights)


def test_configuration_equals_newton_closure_in_pinocchio(
    robot: psp3.PSP3, closures: tuple[Array, Array]
) -> None:
    """1e-11 m and rad: Newton's method stops at a residual of 1e-16 to 1e-13.

    The closures' condition number is at most 300 here.
    """
    heights, expected = closures
    q = robot.configuration(heights)
    assert q.shape == (1000, 15)
    assert_allclose(q, expected, rtol=0, atol=1e-11)


def test_pose_equals_the_frames_of_the_tree_closed_by_newton(
    robot: psp3.PSP3, closures: tuple[Array, Array]
) -> None:
    """Center, rotation, tip and arms from Pinocchio's placements; 1e-11 for the same reason."""
    heights, configurations = closures
    pose = robot.forward_kinematics(heights)
    data = robot.model.createData()
    frames = [robot.model.getFrameId(f"star{leg}_center") for leg in (1, 2, 3)]
    tip, sliders = (
        robot.model.getFrameId("tip"),
        [robot.model.joints[robot.model.getJointId(f"b{leg}")].idx_q for leg in (1, 2, 3)],
    )
    for i, q in enumerate(configurations):
        pin.framesForwardKinematics(robot.model, data, q)
        for frame in frames:
            assert_allclose(pose.center[i], data.oMf[frame].translation, rtol=0, atol=1e-11)
            assert_allclose(pose.rotation[i], data.oMf[frame].rotation, rtol=0, atol=1e-11)
        assert_allclose(pose.tip[i], data.oMf[tip].translation, rtol=0, atol=1e-11)
    assert_allclose(pose.arms, configurations[:, sliders], rtol=0, atol=1e-11)


def test_tip_jacobian_equals_that_of_the_tree(robot: psp3.PSP3) -> None:
    """Pinocchio's frame Jacobian times L; 1e-11 as for the closures."""
    heights = random_heights(np.random.default_rng(6), 100)
    expected = robot.dynamics("pinocchio").frame_jacobian(heights, "tip")
    assert_allclose(robot.tip_jacobian(heights), expected[:, :3], rtol=0, atol=1e-11)


# Dynamics: closed form, Pinocchio path and natural orthogonal complement


@pytest.mark.slow
@pytest.mark.parametrize("parameters", STATES)
def test_three_implementations_agree_on_the_equation_of_motion(parameters: str) -> None:
    """M, C, G and forces of random states, of any two. Each closes the loops itself."""
    robot = psp3.load("psp3", parameters)
    count = STATES[parameters]
    heights, speeds = random_states(rng := np.random.default_rng(7), count)
    accelerations = rng.normal(size=(count, 3))
    found = {}
    for name in ("closed_form", "pinocchio", "noc"):
        M, C, G = robot.dynamics(name).equation_of_motion(heights, speeds)
        forces = np.einsum("nij,nj->ni", M, accelerations) + np.einsum("nij,nj->ni", C, speeds) + G
        found[name] = {"M": M, "C": C, "G": G, "forces": forces}
    own = robot.inverse_dynamics(heights, speeds, accelerations)
    assert relative_error(found["closed_form"]["forces"], own) < BARS["forces"]
    for one, other in itertools.combinations(found, 2):
        for name, bar in BARS.items():
            gap = relative_error(found[one][name], found[other][name])
            assert gap < bar, f"{name} of {one} and {other}"


def test_inverse_dynamics_equals_projected_rnea_and_noc(robot: psp3.PSP3) -> None:
    """Forces asked of each model, not put together here; 1e-9 relative."""
    heights, speeds = random_states(rng := np.random.default_rng(8), 200)
    accelerations = rng.normal(size=(200, 3))
    forces = robot.inverse_dynamics(heights, speeds, accelerations)
    for name in ("pinocchio", "noc"):
        found = robot.dynamics(name).actuator_forces(heights, speeds, accelerations)
        assert relative_error(forces, found) < 1e-9, name


@pytest.mark.parametrize(
    ("parameters", "count"), [("default", 500), ("table_3_1", 50), ("table_5_1", 50)]
)
def test_forward_dynamics_equals_constraint_dynamics(parameters: str, count: int) -> None:
    """Pinocchio's constraintDynamics on the tree with its loops.

    1e-8 relative (its constraint inertia has condition number 1e4).
    """
    robot = psp3.load("psp3", parameters)
    heights, speeds = random_states(rng := np.random.default_rng(9), count)
    forces = rng.normal(scale=100.0, size=(count, 3))
    found = robot.forward_dynamics(heights, speeds, forces)
    assert (
        relative_error(found, robot.dynamics("pinocchio").forward_dynamics(heights, speeds, forces))
        < 1e-8
    )


def test_energies_equal_those_of_the_tree(robot: psp3.PSP3) -> None:
    """Pinocchio's sums over all fifteen bodies; 1e-12 relative."""
    heights, speeds = random_states(np.random.default_rng(11), 100)
    tree = robot.dynamics("pinocchio")
    assert_allclose(
        robot.kinetic_energy(heights, speeds), tree.kinetic_energy(heights, speeds), rtol=1e-12
    )
    assert_allclose(
        robot.potential_energy(heights), tree.potential_energy(heights), rtol=1e-12, atol=1e-12
    )


# Against bare Pinocchio


class BarePinocchio:
    """The tree with its two closures, by Pinocchio and numpy's least squares alone."""

    def __init__(self, model: pin.Model) -> None:
        self.model, self.data = model, model.createData()
        first, *others = (model.frames[model.getFrameId(f"star{leg}_center")] for leg in (1, 2, 3))
        self.constraints, self.constraint_data = (
            pin.StdVec_RigidConstraintModel(),
            pin.StdVec_RigidConstraintData(),
        )
        for other in others:
            self.constraints.append(
                pin.RigidConstraintModel(
                    pin.ContactType.CONTACT_6D,
                    model,
                    first.parentJoint,
                    first.placement,
                    other.parentJoint,
                    other.placement,
                    pin.ReferenceFrame.LOCAL,
                )
            )
            self.constraint_data.append(self.constraints[-1].createData())
        self.frames = [model.getFrameId(f"star{leg}_center") for leg in (1, 2, 3)]
        self.actuated = [model.joints[model.getJointId(f"a{leg}")].idx_v for leg in (1, 2, 3)]
        self.dependent = [i for i in range(model.nv) if i not in self.actuated]

    def difference(self, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Twists between the hub frames in world axes at their own origins.

        Residual of closing, Jacobian, and drift.
        """
        pin.forwardKinematics(self.model, self.data, q, v, np.zeros(self.model.nv))
        pin.computeJointJacobians(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobians = [
            pin.getFrameJacobian(self.model, self.data, frame, axes) for frame in self.frames
        ]
        drifts = [
            pin.getFrameClassicalAcceleration(self.model, self.data, frame, axes).vector
            for frame in self.frames
        ]
        places = [self.data.oMf[frame] for frame in self.frames]
        residuals = [
            np.concatenate(
                [
                    place.translation - places[0].translation,
                    pin.log3(place.rotation @ places[0].rotation.T),
                ]
            )
            for place in places[1:]
        ]
        return (
            np.concatenate(residuals),
            np.concatenate([jacobian - jacobians[0] for jacobian in jacobians[1:]]),
            np.concatenate([drift - drifts[0] for drift in drifts[1:]]),
        )

    def closed(self, heights: Array) -> Array:
        """Newton's method in ten steps from home."""
        q, rest = pin.neutral(self.model), np.zeros(self.model.nv)
        for name in ("b1", "b2", "b3"):
            q[self.model.joints[self.model.getJointId(name)].idx_q] = 0.181
        for share in np.linspace(0.1, 1.0, 10):
            q[self.actuated] = share * heights
            for _ in range(5):
                residual, jacobian, _ = self.difference(q, rest)
                q[self.dependent] -= np.linalg.solve(jacobian[:, self.dependent], residual)
        return q


def test_configuration_equals_newton_from_home_step_by_step(robot: psp3.PSP3) -> None:
    """Both our routes to a configuration against a plain Newton's method; 1e-11 m, rad."""
    bare = BarePinocchio(robot.model)
    heights = random_heights(np.random.default_rng(20), 60)
    expected = np.array([bare.closed(row) for row in heights])
    assert_allclose(robot.configuration(heights), expected, rtol=0, atol=1e-11)
    assert_allclose(
        robot.dynamics("pinocchio").configuration(heights), expected, rtol=0, atol=1e-11
    )


@pytest.mark.parametrize("parameters", SETS)
def test_dynamics_equal_bare_rnea_and_constraint_dynamics(parameters: str) -> None:
    """Velocities and accelerations solved from world-frame closures.

    Forces from RNEA, and the way back by constraintDynamics.

    1e-9 relative for RNEA, 1e-8 for constraintDynamics.
    """
    robot = psp3.load("psp3", parameters)
    bare = BarePinocchio(robot.model)
    model, data = bare.model, bare.data
    heights, speeds = random_states(rng := np.random.default_rng(21), 60)
    accelerations = rng.normal(size=(60, 3))
    forces = robot.inverse_dynamics(heights, speeds, accelerations)
    settings: Any = pin.ProximalSettings(1e-12, 0.0, 1)
    for i, q in enumerate(robot.configuration(heights)):
        rest = np.zeros(model.nv)
        _, jacobian, _ = bare.difference(q, rest)
        v, a = rest.copy(), rest.copy()
        v[bare.actuated], a[bare.actuated] = speeds[i], accelerations[i]
        solve = np.linalg.inv(jacobian[:, bare.dependent])
        v[bare.dependent] = -solve @ jacobian[:, bare.actuated] @ speeds[i]
        _, _, drift = bare.difference(q, v)
        a[bare.dependent] = -solve @ (jacobian[:, bare.actuated] @ accelerations[i] + drift)
        # Forces of the tree's joints that the closures carry do no work: what is left in the screws
        # are the actuator forces.
        carried = pin.rnea(model, data, q, v, a)
        expected = (
            carried[bare.actuated]
            - (solve @ jacobian[:, bare.actuated]).T @ carried[bare.dependent]
        )
        assert_allclose(forces[i], expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        tau = rest.copy()
        tau[bare.actuated] = forces[i]
        pin.initConstraintDynamics(model, data, bare.constraints, bare.constraint_data)
        found = pin.constraintDynamics(
            model, data, q, v, tau, bare.constraints, bare.constraint_data, settings
        )
        assert_allclose(found, a, rtol=0, atol=1e-8 * np.abs(a).max())

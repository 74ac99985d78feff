"""A user's own controllers, trajectories and plants: what is wrong with them is said."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.drives import Drive
from psp3.errors import InvalidArray, InvalidTorque, InvalidValue, SimulationDiverged
from psp3.simulation.arguments import as_object, finite_row
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories import Hold, Motion
from tests.psp3.simulation.controllers import Recording

ROBOT = psp3.load("five_bar")
HOLD = Hold(robot=ROBOT)
ROWS = np.tile(ROBOT.reference, (6, 1))
STILL, TIP = np.zeros((6, 2)), np.zeros((6, 3))


def run(controller: Any = None, trajectory: Any = HOLD, **options: Any) -> psp3.Result:
    """Return the result of five periods."""
    controller = Recording((0.0, 0.0)) if controller is None else controller
    return psp3.simulate(ROBOT, controller, trajectory, 0.01, **options)


class Partial:
    """A controller without ``reset``, and a plant without ``start``."""

    def torque(self, *_: object) -> list[float]:
        """Return no force."""
        return [0.0, 0.0]

    def advance(self, *_: object) -> None:
        """Return nothing."""


class Plant:
    """A plant that always reaches the same."""

    def __init__(self, reached: object) -> None:
        self.reached = reached

    def start(self, *_: object) -> None:
        """Do nothing."""

    def advance(self, *_: object) -> Any:
        """Return what was given."""
        return self.reached


def test_a_method_that_is_missing_is_named() -> None:
    with pytest.raises(InvalidValue, match="controller, with methods torque and reset"):
        run(Partial())
    numbers = Recording()
    numbers.torque = 5.0  # type: ignore[method-assign, assignment]
    with pytest.raises(InvalidValue, match="controller, with methods torque and reset"):
        run(numbers)
    with pytest.raises(InvalidValue, match="plant, with methods start and advance"):
        run(plant=Partial())
    with pytest.raises(InvalidValue, match="progress, with a method __call__"):
        run(progress=3)


@pytest.mark.parametrize("returned", [0, None, "text", (1, 2, 3, 4), ROWS])
def test_a_trajectory_that_returns_no_motion(returned: object) -> None:
    with pytest.raises(InvalidValue, match=r"what the trajectory returns must be a .*Motion"):
        run(trajectory=lambda _: returned)


@pytest.mark.parametrize(
    ("motion", "named"),
    [
        (Motion(ROWS[0], STILL[0], STILL[0], TIP[0]), r"positions .* shape \(6, 2\)"),
        (Motion(ROWS, STILL[:5], STILL, TIP), r"speeds .* shape \(6, 2\)"),
        (Motion(ROWS, STILL, "text", TIP), "accelerations"),  # type: ignore[arg-type]
        (Motion(ROWS, STILL, STILL * np.nan, TIP), "accelerations"),
        (Motion(ROWS, STILL, STILL, TIP[0]), r"tip .* shape \(6, 3\)"),
        (Motion([[1.0], [1.0, 2.0]], STILL, STILL, TIP), "positions"),  # type: ignore[arg-type]
    ],
)
def test_a_motion_of_the_wrong_shape(motion: Motion, named: str) -> None:
    with pytest.raises(InvalidArray, match=named):
        run(trajectory=lambda _: motion)
    with pytest.raises(InvalidArray, match=named):
        psp3.TimeVaryingLinearQuadraticRegulator(
            ROBOT,
            lambda _: motion,  # type: ignore[arg-type]
            0.01,
            np.eye(4),
            np.eye(2),
        )


def test_motions_as_lists_and_of_another_number_of_joints() -> None:
    lists = Motion(*(part.tolist() for part in (ROWS, STILL, STILL, TIP)))
    assert len(run(trajectory=lambda _: lists).t) == 6
    wide = np.zeros((6, 3))
    with pytest.raises(InvalidValue, match="a motion of 2 actuated joints"):
        run(trajectory=lambda _: Motion(wide, wide, wide, TIP))


@pytest.mark.parametrize(
    "force",
    [
        "text",
        None,
        ["1", "2"],
        np.array([1j, 0.0]),
        [[1.0], [1.0, 2.0]],
        [np.zeros((2, 2)), np.zeros((2, 3))],
        [10**400, 1],
        {1: 2},
        0.0,
    ],
)
def test_what_is_no_force_is_refused(force: Any) -> None:
    with pytest.raises(InvalidTorque, match="something else than 2 finite forces") as caught:
        run(Recording(force))
    assert len(str(caught.value)) < 3000
    assert finite_row(force, 2) is None
    assert as_object(force).dtype == object


@pytest.mark.parametrize(
    ("reached", "message"),
    [
        (0, "positions and speeds, or None"),
        ((ROWS[0], STILL[0], 0.0), "positions and speeds, or None"),
        ((ROWS[0], np.zeros(3)), r"speeds from the plant's advance .* \(2,\)"),
        (("a", STILL[0]), "positions from the plant's advance"),
    ],
)
def test_what_is_no_state_of_a_plant(reached: object, message: str) -> None:
    with pytest.raises((InvalidValue, InvalidArray), match=message):
        run(plant=Plant(reached))
    assert len(run(plant=Plant((ROWS[0].tolist(), [0.0, 0.0]))).t) == 6


def test_attributes_of_the_users_own() -> None:
    """A table of numbers is not a compiled table; a report of the wrong shape is refused."""
    controller: Any = Recording((0.0, 0.0))
    controller.table, controller.numbers_said = np.zeros(3), "two"
    assert len(run(controller).t) == 6
    controller.torque_interval = np.zeros((3, 2))
    with pytest.raises(InvalidValue, match=r"controller.torque_interval must be of shape \(2, 2\)"):
        run(controller)


@pytest.mark.parametrize("controller", [Recording((0.1, 0.1)), psp3.PD(10.0, 1.0)])
def test_a_robot_without_mass_is_named_as_such(controller: Any) -> None:
    """In both loops; not its poses are the reason, but that nothing has inertia."""
    model = ROBOT.model.copy()
    for joint in range(model.njoints):
        model.inertias[joint] = pin.Inertia.Zero()
    robot = psp3.ClosedLoopRobot(model, ROBOT.constraint_models, ROBOT.actuated, ROBOT.q0)
    hold = Hold(robot=robot)
    with pytest.raises(SimulationDiverged, match="every motion some mass or inertia") as caught:
        psp3.simulate(robot, controller, hold, 0.1)
    assert caught.value.time == 0.0
    assert len(caught.value.result.t) == 1
    # The motors' own inertia is enough.
    plant = RungeKutta(robot, drive=Drive(motor_inertia=0.1, lead=2.0 * np.pi))
    assert len(psp3.simulate(robot, controller, hold, 0.01, plant=plant).t) == 6

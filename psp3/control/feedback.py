"""Check whether a controller's forces are motor forces or act along the coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np

from psp3.control.controller import Controller
from psp3.errors import InvalidValue


def check_feedback(robot: Any, controller: Controller) -> None:
    """Refuse forces along coordinates if the motor forces differ from them.

    Motors that are the first coordinates need no conversion: they exert no force along the others.

    Raises
    ------
    InvalidValue
        If the controller does not know the robot's motors, and they are not coordinates.
    """
    if not getattr(controller, "along_coordinates", False) or robot.drives_coordinates:
        return
    actuation = robot.actuation_matrix(robot.reference)
    if actuation.shape[1] != robot.commanded or (actuation != np.eye(*actuation.shape)).any():
        raise InvalidValue(
            "controller",
            type(controller).__name__,
            "one that knows the robot, whose motors are not the first of its coordinates: give it "
            "model=robot",
        )

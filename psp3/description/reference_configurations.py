"""Reference configurations of a model: poses that have a name."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.checks import Array


def set_reference_configuration(model: pin.Model, name: str, pose: Array) -> None:
    """Set a pose in the model's ``referenceConfigurations``.

    Parameters
    ----------
    model : pinocchio.Model
        The model, changed in place.
    name : str
        Name of the pose.
    pose : (nq,) ndarray
        The configuration.
    """
    poses: Any = model.referenceConfigurations
    # Pinocchio never frees an array that is assigned, but copies into one that is there.
    poses[name] = _zeros(model.nq)
    poses[name][:] = pose


@functools.cache
def _zeros(count: int) -> Array:
    return np.zeros(count)

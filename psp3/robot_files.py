"""Robot description files: a tree from a URDF, reference poses from an SRDF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.arrays import Array
from psp3.errors import InvalidRobotFile


def read_tree(urdf: str | Path) -> tuple[pin.Model, Any]:
    """Return the Pinocchio model and the visual model of a URDF.

    Raises
    ------
    InvalidRobotFile
        If the file is missing or Pinocchio cannot read it.
    """
    path = Path(urdf)
    if not path.is_file():
        raise InvalidRobotFile(path, "no such file")
    try:
        model = pin.buildModelFromUrdf(str(path))
        visual_model = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.VISUAL, package_dirs=[str(path.parent)])
    except (ValueError, RuntimeError) as error:
        raise InvalidRobotFile(path, f"Pinocchio cannot read it: {error}") from error
    return model, visual_model


def reference_poses(model: pin.Model, srdf: str | Path) -> dict[str, Array]:
    """Return the reference poses of an SRDF by name.

    Raises
    ------
    InvalidRobotFile
        If the file is missing or Pinocchio cannot read it.
    """
    path = Path(srdf)
    if not path.is_file():
        raise InvalidRobotFile(path, "no such file")
    try:
        pin.loadReferenceConfigurations(model, str(path), False)
    except (ValueError, RuntimeError) as error:
        raise InvalidRobotFile(path, f"Pinocchio cannot read it: {error}") from error
    return {item.key(): np.array(item.data()) for item in model.referenceConfigurations}

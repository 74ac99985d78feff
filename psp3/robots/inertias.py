"""Find inertias of bodies that are physically impossible.

Each moment of a body is a sum of squares of two coordinates, so none is negative and none exceeds
the sum of the other two. Readers refuse files with negative masses or moments. This module checks a
model that is built in memory; negative moments there only cause a warning.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.errors import InvalidValue

IMPOSSIBLE = 1e-9
"""A principal moment may exceed the sum of the other two by this share of the largest one, because
of floating-point rounding: the moments of a flat body are exactly at the border.
"""

ROUNDED = 2e-3
"""An impossible inertia below this share may be a rounded one."""


def check_model(model: pin.Model) -> None:
    """Raise :class:`InvalidValue` if a model contains impossible numbers.

    These are numbers that are not finite, and negative masses. Negative moments only cause a
    warning, because identified parameters and differences of robots may have them and still give
    correct forces.
    """
    for name, inertia in zip(model.names, model.inertias, strict=True):
        numbers = inertia.toDynamicParameters()
        if not np.isfinite(numbers).all() or not np.isfinite(inertia.lever).all():
            wrong, wanted = numbers.tolist(), "finite mass, moments and inertia"
        elif inertia.mass < 0.0:
            wrong, wanted = inertia.mass, "a mass that is not negative"
        else:
            continue
        raise InvalidValue(f"model.inertias of joint {str(name)!r}", wrong, wanted)
    _check_numbers(model)


def _check_numbers(model: pin.Model) -> None:
    """Raise :class:`InvalidValue` if a number in the equations is not valid."""
    numbers: dict[str, Array] = {
        "jointPlacements": np.array([place.homogeneous for place in model.jointPlacements]),
        "gravity": np.asarray(model.gravity.vector),
        "armature": np.asarray(model.armature),
        "damping": np.asarray(model.damping),
        "upperDryFrictionLimit": np.asarray(model.upperDryFrictionLimit),
    }
    for name, array in numbers.items():
        if not np.isfinite(array).all():
            raise InvalidValue(f"model.{name}", array, "finite")
    for name in ("armature", "upperDryFrictionLimit"):
        if (numbers[name] < 0.0).any():
            raise InvalidValue(f"model.{name}", numbers[name], "not negative")
    for name in ("lowerPositionLimit", "upperPositionLimit"):
        if np.isnan(getattr(model, name)).any():
            raise InvalidValue(f"model.{name}", getattr(model, name), "numbers")


def impossible(inertia: pin.Inertia) -> str:
    """Return a description of what is wrong with an inertia; empty if a body can have it."""
    moments = np.linalg.eigvalsh(inertia.inertia)
    if inertia.mass < 0.0 or moments[0] < -ROUNDED * abs(moments[2]):
        return f"mass {inertia.mass:.6g} kg, principal moments {moments} kg m²"
    if inertia.mass == 0.0 and moments[2] > 0.0:
        return f"no mass, but moments of inertia up to {moments[2]:.6g} kg m²"
    excess = moments[2] - moments[1] - moments[0]
    if excess <= IMPOSSIBLE * moments[2]:
        return ""
    share = f"{100.0 * excess / moments[2]:.2g} %"
    rounded = " (rounding may have done it)" if excess < ROUNDED * moments[2] else ""
    return (
        f"its largest principal moment, {moments[2]:.6g} kg m², exceeds the sum of the other two "
        f"by {share}{rounded}"
    )


def turning(model: pin.Model) -> list[bool]:
    """Return which bodies can rotate, joint by joint; the moments of the others do not matter."""
    data, local = model.createData(), pin.ReferenceFrame.LOCAL
    pin.computeJointJacobians(model, data, pin.neutral(model))
    return [
        # For a model with a single degree of freedom Pinocchio returns a vector.
        bool(np.any(pin.getJointJacobian(model, data, index, local).reshape(6, model.nv)[3:]))
        for index in range(model.njoints)
    ]


def warning_of_inertias(model: pin.Model) -> str:
    """Return the warning about rotating bodies with an impossible inertia; empty if none.

    Violations that rounding can explain are not reported.
    """
    wrong = []
    for name, inertia, turns in zip(model.names, model.inertias, turning(model), strict=True):
        moments = np.linalg.eigvalsh(inertia.inertia)
        rounded = moments[2] - moments[1] - moments[0] <= ROUNDED * moments[2]
        if turns and impossible(inertia) and (inertia.mass == 0.0 or not rounded):
            wrong.append(f"joint {str(name)!r} ({impossible(inertia)})")
    if not wrong:
        return ""
    more = f", and {len(wrong) - 3} others" if len(wrong) > 3 else ""
    return (
        f"{model.name}: no rigid body has the inertia of what is carried by "
        f"{'; '.join(wrong[:3])}{more}: take mass, center and moments from one source"
    )

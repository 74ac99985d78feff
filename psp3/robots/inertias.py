"""Inertias of bodies: which ones are physically impossible.

The moments of a body are sums of squares of two coordinates each, so that none is negative and none
exceeds the sum of the other two. Readers refuse files whose masses or moments are negative; a model
that is built in memory is looked at here, and only told of where its moments are.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.errors import InvalidValue

IMPOSSIBLE = 1e-9
"""So far, as a share of the largest, a principal moment may exceed the sum of the other two by the
rounding of the computer: those of a flat body are at the very border.
"""

ROUNDED = 2e-3
"""Below this share an impossible inertia may be one that was rounded."""


def check_model(model: pin.Model) -> None:
    """Raise :class:`InvalidValue` if a model holds what no robot is made of.

    That is a number that is not finite, or a negative mass. Of negative moments a warning tells:
    identified parameters, and differences of robots, may have them and forces that are right.
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
    """Raise :class:`InvalidValue` if a number that enters equations is none."""
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
    """Return what is wrong with an inertia in words; nothing if a body can have it."""
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
    """Return which bodies can turn, joint by joint; the moments of the others do not matter."""
    data, local = model.createData(), pin.ReferenceFrame.LOCAL
    pin.computeJointJacobians(model, data, pin.neutral(model))
    return [
        # Of a model with a single degree of freedom Pinocchio returns a vector.
        bool(np.any(pin.getJointJacobian(model, data, index, local).reshape(6, model.nv)[3:]))
        for index in range(model.njoints)
    ]


def warning_of_inertias(model: pin.Model) -> str:
    """Return what is told of bodies that turn with an inertia that none has; nothing of others.

    What rounding may have done is not told.
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

"""The numbers of Table 3.1 as unknowns of an identification."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from psp3.checks import Array
from psp3.errors import InvalidValue
from psp3.identification.unknowns import Unknowns
from psp3.three_psp.model import set_parameters
from psp3.three_psp.parameters import Parameters
from psp3.three_psp.robot import PSP3


def numbers_of_table_3_1(robot: PSP3) -> Unknowns:
    """Return the masses and moments of inertia of the thesis's Table 3.1 as unknowns.

    See :class:`psp3.Parameters`.

    The products of inertia and the offsets that the table lacks are zero, and the three legs are
    equal.

    Raises
    ------
    InvalidValue
        If the robot is not a 3-PSP.
    """
    if not isinstance(robot, PSP3):
        raise InvalidValue(
            "robot",
            robot,
            "a 3-PSP: Table 3.1 is about that robot; use all_parameters or equal_bodies",
        )
    known = ("screw_radius", "tool_length", "gravity")
    names, believed, columns = [], [], []
    for field in fields(Parameters):
        if field.name in known:
            continue
        value = np.atleast_1d(getattr(robot.parameters, field.name))
        for k in range(len(value)):
            # The standard parameters are linear in each number, so a finite difference of any step
            # is the exact derivative.
            raised = value.copy()
            raised[k] += 1.0
            change: dict[str, Any] = {
                field.name: tuple(raised) if len(value) == 3 else float(raised[0])
            }
            columns.append(_standard(robot, replace(robot.parameters, **change)))
            names.append(field.name if len(value) == 1 else f"{field.name}_{'xyz'[k]}")
            believed.append(float(value[k]))
    expansion = np.stack(columns, axis=1) - _standard(robot, robot.parameters)[:, np.newaxis]
    return Unknowns(robot, tuple(names), expansion, np.array(believed), np.zeros(len(expansion)))


def _standard(robot: PSP3, parameters: Parameters) -> Array:
    model = robot.model.copy()
    set_parameters(model, parameters)
    return np.concatenate([inertia.toDynamicParameters() for inertia in list(model.inertias)[1:]])

"""The 3-PSP in closed form as C99 code, with the same results as in Python to the last bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known
from psp3.export import closed_form_kernels as kernels
from psp3.export import robot_text
from psp3.three_psp.closed_form import MOST_TIP_ITERATIONS, MOST_TIP_STEPS
from psp3.three_psp.stepping import ClosedForm
from psp3.version import __version__

LEG = ("a", "phi", "theta", "lambda", "b")
"""Joints of each leg, in the order of the closed form."""

CODE = "0; or 1 if there is no such pose or a number is not finite, and the results are then NaN"

OVER_LEGS = ("configuration", "tip_jacobian")
"""Kernels with loops over the entries of tuples."""

SINGLE = {"TIP_ROUNDING": 6e-8, "SMALLEST_TIP_STEP": 1e-5}
"""Constants of the closed form's module in single precision, chosen for its rounding errors."""


def code_of(
    robot: Any,
    table: ClosedForm,
    precision: str,
    name: str,
    frames: Sequence[str] | None,
    functions: Sequence[str] | None,
) -> CCode:
    """Return the C code of the 3-PSP in closed form.

    Raises
    ------
    NotExportable
        If ``frames`` names another frame than ``tip``, the only one of the closed form.
    """
    unknown = [frame for frame in frames or () if frame != "tip"]
    if unknown:
        raise NotExportable(
            f"frame {unknown[0]!r} of the closed form",
            "it has only the star's pose and its tip",
            'robot.dynamics("core"), which has all frames',
        )
    model = robot.model
    order = [
        model.joints[model.getJointId(f"{joint}{leg}")].idx_q for leg in (1, 2, 3) for joint in LEG
    ]
    joints = [str(joint) for joint in list(model.names)[1:]]
    about = [
        f"{robot.title}: kinematics and dynamics in closed form, written by psp3 {__version__}.",
        "SI units: m, rad, s, kg, N. Matrices stand row by row, in base axes. No call has loops\n"
        "but those that are counted; tip_heights is the only one that iterates: no call takes\n"
        f"more than {MOST_TIP_STEPS * MOST_TIP_ITERATIONS} steps of Newton's method.",
        robot_text.numbered("Heights of the nuts, and forces along the screws", robot.coordinates),
        robot_text.numbered("Coordinates of all joints, q", joints),
    ]
    constants = SINGLE if precision == "single" else None
    writer = CWriter(name, precision, about, OVER_LEGS, constants)
    known = Known("robot", kernels.ThreePSP(table.parameters, np.array(order)))
    every = {called: rest for called, *rest in _functions()}
    for called in robot_text.chosen(functions, list(every)):
        does, kernel, arguments = every[called]
        writer.add(called, does, kernel, [known, *arguments], CODE)
    return writer.code()


def _functions() -> list[tuple[str, str, Any, list[Argument]]]:
    """Return the name, description, kernel and arguments of each function."""
    heights = Argument("heights", "nut heights [m]", 3)
    speeds = Argument("speeds", "their speeds [m/s]", 3)
    M = Argument("M", "mass matrix, row by row (3, 3) [kg]", 9, "out")
    accelerations, forces = "accelerations of the nuts [m/s²]", "forces along the screws [N]"
    return [
        (
            "forward_kinematics",
            "Write the pose of the star in base axes.",
            kernels.forward_kinematics,
            [
                heights,
                Argument("center", "point where its arms meet [m]", 3, "out"),
                Argument(
                    "rotation", "rotation from star axes to base axes, row by row (3, 3)", 9, "out"
                ),
                Argument("arms", "arm lengths [m]", 3, "out"),
                Argument("tip", "tip of the tool [m]", 3, "out"),
            ],
        ),
        (
            "configuration",
            "Write the coordinates of all joints with closed loops.",
            kernels.configuration,
            [heights, Argument("q", "coordinates of all joints, in the order above", 15, "out")],
        ),
        (
            "tip_heights",
            "Write the heights that put the tip at a point, on the branch of the home pose.",
            kernels.tip_heights,
            [
                Argument("tip", "the point in base axes [m]", 3),
                Argument("heights", "nut heights [m]", 3, "out"),
            ],
        ),
        (
            "tip_jacobian",
            "Write the Jacobian of the tip.",
            kernels.jacobian,
            [heights, Argument("J", "tip velocity per nut speed, row by row (3, 3)", 9, "out")],
        ),
        (
            "inverse_dynamics",
            "Write the screw forces for a motion.",
            kernels.inverse_dynamics,
            [
                heights,
                speeds,
                Argument("accelerations", accelerations, 3),
                Argument("forces", forces, 3, "out"),
            ],
        ),
        (
            "forward_dynamics",
            "Write the accelerations under screw forces.",
            kernels.forward_dynamics,
            [
                heights,
                speeds,
                Argument("forces", forces, 3),
                Argument("accelerations", accelerations, 3, "out"),
            ],
        ),
        (
            "equation_of_motion",
            "Write M, C and G of M a + C v + G = forces.",
            kernels.equation_of_motion,
            [
                heights,
                speeds,
                M,
                Argument("C", "Coriolis matrix, row by row (3, 3) [kg/s]", 9, "out"),
                Argument("G", "gravity, the weight that each screw carries [N]", 3, "out"),
            ],
        ),
        ("mass_matrix", "Write the mass matrix M.", kernels.mass, [heights, M]),
    ]

"""The learned computed-torque controller as a function of CasADi's symbols."""

from __future__ import annotations

from typing import Any

from psp3.checks import (
    checked_kind,
)
from psp3.errors import InvalidValue
from psp3.fuzzy_control import kernels
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.symbolic.interpreter import Interpreter
from psp3.symbolic.memory import piece_of, piece_with, symbols_in
from psp3.symbolic.numbers import SX, casadi
from psp3.symbolic.robot import vector


def fuzzy_torque(controller: FuzzyComputedTorque) -> Any:
    """Return the torque of a learned controller, of any kind, with all that it chooses between.

    Type reduction searches for switch points, and what it finds is a choice among the ends of the
    rules. So the torque is continuous, and its derivatives jump where a switch point goes to
    another rule, and at the ends of the trained ranges.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        A trained one. Its rules and gains are taken as they are now.

    Returns
    -------
    casadi.Function
        Of ``positions``, ``speeds``, ``desired_positions``, ``desired_speeds`` and
        ``desired_accelerations`` (n,), to ``forces`` (n,) of the motors [N or N m].

    Raises
    ------
    InvalidValue
        If the exact dynamics take over outside of the trained range.
    NotTrained
        If nothing was learned yet.
    MissingPackage
        If CasADi is not installed: ``pip install 'psp3[symbolic]'``.
    """
    wanted = "a FuzzyComputedTorque"
    checked_kind("controller", controller, FuzzyComputedTorque, wanted)
    table = controller.controller
    if controller.outside != "clamp":
        wanted = "'clamp': the exact dynamics, which close the loops by iteration, cannot take over"
        raise InvalidValue("outside", controller.outside, wanted)
    n = controller.joints
    inputs = {name: SX.sym(name, n) for name in INPUTS}
    arrays: Any = (piece_of(array) for array in table[5:])
    known = kernels.Fuzzy(*table[:5], *arrays)
    positions, speeds, *wanted_motion = (symbols_in(one) for one in inputs.values())
    desired = piece_with([entry for part in wanted_motion for entry in part.cells])
    out = piece_with([float("nan")] * kernels.step_width(n))
    Interpreter().call(
        kernels.fuzzy_torque, known, kernels.NO_MODEL, positions, speeds, desired, NOTHING, out
    )
    forces = vector(out.cells[:n])
    return casadi.Function("fuzzy_torque", [*inputs.values()], [forces], [*inputs], ["forces"])


INPUTS = (
    "positions",
    "speeds",
    "desired_positions",
    "desired_speeds",
    "desired_accelerations",
)
"""What the torque is a function of."""

NOTHING = piece_with([])
"""What is added to the estimates."""

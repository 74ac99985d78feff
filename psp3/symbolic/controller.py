"""The learned computed-torque controller as a function of CasADi symbols."""

from __future__ import annotations

from typing import Any

from psp3.checks import checked_kind
from psp3.fuzzy_control import kernels
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.symbolic.interpreter import Interpreter
from psp3.symbolic.memory import piece_of, piece_with, symbols_in
from psp3.symbolic.numbers import SX, casadi
from psp3.symbolic.robot import SymbolicRobot, vector
from psp3.three_psp.stepping import ClosedForm


def fuzzy_torque(controller: FuzzyComputedTorque) -> Any:
    """Return the torque of a learned controller of any kind, with all of its branches.

    Type reduction searches for switch points, and each switch point selects one end of each rule.
    So the torque is continuous, but its derivatives jump when a switch point moves to another rule,
    and at the ends of the trained ranges. If the exact dynamics take over outside these ranges
    (``outside="crisp"``), the torque itself jumps there.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        A trained controller. The function uses its present rules and gains, and the present numbers
        of the robot whose exact dynamics take over.

    Returns
    -------
    casadi.Function
        A function of ``positions``, ``speeds``, ``desired_positions``, ``desired_speeds`` and
        ``desired_accelerations`` (n,), to ``forces`` (n,) of the motors [N or N m]. If exact
        dynamics take over that are not in closed form, it is also a function of ``q`` (nq,), the
        configuration of the robot at the positions, which closes its loops.

    Raises
    ------
    NotTrained
        If nothing has been learned yet.
    MissingPackage
        If CasADi is not installed: ``pip install 'psp3[symbolic]'``.
    """
    checked_kind("controller", controller, FuzzyComputedTorque, "a FuzzyComputedTorque")
    table = controller.controller
    n = controller.joints
    inputs = {name: SX.sym(name, n) for name in INPUTS}
    arrays: Any = (piece_of(array) for array in table[5:])
    known = kernels.Fuzzy(*table[:5], *arrays)
    positions, speeds, *wanted_motion = (symbols_in(one) for one in inputs.values())
    desired = piece_with([entry for part in wanted_motion for entry in part.cells])
    out = piece_with([float("nan")] * kernels.step_width(n))
    model, configuration = _exact(controller)
    Interpreter().call(kernels.fuzzy_torque, known, model, positions, speeds, desired, NOTHING, out)
    inputs |= configuration
    forces = vector(out.cells[:n])
    return casadi.Function("fuzzy_torque", [*inputs.values()], [forces], [*inputs], ["forces"])


def _exact(controller: FuzzyComputedTorque) -> tuple[Any, dict[str, SX]]:
    """Return the dynamics outside of the trained range, and its additional arguments."""
    if controller.outside == "clamp":
        return kernels.NO_MODEL, {}
    table: Any = controller.robot.compiled_table()
    if isinstance(table, ClosedForm):
        arrays: Any = map(piece_of, table)
        return ClosedForm(*arrays), {}
    robot = SymbolicRobot(controller.robot)
    return robot.placed(), {"q": robot.configuration}


INPUTS = (
    "positions",
    "speeds",
    "desired_positions",
    "desired_speeds",
    "desired_accelerations",
)
"""The arguments of the torque."""

NOTHING = piece_with([])
"""No terms are added to the estimates."""

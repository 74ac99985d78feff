"""The 3-PSP's closed form as functions of CasADi symbols for the nut heights."""

from __future__ import annotations

import functools
from typing import Any

from psp3.errors import InvalidValue
from psp3.symbolic.interpreter import Interpreter
from psp3.symbolic.memory import piece_of, piece_with, symbols_in
from psp3.symbolic.numbers import SX, Number, casadi
from psp3.symbolic.robot import matrix, vector
from psp3.three_psp import closed_form
from psp3.three_psp.robot import PSP3
from psp3.three_psp.stepping import ClosedForm


class SymbolicPSP3:
    """The 3-PSP as ``casadi.Function`` objects of heights (3,), which are created on demand.

    The closed form closes the loops. ``casadi.jacobian`` gives the derivatives by the heights.
    Results are NaN at heights that the robot cannot take.

    Parameters
    ----------
    robot : PSP3
        The robot; its present parameters are used.

    Raises
    ------
    InvalidValue
        If the robot has no closed form.
    MissingPackage
        If CasADi is not installed: ``pip install 'psp3[symbolic]'``.
    """

    def __init__(self, robot: PSP3) -> None:
        table = robot.compiled_table() if hasattr(robot, "compiled_table") else None
        if not isinstance(table, ClosedForm):
            wanted = 'the 3-PSP, psp3.load("psp3"); any other is a psp3.symbolic.SymbolicRobot'
            raise InvalidValue("robot", robot, wanted)
        self.robot = robot
        self._parameters = piece_of(table.parameters)
        self._name_symbols()

    def _name_symbols(self) -> None:
        self._interpreter = Interpreter()
        self._heights, self._speeds = SX.sym("heights", 3), SX.sym("speeds", 3)
        self._accelerations, self._forces = SX.sym("accelerations", 3), SX.sym("forces", 3)

    def __getstate__(self) -> dict[str, Any]:
        # CasADi cannot pickle symbols, so functions are created again on demand.
        return {name: self.__dict__[name] for name in ("robot", "_parameters")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._name_symbols()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.robot.title})"

    def _numbers(self, kernel: Any, width: int, *vectors: SX) -> list[Number]:
        """Return the numbers that a kernel writes for one row."""
        out = piece_with([float("nan")] * width)
        rows = (symbols_in(one) for one in vectors)
        self._interpreter.call(kernel, *rows, self._parameters, out)
        return out.cells

    def _function(self, name: str, inputs: tuple[str, ...], outputs: dict[str, SX]) -> Any:
        given = [getattr(self, f"_{what}") for what in inputs]
        return casadi.Function(name, given, [*outputs.values()], [*inputs], [*outputs])

    @functools.cached_property
    def forward_kinematics(self) -> Any:
        """``heights`` to ``center`` (3,), ``rotation`` (3, 3), ``arms`` (3,) and ``tip`` (3,)."""
        out = self._numbers(closed_form.forward_kinematics, 18, self._heights)
        outputs = {
            "center": vector(out[:3]),
            "rotation": matrix(out[3:12], 3, 3),
            "arms": vector(out[12:15]),
            "tip": vector(out[15:]),
        }
        return self._function("forward_kinematics", ("heights",), outputs)

    @functools.cached_property
    def tip_jacobian(self) -> Any:
        """``heights`` to ``J`` (3, 3), the derivative of the tip."""
        out = self._numbers(closed_form.tip_jacobian, 9, self._heights)
        return self._function("tip_jacobian", ("heights",), {"J": matrix(out, 3, 3)})

    @functools.cached_property
    def equation_of_motion(self) -> Any:
        """``heights``, ``speeds`` to ``M`` (3, 3), ``C`` (3, 3) and ``G`` (3,)."""
        out = self._numbers(closed_form.equation_of_motion, 21, self._heights, self._speeds)
        outputs = {
            "M": matrix(out[:9], 3, 3),
            "C": matrix(out[9:18], 3, 3),
            "G": vector(out[18:]),
        }
        return self._function("equation_of_motion", ("heights", "speeds"), outputs)

    @functools.cached_property
    def inverse_dynamics(self) -> Any:
        """``heights``, ``speeds``, ``accelerations`` to ``forces`` (3,) of the screws [N]."""
        motion = self._heights, self._speeds, self._accelerations
        out = self._numbers(closed_form.inverse_dynamics, 3, *motion)
        inputs = ("heights", "speeds", "accelerations")
        return self._function("inverse_dynamics", inputs, {"forces": vector(out)})

    @functools.cached_property
    def forward_dynamics(self) -> Any:
        """``heights``, ``speeds``, ``forces`` to ``accelerations`` (3,) of the nuts [m/s²]."""
        state = self._heights, self._speeds, self._forces
        out = self._numbers(closed_form.forward_dynamics, 3, *state)
        inputs = ("heights", "speeds", "forces")
        return self._function("forward_dynamics", inputs, {"accelerations": vector(out)})

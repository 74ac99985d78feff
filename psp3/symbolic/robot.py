r"""Dynamics of any robot with loops as functions of CasADi symbols.

These functions do not close the loops by iteration. All of them take a configuration q of all
joints that closes the loops. There are three ways to get derivatives along the independent
coordinates:

- **q as parameter**: numbers from ``robot.configuration``, for example along a given path.
- **q as unknowns** of an optimization, with the constraint
  :attr:`SymbolicRobot.closure_equations` = 0.
- **implicit differentiation**: a small motion of the independent coordinates changes q by
  :math:`\partial q / \partial a = E L`, with L the complement of the loops and E the map from
  velocities to rates of coordinates, so that :math:`\mathrm d f / \mathrm d a = f_q\, E L`;
  :meth:`SymbolicRobot.derivatives`.

L is an expression in q that contains the factored Jacobian of the closures, and so are M, C, G and
all other results. Their derivatives by q include the change of L. Only derivatives along motions
that keep the loops closed have a meaning.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np

from psp3.dynamics.compiled_robot import write_forces
from psp3.errors import InvalidValue, UnknownName
from psp3.multibody import motion, tree
from psp3.multibody.closing import CLOSED, factored
from psp3.multibody.constraint import closure_equations
from psp3.multibody.loops import residual_of
from psp3.multibody.motion import INVERSE_DYNAMICS, answer_of_pose
from psp3.multibody.named_frames import frame_number
from psp3.multibody.placement import place
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.symbolic.interpreter import Interpreter
from psp3.symbolic.memory import Piece, piece_of, piece_with, symbols_in
from psp3.symbolic.numbers import SX, Number, casadi

NOTHING = piece_with([])

WIDTHS = {tree.SCREW: 1, tree.UNBOUNDED: 2, tree.BALL: 4, tree.FREE: 7, tree.PLANAR: 4}
"""Coordinates of each kind of element."""


class PlacedRobot(NamedTuple):
    """A robot at a configuration q that closes its loops; kernels use it as a robot's table.

    ``tree`` and ``numbers`` are the robot's, ``memory`` is placed at q.
    """

    tree: Any
    numbers: Any
    memory: Any


@write_forces.register(PlacedRobot)
def _write_forces(
    robot: PlacedRobot, positions: Any, speeds: Any, accelerations: Any, out: Any
) -> bool:
    tree, numbers, memory = robot
    done: int = answer_of_pose(  # type: ignore[no-untyped-call]
        INVERSE_DYNAMICS, tree, numbers, memory, speeds, accelerations, 0, out, 0
    )
    return done == CLOSED


DIFFERENTIABLE = (
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "coriolis_matrix",
    "gravity",
    "actuation_matrix",
    "complement",
)
"""Functions that have derivatives along the loops."""


def vector(entries: list[Number]) -> SX:
    """Return numbers and symbols as a column."""
    return SX(casadi.vertcat(*entries)) if entries else SX(0, 1)


def matrix(entries: list[Number], rows: int, columns: int) -> SX:
    """Return numbers and symbols, row by row, as a matrix."""
    return casadi.reshape(vector(entries), columns, rows).T


class SymbolicRobot:
    """A robot of any kind as ``casadi.Function`` objects, which are created on demand.

    Inputs and outputs have names: ``q`` (nq,), a configuration that closes the loops, ``speeds``,
    ``accelerations`` and ``forces`` (n,) of the independent coordinates, in the order of
    ``robot.coordinates``. If the motors are not the coordinates, forces are those along the
    coordinates, and :attr:`actuation_matrix` gives the effect of the motors.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot; its present numbers, including gravity, are used.

    Raises
    ------
    InvalidValue
        If it is not such a robot.
    MissingPackage
        If CasADi is not installed: ``pip install 'psp3[symbolic]'``.
    """

    def __init__(self, robot: ClosedLoopRobot) -> None:
        if not isinstance(robot, ClosedLoopRobot):
            raise InvalidValue("robot", robot, 'a robot, such as psp3.load("delta")')
        self.robot = robot
        tables = robot.core.tables()
        self._tree, self._numbers = piece_of(tables.tree), piece_of(tables.numbers)
        self._start, self._counts = tables.memory, tables.tree
        self.joints = int(self._counts[tree.INDEPENDENT])
        self._name_symbols()

    def _name_symbols(self) -> None:
        self._interpreter = Interpreter()
        self._q = SX.sym("q", self.robot.model.nq)
        self._speeds = SX.sym("speeds", self.joints)
        self._accelerations = SX.sym("accelerations", self.joints)
        self._forces = SX.sym("forces", self.joints)

    def __getstate__(self) -> dict[str, Any]:
        # CasADi cannot pickle symbols, so functions are created again on demand.
        kept = ("robot", "_tree", "_numbers", "_start", "_counts", "joints")
        return {name: self.__dict__[name] for name in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._name_symbols()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.robot.title})"

    # Calls of kernels

    def _call(self, kernel: Any, memory: Piece, *arguments: Any) -> Any:
        return self._interpreter.call(kernel, self._tree, self._numbers, memory, *arguments)

    @functools.cached_property
    def _pose(self) -> list[Number]:
        """The memory of kernels at q: placed, with the Jacobians of the loops factored."""
        memory = piece_of(self._start)
        at, counts = int(self._counts[tree.AT_CONFIGURATION]), self._counts
        memory.cells[at : at + self.robot.model.nq] = symbols_in(self._q).cells
        last = int(counts[tree.MEMBERS])
        self._call(place, memory, last - int(counts[tree.ELEMENTS]), last)
        for group in range(int(counts[tree.GROUPS])):
            self._call(residual_of, memory, group)
            self._call(factored, memory, group)
        return memory.cells

    @property
    def configuration(self) -> SX:
        """The symbol q (nq,) of :meth:`placed`."""
        return self._q

    def placed(self) -> PlacedRobot:
        """Return the robot at :attr:`configuration`, for kernels that need its forces."""
        return PlacedRobot(self._tree, self._numbers, piece_with(self._pose))

    def _answer(self, question: int, width: int, second: Piece, third: Piece) -> list[Number]:
        """Return the kernel's answer to a question about the pose at q."""
        memory, out = piece_with(self._pose), piece_with([float("nan")] * width)
        arguments = (self._tree, self._numbers, memory, second, third, 0, out, 0)
        self._interpreter.call(motion.answer_of_pose, question, *arguments)
        return out.cells

    def _function(self, name: str, inputs: dict[str, SX], outputs: dict[str, SX]) -> Any:
        return casadi.Function(name, [*inputs.values()], [*outputs.values()], [*inputs], [*outputs])

    # Kinematics

    @functools.cached_property
    def closure_equations(self) -> Any:
        """``q`` to ``residual``: zero where q closes the loops [m, rad].

        There is a row for each closure equation, group by group (some may be redundant), then one
        for the length of each quaternion and of each angle that is given as cosine and sine. If
        frames are joined in orientation, the residual is the sine of their angle along its axis,
        which has additional zeros only at half turns.
        """
        rows = int(self._counts[tree.ROWS])
        memory, out = piece_of(self._start), piece_with([float("nan")] * rows)
        self._call(closure_equations, memory, symbols_in(self._q), out)
        lengths = [self._length(e) for e in range(int(self._counts[tree.ELEMENTS]))]
        residual = vector([*out.cells, *(length for length in lengths if length is not None)])
        return self._function("closure_equations", {"q": self._q}, {"residual": residual})

    def _element(self, e: int) -> tuple[int, int, int, int]:
        """Return kind, places of first coordinate and velocity, and freedoms of an element."""
        row = int(self._counts[tree.AT_ELEMENTS]) + tree.ELEMENT_INTEGERS * e
        named = (tree.KIND, tree.INDEX_Q, tree.INDEX_V, tree.FREEDOMS)
        kind, q, v, freedoms = (int(self._counts[row + what]) for what in named)
        return kind, q, v, freedoms

    def _length(self, e: int) -> SX | None:
        """Return how far the squared lengths of quaternions, cosines and sines are from one."""
        kind, q, _, _ = self._element(e)
        first, count = {
            tree.UNBOUNDED: (q, 2),
            tree.PLANAR: (q + 2, 2),
            tree.BALL: (q, 4),
            tree.FREE: (q + 3, 4),
        }.get(kind, (q, 0))
        return casadi.sumsqr(self._q[first : first + count]) - 1.0 if count else None

    @functools.cached_property
    def complement(self) -> Any:
        """``q`` to ``L`` (nv, n), from speeds of the coordinates to velocities of all joints."""
        n, nv, nq = self.joints, self.robot.model.nv, self.robot.model.nq
        answered = self._answer(motion.COMPLEMENT, nq + n * nv, NOTHING, NOTHING)
        L = matrix(answered[nq:], n, nv).T
        return self._function("complement", {"q": self._q}, {"L": L})

    @functools.cached_property
    def configuration_rates(self) -> Any:
        """``q``, ``speeds`` to ``rates`` (nq,): the rates of q with closed loops."""
        velocities = self.complement(self._q) @ self._speeds
        rates = SX.zeros(self.robot.model.nq)
        for e in range(int(self._counts[tree.ELEMENTS])):
            kind, q, v, freedoms = self._element(e)
            coordinates = self._q[q : q + WIDTHS[kind]]
            changed = _rates(kind, coordinates, velocities[v : v + freedoms])
            rates[q : q + changed.shape[0]] = changed
        inputs = {"q": self._q, "speeds": self._speeds}
        return self._function("configuration_rates", inputs, {"rates": rates})

    def frame(self, name: str) -> Any:
        """Return ``q`` to ``position`` (3,), ``rotation`` (3, 3) and ``jacobian`` (6, n).

        All are in base axes. The Jacobian has the linear velocity of the frame's origin, then the
        angular velocity, for unit speeds of the coordinates.

        Parameters
        ----------
        name : str
            Name of a frame, as in :meth:`psp3.ClosedLoopRobot.frame_placement`.

        Raises
        ------
        UnknownName
            If the model has no such frame.
        """
        model = self.robot.model
        known = model.frames[frame_number(model, name)]
        numbers = piece_of(self.robot.core.frame(known.parentJoint, known.placement))
        out = self._answer(motion.FRAME, 12 + 6 * self.joints, NOTHING, numbers)
        outputs = {
            "rotation": matrix(out[:9], 3, 3),
            "position": vector(out[9:12]),
            "jacobian": matrix(out[12:], self.joints, 6).T,
        }
        order = ("position", "rotation", "jacobian")
        return self._function("frame", {"q": self._q}, {what: outputs[what] for what in order})

    # Dynamics

    @functools.cached_property
    def inverse_dynamics(self) -> Any:
        """``q``, ``speeds``, ``accelerations`` to ``forces`` (n,) [N, N m]."""
        second, third = symbols_in(self._speeds), symbols_in(self._accelerations)
        forces = self._answer(motion.INVERSE_DYNAMICS, self.joints, second, third)
        inputs = {"q": self._q, "speeds": self._speeds, "accelerations": self._accelerations}
        return self._function("inverse_dynamics", inputs, {"forces": vector(forces)})

    @functools.cached_property
    def forward_dynamics(self) -> Any:
        """``q``, ``speeds``, ``forces`` to ``accelerations`` (n,) [m/s², rad/s²]."""
        second, third = symbols_in(self._speeds), symbols_in(self._forces)
        found = self._answer(motion.FORWARD_DYNAMICS, self.joints, second, third)
        inputs = {"q": self._q, "speeds": self._speeds, "forces": self._forces}
        return self._function("forward_dynamics", inputs, {"accelerations": vector(found)})

    @functools.cached_property
    def equation_of_motion(self) -> Any:
        """``q``, ``speeds`` to ``M`` (n, n), ``C`` (n, n) and ``G`` (n,)."""
        n, speeds = self.joints, symbols_in(self._speeds)
        out = self._answer(motion.EQUATION_OF_MOTION, 2 * n * n + n, speeds, speeds)
        outputs = {
            "M": matrix(out[: n * n], n, n),
            "C": matrix(out[n * n : 2 * n * n], n, n),
            "G": vector(out[2 * n * n :]),
        }
        inputs = {"q": self._q, "speeds": self._speeds}
        return self._function("equation_of_motion", inputs, outputs)

    @functools.cached_property
    def mass_matrix(self) -> Any:
        """``q`` to ``M`` (n, n)."""
        M, _, _ = self.equation_of_motion(self._q, 0.0)
        return self._function("mass_matrix", {"q": self._q}, {"M": M})

    @functools.cached_property
    def coriolis_matrix(self) -> Any:
        """``q``, ``speeds`` to ``C`` (n, n)."""
        _, C, _ = self.equation_of_motion(self._q, self._speeds)
        inputs = {"q": self._q, "speeds": self._speeds}
        return self._function("coriolis_matrix", inputs, {"C": C})

    @functools.cached_property
    def gravity(self) -> Any:
        """``q`` to ``G`` (n,), the forces of gravity and of springs."""
        _, _, G = self.equation_of_motion(self._q, 0.0)
        return self._function("gravity", {"q": self._q}, {"G": G})

    @functools.cached_property
    def actuation_matrix(self) -> Any:
        """``q`` to ``A`` (n, m): maps motor forces to forces along the coordinates."""
        A = self.complement(self._q).T @ casadi.DM(np.asarray(self.robot.motors))
        return self._function("actuation_matrix", {"q": self._q}, {"A": A})

    def derivatives(self, name: str) -> Any:
        r"""Return the derivatives of a function along the coordinates, with closed loops.

        The derivatives by positions are :math:`f_q\, E L`, the matrix of
        ``robot.inverse_dynamics_derivatives``; there are also those by the function's other inputs.
        A matrix is treated as the vector of its stacked columns.

        Parameters
        ----------
        name : str
            The name of a function, one of ``DIFFERENTIABLE``.

        Returns
        -------
        casadi.Function
            A function of the same inputs, to ``by_positions`` and, if there are such inputs,
            ``by_speeds``, ``by_accelerations`` or ``by_forces``.

        Raises
        ------
        UnknownName
            If there is no such function.
        """
        if name not in DIFFERENTIABLE:
            raise UnknownName("function with derivatives", name, DIFFERENTIABLE)
        function = getattr(self, name)
        every = {
            "q": self._q,
            "speeds": self._speeds,
            "accelerations": self._accelerations,
            "forces": self._forces,
        }
        inputs = {what: every[what] for what in function.name_in()}
        value = casadi.vec(function(*inputs.values()))
        # The rates are linear in the speeds.
        along = casadi.jacobian(self.configuration_rates(self._q, self._speeds), self._speeds)
        outputs = {"by_positions": casadi.jacobian(value, self._q) @ along}
        for what in [*inputs][1:]:
            outputs[f"by_{what}"] = casadi.jacobian(value, inputs[what])
        return self._function(f"{name}_derivatives", inputs, outputs)


def _rates(kind: int, q: SX, v: SX) -> SX:
    """Return the rates of an element's coordinates for velocities in its own axes."""
    if kind == tree.UNBOUNDED:
        return vector([-q[1] * v[0], q[0] * v[0]])
    if kind == tree.PLANAR:
        c, s = q[2], q[3]
        return vector([c * v[0] - s * v[1], s * v[0] + c * v[1], -s * v[2], c * v[2]])
    if kind == tree.BALL:
        return _rates_of_quaternion(q[:4], v)
    if kind == tree.FREE:
        u, w = q[3:6], q[6]
        side = 2.0 * casadi.cross(u, v[:3])
        way = v[:3] + w * side + casadi.cross(u, side)
        return casadi.vertcat(way, _rates_of_quaternion(q[3:7], v[3:]))
    return v


def _rates_of_quaternion(q: SX, w: SX) -> SX:
    u = q[:3]
    return 0.5 * casadi.vertcat(q[3] * w + casadi.cross(u, w), -casadi.dot(u, w))

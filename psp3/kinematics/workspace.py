"""Workspaces of any robot with loops.

The module computes maps over one or more coordinates, their borders, and the distance to the border
along a ray.

Poses are reached from the robot's reference configuration by continuation, each from a neighbor. So
a map shows one assembly mode (over the actuated coordinates) or one working mode (over those of a
task). Joint limits and singularities do not stop the continuation; they are recorded.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.support.described import Described
from psp3.checks import (
    Array,
    as_floats,
    checked_kind,
    checked_not_negative,
    checked_number,
    checked_positive,
)
from psp3.errors import (
    ClosureFailed,
    InvalidArray,
    InvalidValue,
    SingularConfiguration,
    UnknownName,
)
from psp3.kinematics.border import EDGE_ACCURACY, Boundary, Tracer
from psp3.kinematics.pose_map import COORDINATES, KinematicMap, Status
from psp3.kinematics.singularities import Measures, SingularityAnalysis
from psp3.kinematics.task_driven import TaskDrivenRobot, without_limits
from psp3.kinematics.tasks import equations_of, rotating
from psp3.robots.closed_loop_robot import ClosedLoopRobot

UNLIMITED = 1e30
"""A limit beyond this is no limit; Pinocchio represents no limit as the largest number."""

LEAST_CONSTRAINT = 1e-6
"""A pose counts as a constraint singularity if its measure is below this share of that in the
reference configuration.

Branches of the motion meet there, and the continuation could follow any of them.
"""

RAY_STEPS = 64
"""Number of steps in which a ray is searched for its end."""

RAY_ACCURACY = 1e-11
"""Accuracy of the end of a ray, as a share of the ray. A much smaller one would be lost in
rounding.
"""


class Reach(NamedTuple):
    """How far a ray goes.

    ``distance`` is in multiples of the direction, ``ends`` is the reason why the ray ends, and
    ``configuration`` is the last good configuration.

    ``ends`` is ``"limit"``, and ``joint`` then names the joint; ``"actuation"``, ``"end_effector"``
    or ``"constraint"`` for a singularity of this kind; or ``"farthest"`` if the search reached its
    end.
    """

    distance: float
    ends: str
    joint: str
    configuration: Array


class Workspace(Described):
    """The workspace of a robot's frame: the poses that it reaches, and their conditioning.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    frame : str
        Name of the frame.
    task : sequence of str
        Coordinates of the frame that matter, see
        :class:`psp3.kinematics.task_driven.TaskDrivenRobot`.
    over : {"task", "actuators"}
        Coordinates of the workspace: those of the task, whose number must be that of the
        coordinates that the motors command, or the robot's own, which usually are its motors.
    length : float, optional
        Characteristic length [m], see :mod:`psp3.kinematics.singularities`.
    singular_below : float
        A pose counts as singular if its measure of actuation or of the end effector is below this,
        or if its measure of constraint is below this share of that in the reference configuration.
        At 0.01, some motion of the motors moves the robot's joints a hundred times as fast, or
        hardly moves the frame. With 0, only exact singularities count.

    Attributes
    ----------
    analysis : SingularityAnalysis
        Computes the measures of the poses.
    coordinates : tuple of str
        Names of the coordinates.
    units : dict
        Their units.
    reference : dict
        Their values in the robot's reference configuration.

    Raises
    ------
    UnknownName
        If the robot has no such frame, there is no such coordinate, or ``over`` is unknown.
    InvalidValue
        If the task cannot drive the robot, or a number is out of range.
    """

    def __init__(
        self,
        robot: ClosedLoopRobot,
        frame: str,
        task: Sequence[str],
        over: str = "task",
        length: float | None = None,
        singular_below: float = 0.01,
    ) -> None:
        if over not in COORDINATES:
            raise UnknownName("coordinates of a workspace", over, COORDINATES)
        self.singular_below = checked_not_negative("singular_below", singular_below)
        self.analysis, self.over = SingularityAnalysis(robot, frame, task, length), over
        if over == "task":
            self._driven: ClosedLoopRobot = TaskDrivenRobot(robot, frame, task)
            self.coordinates: tuple[str, ...] = self.analysis.task
        else:
            self._driven = ClosedLoopRobot(
                without_limits(robot.model),
                robot.constraint_models,
                robot.coordinates,
                robot.q0,
                equations=equations_of(robot),
            )
            self.coordinates = robot.coordinates
        angular = rotating(self._driven.model)[self._driven.coordinates_v]
        self.units = {
            name: "rad" if turns else "m"
            for name, turns in zip(self.coordinates, angular, strict=True)
        }
        self.reference = dict(zip(self.coordinates, self._driven.reference.tolist(), strict=True))
        self._scale = np.where(angular, self.analysis.length, 1.0)
        self._limits = _Margins(robot, self.analysis.length)
        at_reference = self.analysis.measures(robot.q0)
        self._signs = float(at_reference.orientation), float(at_reference.assembly)
        self._tight = float(at_reference.constraint)

    def _facts(self) -> dict[str, Any]:
        return {
            "robot": self.analysis.robot,
            "frame": self.analysis.frame,
            "task": self.analysis.task,
            "over": self.coordinates,
        }

    def map(
        self, grid: Mapping[str, ArrayLike], held: Mapping[str, float] | None = None
    ) -> KinematicMap:
        """Return the poses over a grid.

        Each is reached from a neighbor, the first from the reference configuration.

        Parameters
        ----------
        grid : mapping
            Values of one or more coordinates, ascending [m or rad]:
            ``{"x": np.linspace(-0.1, 0.1, 41), "z": [...]}``.
        held : mapping, optional
            Values of the other coordinates [m or rad]; by default those of the reference
            configuration.

        Returns
        -------
        KinematicMap

        Raises
        ------
        UnknownName
            If there is no such coordinate.
        InvalidArray, InvalidValue
            If values are not finite and ascending, or a coordinate is both in the grid and held.
        """
        self._check_mapping("grid", grid)
        axes = {name: self._ascending(name, values) for name, values in grid.items()}
        if not axes:
            raise InvalidValue(
                "grid", dict(grid), f"values of one or more of {', '.join(self.coordinates)}"
            )
        fixed = self._point({} if held is None else held, "held")
        for name in axes:
            if held is not None and name in held:
                raise InvalidValue("held", name, "a coordinate that is not in the grid")
        shape = tuple(values.size for values in axes.values())
        targets = np.empty((*shape, len(self.coordinates)))
        targets[:] = fixed
        for name, values in zip(axes, np.meshgrid(*axes.values(), indexing="ij"), strict=True):
            targets[..., self.coordinates.index(name)] = values
        configuration = self._flood(targets)[..., : self.analysis.robot.model.nq]
        status, position, margin, measures = self._evaluated(configuration)
        status[_cut_off(status == Status.USABLE, self._away(targets))] = Status.APART
        return KinematicMap(
            robot=self.analysis.robot.model.name,
            frame=self.analysis.frame,
            task=self.analysis.task,
            over=self.over,
            grid=axes,
            held={
                name: value
                for name, value in zip(self.coordinates, fixed.tolist(), strict=True)
                if name not in axes
            },
            units=self.units,
            length=self.analysis.length,
            singular_below=self.singular_below,
            status=status,
            configuration=configuration,
            position=position,
            margin=margin,
            measures=measures,
        )

    def boundary(self, poses: KinematicMap, at_least: Status = Status.USABLE) -> Boundary:
        """Return the border of the poses of a map that have a status or a better one.

        On each edge of the grid that crosses the border, the crossing is accurate to a thousandth
        of the edge. Crossings are joined by straight lines, so the error of the area is
        proportional to the square of the grid's step. If the region extends beyond the grid, the
        outline of the grid is not part of the border.

        Parameters
        ----------
        poses : KinematicMap
            A map of two dimensions that this workspace made, of two lengths or two angles.
        at_least : Status
            Worst status of the poses inside; ``Status.BEYOND_LIMIT`` for all reachable poses.

        Returns
        -------
        Boundary

        Raises
        ------
        InvalidValue
            If the map has other dimensions or coordinates, or ``at_least`` is not a status of
            reachable poses.
        """
        checked_kind("poses", poses, KinematicMap, "a map, as workspace.map returns it")
        if len(poses.grid) != 2 or len({poses.units[name] for name in poses.grid}) != 1:
            raise InvalidValue(
                "poses", tuple(poses.grid), "a map over two coordinates of the same unit"
            )
        if poses.over != self.over or set(poses.grid) | set(poses.held) != set(self.coordinates):
            raise InvalidValue(
                "poses",
                tuple(poses.grid),
                f"a map over {', '.join(self.coordinates)} of this workspace",
            )
        if not isinstance(at_least, int | np.integer) or at_least not in tuple(Status)[1:]:
            raise InvalidValue("at_least", at_least, "a Status better than UNREACHABLE")
        base, places, least = (
            self._point(poses.held, "held"),
            [self._place(name) for name in poses.grid],
            Status(at_least),
        )

        def along(start: Array, way: Array, configuration: Array) -> float:
            origin, whole_way = base.copy(), np.zeros_like(base)
            origin[places], whole_way[places] = start, way
            return self._as_far_as(
                origin, whole_way, self._whole(configuration), 1.0, 0.5, EDGE_ACCURACY, least
            )[0]

        return Tracer(poses, least, along).trace()

    def distance(
        self,
        direction: Mapping[str, float],
        farthest: float,
        start: Mapping[str, float] | None = None,
    ) -> Reach:
        """Return how far the robot can move in a direction, and why not farther.

        Beyond this distance its poses are not usable.

        Parameters
        ----------
        direction : mapping
            Components of the direction; the others are zero. ``{"x": 1.0}`` gives a distance in
            meters along x.
        farthest : float
            End of the search, in multiples of the direction. The ray is searched in 64 steps.
        start : mapping, optional
            Coordinates of the start [m or rad]; by default those of the reference configuration.

        Returns
        -------
        Reach
            The distance is 0 if the start is not usable.

        Raises
        ------
        UnknownName
            If there is no such coordinate.
        InvalidValue
            If a number is not finite, the direction is zero, or ``farthest`` is not positive.
        ClosureFailed, SingularConfiguration
            If the start cannot be reached.
        """
        end, way = checked_positive("farthest", farthest), np.zeros(len(self.coordinates))
        self._check_mapping("direction", direction)
        for name, value in direction.items():
            way[self._place(name)] = checked_number(
                f"direction[{name!r}]", value, "a finite number"
            )
        if not (np.isfinite(way).all() and way.any()):
            raise InvalidValue("direction", dict(direction), "finite and not zero")
        origin = self._point({} if start is None else start, "start")
        nq = self.analysis.robot.model.nq
        good = self._driven.configuration(origin)
        if self._status(good) < Status.USABLE:
            return Reach(0.0, *self._reason(good), good[:nq])
        done, good, bad = self._as_far_as(
            origin, way, good, end, end / RAY_STEPS, RAY_ACCURACY * end, Status.USABLE
        )
        if done == end:
            return Reach(end, "farthest", "", good[:nq])
        return Reach(
            done, *self._reason(good if bad is None else bad, unreachable=bad is None), good[:nq]
        )

    # Inside

    def _place(self, name: str) -> int:
        if name not in self.coordinates:
            raise UnknownName("coordinate", name, self.coordinates)
        return self.coordinates.index(name)

    def _point(self, values: Mapping[str, float], what: str) -> Array:
        """Return all coordinates.

        The default is those of the reference configuration.
        """
        self._check_mapping(what, values)
        point = np.array(list(self.reference.values()))
        for name, value in values.items():
            point[self._place(name)] = checked_number(f"{what}[{name!r}]", value, "a finite number")
        if not np.isfinite(point).all():
            raise InvalidValue(what, dict(values), "finite numbers")
        return point

    @staticmethod
    def _check_mapping(name: str, values: object) -> None:
        checked_kind(name, values, Mapping, 'by names of coordinates, such as {"x": 0.1}')

    def _ascending(self, name: str, values: ArrayLike) -> Array:
        self._place(name)
        row = as_floats(f"grid[{name!r}]", values, "(N,)")
        if (
            row.ndim != 1
            or row.size < 2
            or not np.isfinite(row).all()
            or not (np.diff(row) > 0.0).all()
        ):
            raise InvalidArray(f"grid[{name!r}]", "(N,), at least two, ascending", values)
        return row

    def _whole(self, configuration: Array) -> Array:
        """Return the configuration of the driven robot that belongs to one of the robot."""
        return (
            self._driven.completed(configuration)
            if isinstance(self._driven, TaskDrivenRobot)
            else configuration
        )

    def _followed(self, target: Array, guess: Array) -> Array | None:
        """Return the configuration at a target, reached from a guess; None if it is unreachable."""
        try:
            return self._driven.configuration(target, guess=guess)
        except (ClosureFailed, SingularConfiguration):
            return None

    def _as_far_as(
        self,
        start: Array,
        way: Array,
        q: Array,
        end: float,
        longest: float,
        accuracy: float,
        least: Status,
    ) -> tuple[float, Array, Array | None]:
        """Move from a configuration along a vector, as long as poses have a status or a better one.

        Return the multiple of the vector, the last good configuration, and the first bad one, None
        if the loops did not close there. Bisection is not used, because a pose that is unreachable
        from far away may be reachable from nearby.
        """
        done, step, streak, bad = 0.0, longest, 0, None
        # After a failure the step is halved, so the last failure is two steps away.
        while done < end and 2.0 * step > accuracy:
            goal = min(done + step, end)
            found = self._followed(start + goal * way, q)
            if found is not None and (least == Status.BEYOND_LIMIT or self._status(found) >= least):
                done, q, streak = goal, found, streak + 1
                if streak > 1:
                    step = min(2.0 * step, longest)
            else:
                streak, step, bad = 0, 0.5 * step, found
        return done, q, bad

    def _flood(self, targets: Array) -> Array:
        """Return configurations of the driven robot, NaN where there are none.

        They are found from neighbor to neighbor, starting at the node nearest to the reference.
        """
        shape = targets.shape[:-1]
        found = np.full((*shape, self._driven.model.nq), np.nan)
        for entry in np.argsort(self._away(targets), axis=None, kind="stable"):
            index = tuple(int(i) for i in np.unravel_index(entry, shape))
            first = self._followed(targets[index], self._driven.q0)
            if first is not None:
                found[index] = first
                self._spread(targets, found, index)
                break
        return found

    def _away(self, targets: Array) -> Array:
        """Return the squared distances of targets from the reference configuration."""
        squares: Array = (((targets - self._driven.reference) * self._scale) ** 2).sum(axis=-1)
        return squares

    def _spread(self, targets: Array, found: Array, start: tuple[int, ...]) -> None:
        shape = targets.shape[:-1]
        waiting = deque([start])
        while waiting:
            here = waiting.popleft()
            for axis in range(len(shape)):
                for step in (-1, 1):
                    there = (*here[:axis], here[axis] + step, *here[axis + 1 :])
                    if not 0 <= there[axis] < shape[axis] or not np.isnan(found[there][0]):
                        continue
                    reached = self._followed(targets[there], found[here])
                    if reached is not None:
                        found[there] = reached
                        waiting.append(there)

    def _evaluated(self, configuration: Array) -> tuple[NDArray[np.int64], Array, Array, Measures]:
        """Return status, position, margin and measures of configurations; some may be NaN."""
        reached = ~np.isnan(configuration[..., 0])
        rows = configuration[reached]
        measures = self.analysis.measures(rows)

        def spread(values: Array, fill: float = np.nan) -> Array:
            whole = np.full(reached.shape + values.shape[1:], fill)
            whole[reached] = values
            return whole

        margin = self._limits.of(rows)[0]
        status = spread(self._statuses(margin, measures).astype(float), Status.UNREACHABLE).astype(
            np.int64
        )
        return (
            status,
            spread(self.analysis.positions(rows)),
            spread(margin),
            Measures(*(spread(values) for values in measures)),
        )

    def _statuses(self, margin: Array, measures: Measures) -> Array:
        with np.errstate(invalid="ignore"):
            # Measures that are NaN at a constraint singularity count as singular.
            regular = (measures.actuation > self.singular_below) & (
                measures.end_effector > self.singular_below
            )
            regular &= (
                measures.constraint > max(self.singular_below, LEAST_CONSTRAINT) * self._tight
            )
            other_side = (measures.orientation != self._signs[0]) | (
                measures.assembly != self._signs[1]
            )
            kinds = [margin < 0.0, ~regular, other_side]
        return np.select(kinds, [Status.BEYOND_LIMIT, Status.SINGULAR, Status.APART], Status.USABLE)

    def _status(self, q: Array) -> int:
        rows = q[np.newaxis, : self.analysis.robot.model.nq]
        margin = self._limits.of(rows)[0]
        if margin[0] < 0.0:
            return Status.BEYOND_LIMIT
        return int(self._statuses(margin, self.analysis.measures(rows))[0])

    def _reason(self, q: Array, unreachable: bool = False) -> tuple[str, str]:
        """Return why a ray ends at a configuration, and the joint if a limit ends it."""
        q = q[: self.analysis.robot.model.nq]
        margin, joint = self._limits.of(q[np.newaxis])
        if margin[0] < 0.0:
            return "limit", self._limits.names[joint[0]]
        measures = self.analysis.measures(q)
        if measures.mobility > self.analysis.robot.commanded:
            return "constraint", ""
        kinds = {
            "constraint": measures.constraint / self._tight,
            "actuation": measures.actuation,
            "end_effector": measures.end_effector,
        }
        if unreachable:
            # A singularity of the other kind does not prevent the loops from closing.
            kinds.pop("actuation" if self.over == "task" else "end_effector")
        return min(kinds, key=lambda kind: float(kinds[kind])), ""


def _cut_off(good: NDArray[np.bool_], away: Array) -> NDArray[np.bool_]:
    """Return the good nodes of a grid that are cut off from the reference.

    They are not connected with the good node that is nearest to it.
    """
    if not good.any():
        return good
    from scipy.ndimage import label

    parts, _ = label(good)
    here = np.unravel_index(np.where(good, away, np.inf).argmin(), good.shape)
    cut: NDArray[np.bool_] = good & (parts != parts[here])
    return cut


class _Margins:
    """Distances of joints of one coordinate from their limits."""

    def __init__(self, robot: ClosedLoopRobot, length: float) -> None:
        model, angular = robot.model, rotating(robot.model)
        joints = [
            (str(name), joint.idx_q, joint.idx_v)
            for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
            if joint.nq == 1
        ]
        self.names = [name for name, _, _ in joints]
        self._q = np.array([q for _, q, _ in joints], dtype=np.int64)
        self._scale = np.where(
            angular[np.array([v for _, _, v in joints], dtype=np.int64)], length, 1.0
        )
        self._lower, self._upper = (
            model.lowerPositionLimit[self._q],
            model.upperPositionLimit[self._q],
        )

    def of(self, configurations: Array) -> tuple[Array, Array]:
        """Return the smallest margin of configurations (N, nq) [m], and its joint.

        The margin is infinite without limits. The joint is given as an index.
        """
        if not self.names:
            return np.full(len(configurations), np.inf), np.zeros(
                len(configurations), dtype=np.int64
            )
        values = configurations[:, self._q]
        below = np.where(
            self._lower < -UNLIMITED, np.inf, values - np.maximum(self._lower, -UNLIMITED)
        )
        above = np.where(
            self._upper > UNLIMITED, np.inf, np.minimum(self._upper, UNLIMITED) - values
        )
        margins = np.minimum(below, above) * self._scale
        nearest = margins.argmin(axis=1)
        return margins[np.arange(len(margins)), nearest], nearest

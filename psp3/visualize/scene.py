"""The robot on a floor in one page, at rest or in motion, beside other robots.

The page needs no network.

A scene is a list of MeshCat's drawing commands. :class:`Scene` collects them with Pinocchio's
MeshCat visualizer and puts them in one page, ``scene.html``, which holds MeshCat itself, the lights
and the camera. Written to a file, the page carries the commands; served by
:class:`psp3.visualize.viewer.Viewer`, it receives them one by one.
"""

from __future__ import annotations

import base64
import gzip
import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from fuzzy2.errors import printable
from fuzzy2.support.markup import Markup, data_from_json, element, filled
from fuzzy2.support.text_files import write_text
from psp3.checks import Array, checked_positive, checked_robot, one_row
from psp3.errors import InvalidValue
from psp3.kinematics.tasks import rotating
from psp3.robots.robot import Robot
from psp3.simulation.result import Result
from psp3.trajectories.motion import completed
from psp3.trajectories.trajectory import Trajectory
from psp3.visualize.animation import Frames, clip, frames_of
from psp3.visualize.commands import DrawingCommands
from psp3.visualize.force_arrows import FORCE_COLOR, ForceArrow, newtons_per_decimeter
from psp3.visualize.robot_visualizer import RobotVisualizer
from psp3.visualize.shapes import Flat, Tube, geometry, meshcat, meshcat_script
from psp3.visualize.tracking_error import tracking_error

VIEW_DIRECTION = (0.47, 0.76, 0.44)
"""Direction from the robot to the camera: between arms 1 and 2, so the third column is behind the
star.
"""

FIELD_OF_VIEW = 24.0
"""Vertical field of view of the camera [degrees]."""

SPACING = 0.72
"""Least distance between robots that stand side by side [m]."""

DESIRED_COLOR, ACTUAL_COLOR = "#0b7285", "#c2255c"

TRACE_RADIUS = 0.0014
"""WebGL draws lines one pixel wide, so the tip's path is a tube of this radius [m]; the desired one
is a translucent sleeve of twice it.
"""

FRAME_HEIGHT = 520
"""Height of a scene in a notebook [pixels]."""

LISTEN = "null"
"""Placeholder for commands in a served page, which gets them from its server."""

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; worker-src blob:; connect-src 'self' data: blob:"
)
"""Content security policy of a scene: nothing is loaded from elsewhere, whatever a mesh refers
to."""


class _Performer:
    """One robot of a scene.

    It has a body and, if requested, a ghost, force arrows, paths of the tip, and a target.
    """

    def __init__(self, robot: Robot, viewer: meshcat.Visualizer, node: str, frames: Frames) -> None:
        self._robot, self._viewer, self._node = robot, viewer, node
        self.body = RobotVisualizer(robot, viewer, node)
        self._ghost = (
            None
            if frames.desired_positions is None
            else RobotVisualizer(robot, viewer, f"{node}/ghost", DESIRED_COLOR)
        )
        self._arrows: list[ForceArrow] = []
        if frames.force is not None:
            joints = [robot.model.getJointId(name) for name in robot.actuated]
            self._arrows = [
                ForceArrow(viewer[self.body.joint_node(joint)], robot.point_of_force, axis)
                for joint, axis in zip(joints, _axes_of_slides(robot), strict=True)
            ]

    def perform(self, frames: Frames, meters_per_newton: float) -> list[dict[str, Any]]:
        """Set the pose of the first frame; return the animations through all frames."""
        seconds = frames.time - frames.time[0]
        configurations = self._robot.configuration(frames.positions)
        clips = self.body.clips(configurations, seconds)
        self.body.display(configurations[0])
        if self._ghost is not None and frames.desired_positions is not None:
            desired = self._robot.configuration(frames.desired_positions)
            clips += self._ghost.clips(desired, seconds)
            self._ghost.display(desired[0])
        if frames.force is not None:
            for arrow, force in zip(self._arrows, frames.force.T, strict=True):
                clips += arrow.place(meters_per_newton * force, seconds)
        self._draw_path("actual", frames.tip, Flat(ACTUAL_COLOR), TRACE_RADIUS)
        self._draw_path(
            "desired", frames.desired_tip, Flat(DESIRED_COLOR, opacity=0.5), 2.0 * TRACE_RADIUS
        )
        if frames.desired_tip is not None:
            target = self._viewer[f"{self._node}/target"]
            target.set_object(geometry.Sphere(4.0 * TRACE_RADIUS), Flat(DESIRED_COLOR))
            target.set_transform(pin.SE3(np.eye(3), frames.desired_tip[0]).homogeneous)
            clips.append(clip(target.path.lower(), seconds, {"position": frames.desired_tip}))
        return [one for one in clips if one["clip"]["tracks"]]

    def _draw_path(self, name: str, path: Array | None, material: Flat, radius: float) -> None:
        node = self._viewer[f"{self._node}/{name}"]
        node.delete()
        if path is None:
            return
        distinct = path[np.append(True, np.linalg.norm(np.diff(path, axis=0), axis=1) > 1e-6)]
        if len(distinct) > 1:
            node.set_object(Tube(distinct.round(5), radius), material)


class Scene:
    """Robots on a floor, in one pose or in motion.

    It can be written to a file or shown in a notebook.

    Parameters
    ----------
    robot : robot from :func:`psp3.load`
        What to show.

    Notes
    -----
    A scene that is the last value of a notebook's cell is displayed. The whole scene is in the
    output, so it works on a JupyterHub and in exported pages, which cannot reach a local server.
    """

    def __init__(self, robot: Robot) -> None:
        checked_robot(robot)
        self.robot = robot
        self._commands = DrawingCommands()
        self._viewer = meshcat.Visualizer(window=self._commands)
        self._performers: list[_Performer] = []
        self._cast: tuple[Any, ...] | None = None

    def show(
        self,
        positions: ArrayLike,
        *,
        desired: ArrayLike | None = None,
        force: ArrayLike | None = None,
    ) -> Self:
        """Show the robot at rest.

        Parameters
        ----------
        positions : (n,) array_like
            Positions of the actuated joints [m or rad]; for the 3-PSP its nut heights.
        desired : (3,) array_like, optional
            Positions of a pose to show as a translucent ghost [m], which is visible where it
            differs from the robot.
        force : (n,) array_like, optional
            Forces of the sliding motors to show as arrows along them [N]; for the 3-PSP those of
            the screws on the nuts, positive upward.

        Returns
        -------
        Scene
            The scene itself.

        Raises
        ------
        InvalidArray
            If positions or forces are not finite, or not one number for each motor.
        UnreachablePose
            If the positions require an arm length that is not positive.
        InvalidValue
            If a force is given for a robot with motors that do not slide.
        """
        if force is not None and not _is_driven_by_slides(self.robot):
            raise InvalidValue(
                "force",
                force,
                "left out: arrows are drawn along sliding motors only, and this robot has others",
            )
        # Checked before anything is drawn, so an error leaves the scene unchanged.
        pose = self._checked_pose("positions", positions)
        ghost = None if desired is None else self._checked_pose("desired", desired)[None]
        self._perform(
            {
                "": Frames(
                    np.zeros(1),
                    pose[None],
                    desired_positions=ghost,
                    force=None
                    if force is None
                    else one_row("force", force, len(self.robot.actuated))[None],
                )
            }
        )
        return self

    def _checked_pose(self, name: str, positions: ArrayLike) -> Array:
        """Return a pose after checking that the robot can take it."""
        pose = one_row(name, positions, len(self.robot.reference))
        self.robot.configuration(pose)
        return pose

    def animate(
        self,
        motions: Result | Trajectory | Mapping[str, Result] | Mapping[str, Result | Trajectory],
        duration: float | None = None,
    ) -> Self:
        """Show simulated or desired motion in real time.

        For a result, the scene shows the robot, the desired pose as a translucent ghost, the paths
        of the tip and of the desired tip, the screw forces as arrows, and the tip's distance from
        its desired position as a number. For a trajectory it shows a robot that follows it exactly,
        and the path of the tip. If the motors do not command all coordinates, no desired pose is
        shown, and on a trajectory the other coordinates stay constant.

        Parameters
        ----------
        motions : Result, Trajectory, or mapping of str to these
            A result of :func:`psp3.simulate`, a trajectory, or several by name: their robots are
            side by side, each under its name.
        duration : float, optional
            Time to follow trajectories [s]; by default until they rest. Results have the time of
            their simulation.

        Returns
        -------
        Scene
            The scene itself.

        Raises
        ------
        InvalidValue
            If there is no motion, if a result has no samples, or if a trajectory never rests and no
            duration is given.
        """
        if duration is not None:
            checked_positive("duration", duration)
        named: dict[str, Result | Trajectory] = (
            dict(motions) if isinstance(motions, Mapping) else {"": motions}
        )
        samples = {
            name: len(motion.t) for name, motion in named.items() if isinstance(motion, Result)
        }
        for motion in named.values():
            if not isinstance(motion, Result) and not callable(motion):
                raise InvalidValue("motions", motion, "results, or trajectories")
        if not named or min(samples.values(), default=1) == 0:
            raise InvalidValue(
                "motions",
                samples,
                "one simulation result or more, none of them empty (number of samples by name)",
            )
        frames = {
            name: _of_all_coordinates(self.robot, _without_missing_tip(frames_of(motion, duration)))
            for name, motion in named.items()
        }
        if not _is_driven_by_slides(self.robot):
            # Torques are not drawn as arrows.
            frames = {name: one._replace(force=None) for name, one in frames.items()}
        self._perform(frames)
        return self

    def html(self) -> str:
        """Return the scene as one page that needs no network."""
        return page(self._commands.as_json(), self.robot.title)

    def write_html(self, path: str | Path) -> None:
        """Write the scene to a file that any browser opens, without a network.

        Parameters
        ----------
        path : path
            The file, conventionally ``.html``.
        """
        write_text(self.html(), path)

    def _repr_html_(self) -> Markup:
        # Compression reduces a scene in the notebook's file to a third; the frame decompresses it.
        packed = base64.b64encode(gzip.compress(self.html().encode(), mtime=0)).decode()
        unpack = Markup(
            f'const packed = Uint8Array.from(atob("{packed}"), (letter) => letter.charCodeAt(0));'
            "new Response(new Blob([packed]).stream().pipeThrough(new "
            'DecompressionStream("gzip"))).text().then((page) => '
            "{ document.open(); document.write(page); document.close(); })"
        )
        return element(
            "iframe",
            srcdoc=element("script", unpack),
            sandbox="allow-scripts",
            title=f"{self.robot.title} in 3D",
            style=f"width: 100%; height: {FRAME_HEIGHT}px; border: 0",
        )

    def _perform(self, frames: Mapping[str, Frames]) -> None:
        self._animate([])
        largest = max(
            (np.abs(one.force).max() for one in frames.values() if one.force is not None),
            default=0.0,
        )
        newtons = newtons_per_decimeter(largest)
        self._set_up(frames, newtons)
        animations: list[dict[str, Any]] = []
        for performer, of_robot in zip(self._performers, frames.values(), strict=True):
            animations += performer.perform(of_robot, 0.1 / newtons)
        self._animate(animations)

    def _set_up(self, frames: Mapping[str, Frames], newtons: float) -> None:
        """Set up one robot for each name, side by side, and the camera before them.

        Nothing is done if they are already there.
        """
        in_motion = any(len(one.time) > 1 for one in frames.values())
        shown = tuple((name, *(part is not None for part in one)) for name, one in frames.items())
        cast = (
            shown,
            in_motion,
            newtons if any(one.force is not None for one in frames.values()) else None,
        )
        if not in_motion and cast == self._cast:
            return
        self._viewer["robots"].delete()
        self._performers = []
        rightward = np.cross([0.0, 0.0, 1.0], VIEW_DIRECTION) / np.hypot(*VIEW_DIRECTION[:2])
        points, nearby, texts = [], [], []
        for number, (name, of_robot) in enumerate(frames.items()):
            performer = _Performer(self.robot, self._viewer, f"robots/{number}", of_robot)
            corners = performer.body.corners(self.robot.q0)
            spacing = max(
                SPACING, 1.1 * float(np.ptp(corners @ rightward, axis=0)) if len(corners) else 0.0
            )
            offset = (number - 0.5 * (len(frames) - 1)) * spacing * rightward
            self._viewer[f"robots/{number}"].set_transform(pin.SE3(np.eye(3), offset).homogeneous)
            corners = corners + offset
            points.append(corners)
            nearby += [
                performer.body.corners(q, moving_only=True) + offset
                for q in self._extremes(of_robot)
            ]
            error = tracking_error(self.robot, of_robot)
            if name or error:
                above = np.append(offset[:2], corners[:, 2].max() + 0.1)
                points.append(above[None])
                text: dict[str, Any] = {"text": printable(name), "point": above.round(4)}
                seconds = float(of_robot.time[-1] - of_robot.time[0])
                if error:
                    text["error"] = error.as_command(seconds)
                texts.append(text)
            self._performers.append(performer)
        self._cast = cast
        self._commands.add(
            {
                "type": "stage",
                "points": _hull(np.concatenate(points)),
                "nearby": _hull(np.concatenate(nearby)) if in_motion else [],
                "direction": VIEW_DIRECTION,
                "field_of_view": FIELD_OF_VIEW,
                "texts": texts,
                "legend": _legend(frames, newtons),
            }
        )

    def _extremes(self, frames: Frames) -> Array:
        """Return the configurations with the highest and lowest nuts, actual or desired."""
        positions = (
            frames.positions
            if frames.desired_positions is None
            else np.concatenate([frames.positions, frames.desired_positions])
        )
        return self.robot.configuration(
            positions[np.unique([positions.argmin(axis=0), positions.argmax(axis=0)])]
        )

    def _animate(self, animations: list[dict[str, Any]]) -> None:
        endless = 1e9
        options = {"play": True, "repetitions": endless}
        self._commands.add(
            {"type": "set_animation", "path": "", "animations": animations, "options": options}
        )


def _of_all_coordinates(robot: Robot, frames: Frames) -> Frames:
    """Return frames with positions of all coordinates from those of the commanded ones.

    Passive coordinates have no desired motion, so there is no desired pose or tip.
    """
    if robot.commanded == len(robot.coordinates_v):
        return frames
    return frames._replace(
        positions=frames.positions
        if frames.positions.shape[1] == len(robot.reference)
        else completed(robot, frames.positions),
        desired_positions=None,
        desired_tip=None,
    )


def _without_missing_tip(frames: Frames) -> Frames:
    """Return frames without a tip if its position is NaN, because the robot has none."""
    if frames.tip is None or np.isfinite(frames.tip).all():
        return frames
    return frames._replace(tip=None, desired_tip=None)


def _legend(frames: Mapping[str, Frames], newtons: float) -> list[dict[str, str]]:
    """Return the entries of the legend.

    Each entry has its own mark, so that none is distinguished by color alone.
    """
    entries = {
        "desired_positions": ("desired pose", DESIRED_COLOR, "area"),
        "desired_tip": ("desired tip", DESIRED_COLOR, "sleeve"),
        "tip": ("tip", ACTUAL_COLOR, "line"),
        "force": (f"screw force, 10 cm for {newtons:g} N", FORCE_COLOR, "arrow"),
    }
    return [
        {"text": text, "color": color, "mark": mark}
        for part, (text, color, mark) in entries.items()
        if any(getattr(one, part) is not None for one in frames.values())
    ]


def _hull(points: Array) -> Array:
    """Return the corners of the convex hull; where rounding makes it flat, of the bounding box."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        corners: Array = points[ConvexHull(points).vertices].round(3)
    except QhullError:
        ends = zip(points.min(axis=0), points.max(axis=0), strict=True)
        corners = np.array(list(itertools.product(*ends))).round(3)
    return corners


def _is_driven_by_slides(robot: Robot) -> bool:
    """Return whether all motors of a robot push along a line, which an arrow can show."""
    turns = rotating(robot.model)[robot.actuated_v]
    # A motor on a tendon is not at a joint.
    return len(turns) == len(robot.actuated) and not turns.any()


def _axes_of_slides(robot: Robot) -> Array:
    """Return the directions (n, 3) of a robot's sliding motors, in the axes of their joints."""
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, robot.q0)
    axes = []
    for name, column in zip(robot.actuated, robot.actuated_v, strict=True):
        jacobian = pin.getJointJacobian(
            robot.model, data, robot.model.getJointId(name), pin.ReferenceFrame.LOCAL
        )
        axes.append(jacobian.reshape(6, robot.model.nv)[:3, column])
    return np.array(axes)


def page(commands: str = LISTEN, name: str = "Robot") -> Markup:
    """Return the page with MeshCat and commands in JSON; ``name`` is its title."""
    return filled(
        Path(__file__).with_suffix(".html").read_text(encoding="utf-8"),
        {
            "NAME": name,
            "POLICY": POLICY,
            "COMMANDS": data_from_json(commands),
            "MESHCAT": Markup(meshcat_script()),
        },
    )


def write_animation(robot: Robot, results: Result | Mapping[str, Result], path: str | Path) -> None:
    """Write a simulated motion to a file that any browser opens, without a network.

    Parameters
    ----------
    robot : robot from :func:`psp3.load`
        The robot that was simulated.
    results : Result or mapping of str to Result
        One result of :func:`psp3.simulate`, or several by name: their robots stand side by side,
        each under its name.
    path : path
        The file, conventionally ``.html``.

    Raises
    ------
    InvalidValue
        If there is no result, or one without a sample.
    """
    Scene(robot).animate(results).write_html(path)

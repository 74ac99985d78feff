"""Show the robot in the browser with MeshCat: poses, simulated motion, files that need no network, and a live viewer.

A scene is a list of MeshCat's drawing commands. :class:`Scene` collects them with Pinocchio's MeshCat visualizer and puts them
in one page, ``visualize.html``, which holds MeshCat itself, the lights and the camera. Written to a file, the page carries the
commands; served by :class:`Viewer`, it receives them one by one. MeshCat's own server is not used because it listens on all
network interfaces; the viewer listens on this machine only.
"""

from __future__ import annotations

import html
import json
import queue
import threading
import warnings
from collections.abc import Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.arrays import Array
from psp3.errors import InvalidValue

with warnings.catch_warnings():
    # MeshCat 0.3.2 imports a module of pyzmq that is deprecated.
    warnings.simplefilter("ignore", DeprecationWarning)
    import meshcat
    import meshcat.geometry
    from pinocchio.visualize import MeshcatVisualizer

if TYPE_CHECKING:
    from psp3.closed_loop_robot import ClosedLoopRobot
    from psp3.simulation import Result

FRAME_RATE = 30.0
"""Frames per second of an animation; the browser interpolates between them."""

VIEW_DIRECTION = (0.47, 0.76, 0.44)
"""From the robot toward the camera: between arms 1 and 2, so that the third column stands behind the star."""

FIELD_OF_VIEW = 24.0
"""Vertical angle that the camera sees [degrees]."""

SPACING = 0.72
"""Distance between robots that stand side by side [m]."""

DESIRED_COLOR, ACTUAL_COLOR = "#0b7285", "#c2255c"

TRACE_RADIUS = 0.0014
"""WebGL draws lines one pixel wide, so the tip's path is a tube of this radius [m]; the desired one is a translucent sleeve of twice it."""

NUMPY_TYPES = {0x12: np.uint8, 0x15: np.int32, 0x16: np.uint32, 0x17: np.float32}
"""Types of the arrays in MeshCat's commands, by their MessagePack code."""


class _Satin(meshcat.geometry.MeshPhongMaterial):  # type: ignore[misc]
    """Machined, anodized or painted metal: every part of the robot has this finish, in its own color."""

    def __init__(self, color: ArrayLike) -> None:
        super().__init__(color=_hexadecimal(color), specular=0x303030, shininess=50)


class _Flat(meshcat.geometry.MeshBasicMaterial):  # type: ignore[misc]
    """A color that no light changes, given as ``#rrggbb``."""

    def __init__(self, color: str, opacity: float = 1.0) -> None:
        super().__init__(color=_hexadecimal([int(color[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]), opacity=opacity)


class _Tube(meshcat.geometry.Geometry):  # type: ignore[misc]
    """A tube along a path of shape (n, 3)."""

    def __init__(self, path: Array, radius: float) -> None:
        super().__init__()
        self.path, self.radius = path, radius

    def lower(self, object_data: Any) -> dict[str, Any]:
        segments = len(self.path)
        curve = {
            "type": "CatmullRomCurve3",
            "curveType": "centripetal",
            "tension": 0.5,
            "closed": False,
            "arcLengthDivisions": segments,
            "points": self.path.tolist(),
        }
        return {
            "uuid": self.uuid,
            "type": "TubeGeometry",
            "path": curve,
            "tubularSegments": segments,
            "radius": self.radius,
            "radialSegments": 8,
            "closed": False,
        }


def _hexadecimal(color: ArrayLike) -> int:
    """Return an sRGB color, given by numbers in [0, 1], as three.js wants it: in linear light, 0xRRGGBB."""
    red, green, blue = (int(np.rint(255.0 * value**2.2)) for value in np.asarray(color, dtype=float)[:3])
    return (red << 16) + (green << 8) + blue


def _as_plain_data(value: Any) -> Any:
    """Turn what JSON does not know, packed arrays of MeshCat and numbers of NumPy, into lists and numbers."""
    if hasattr(value, "data") and hasattr(value, "type"):
        return np.frombuffer(value.data, NUMPY_TYPES[value.type]).tolist()
    return np.asarray(value).tolist()


class _Commands:
    """The commands that build the scene as it is now, in JSON; MeshCat takes it for the connection to its server."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._current: dict[tuple[str, ...], str] = {}
        self._subscribers: list[queue.Queue[str | None]] = []

    def send(self, command: Any) -> None:
        """Take one of MeshCat's command objects."""
        self.add(command.lower())

    def add(self, command: dict[str, Any]) -> None:
        """Take a command; it replaces an earlier one to the same effect and reaches every subscriber."""
        text = json.dumps(command, default=_as_plain_data, separators=(",", ":"))
        path = command.get("path", "")
        with self._lock:
            if command["type"] == "delete":
                for key in [key for key in self._current if f"{key[1]}/".startswith(f"{path}/")]:
                    del self._current[key]
            else:
                self._current[command["type"], path, command.get("property", "")] = text
            for subscriber in self._subscribers:
                subscriber.put(text)

    def as_json(self) -> str:
        """Return all commands as one JSON array."""
        with self._lock:
            return f"[{','.join(self._current.values())}]"

    def subscribe(self) -> queue.Queue[str | None]:
        """Return a queue of all commands up to now and, as they come, all further ones; None ends it."""
        subscriber: queue.Queue[str | None] = queue.Queue()
        with self._lock:
            for text in self._current.values():
                subscriber.put(text)
            self._subscribers.append(subscriber)
        return subscriber

    def unsubscribe(self, subscriber: queue.Queue[str | None]) -> None:
        """Send nothing more to a queue."""
        with self._lock:
            self._subscribers.remove(subscriber)

    def end(self) -> None:
        """End all subscriptions."""
        with self._lock:
            for subscriber in self._subscribers:
                subscriber.put(None)


class _RobotVisualizer(MeshcatVisualizer):  # type: ignore[misc]
    """Pinocchio's visualizer with one node for each joint, so that a motion is one track a joint and not one a shape."""

    def joint_node(self, joint: int) -> str:
        return f"{self.viewerVisualGroupName}/{self.model.names[joint]}"

    @property
    def joints(self) -> list[int]:
        """Joints that carry a shape."""
        return sorted({shape.parentJoint for shape in self.visual_model.geometryObjects})

    def getViewerNodeName(self, geometry_object: Any, geometry_type: Any) -> str:
        return f"{self.joint_node(geometry_object.parentJoint)}/{geometry_object.name}"

    def loadViewerGeometryObject(self, geometry_object: Any, geometry_type: Any, color: Any = None) -> None:
        node = self.viewer[self.getViewerNodeName(geometry_object, geometry_type)]
        if isinstance(geometry_object.geometry, coal.Box | coal.Cylinder | coal.Sphere):
            node.set_object(self.loadPrimitive(geometry_object), _Satin(geometry_object.meshColor))
        else:
            super().loadViewerGeometryObject(geometry_object, geometry_type, color)
        node.set_transform(geometry_object.placement.homogeneous @ np.diag([*geometry_object.meshScale, 1.0]))

    def updatePlacements(self, geometry_type: Any) -> None:
        for joint in self.joints:
            self.viewer[self.joint_node(joint)].set_transform(self.data.oMi[joint].homogeneous)

    def corners(self, q: Array) -> Array:
        """Return the corners of the boxes around all shapes, (n, 3) [m]."""
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateGeometryPlacements(self.model, self.data, self.visual_model, self.visual_data)
        corners = []
        for shape, placement in zip(self.visual_model.geometryObjects, self.visual_data.oMg, strict=True):
            shape.geometry.computeLocalAABB()
            box = np.array([shape.geometry.aabb_local.min_, shape.geometry.aabb_local.max_]) * shape.meshScale
            grid = np.stack(np.meshgrid(*box.T), axis=-1).reshape(-1, 3)
            corners.append(grid @ placement.rotation.T + placement.translation)
        return np.concatenate(corners)


class Scene:
    """The robot on a floor, in one pose or in motion, ready to be written to a file or shown in a notebook.

    Parameters
    ----------
    robot : robot from :func:`psp3.load`
        What to show.
    """

    def __init__(self, robot: ClosedLoopRobot) -> None:
        self.robot = robot
        self._commands = _Commands()
        self._viewer = meshcat.Visualizer(window=self._commands)
        self._visualizers: list[_RobotVisualizer] = []
        self._names: tuple[str, ...] = ()
        self._in_motion = False

    def show(self, heights: ArrayLike) -> None:
        """Show the robot at rest.

        Parameters
        ----------
        heights : (3,) array_like
            Nut heights [m].

        Raises
        ------
        InvalidArray
            If the heights are not three finite numbers.
        UnreachablePose
            If they ask for an arm length that is not positive.
        """
        q = self.robot.configuration(np.reshape(heights, -1))
        self._arrange(("",), in_motion=False)
        self._visualizers[0].display(q)

    def animate(self, results: Result | Mapping[str, Result]) -> None:
        """Show a simulated motion in real time, with the paths of the tip and of the desired tip.

        Parameters
        ----------
        results : Result or mapping of str to Result
            One result of :func:`psp3.simulate`, or several by name: their robots stand side by side, each under its name.

        Raises
        ------
        InvalidValue
            If there is no result, or one without a sample.
        """
        named = dict(results) if isinstance(results, Mapping) else {"": results}
        samples = {name: len(result.t) for name, result in named.items()}
        if not samples or min(samples.values()) == 0:
            raise InvalidValue("results", samples, "one simulation result or more, none of them empty (number of samples by name)")
        self._arrange(tuple(named), in_motion=True)
        animations: list[dict[str, Any]] = []
        for visualizer, result in zip(self._visualizers, named.values(), strict=True):
            animations += self._motion(visualizer, result)
        self._animate(animations)

    def html(self) -> str:
        """Return the scene as one page that needs no network."""
        return _page(f"{self._commands.as_json()}.forEach(handle);".replace("</", "<\\/"))

    def write_html(self, path: str | Path) -> None:
        """Write the scene to a file that any browser opens, without a network.

        Parameters
        ----------
        path : path
            The file, conventionally ``.html``.
        """
        Path(path).write_text(self.html(), encoding="utf-8")

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self.html())}" style="width: 100%; height: 520px; border: 0"></iframe>'

    def _arrange(self, names: tuple[str, ...], in_motion: bool) -> None:
        """Set up one robot for each name, side by side, and the camera before them."""
        self._animate([])
        if (names, in_motion) == (self._names, self._in_motion):
            return
        self._names, self._in_motion = names, in_motion
        self._viewer["robots"].delete()
        self._visualizers = []
        rightward = np.cross([0.0, 0.0, 1.0], VIEW_DIRECTION) / np.hypot(*VIEW_DIRECTION[:2])
        points, texts = [], []
        for number, name in enumerate(names):
            visualizer = _RobotVisualizer(self.robot.model, visual_model=self.robot.visual_model)
            visualizer.initViewer(self._viewer)
            visualizer.loadViewerModel(f"robots/{number}")
            offset = (number - 0.5 * (len(names) - 1)) * SPACING * rightward
            self._viewer[f"robots/{number}"].set_transform(pin.SE3(np.eye(3), offset).homogeneous)
            corners = visualizer.corners(self.robot.q0) + offset
            points.append(corners)
            if name:
                above = np.append(offset[:2], corners[:, 2].max() + 0.1)
                points.append(above[None])
                texts.append({"text": name, "point": above.round(4)})
            self._visualizers.append(visualizer)
        legend = [{"text": "desired tip", "color": DESIRED_COLOR}, {"text": "tip", "color": ACTUAL_COLOR}] if in_motion else []
        self._commands.add(
            {
                "type": "stage",
                "points": np.unique(np.concatenate(points).round(3), axis=0),
                "direction": VIEW_DIRECTION,
                "field_of_view": FIELD_OF_VIEW,
                "texts": texts,
                "legend": legend,
            }
        )

    def _motion(self, visualizer: _RobotVisualizer, result: Result) -> list[dict[str, Any]]:
        """Draw the tip's paths; return the animation of every joint that moves and of the desired tip."""
        frames = max(2, round((result.t[-1] - result.t[0]) * FRAME_RATE) + 1)
        time = np.linspace(result.t[0], result.t[-1], frames)

        def at_frames(values: Array) -> Array:
            return np.stack([np.interp(time, result.t, column) for column in values.T], axis=-1)

        tip, desired_tip = at_frames(result.tip), at_frames(result.desired.tip)
        root = visualizer.viewerRootNodeName
        for name, path, radius, material in (
            ("actual", tip, TRACE_RADIUS, _Flat(ACTUAL_COLOR)),
            ("desired", desired_tip, 2.0 * TRACE_RADIUS, _Flat(DESIRED_COLOR, opacity=0.5)),
        ):
            distinct = path[np.append(True, np.linalg.norm(np.diff(path, axis=0), axis=1) > 1e-6)]
            self._viewer[f"{root}/{name}"].delete()
            if len(distinct) > 1:
                self._viewer[f"{root}/{name}"].set_object(_Tube(distinct.round(5), radius), material)
        marker = self._viewer[f"{root}/target"]
        marker.set_object(meshcat.geometry.Sphere(4.0 * TRACE_RADIUS), _Flat(DESIRED_COLOR))

        configurations = self.robot.configuration(at_frames(result.heights))
        placements: dict[int, list[Array]] = {joint: [] for joint in visualizer.joints}
        for q in configurations:
            pin.forwardKinematics(visualizer.model, visualizer.data, q)
            for joint, poses in placements.items():
                poses.append(pin.SE3ToXYZQUAT(visualizer.data.oMi[joint]))
        visualizer.display(configurations[0])
        marker.set_transform(pin.SE3(np.eye(3), desired_tip[0]).homogeneous)

        seconds = time - time[0]
        moving = [_clip(marker.path.lower(), seconds, {"position": desired_tip})]
        for joint, poses in placements.items():
            pose = np.array(poses)
            node = self._viewer[visualizer.joint_node(joint)]
            moving.append(_clip(node.path.lower(), seconds, {"position": pose[:, :3], "quaternion": pose[:, 3:]}))
        return [clip for clip in moving if clip["clip"]["tracks"]]

    def _animate(self, animations: list[dict[str, Any]]) -> None:
        endless = 1e9
        options = {"play": True, "repetitions": endless}
        self._commands.add({"type": "set_animation", "path": "", "animations": animations, "options": options})


def _clip(path: str, seconds: Array, tracks: Mapping[str, Array]) -> dict[str, Any]:
    """Return MeshCat's animation of a node, without the tracks that stand still."""
    types = {"position": "vector3", "quaternion": "quaternion"}
    moving = [
        {"name": f".{name}", "type": types[name], "times": seconds.round(4), "values": values.ravel().round(5)}
        for name, values in tracks.items()
        if np.ptp(values, axis=0).max() > 1e-6
    ]
    return {"path": path, "clip": {"name": "default", "fps": 1, "tracks": moving}}


def _page(script: str) -> str:
    """Return the page with MeshCat and a script that feeds it commands."""
    meshcat_script = Path(meshcat.__file__).with_name("viewer") / "dist" / "main.min.js"
    page = Path(__file__).with_suffix(".html").read_text(encoding="utf-8")
    # MeshCat last: the marks are then looked for in our own text only.
    return page.replace("/*COMMANDS*/", script).replace("/*MESHCAT*/", meshcat_script.read_text(encoding="utf-8"))


class _Server(ThreadingHTTPServer):
    """Serves the page and, on one long connection to each browser, the commands as server-sent events."""

    daemon_threads = True

    def __init__(self, port: int, commands: _Commands) -> None:
        super().__init__(("127.0.0.1", port), _Handler)
        self.commands = commands


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        if self.path == "/":
            self._answer("text/html; charset=utf-8")
            self.wfile.write(_page("listen();").encode())
        elif self.path == "/commands":
            self._answer("text/event-stream")
            self._stream()
        else:
            self.send_error(404)

    def _answer(self, content_type: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", content_type)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()

    def _stream(self) -> None:
        commands = self.server.commands.subscribe()
        try:
            while True:
                try:
                    text = commands.get(timeout=10.0)
                except queue.Empty:
                    # A comment, by which a browser that has left is noticed.
                    self.wfile.write(b":\n\n")
                    continue
                if text is None:
                    self.wfile.write(b'data: {"type":"end"}\n\n')
                    return
                self.wfile.write(f"data: {text}\n\n".encode())
        except ConnectionError:
            return
        finally:
            self.server.commands.unsubscribe(commands)

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing: the library never does."""


class Viewer(Scene):
    """A scene in the browser that follows what is done to it, served to this machine only.

    Use it as a context manager, or call :meth:`close`.

    Parameters
    ----------
    robot : robot from :func:`psp3.load`
        What to show.
    port : int
        Port to listen on; if it is taken, the next one that is free.

    Attributes
    ----------
    url : str
        What to open in the browser.
    """

    def __init__(self, robot: ClosedLoopRobot, port: int = 7000) -> None:
        super().__init__(robot)
        self._server = self._listen(port)
        self.url = f"http://127.0.0.1:{self._server.server_port}/"
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
        self._thread.start()

    def _listen(self, port: int) -> _Server:
        for candidate in range(port, port + 100):
            try:
                return _Server(candidate, self._commands)
            except OSError:
                continue
        any_free_port = 0
        return _Server(any_free_port, self._commands)

    def close(self) -> None:
        """Stop serving and free the port; the page in the browser keeps its last picture."""
        self._commands.end()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def write_animation(robot: ClosedLoopRobot, results: Result | Mapping[str, Result], path: str | Path) -> None:
    """Write a simulated motion to a file that any browser opens, without a network.

    Parameters
    ----------
    robot : robot from :func:`psp3.load`
        The robot that was simulated.
    results : Result or mapping of str to Result
        One result of :func:`psp3.simulate`, or several by name: their robots stand side by side, each under its name.
    path : path
        The file, conventionally ``.html``.

    Raises
    ------
    InvalidValue
        If there is no result, or one without a sample.
    """
    scene = Scene(robot)
    scene.animate(results)
    scene.write_html(path)

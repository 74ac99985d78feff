"""A map of a robot's poses.

The map has the status of each pose and its distance from limits and singularities. It can be saved
to a file.

:class:`psp3.kinematics.workspace.Workspace` creates maps, and :mod:`psp3.plots.workspace` draws
them.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.bounded_files import LARGEST_NUMBERS, not_read
from fuzzy2.support.described import Described
from fuzzy2.support.json_text import parse_json
from fuzzy2.support.text_files import read_text, write_text
from psp3.checks import Array, checked_count, checked_path
from psp3.errors import InvalidArray, InvalidMapFile, InvalidValue, UnknownName
from psp3.kinematics.singularities import Measures
from psp3.kinematics.tasks import checked_task

FORMAT = "psp3 map 1"
"""Tag that identifies the file format."""

COORDINATES = ("task", "actuators")
"""The kinds of coordinates over which a workspace can be mapped."""

VECTORS = ("configuration", "position")
"""Fields of a map that hold several numbers per pose."""


RANGES = {
    "status": (0.0, 4.0),
    "margin": (-math.inf, math.inf),
    "configuration": (-1e300, 1e300),
    "position": (-1e300, 1e300),
    "constraint": (0.0, 1.0),
    "actuation": (0.0, 1.0 + 1e-9),
    "end_effector": (0.0, 1e300),
    "closure_condition": (1.0, math.inf),
    "condition": (1.0, math.inf),
    "manipulability": (0.0, math.inf),
    "orientation": (-1.0, 1.0),
    "assembly": (-1.0, 1.0),
    "mobility": (0.0, 1e9),
}
"""The allowed range of the numbers in each field of a map."""

ALWAYS = ("status", "margin", *VECTORS, "constraint", "actuation", "assembly", "mobility")
"""Fields that have a value for every reachable pose."""

WHOLE = ("status", "orientation", "assembly", "mobility")
"""Fields of whole numbers."""


class Status(IntEnum):
    """The status of a pose, from unreachable to usable."""

    UNREACHABLE = 0
    """The loops cannot be closed."""
    BEYOND_LIMIT = 1
    """A joint, actuated or not, would be beyond its limits."""
    SINGULAR = 2
    """At a singularity, or closer to one than allowed."""
    APART = 3
    """The pose itself is good, but singularities or limits separate it from the usable poses."""
    USABLE = 4
    """None of these; usable poses are connected with each other."""


@dataclass(frozen=True, eq=False, repr=False)
class KinematicMap(Described):
    """A robot's poses over a grid.

    The first dimensions of each array are those of the grid. Numbers of unreachable poses are NaN.

    Parameters
    ----------
    robot, frame : str
        Names of the robot's model and of the frame.
    task : tuple of str
        Coordinates of the frame's velocity that matter.
    over : {"task", "actuators"}
        The kind of the grid's coordinates.
    grid : dict
        Ascending values of each coordinate [m or rad]; the order of the coordinates is that of the
        arrays' dimensions.
    held : dict
        Values of the coordinates that do not vary [m or rad].
    units : dict
        Unit of every coordinate, ``"m"`` or ``"rad"``.
    length : float
        Characteristic length [m].
    singular_below : float
        Measures below which a pose counts as singular, see
        :class:`psp3.kinematics.workspace.Workspace`.
    status : (...,) ndarray of int
        See :class:`Status`.
    configuration : (..., nq) ndarray
        Pinocchio configurations.
    position : (..., 3) ndarray
        Position of the frame in base axes [m].
    margin : (...,) ndarray
        Distance to its limit of the joint that is nearest to one, negative beyond the limit; for a
        hinge, the arc at the characteristic length [m]. Infinite without limits.
    measures : Measures
        See :class:`psp3.kinematics.singularities.Measures`.
    """

    robot: str
    frame: str
    task: tuple[str, ...]
    over: str
    grid: dict[str, Array]
    held: dict[str, float]
    units: dict[str, str]
    length: float
    singular_below: float
    status: NDArray[np.int64]
    configuration: Array
    position: Array
    margin: Array
    measures: Measures

    def _facts(self) -> dict[str, Any]:
        return {
            "robot": self.robot,
            "frame": self.frame,
            "task": self.task,
            "grid": tuple(f"{name}: {len(values)}" for name, values in self.grid.items()),
            "held": tuple(f"{name} = {value:.4g}" for name, value in self.held.items()) or None,
        }

    def __post_init__(self) -> None:
        shape = tuple(values.size for values in self.grid.values())
        for name, array in self.arrays().items():
            if array.shape != shape + (array.shape[-1:] if name in VECTORS else ()):
                raise InvalidArray(name, f"{shape}, that of the grid,", array)

    def arrays(self) -> dict[str, Array]:
        """Return all arrays by name, including the measures."""
        mine = {name: getattr(self, name) for name in ("status", "margin", *VECTORS)}
        return mine | self.measures._asdict()

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """Whether the loops can be closed, (...,) of bool."""
        return self.status > Status.UNREACHABLE

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Whether a pose is usable: within limits, and neither near nor behind a singularity.

        An array (...,) of bool.
        """
        usable: NDArray[np.bool_] = self.status == Status.USABLE
        return usable

    def save(self, path: str | Path) -> Path:
        """Write the map as JSON; :meth:`load` recovers all bits of the numbers.

        Raises
        ------
        InvalidValue
            If the path is neither text nor a path.
        fuzzy2.errors.FileNotWritten
            If the file cannot be written; an existing file then remains.
        """
        target = checked_path("path", path)
        content = {
            "format": FORMAT,
            "robot": self.robot,
            "frame": self.frame,
            "task": self.task,
            "over": self.over,
            "units": self.units,
            "length": self.length,
            "singular_below": self.singular_below,
            "held": self.held,
            "grid": {name: values.tolist() for name, values in self.grid.items()},
            "arrays": {name: _written(array) for name, array in self.arrays().items()},
        }
        write_text(json.dumps(content, allow_nan=False, ensure_ascii=False) + "\n", target)
        return target

    @classmethod
    def load(cls, path: str | Path, largest: int = LARGEST_NUMBERS) -> KinematicMap:
        """Read a map that :meth:`save` wrote.

        Parameters
        ----------
        path : path
            The file.
        largest : int
            Largest allowed size [bytes].

        Raises
        ------
        InvalidValue
            If the path is neither text nor a path.
        InvalidMapFile
            If the file is missing, too large, or not a complete map of this version.
        """
        path = checked_path("path", path)
        try:
            content = parse_json(read_text(path, checked_count("largest", largest)))
        except OSError as error:
            raise InvalidMapFile(path, not_read(error)) from error
        except ValueError as error:
            raise InvalidMapFile(path, f"is not JSON ({error})") from error
        return cls(**_Reader(path).fields(content))


def _written(array: Array) -> list[Any]:
    """Return the numbers of an array as a list; NaN becomes null, infinity a word."""
    return [
        None if math.isnan(value) else value if math.isfinite(value) else str(value)
        for value in array.ravel().tolist()
    ]


class _Reader:
    """Checks the content of a file piece by piece, and names the first wrong piece."""

    def __init__(self, path: str | Path) -> None:
        self._path = path

    def fields(self, content: Any) -> dict[str, Any]:
        """Return the arguments of a map."""
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            found = content.get("format") if isinstance(content, dict) else type(content).__name__
            self._refuse(f"has format {found!r}, this version reads {FORMAT!r}")
        self._keys(
            content,
            "the file",
            (
                "format",
                "robot",
                "frame",
                "task",
                "over",
                "units",
                "length",
                "singular_below",
                "held",
                "grid",
                "arrays",
            ),
        )
        grid = {
            name: self._axis(name, values)
            for name, values in self._mapping("grid", content["grid"]).items()
        }
        if not grid:
            self._refuse("has a grid without coordinates")
        held = {
            name: self._number(f"held[{name!r}]", value)
            for name, value in self._mapping("held", content["held"]).items()
        }
        units = self._mapping("units", content["units"])
        self._keys(units, "units", (*grid, *held))
        for name, unit in units.items():
            if unit not in ("m", "rad"):
                self._refuse(f"has the unit {unit!r} for {name!r}, not 'm' or 'rad'")
        try:
            task = checked_task(
                [self._text("task", name) for name in self._list("task", content["task"])]
            )
        except (UnknownName, InvalidValue) as error:
            self._refuse(f"has a task that is none ({error})")
        if content["over"] not in COORDINATES:
            self._refuse(f"has over {content['over']!r}, not {' or '.join(map(repr, COORDINATES))}")
        length, singular_below = (
            self._number(name, content[name]) for name in ("length", "singular_below")
        )
        if length <= 0.0 or singular_below < 0.0:
            self._refuse(
                f"has length {length} and singular_below {singular_below}; they are positive, "
                "and not negative"
            )
        return {
            "robot": self._text("robot", content["robot"]),
            "frame": self._text("frame", content["frame"]),
            "task": task,
            "over": content["over"],
            "grid": grid,
            "held": held,
            "units": units,
            "length": length,
            "singular_below": singular_below,
            **self._arrays(content["arrays"], tuple(values.size for values in grid.values())),
        }

    def _refuse(self, reason: str) -> NoReturn:
        raise InvalidMapFile(self._path, reason)

    def _keys(self, mapping: dict[str, Any], what: str, names: tuple[str, ...]) -> None:
        missing, strange = (
            [name for name in names if name not in mapping],
            [name for name in mapping if name not in names],
        )
        if missing or strange:
            verb, keys = ("lacks", missing) if missing else ("has the unknown", strange)
            self._refuse(f"{what} {verb} {', '.join(map(repr, keys))}")

    def _mapping(self, name: str, value: Any) -> dict[str, Any]:
        if not isinstance(value, dict):
            self._refuse(f"has {name} of type {type(value).__name__}, not an object")
        return value

    def _list(self, name: str, value: Any) -> list[Any]:
        if not isinstance(value, list):
            self._refuse(f"has {name} of type {type(value).__name__}, not a list")
        return value

    def _text(self, name: str, value: Any) -> str:
        if not isinstance(value, str):
            self._refuse(f"has {name} {value!r}, not a text")
        return value

    def _number(self, name: str, value: Any) -> float:
        if not isinstance(value, int | float) or isinstance(value, bool) or not abs(value) < 1e300:
            self._refuse(f"has {name} {str(value)[:40]!r}, not a number")
        return float(value)

    def _axis(self, name: str, values: Any) -> Array:
        axis = np.array(
            [
                self._number(f"grid[{name!r}]", value)
                for value in self._list(f"grid[{name!r}]", values)
            ]
        )
        if axis.size < 2 or not (np.diff(axis) > 0.0).all():
            self._refuse(f"has grid[{name!r}] that is not two numbers or more, ascending")
        return axis

    def _array(self, name: str, values: Any, shape: tuple[int, ...]) -> Array:
        count = math.prod(shape)
        if (
            not isinstance(values, list)
            or len(values) == 0
            or len(values) % count
            or (name not in VECTORS and len(values) != count)
        ):
            self._refuse(
                f"has {name} that is not a list of one entry for each of the {count} poses"
            )
        row = [
            math.nan
            if value is None
            else float(value)
            if value in ("inf", "-inf")
            else self._number(name, value)
            for value in values
        ]
        return np.array(row).reshape(shape + ((len(row) // count,) if name in VECTORS else ()))

    def _arrays(self, content: Any, shape: tuple[int, ...]) -> dict[str, Any]:
        mapping = self._mapping("arrays", content)
        self._keys(mapping, "arrays", ("status", "margin", *VECTORS, *Measures._fields))
        arrays = {name: self._array(name, values, shape) for name, values in mapping.items()}
        for name in WHOLE:
            if not (np.isnan(arrays[name]) | (arrays[name] == np.round(arrays[name]))).all():
                self._refuse(f"has {name} that is not a whole number")
        reached = arrays["status"] > Status.UNREACHABLE
        for name, (least, most) in RANGES.items():
            values = arrays[name].reshape(*shape, -1)
            if not ((values >= least) & (values <= most) | np.isnan(values)).all():
                self._refuse(f"has {name} outside {least:g} to {most:g}")
            # At a constraint singularity some measures have no value.
            if (np.isfinite(values[~reached]).any() and name != "status") or (
                name in ALWAYS and np.isnan(values[reached]).any()
            ):
                self._refuse(f"has {name} where there is no pose, or none where there is one")
        if arrays["position"].shape[-1] != 3 or np.isnan(arrays["status"]).any():
            self._refuse("has positions that are not three numbers, or poses without a status")
        measures = Measures(*(arrays.pop(name) for name in Measures._fields))
        return arrays | {"status": arrays["status"].astype(np.int64), "measures": measures}

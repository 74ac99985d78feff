"""Result of a simulation: samples, and their file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.bounded_files import not_read
from fuzzy2.support.described import Described
from fuzzy2.support.text_files import written_whole
from psp3.checks import Array, checked_count, checked_path
from psp3.errors import InvalidResultFile
from psp3.simulation.array_files import LARGEST, arrays_of
from psp3.trajectories.motion import Motion

FORMAT = "psp3-result-2"
"""Format mark of result files; a file with another mark is refused."""

JOINTS = -1
"""Placeholder for the number of actuated joints in a shape."""

POSITIONS = "heights"
"""Name of positions in files, from the time when the 3-PSP was the only robot."""

_ARRAYS: dict[str, tuple[int, ...]] = {
    "t": (),
    POSITIONS: (JOINTS,),
    "speeds": (JOINTS,),
    "torque": (JOINTS,),
    "tip": (3,),
}
"""Arrays of every result: shape of a sample."""

_DESIRED = tuple(f"desired_{POSITIONS if name == 'positions' else name}" for name in Motion._fields)
"""Arrays of the desired motion in every result, in the order of its fields."""

_OWN_WIDTH = (POSITIONS, "torque", _DESIRED[0])
"""Arrays of any width. There are as many speeds as positions, or one less with a floating base;
every other array has the width of the one it belongs to.
"""

REPORTED: dict[str, tuple[tuple[int, ...], type]] = {
    "covered": ((), np.bool_),
    "fell_back": ((), np.bool_),
    "torque_interval": ((JOINTS, 2), np.float64),
}
"""Reports that a controller may give on its last call: shape and type of each."""


@dataclass(frozen=True, repr=False)
class Result(Described):
    """The course of a simulation, sampled at every control period.

    Parameters
    ----------
    t : (N,) ndarray
        Times, from 0 [s].
    positions, speeds : (N, n) ndarray
        Positions of the actuated joints and their speeds [m or rad, per s]; nut heights for the
        3-PSP. If a robot's coordinates are not its motors, those of the coordinates, (N, p) and (N,
        n).
    desired : Motion
        Desired ``.positions .speeds .accelerations``, each (N, n), and ``.tip`` (N, 3); for such a
        robot those of the first k coordinates, which the motors command.
    torque : (N, n) ndarray
        Forces of the actuated joints applied from each sample on [N], at revolute joints torques [N
        m]. As motor torques: ``drive.motor_torque(result.torque)``.
    tip : (N, 3) ndarray
        Tip in base axes [m]; for robots other than the 3-PSP the frame ``tip``, and NaN without
        one.
    covered, fell_back : (N,) ndarray of bool, optional
        Whether the controller was inside its trained range, and whether it fell back on its
        average; only for controllers that report this.
    torque_interval : (N, n, 2) ndarray, optional
        Torque as the fuzzy number that was defuzzified, see
        :attr:`psp3.FuzzyComputedTorque.torque_interval` [N].
    """

    t: Array
    positions: Array
    speeds: Array
    desired: Motion
    torque: Array
    tip: Array
    covered: NDArray[np.bool_] | None = None
    fell_back: NDArray[np.bool_] | None = None
    torque_interval: Array | None = None

    def _facts(self) -> dict[str, Any]:
        error = self.desired.positions - self.positions[:, : self.desired.positions.shape[1]]
        away = np.linalg.norm(self.desired.tip - self.tip, axis=1)
        return {
            "duration": f"{self.t[-1] if len(self.t) else 0.0:g} s",
            "samples": len(self.t),
            "joints": self.positions.shape[1],
            "largest_error_of_positions": _largest(error),
            "rms_error_of_positions": float(np.sqrt(np.mean(error**2))) if error.size else None,
            "largest_error_of_tip": _with_meters(_largest(away)),
            "largest_force": _largest(self.torque),
        }

    @property
    def heights(self) -> Array:
        """The positions, under their name for the 3-PSP."""
        return self.positions

    def save(self, path: str | Path) -> Path:
        """Write the result to an ``.npz`` file and return its path.

        Parameters
        ----------
        path : path
            The file; an existing one is replaced only when the new one is complete.
        """
        path = checked_path("path", path)
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= dict(zip(_DESIRED, self.desired, strict=True))
        arrays |= {
            name: getattr(self, name) for name in REPORTED if getattr(self, name) is not None
        }
        with written_whole(path, "wb") as file:
            np.savez_compressed(file, format=np.array(FORMAT), **arrays)
        return path


def _largest(numbers: Array) -> float | None:
    """Return the largest number, or None if there is none or a value is not a number."""
    largest = float(np.abs(numbers).max()) if numbers.size else np.nan
    return largest if np.isfinite(largest) else None


def _with_meters(number: float | None) -> str | None:
    return None if number is None else f"{number:.4g} m"


def load_result(path: str | Path, largest: int = LARGEST) -> Result:
    """Read a result that :meth:`Result.save` wrote.

    Parameters
    ----------
    path : path
        The ``.npz`` file.
    largest : int
        Limit of the bytes of its arrays, because a compressed file can hold a thousand times its
        own size.

    Returns
    -------
    Result

    Raises
    ------
    InvalidResultFile
        If the file is missing, truncated, of another kind or version, larger than ``largest``, or
        if its arrays do not fit together.
    """
    path, largest = checked_path("path", path), checked_count("largest", largest)
    try:
        content: dict[str, Any] = dict(arrays_of(path, largest))
    except (OSError, ValueError) as error:
        raise InvalidResultFile(path, not_read(error, "is not a whole result file")) from error
    found = str(content.pop("format", "none"))
    if found != FORMAT:
        raise InvalidResultFile(path, f"has format {found!r}, this version reads {FORMAT!r}")
    shapes = _ARRAYS | {name: (3,) if name == "desired_tip" else (JOINTS,) for name in _DESIRED}
    if not set(shapes) <= set(content) <= set(shapes) | set(REPORTED):
        raise InvalidResultFile(
            path,
            f"must hold the arrays {', '.join(sorted(shapes))}; it holds "
            f"{', '.join(sorted(content))}",
        )
    samples, widths = content["t"].shape, _widths(content)
    for name, array in content.items():
        shape, kind = REPORTED.get(name) or (shapes[name], np.float64)
        whole = (
            *samples,
            *(widths.get(name, JOINTS) if length == JOINTS else length for length in shape),
        )
        if len(samples) != 1 or array.shape != whole or array.dtype != kind:
            raise InvalidResultFile(
                path, f"array {name} has shape {array.shape} and type {array.dtype}"
            )
    desired = Motion(*(content[name] for name in _DESIRED))
    reported = {name: content.get(name) for name in REPORTED}
    return Result(
        content["t"],
        content[POSITIONS],
        content["speeds"],
        desired,
        content["torque"],
        content["tip"],
        **reported,
    )


def _widths(content: dict[str, Array]) -> dict[str, int]:
    """Return the required widths of a file's arrays, by name."""
    positions, motors, desired = (
        content[name].shape[-1] if content[name].ndim else JOINTS for name in _OWN_WIDTH
    )
    speeds = content["speeds"].shape[-1] if content["speeds"].ndim else JOINTS
    return {
        POSITIONS: positions,
        "speeds": speeds if speeds == positions - 1 else positions,
        "torque": motors,
        "torque_interval": motors,
        **dict.fromkeys(_DESIRED, desired),
    }

"""Everything this package raises on purpose: each error carries the values it is about and says what to do.

Errors about an argument are also :class:`ValueError`, so code that knows nothing of this package catches them too.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from psp3.simulation import Result

Array = NDArray[np.float64]


def _numbers(values: Any) -> str:
    text = np.array2string(np.asarray(values), precision=6, separator=", ", threshold=12, suppress_small=True)
    return " ".join(text.split())


class PSP3Error(Exception):
    """Base of every error this package raises on purpose. They can be pickled, so they cross process boundaries whole."""

    _arguments: tuple[Any, ...]

    def __new__(cls, *arguments: Any) -> Self:
        """Remember the arguments, from which a pickled error is made again."""
        error = super().__new__(cls, *arguments)
        error._arguments = arguments
        return error

    def __reduce__(self) -> tuple[type[PSP3Error], tuple[Any, ...]]:
        return type(self), self._arguments


class UnknownName(PSP3Error, ValueError):
    """A name that is looked up is not among the known ones."""

    def __init__(self, kind: str, name: object, known: Sequence[str]) -> None:
        self.name, self.known = name, tuple(known)
        super().__init__(f"unknown {kind} {name!r}; known are {', '.join(known)}")


class InvalidArray(PSP3Error, ValueError):
    """An array has the wrong shape or holds numbers that are not finite."""

    def __init__(self, name: str, shape: str, array: Any) -> None:
        self.name, self.array = name, array
        try:
            values = np.asarray(array)
        except ValueError:  # rows of different lengths
            values = np.asarray(None)
        if values.dtype.kind in "fiu":
            bad = np.count_nonzero(~np.isfinite(values))
            found = f"shape {values.shape}" + (f", {bad} of its entries not finite: {_numbers(values)}" if bad else "")
        else:
            found = repr(array)[:80].replace("\n", " ")
        super().__init__(f"{name} must be finite numbers of shape {shape}, got {found}")


class InvalidValue(PSP3Error, ValueError):
    """A scalar argument is outside the values it can take."""

    def __init__(self, name: str, value: object, requirement: str) -> None:
        self.name, self.value = name, value
        super().__init__(f"{name} must be {requirement}, got {value!r}")


class UnreachablePose(PSP3Error, ValueError):
    """The nut heights put the star's center outside the nut triangle: an arm length is not positive."""

    def __init__(self, heights: Array, arms: Array) -> None:
        self.heights, self.arms = heights, arms
        super().__init__(
            f"heights {_numbers(heights)} m ask for arm lengths {_numbers(arms)} m; every arm must be longer than 0: "
            f"bring the heights closer together (any tilt below 70.53 degrees is safe)"
        )


class UnreachableTip(PSP3Error, ValueError):
    """The tip is asked to go beyond the fold of the tip's map, where the branch connected to home ends."""

    def __init__(self, tip: Array, radius: float, azimuth: float, reach: float) -> None:
        self.tip, self.radius, self.azimuth, self.reach = tip, radius, azimuth, reach
        super().__init__(
            f"tip {_numbers(tip)} m is {1e3 * radius:.1f} mm from the vertical axis at azimuth {np.degrees(azimuth):.1f} degrees, "
            f"where the robot reaches {1e3 * reach:.1f} mm; choose a smaller radius"
        )


class StrokeExceeded(PSP3Error, ValueError):
    """A trajectory asks a nut to go beyond the end of its screw."""

    def __init__(self, time: float, heights: Array, lower: Array, upper: Array) -> None:
        self.time, self.heights, self.lower, self.upper = time, heights, lower, upper
        super().__init__(
            f"at t = {time:.6g} s the trajectory asks for heights {_numbers(heights)} m, outside the stroke "
            f"{_numbers(lower)} to {_numbers(upper)} m; move or shrink the path"
        )


class OpenLoops(PSP3Error, ValueError):
    """A configuration does not close the loops."""

    def __init__(self, residual: float, tolerance: float) -> None:
        self.residual, self.tolerance = residual, tolerance
        super().__init__(
            f"the configuration leaves the loops open by {residual:.3g} (m, rad; allowed {tolerance:.0e}); "
            f"get a closed one from robot.configuration(heights)"
        )


class ClosureFailed(PSP3Error, ValueError):
    """Newton's method did not close the loops for the given actuated coordinates."""

    def __init__(self, positions: Array, residual: float, reached: float) -> None:
        self.positions, self.residual, self.reached = positions, residual, reached
        super().__init__(
            f"the loops could not be closed at actuated positions {_numbers(positions)}: {100 * reached:.0f} % of the way from the "
            f"reference pose the residual stays at {residual:.3g} (m, rad); the pose is outside the workspace or past a singularity"
        )


class JointLimitExceeded(PSP3Error, ValueError):
    """The loops close only with an un-actuated joint beyond its limits."""

    def __init__(self, joint: str, position: float, lower: float, upper: float) -> None:
        self.joint, self.position, self.lower, self.upper = joint, position, lower, upper
        super().__init__(f"the loops close with joint {joint!r} at {position:.6g}, outside its limits {lower:.6g} to {upper:.6g} (m, rad)")


class InconsistentVelocity(PSP3Error, ValueError):
    """A velocity would tear the loops apart."""

    def __init__(self, residual: float, tolerance: float) -> None:
        self.residual, self.tolerance = residual, tolerance
        super().__init__(f"the velocity violates the loops by {residual:.3g} (m/s, rad/s; allowed {tolerance:.0e}); use v = L(q) @ speeds")


class SingularConfiguration(PSP3Error, ValueError):
    """The actuated joints do not determine the motion of the others here."""

    def __init__(self, rank: int, needed: int, condition: float) -> None:
        self.rank, self.needed, self.condition = rank, needed, condition
        super().__init__(
            f"the constraint Jacobian of the un-actuated joints has rank {rank} of {needed} (condition number {condition:.2g}); "
            f"this configuration is singular (a ball joint of the 3-PSP at 90 degrees, for example)"
        )


class MobilityMismatch(PSP3Error, ValueError):
    """The loops leave another number of degrees of freedom than there are actuated joints."""

    def __init__(self, mobility: int, actuated: Sequence[str]) -> None:
        self.mobility, self.actuated = mobility, tuple(actuated)
        super().__init__(
            f"the mechanism has {mobility} degree{'s' if mobility != 1 else ''} of freedom but {len(actuated)} actuated joints "
            f"({', '.join(actuated)}); correct name_mot or the loops"
        )


class InvalidRobotFile(PSP3Error, ValueError):
    """A URDF, SRDF or loop file cannot be used."""

    def __init__(self, path: str | Path, reason: str) -> None:
        self.path, self.reason = Path(path), reason
        super().__init__(f"{path}: {reason}")


class InvalidTrajectoryFile(PSP3Error, ValueError):
    """A trajectory's CSV file cannot be used."""

    def __init__(self, path: str | Path, reason: str) -> None:
        self.path, self.reason = Path(path), reason
        super().__init__(f"{path}: {reason}")


class InvalidResultFile(PSP3Error, ValueError):
    """A file is not a whole simulation result of this version."""

    def __init__(self, path: str | Path, reason: str) -> None:
        self.path, self.reason = Path(path), reason
        super().__init__(f"{path}: {reason}")


class SimulationStopped(PSP3Error, RuntimeError):
    """Base of the errors that end a simulation early; ``result`` holds the part simulated so far."""

    def __init__(self, message: str, time: float, heights: Array, speeds: Array, torque: Array, result: Result) -> None:
        self.time, self.heights, self.speeds, self.torque, self.result = time, heights, speeds, torque, result
        super().__init__(
            f"{message} at t = {time:.6g} s: heights {_numbers(heights)} m, speeds {_numbers(speeds)} m/s, torque {_numbers(torque)} N"
        )


class SimulationDiverged(SimulationStopped):
    """The simulated robot left the poses it can take: an arm, a stroke or the numbers themselves ran out."""


class InvalidTorque(SimulationStopped):
    """A controller returned a torque that is not three finite numbers."""


class MotionDiverged(PSP3Error, RuntimeError):
    """A simulated motion leaves the range of the numbers, or a force on the way is not a finite number."""

    def __init__(self, time: float, position: float, speed: float, force: float) -> None:
        self.time, self.position, self.speed, self.force = time, position, speed, force
        super().__init__(
            f"the motion diverges at t = {time:.6g} s: position {position:.6g} m, speed {speed:.6g} m/s, force {force:.6g} N; "
            f"check the gains (error_dynamics.is_stable) and the model, alpha and beta"
        )


class NotTrained(PSP3Error, RuntimeError):
    """A fuzzy controller is asked for a torque before it has learned anything."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(f"this {name} has learned nothing yet; call fit(trajectory) or learn(record), or load a trained one")


class InvalidControllerFile(PSP3Error, ValueError):
    """A file is not a trained controller, or one for another robot."""

    def __init__(self, path: str | Path, reason: str) -> None:
        self.path, self.reason = Path(path), reason
        super().__init__(f"{path}: {reason}")


class UnusableEstimate(PSP3Error, ValueError):
    """What was learned holds no mass matrix at all: even the average over the rules is not positive definite."""

    def __init__(self, mass: Array) -> None:
        self.mass = mass
        super().__init__(
            f"the average mass matrix of the rules, {_numbers(mass)}, is not positive definite, so there is nothing to fall back on; "
            f"learn from more samples or less noise"
        )


class InvalidStudyFile(PSP3Error, ValueError):
    """A file does not hold the results of a study: it is missing, damaged or another program's."""

    def __init__(self, path: str | Path, reason: str) -> None:
        self.path, self.reason = Path(path), reason
        super().__init__(f"{path}: {reason}")


class StudyMismatch(PSP3Error, ValueError):
    """A file holds the results of another study, or of another version of this one."""

    def __init__(self, path: str | Path, what: str, found: object, expected: object) -> None:
        self.path, self.what, self.found, self.expected = Path(path), what, found, expected
        super().__init__(f"{path} holds another study: its {what} is {found}, not {expected}; give another file, this one stays as it is")


class StudyFileNotWritable(PSP3Error, RuntimeError):
    """Results cannot be written to a study's file; ``kept`` of them are in it and stay there."""

    def __init__(self, path: str | Path, reason: str, kept: int = 0) -> None:
        self.path, self.reason, self.kept = Path(path), reason, kept
        safe = f"; the {kept} results in it are safe, and once it can be written the study goes on from there" if kept else ""
        super().__init__(f"{path} cannot be written to: {reason}{safe}")


class StudyInUse(PSP3Error, RuntimeError):
    """Another study is writing to the same file."""

    def __init__(self, path: str | Path, holder: str) -> None:
        self.path, self.holder = Path(path), holder
        super().__init__(f"{path} is being written to by {holder}; wait until that study has ended, or give another file")


class RunsFailed(PSP3Error, RuntimeError):
    """Runs of a study raised errors; the results of the others are kept. ``failures`` holds each run with its error in words."""

    def __init__(self, path: str | Path, failures: Sequence[tuple[object, str]], not_started: int) -> None:
        self.path, self.failures, self.not_started = Path(path), tuple(failures), not_started
        run, reason = self.failures[0]
        more = f" (and {len(failures) - 1} more)" if len(failures) > 1 else ""
        given_up = f"; after so many failures {not_started} others were not started" if not_started else ""
        super().__init__(f"{run} failed{more}: {reason}{given_up}; the results of the others are in {path}")


class SchedulerUnavailable(PSP3Error, RuntimeError):
    """A dask scheduler cannot be used, or was lost."""

    def __init__(self, address: str, reason: str) -> None:
        self.address, self.reason = address, reason
        super().__init__(f"scheduler {address}: {reason}")


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C ended a study; its file holds ``done`` of ``total`` runs and is valid.

    Not a :class:`PSP3Error`: whoever interrupts wants out, and ``except Exception`` must not stop that.
    """

    def __init__(self, path: str | Path, done: int, total: int) -> None:
        self.path, self.done, self.total = Path(path), done, total
        super().__init__(
            f"interrupted after {done} of {total} runs, which are in {path}; run the same study again and it goes on from there"
        )

"""Everything this package raises on purpose.

Each error stores the values that caused it, and its message says what to do.

Errors about an argument are also :class:`ValueError`, so code that knows nothing of this package
catches them too. An error that has the same name in :mod:`fuzzy2.errors` is derived from it, so one
``except`` clause catches the wrong values of both packages.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import fuzzy2.errors
from fuzzy2.errors import RaisedOnPurpose, in_words
from fuzzy2.support.bounded_files import shortened
from fuzzy2.support.checks import Array


def _numbers(values: Any) -> str:
    text = np.array2string(
        np.asarray(values), precision=6, separator=", ", threshold=12, suppress_small=True
    )
    return " ".join(text.split())


class PSP3Error(RaisedOnPurpose, Exception):
    """Base of every error this package raises on purpose."""


class UnknownName(fuzzy2.errors.UnknownName, PSP3Error):
    """A name is not among the known ones."""


class UnknownRobot(UnknownName):
    """A robot that neither comes with the package nor is a file."""

    def __init__(self, name: object, known: Sequence[str]) -> None:
        self.name, self.known = name, tuple(known)
        PSP3Error.__init__(
            self,
            f"unknown robot {in_words(name)}; known are {', '.join(known)}; for your own robot "
            "give the file: psp3.load('my_robot.urdf'), or an .xml (MJCF) or .sdf",
        )


class InvalidArray(PSP3Error, ValueError):
    """An array has the wrong shape or holds numbers that are not finite."""

    def __init__(self, name: str, shape: str, array: Any) -> None:
        self.name, self.array = name, array
        try:
            values = np.asarray(array)
        except Exception:  # rows of different lengths, or a foreign class whose conversion fails
            values = np.asarray(None)
        if values.dtype.kind in "fiu":
            bad = np.count_nonzero(~np.isfinite(values))
            found = f"shape {values.shape}" + (
                f", {bad} of its entries not finite: {_numbers(values)}" if bad else ""
            )
        else:
            found = in_words(array)
        super().__init__(f"{name} must be finite numbers of shape {shape}, got {found}")


class InvalidValue(fuzzy2.errors.InvalidValue, PSP3Error):
    """A scalar argument is outside the values it can take."""

    @staticmethod
    def _shown(value: object) -> str:
        return in_words(value)


class UnreachablePose(PSP3Error, ValueError):
    """The nut heights put the star's center outside the nut triangle.

    An arm length is not positive.
    """

    def __init__(self, heights: Array, arms: Array) -> None:
        self.heights, self.arms = heights, arms
        super().__init__(
            f"heights {_numbers(heights)} m ask for arm lengths {_numbers(arms)} m; every arm "
            "must be longer than 0: bring the heights closer together (any tilt below 70.53 "
            "degrees is safe)"
        )


class UnreachableTip(PSP3Error, ValueError):
    """The tip is asked to go beyond the fold of the tip's map.

    There the branch connected to home ends.
    """

    def __init__(self, tip: Array, radius: float, azimuth: float, reach: float) -> None:
        self.tip, self.radius, self.azimuth, self.reach = tip, radius, azimuth, reach
        super().__init__(
            f"tip {_numbers(tip)} m is {1e3 * radius:.1f} mm from the vertical axis at azimuth "
            f"{np.degrees(azimuth):.1f} degrees, where the robot reaches {1e3 * reach:.1f} mm: "
            "bring it nearer to the axis (for a helix or circle choose a smaller radius)"
        )


class StrokeExceeded(PSP3Error, ValueError):
    """A trajectory asks an actuated joint to go beyond its limits.

    The limits of a nut are the ends of its screw.
    """

    def __init__(self, time: float, positions: Array, lower: Array, upper: Array) -> None:
        self.time, self.positions, self.lower, self.upper = time, positions, lower, upper
        super().__init__(
            f"at t = {time:.6g} s the trajectory asks for positions {_numbers(positions)}, outside "
            f"the stroke {_numbers(lower)} to {_numbers(upper)} (m or rad); move or shrink the "
            "path"
        )

    @property
    def heights(self) -> Array:
        """The positions, by their name of the 3-PSP."""
        return self.positions


class OpenLoops(PSP3Error, ValueError):
    """The loops are open at a configuration."""

    def __init__(self, residual: float, tolerance: float) -> None:
        self.residual, self.tolerance = residual, tolerance
        super().__init__(
            f"the configuration leaves the loops open by {residual:.3g} (m, rad; allowed "
            f"{tolerance:.0e}); get a closed one from robot.configuration(heights)"
        )


class ClosureFailed(PSP3Error, ValueError):
    """The loops cannot be closed at the given actuated positions.

    ``residual`` is how far they are open there.
    """

    def __init__(self, positions: Array, residual: float, reached: float) -> None:
        self.positions, self.residual, self.reached = positions, residual, reached
        where = (
            f"at actuated positions {_numbers(positions)}"
            if np.size(positions)
            else "near the reference pose"
        )
        super().__init__(
            f"the loops could not be closed {where}: the way "
            f"from the reference pose ends after {100 * reached:.0f} %, and at its goal they "
            f"would be open by {residual:.3g} (m, rad); the pose is outside the workspace or "
            "past a singularity: ask for one nearer to the reference pose"
        )


class LoopsDoNotClose(ClosureFailed):
    """The search found no configuration that closes the robot's loops, not even nearly.

    ``residual`` is the smallest opening found, and ``loop`` names the loop that is open most there.
    """

    def __init__(self, q: Array, residual: float, loop: str, tried: int) -> None:
        self.positions, self.residual, self.reached = q, residual, 0.0
        self.loop, self.tried = loop, tried
        where = f"loop {loop!r}" if loop else "they"
        PSP3Error.__init__(
            self,
            f"the loops do not close: from {tried} starts, within the joint limits and beyond, "
            f"{where} stays open by at least {residual:.3g} (m, rad): correct its frames, or give "
            "a pose near a closed one (home in an SRDF or a key frame)",
        )


class RoundedLoops(PSP3Error, ValueError):
    """Rounded numbers in a file cannot explain by how much the loops contradict themselves."""

    def __init__(self, loop: str, length: float, angle: float, freedoms: int) -> None:
        self.loop, self.length, self.angle, self.freedoms = loop, length, angle, freedoms
        super().__init__(
            f"loop {loop!r} contradicts itself by {length:.3g} m and {angle:.3g} rad, and leaves "
            f"{freedoms} degrees of freedom: write the numbers of its frames with more digits, or "
            "replace one of its hinges by a ball or universal joint (joint_name and joint_type of "
            "a loop file)"
        )


class JointLimitExceeded(PSP3Error, ValueError):
    """The loops close only with an un-actuated joint beyond its limits."""

    def __init__(self, joint: str, position: float, lower: float, upper: float) -> None:
        self.joint, self.position, self.lower, self.upper = joint, position, lower, upper
        super().__init__(
            f"the loops close with joint {joint!r} at {position:.6g}, outside its limits "
            f"{lower:.6g} to {upper:.6g} (m, rad): ask for a pose nearer to the reference pose"
        )


class InconsistentVelocity(PSP3Error, ValueError):
    """A velocity violates the loop constraints."""

    def __init__(self, residual: float, tolerance: float) -> None:
        self.residual, self.tolerance = residual, tolerance
        super().__init__(
            f"the velocity violates the loops by {residual:.3g} (m/s, rad/s; allowed "
            f"{tolerance:.0e}); use v = L(q) @ speeds"
        )


class SingularConfiguration(PSP3Error, ValueError):
    """The actuated joints do not determine the motion of the others here."""

    def __init__(self, rank: int, needed: int, condition: float) -> None:
        self.rank, self.needed, self.condition = rank, needed, condition
        super().__init__(
            f"the constraint Jacobian of the un-actuated joints has rank {rank} of {needed} "
            f"(condition number {condition:.2g}); this configuration is singular: move the "
            "coordinates away from it, or name others in coordinates=[...]"
        )


class NoFiniteAnswer(PSP3Error, ValueError):
    """The dynamics of a pose has no finite answer.

    Speeds or forces are too large for a floating-point number, or a motion has no inertia.
    """

    REMEDY = "give smaller speeds or forces, or every motion some mass or inertia"

    def __init__(self, positions: Any) -> None:
        self.positions = positions
        super().__init__(
            f"there is no finite answer at the actuated positions {positions}: {self.REMEDY}"
        )


class MobilityMismatch(PSP3Error, ValueError):
    """The actuated joints do not command each degree of freedom exactly once.

    Only the degrees of freedom that remain when the loops are closed count.
    """

    def __init__(self, mobility: Any, actuated: Sequence[str]) -> None:
        self.mobility, self.actuated = mobility, tuple(actuated)
        super().__init__(
            f"the mechanism has {mobility}; actuated are {', '.join(actuated) or 'none'}: "
            "name other motors (actuated=[...], name_mot of a loop file), correct the loops, or "
            "hold a joint that need not move (joint_type FIXED)"
        )


class DependentCoordinates(PSP3Error, ValueError):
    """A joint cannot be an independent coordinate."""

    def __init__(self, joint: str, others: Sequence[str]) -> None:
        self.joint, self.others = joint, tuple(others)
        if not joint:
            reason = (
                "a free motion has no joint of one degree of freedom that measures it: name "
                "coordinates=[...], or hold a joint (joint_type FIXED)"
            )
        elif others:
            reason = (
                f"joint {joint!r} is determined by {', '.join(others)}, or has not one degree of "
                "freedom: name another in coordinates=[...]"
            )
        else:
            reason = (
                f"joint {joint!r} cannot be a coordinate, because it does not move or has not one "
                "degree of freedom: name another in coordinates=[...]"
            )
        super().__init__(reason)


class UnreachableForces(PSP3Error, ValueError):
    """The motors cannot produce a motion: it needs a force where no motor acts.

    ``what`` names what cannot be reached: ``"forces"`` (N or N m) or ``"accelerations"`` (m/s² or
    rad/s²).
    """

    def __init__(self, residual: float, coordinates: Sequence[str], what: str = "forces") -> None:
        self.residual, self.coordinates, self.what = residual, tuple(coordinates), what
        units = "N or N m" if what == "forces" else "m/s² or rad/s²"
        super().__init__(
            f"the motors cannot bring about this motion: {what} of {residual:.3g} ({units}) are "
            f"left over at the coordinates {', '.join(coordinates)}; ask for accelerations from "
            "forward_dynamics, for those of fewer or other coordinates (coordinates=[...]), or "
            "drive more joints"
        )


class UnsupportedJoint(PSP3Error, ValueError):
    """Loops through a joint of this kind cannot be closed."""

    def __init__(self, joint: str, kind: str) -> None:
        self.joint, self.kind = joint, kind
        super().__init__(
            f"joint {joint!r} is a {kind}; loops are closed through revolute, prismatic, "
            "helical, universal, ball, planar and free joints: compose it of these"
        )


class DisorderedJoints(PSP3Error, ValueError):
    """The order of a tree's joints makes Pinocchio's mass matrix wrong, without an error."""

    def __init__(self, joint: str, parent: str) -> None:
        self.joint, self.parent = joint, parent
        super().__init__(
            f"joint {joint!r} hangs on {parent!r}, but was added after joints of another branch; "
            "finish every chain before the next is begun, or Pinocchio's mass matrix is wrong"
        )


class InvalidFile(PSP3Error, ValueError):
    """Base of the errors about a file that cannot be used.

    ``reason`` is shortened, because text from the file may be of any length.
    """

    def __init__(self, path: str | Path, reason: str) -> None:
        self.path, self.reason = Path(path), shortened(reason)
        super().__init__(f"{path}: {self.reason}")


class InvalidRobotFile(InvalidFile):
    """A URDF, SRDF or loop file cannot be used."""


class UnphysicalInertia(PSP3Error, ValueError):
    """A body that turns has an inertia that no rigid body can have.

    A simulator that checks inertias refuses it.
    """

    def __init__(self, body: str, moments: Array) -> None:
        self.body, self.moments = body, moments
        super().__init__(
            f"body {body!r} has the principal moments {_numbers(moments)} kg m²; none may exceed "
            "the sum of the other two, and this body turns, so they matter: correct its inertia"
        )


class MasslessBody(PSP3Error, ValueError):
    """A body without mass cannot be joined with the one that it carries."""

    def __init__(self, body: str, closed: bool, children: int) -> None:
        self.body, self.closed, self.children = body, closed, children
        reason = "a loop closes on it" if closed else f"it carries {children} bodies instead of one"
        super().__init__(
            f"body {body!r} has no mass and {reason}; MuJoCo cannot move a body without mass: "
            "give it some"
        )


class UnexportableJoint(PSP3Error, ValueError):
    """MuJoCo has no equivalent of a joint."""

    def __init__(self, joint: str, reason: str) -> None:
        self.joint, self.reason = joint, reason
        super().__init__(
            f"joint {joint!r} cannot be written for MuJoCo, which composes joints of hinges, "
            f"slides and balls: {reason}"
        )


class MissingPackage(PSP3Error, RuntimeError):
    """An optional package, which one of the extras installs, is needed but cannot be imported."""

    def __init__(self, package: str, extra: str, reason: object) -> None:
        self.package, self.extra = package, extra
        super().__init__(
            f"the package {package} cannot be imported ({reason}); install it with: pip install "
            f"'psp3[{extra}]'"
        )


class OverlappingShapes(PSP3Error, ValueError):
    """Two links of a checked pair already overlap at the reference pose."""

    def __init__(self, pairs: Sequence[tuple[str, str]], depths: Sequence[float]) -> None:
        self.pairs, self.depths = tuple(pairs), tuple(depths)
        found = ", ".join(
            f"{one!r} and {other!r} by {1e3 * depth:.3g} mm"
            for (one, other), depth in zip(pairs, depths, strict=True)
        )
        super().__init__(
            f"at the reference pose links overlap: {found}; correct their shapes, or exclude "
            "what touches by construction with "
            f'<disable_collisions link1="..." link2="..." reason="..."/> in the SRDF'
        )


class CollisionFound(PSP3Error, ValueError):
    """Two links come closer to each other along a motion than the clearance allows."""

    def __init__(
        self,
        time: float,
        links: tuple[str, str],
        distance: float,
        clearance: float,
        worst_time: float,
        worst_distance: float,
    ) -> None:
        self.time, self.links, self.distance, self.clearance = time, links, distance, clearance
        self.worst_time, self.worst_distance = worst_time, worst_distance
        first = "touch" if clearance == 0.0 else f"come as near as {1e3 * clearance:.3g} mm"
        worst = (
            f"{1e3 * worst_distance:.3g} mm apart"
            if worst_distance >= 0.0
            else f"{-1e3 * worst_distance:.3g} mm in each other"
        )
        super().__init__(
            f"at t = {time:.6g} s links {links[0]!r} and {links[1]!r} {first}; the worst is at t "
            f"= {worst_time:.6g} s, {worst}: change the path, or ask for less clearance"
        )


class InvalidTrajectoryFile(InvalidFile):
    """A trajectory's CSV file cannot be used."""


class InvalidResultFile(InvalidFile):
    """A file is not a complete simulation result of this version."""


class InvalidMapFile(InvalidFile):
    """A file is not a complete workspace map of this version."""


class SimulationStopped(PSP3Error, RuntimeError):
    """Base of the errors that end a simulation early.

    ``result`` holds the part simulated so far, a :class:`psp3.Result`.
    """

    def __init__(
        self, message: str, time: float, positions: Array, speeds: Array, torque: Array, result: Any
    ) -> None:
        self.time, self.positions, self.speeds, self.torque, self.result = (
            time,
            positions,
            speeds,
            torque,
            result,
        )
        super().__init__(
            f"{message} at t = {time:.6g} s: positions {_numbers(positions)}, speeds "
            f"{_numbers(speeds)}, torque {shortened(_numbers(torque))} (SI units)"
        )

    @property
    def heights(self) -> Array:
        """The positions, by their name of the 3-PSP."""
        return self.positions


class SimulationDiverged(SimulationStopped):
    """The simulated robot left its workspace.

    An arm length, a stroke, a joint limit or the range of the floating-point numbers was exceeded,
    or a motion has no mass and no inertia.
    """


class InvalidTorque(SimulationStopped):
    """A controller did not return a finite force for each actuated joint."""


class MotionDiverged(PSP3Error, RuntimeError):
    """A simulated motion overflows the floating-point numbers, or a force is not finite."""

    def __init__(self, time: float, position: float, speed: float, force: float) -> None:
        self.time, self.position, self.speed, self.force = time, position, speed, force
        super().__init__(
            f"the motion diverges at t = {time:.6g} s: position {position:.6g} m, speed "
            f"{speed:.6g} m/s, force {force:.6g} N; check the gains (error_dynamics.is_stable) "
            "and the model, alpha and beta"
        )


class NotTrained(PSP3Error, RuntimeError):
    """A fuzzy controller is asked for a torque before it has learned anything."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(
            f"this {name} has learned nothing yet; call fit(trajectory), learn(record) or "
            "learn_from_motion(...), or load a trained one"
        )


class InvalidEntry(InvalidFile):
    """A file, or the controller in it, cannot take part in the benchmark."""


class WorkersLost(PSP3Error, RuntimeError):
    """A worker process of a benchmark ended before its runs were done."""

    def __init__(self, path: str | Path, done: int, total: int) -> None:
        self.path, self.done, self.total = Path(path), done, total
        super().__init__(
            f"a process that did runs was ended from outside, or by an entry, after {done} of "
            f"{total} trials, which are in {path}; the same benchmark goes on from there, with "
            "workers=1 in this process, where the entry that ends it can be seen"
        )


class NoThreshold(PSP3Error, RuntimeError):
    """A monitor is asked for an alarm before it knows what is normal."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(
            f"this {name} has no threshold yet; call learn(runs) with runs in which everything "
            "was normal"
        )


class InvalidControllerFile(InvalidFile):
    """A file does not hold a trained controller, or holds one for another robot."""


class UnusableEstimate(PSP3Error, ValueError):
    """The learned rules give no usable mass matrix.

    Even the average over the rules is not positive definite. ``told_apart`` is the part of the
    accelerations that is not a function of the positions, as a share of their root mean square. It
    is zero for a motion of one harmonic. It is given when the rules were learned from a motion and
    its forces.
    """

    def __init__(self, mass: Array, told_apart: float | None = None) -> None:
        self.mass, self.told_apart = mass, told_apart
        remedy = "learn from more samples or less noise"
        if told_apart is not None:
            remedy = (
                f"on this motion a share of {told_apart:.2g} of the accelerations does not follow "
                "from the positions, and where nothing does, forces cannot tell M from G: learn "
                "from a motion that passes the same places with other accelerations, of more "
                "harmonics, or from more samples or less noise"
            )
        super().__init__(
            f"the average mass matrix of the rules, {_numbers(mass)}, is not positive definite, "
            f"so there is nothing to fall back on; {remedy}"
        )


class InvalidStudyFile(InvalidFile):
    """A file does not hold the results of a study: it is missing, damaged or another program's."""


class StudyMismatch(PSP3Error, ValueError):
    """A file holds the results of another study, or of another version of this one."""

    def __init__(
        self,
        path: str | Path,
        what: str,
        found: object,
        expected: object,
        remedy: str = "give another file, this one stays as it is",
    ) -> None:
        self.path, self.what, self.found, self.expected = Path(path), what, found, expected
        super().__init__(
            f"{path} holds another study: its {what} is {found}, not {expected}; {remedy}"
        )


class StudyFileNotWritable(PSP3Error, RuntimeError):
    """Results cannot be written to a study's file; ``kept`` of them are in it and stay there."""

    def __init__(self, path: str | Path, reason: str, kept: int = 0) -> None:
        self.path, self.reason, self.kept = Path(path), reason, kept
        safe = (
            (
                f"; the {kept} results in it are safe, and once it can be written the study goes "
                "on from there"
            )
            if kept
            else ""
        )
        super().__init__(f"{path} cannot be written to: {reason}{safe}")


class StudyInUse(PSP3Error, RuntimeError):
    """Another study is writing to the same file."""

    def __init__(self, path: str | Path, holder: str) -> None:
        self.path, self.holder = Path(path), holder
        super().__init__(
            f"{path} is being written to by {holder}; wait until that study has ended, or give "
            "another file"
        )


class RunsFailed(PSP3Error, RuntimeError):
    """Runs of a study raised errors.

    The results of the others are kept. ``failures`` holds each run with its error in words.
    """

    def __init__(
        self, path: str | Path, failures: Sequence[tuple[object, str]], not_started: int
    ) -> None:
        self.path, self.failures, self.not_started = Path(path), tuple(failures), not_started
        run, reason = self.failures[0]
        more = f" (and {len(failures) - 1} more)" if len(failures) > 1 else ""
        given_up = (
            f"; after so many failures {not_started} others were not started" if not_started else ""
        )
        super().__init__(
            f"{run} failed{more}: {reason}{given_up}; the results of the others are in {path}"
        )


class SchedulerUnavailable(PSP3Error, RuntimeError):
    """A dask scheduler cannot be used, or was lost."""

    def __init__(self, address: str, reason: str) -> None:
        self.address, self.reason = address, reason
        super().__init__(f"scheduler {address}: {reason}")


class StudyInterrupted(RaisedOnPurpose, KeyboardInterrupt):
    """Ctrl-C ended a study; its file holds ``done`` of ``total`` runs and is valid.

    Not a :class:`PSP3Error`: ``except Exception`` must not catch a Ctrl-C.
    """

    def __init__(self, path: str | Path, done: int, total: int) -> None:
        self.path, self.done, self.total = Path(path), done, total
        super().__init__(
            f"interrupted after {done} of {total} runs, which are in {path}; run the same study "
            "again and it goes on from there"
        )


class NoStabilizingSolution(PSP3Error, ValueError):
    """A Riccati equation has no solution that makes the system stable."""

    def __init__(self, poles: NDArray[np.complex128], period: float | None) -> None:
        self.poles, self.period = poles, period
        region = (
            "to the left of 0"
            if period is None
            else f"within the unit circle (period {period:g} s)"
        )
        super().__init__(
            f"no regulator brings the poles {_numbers(poles)} {region}; the input must reach "
            "every unstable motion, and Q must see every motion that does not die out by itself "
            "(give positions and speeds a positive weight)"
        )


class UncertainRank(PSP3Error, RuntimeError):
    """Rounding hides how many columns of a matrix are independent."""

    def __init__(self, counted: int, rank: int, singular_values: Array) -> None:
        self.counted, self.rank, self.singular_values = counted, rank, singular_values
        super().__init__(
            f"{counted} columns seem independent one after the other, but {rank} singular values "
            f"are not zero (the least are {_numbers(singular_values[-4:])}); two columns are "
            "nearly the same: take fewer unknowns, or give equal bodies as equal"
        )


class PoorExcitation(PSP3Error, ValueError):
    """The measurements do not determine all of the unknowns."""

    def __init__(self, what: str, rank: int, needed: int) -> None:
        self.what, self.rank, self.needed = what, rank, needed
        super().__init__(
            f"the measurements determine {rank} of {needed} {what}; measure longer, or along a "
            "richer motion"
        )


class CorrelatedResiduals(RaisedOnPurpose, UserWarning):
    """The residual forces of an identification are correlated from sample to sample."""

    def __init__(
        self, joint: str, correlation: float, deviation: float, samples: int, effective: float
    ) -> None:
        self.joint, self.correlation, self.deviation = joint, correlation, deviation
        self.samples, self.effective = samples, effective
        # At this distance the correlation of such noise has fallen to 0.1.
        self.step = (
            max(2, int(np.ceil(np.log(0.1) / np.log(correlation))))
            if 0.0 < correlation < 1.0
            else 2
        )
        super().__init__(
            f"neighboring residuals of joint {joint!r} are correlated by {correlation:.2f}, "
            f"{deviation:.1f} standard deviations beyond independent noise: its {samples} samples "
            f"carry as much information as about {effective:.0f} independent ones, so standard "
            f"errors and intervals are too small; measure longer and take every {self.step}th "
            "sample, or add to the model what the residuals show"
        )


class SourceOnlyFMU(RaisedOnPurpose, UserWarning):
    """An FMU was written without a binary."""

    def __init__(self, path: str | Path, why: str) -> None:
        self.path, self.why = Path(path), why
        super().__init__(
            f"{path} holds source code and no binary: {why}; programs that compile FMUs take it as "
            "it is, for others export it on Linux for x86-64 with gcc"
        )

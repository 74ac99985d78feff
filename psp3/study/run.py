r"""One run of the study.

A controller tracks a trajectory under a noise, and its errors are measured.

Everything that decides a run is a field of :class:`Run`, so a run can be repeated anywhere from its
row in a table of results. Noise has five readings:

=============  =====================================================================================
reading        what a signal-to-noise ratio S means (q = 10^(−S/20) is the ratio of amplitudes)
=============  =====================================================================================
parameters     white noise on the recorded M, C and G from which rules are learned; the other
               controllers never see it
inputs         white noise on the recorded differences of heights and speeds from which rules are
               learned, M, C and G being exact; the other controllers never see it
measurement    white noise on measured heights and speeds at run time, seen by servo and estimator
online         white noise on the controller's M, C and G at run time
plant          every mass and inertia of the robot is off by a factor exp(q ε), and a payload of
               5 kg · q abs(ε) rides on the star
=============  =====================================================================================

The power of a signal is its mean square over the recorded training run, mean included, element by
element. The thesis says neither this nor which elements are noisy, and its comparison comes out
otherwise under other definitions: the fields ``snr_reference`` and ``noisy_entries`` choose them.

Under the reading ``plant`` a run can also have a payload of its own, drives with friction and motor
inertia, encoders that count, and a delay: fields that no signal-to-noise ratio scales.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from fuzzy2.learning.noise import mean_variation_from_snr
from fuzzy2.learning.partition import KINDS
from fuzzy2.learning.wang_mendel import LEARNERS
from psp3.checks import Array, checked_count, checked_not_negative, checked_positive
from psp3.control import kernels
from psp3.control.controller import Widths
from psp3.control.kernels import classical
from psp3.drives.drive import Drive
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control.computed_torque import (
    ORDERS,
    OUTSIDE,
    REDUCTIONS,
    FuzzyComputedTorque,
    checked_snr,
)
from psp3.fuzzy_control.kernels import (
    NO_MODEL,
    Fuzzy,
    FuzzyRun,
    nothing_added,
    reported,
    step_width,
)
from psp3.fuzzy_control.records import ENTRIES, REFERENCES, Record, RecordNoise, record
from psp3.loading import load
from psp3.published import DURATION, TABLE_6_1, THESIS_SAMPLING_PERIOD
from psp3.simulation.loop import compiled_loop, new_track, unbounded
from psp3.simulation.metrics import (
    integral_of_squared_error,
    largest_tip_error,
    sum_of_squared_errors,
)
from psp3.simulation.result import Result
from psp3.three_psp.parameters import PARAMETER_SETS, Parameters
from psp3.three_psp.robot import PSP3
from psp3.three_psp.stepping import ClosedFormSteps, closed_form_table
from psp3.trajectories.motion import Motion, check_stroke
from psp3.trajectories.paths import Circle, Helix, PointToPoint
from psp3.trajectories.recorded import Waypoints
from psp3.trajectories.trajectory import Trajectory

CLASSICAL = {
    "feed-forward": kernels.FEED_FORWARD,
    "pd": kernels.PD,
    "pd-gravity": kernels.GRAVITY_COMPENSATED_PD,
    "ctc": kernels.COMPUTED_TORQUE,
}
CONTROLLERS = (*CLASSICAL, *KINDS)
"""Names of the controllers: open loop, PD, PD with gravity, computed torque with the exact model,
and with learned ones.
"""

READINGS = ("parameters", "measurement", "online", "plant", "inputs")
"""Names of the readings of noise."""

OF_PLANT = (
    "payload",
    "coulomb_friction",
    "viscous_friction",
    "motor_inertia",
    "encoder_resolution",
    "delay",
)
"""Fields that say how the plant differs from what controllers believe; zero but under the reading
``"plant"``.
"""

PAYLOAD_PER_MISMATCH = 5.0
"""Payload at q abs(ε) = 1 [kg]."""

LEAST_SNR_OF_PLANT = -20.0
"""Least signal-to-noise ratio under the reading ``"plant"`` [dB]: masses are off by factors up to
exp(±40).
"""

MOST_STEPS = 10_000_000
"""Control periods of the longest run."""


def _square(robot: PSP3) -> Trajectory:
    """Return a square with sides of 24 mm, a corner a second, that rises as the helix does."""
    angles = 0.5 * np.pi * np.arange(11)
    across = 0.012 * np.sqrt(2.0)
    rise = robot.parameters.tool_length + 0.010 * np.arange(11)
    return Waypoints(
        np.arange(11.0),
        np.stack([across * np.cos(angles), across * np.sin(angles), rise], axis=-1),
        robot,
    )


TRAJECTORIES: dict[str, Callable[[PSP3], Trajectory]] = {
    "helix": lambda robot: Helix(robot=robot),
    "circle": lambda robot: Circle(robot=robot),
    "line": lambda robot: PointToPoint((-0.02, 0.0, 0.07), (0.02, 0.01, 0.12), 10.0, robot),
    "fast-helix": lambda robot: Helix(period=1.0, robot=robot),
    "fastest-helix": lambda robot: Helix(period=0.4, robot=robot),
    "large-helix": lambda robot: Helix(radius=0.0235, robot=robot),
    "waypoints": _square,
}
"""Trajectories by name; the estimators are trained on the first."""

METRICS = (
    "sum_of_squared_errors",
    "integral_of_squared_error",
    "rms_error_1",
    "rms_error_2",
    "rms_error_3",
    "largest_error_1",
    "largest_error_2",
    "largest_error_3",
    "rms_tip_error",
    "largest_tip_error",
    "effort",
    "largest_torque",
    "coverage",
    "fallbacks",
    "left_stroke",
    "diverged",
    "end_time",
)
"""Names of what is measured, see :func:`execute`."""

FIRST_TRAJECTORY = next(iter(TRAJECTORIES))


@dataclass(frozen=True)
class Run:
    """Everything that decides a run.

    Parameters
    ----------
    controller : str
        One of ``CONTROLLERS``.
    reading : str
        One of ``READINGS``.
    snr_db : float
        Signal-to-noise ratio [dB]; infinite for none.
    seed : int
        Of the noise. Runs of the same seed see the same noise, whatever the controller, and the
        same but for its amplitude at every signal-to-noise ratio: differences between controllers
        can be paired.
    trajectory : str
        One of ``TRAJECTORIES``.
    learner, n_terms, mean_variation, levels, reduction, outside, term_width, samples
        See :class:`psp3.FuzzyComputedTorque`. The rules are learned on the first trajectory. The
        learner that the thesis cites, table look-up, is ``"strict"``.
    payload : float
        Mass on the star, at its center, that no controller knows of [kg]; of the reading
        ``"plant"``, as are the next six.
    coulomb_friction, viscous_friction, motor_inertia, lead
        Drive of each screw, see :class:`psp3.drives.drive.Drive` [N], [N s/m], [kg m²], [m per
        revolution].
    encoder_resolution : float
        Travel of a nut per count of its encoder [m], see :func:`psp3.simulate`.
    delay : int
        Control periods by which forces come late, see :func:`psp3.simulate`.
    parameters : str
        Name of the robot's parameter set.
    duration, period : float
        Length of the run and control period [s].
    snr_reference : str
        What the signal-to-noise ratio is taken against, one of
        :data:`psp3.fuzzy_control.records.REFERENCES`: a signal's mean square, its variance, or 1 in
        its unit. Of no meaning under the reading ``"plant"``.
    noisy_entries : str
        Which of M, C and G are noisy under the readings ``"parameters"`` and ``"online"``, one of
        :data:`psp3.fuzzy_control.records.ENTRIES`.
    defuzzify : str
        Whether M, C and G become crisp, ``"first"``, or the fuzzy torque, ``"last"``, see
        :class:`psp3.FuzzyComputedTorque`. Of no meaning but to ``"gt2"`` by two α-planes or more:
        other torques are the same number either way.
    """

    controller: str = "it2"
    reading: str = "parameters"
    snr_db: float = math.inf
    seed: int = 0
    trajectory: str = FIRST_TRAJECTORY
    learner: str = "strongest"
    n_terms: int = 2
    mean_variation: float | None = None
    levels: int = 5
    reduction: str = "alpha_planes"
    outside: str = "clamp"
    term_width: float = 1.0
    samples: int = 209
    payload: float = 0.0
    coulomb_friction: float = 0.0
    viscous_friction: float = 0.0
    motor_inertia: float = 0.0
    lead: float | None = None
    encoder_resolution: float = 0.0
    delay: int = 0
    parameters: str = "default"
    duration: float = DURATION
    period: float = 0.002
    snr_reference: str = "mean-square"
    noisy_entries: str = "all"
    defuzzify: str = "first"

    def __post_init__(self) -> None:
        # Of numpy's numbers, which grids are often made of, as of any other.
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.generic):
                object.__setattr__(self, field.name, value.item())

    def check(self) -> None:
        """Raise what :func:`execute` would raise for wrong fields, before any work.

        Wrong are fields that are not what they must be.

        Raises
        ------
        UnknownName
            If a name is unknown.
        InvalidValue
            If a number is outside of what it can be, or terms are so narrow that no rule fires on a
            part of the path learned from.
        StrokeExceeded
            If the trajectory leaves the screws in the duration.
        fuzzy2.errors.UnsupportedRule
            If no sample fires some rule by more than 0.001.
        """
        for what, name, known in (
            ("controller", self.controller, CONTROLLERS),
            ("reading", self.reading, READINGS),
            ("trajectory", self.trajectory, tuple(TRAJECTORIES)),
            ("learner", self.learner, LEARNERS),
            ("reduction", self.reduction, REDUCTIONS),
            ("way outside of the trained range", self.outside, OUTSIDE),
            ("parameter set", self.parameters, tuple(PARAMETER_SETS)),
            ("reference of the signal-to-noise ratio", self.snr_reference, REFERENCES),
            ("choice of noisy entries", self.noisy_entries, ENTRIES),
            ("order of defuzzification", self.defuzzify, ORDERS),
        ):
            if not isinstance(name, str) or name not in known:
                raise UnknownName(what, name, known)
        if checked_snr(self.snr_db) < LEAST_SNR_OF_PLANT and self.reading == "plant":
            raise InvalidValue(
                "snr_db", self.snr_db, f"at least {LEAST_SNR_OF_PLANT:g} under the reading 'plant'"
            )
        for name, least in (
            ("seed", 0),
            ("n_terms", 1),
            ("levels", 1),
            ("samples", 2),
            ("delay", 0),
        ):
            checked_count(name, getattr(self, name), least)
        for name in ("duration", "period"):
            checked_positive(name, getattr(self, name))
        if not self.period <= self.duration <= MOST_STEPS * self.period:
            raise InvalidValue(
                "duration",
                self.duration,
                f"at least one and at most {MOST_STEPS:,} periods of {self.period} s",
            )
        every = round(THESIS_SAMPLING_PERIOD / self.period)
        if abs(every * self.period - THESIS_SAMPLING_PERIOD) > 1e-9 * THESIS_SAMPLING_PERIOD:
            raise InvalidValue(
                "period",
                self.period,
                f"{THESIS_SAMPLING_PERIOD} s, at which errors are summed, or a whole part of it",
            )
        if self.mean_variation is not None:
            checked_not_negative("mean_variation", self.mean_variation)
        checked_positive("term_width", self.term_width)
        for name in ("payload", "encoder_resolution"):
            checked_not_negative(name, getattr(self, name))
        self._drive()
        for name in OF_PLANT:
            if getattr(self, name) > 0.0 and self.reading != "plant":
                raise InvalidValue(name, getattr(self, name), "0, but under the reading 'plant'")
        _desired(self.trajectory, self.parameters, self.duration, self.period)
        if self.controller in KINDS:
            # Terms as wide as they are learned reach every sample, whatever the kind.
            narrow = (
                (self.controller, self.canonical().mean_variation, self.term_width)
                if self.term_width < 1.0
                else ()
            )
            _try_to_learn(self.parameters, self.learner, self.n_terms, self.samples, *narrow)
            if self.reading == "inputs" and self.snr_db < math.inf:
                _learned_from_noisy_inputs(self.canonical())

    @property
    def noise(self) -> RecordNoise:
        """What the signal-to-noise ratio means on a record."""
        return RecordNoise(self.snr_reference, self.noisy_entries, self.reading == "inputs")

    def _drive(self) -> Drive:
        return Drive(self.coulomb_friction, self.viscous_friction, self.motor_inertia, self.lead)

    def canonical(self) -> Run:
        """Return the same run with every field that cannot matter at its default.

        The mean variation is the one that is used.

        Runs with the same canonical form have the same results, so a study does them once.
        """
        run, default = self, Run()

        def reset(*names: str) -> Run:
            return replace(run, **{name: getattr(default, name) for name in names})

        if run.controller in CLASSICAL:
            run = reset(
                "learner",
                "n_terms",
                "mean_variation",
                "levels",
                "reduction",
                "outside",
                "term_width",
                "samples",
                "defuzzify",
            )
        else:
            if run.controller == "t1":
                run = replace(run, mean_variation=0.0)
            elif run.mean_variation is None:
                run = replace(run, mean_variation=float(mean_variation_from_snr(run.snr_db)))
            if run.controller != "gt2":
                run = reset("levels", "reduction", "defuzzify")
            elif run.reduction == "gaussian":
                run = reset("levels", "defuzzify")
            elif run.levels == 1:
                # The one cut's middle, by the same sums.
                run = reset("defuzzify")
        if self.motor_inertia == 0.0:
            # All forces are those at the nuts.
            run = reset("lead")
        if run._sees_no_noise():
            run = replace(
                reset("snr_reference", "noisy_entries"),
                snr_db=math.inf,
                seed=0,
                reading="plant" if any(getattr(run, name) for name in OF_PLANT) else "parameters",
            )
        if run.reading not in ("parameters", "online"):
            run = reset("noisy_entries")
        if run.reading == "plant":
            run = reset("snr_reference")
        return run

    def _sees_no_noise(self) -> bool:
        blind = {
            "parameters": tuple(CLASSICAL),
            "inputs": tuple(CLASSICAL),
            "measurement": ("feed-forward",),
            # Of the exact model, PD with gravity takes G alone.
            "online": ("pd", "pd-gravity") if self.noisy_entries == "mass-coriolis" else ("pd",),
        }.get(self.reading, ())
        return self.controller in blind or self.snr_db == math.inf

    def __str__(self) -> str:
        default = Run()
        changed = [
            f"{field.name}={getattr(self, field.name)!r}"
            for field in fields(self)
            if self._differs(default, field.name)
        ]
        return f"Run({', '.join(changed)})"

    def _differs(self, default: Run, name: str) -> bool:
        return name == "controller" or bool(getattr(self, name) != getattr(default, name))


def execute(run: Run) -> dict[str, float]:
    r"""Do a run and return its metrics.

    Parameters
    ----------
    run : Run
        The run.

    Returns
    -------
    dict
        By name, in the order of ``METRICS``: sum of squared errors at one sample per 0.05 s [m²]
        and its integral [m² s]; root mean square and largest error of each screw, and of the tip
        [m]; effort :math:`\int \lVert\tau\rVert^2 dt` [N² s] and largest torque [N]; share of the
        steps inside the trained range, and of those that fell back on the average over the rules; 1
        if a nut left the stroke of its screw (the run goes on, as in the thesis there is no end to
        a screw); 1 if the run diverged, that is ended before its time, because the robot left the
        poses it can take; the time when it ended [s]. Errors of runs that diverged are NaN.

    Raises
    ------
    InvalidValue, UnknownName
        As from :meth:`Run.check`.
    StrokeExceeded
        If the trajectory leaves the screws in the duration.
    fuzzy2.errors.InvalidValue, fuzzy2.errors.UnsupportedRule, UnusableEstimate
        If the rules cannot be learned.
    """
    return measure(simulate_run(run), run)


@dataclass(frozen=True)
class Samples:
    """What :func:`simulate_run` returns.

    A result, which may end before its time, and what the controller said of itself.

    Parameters
    ----------
    result : Result
        Samples of the run, with the flags of the controller.
    steps : int
        Number of samples of a whole run.
    """

    result: Result
    steps: int


def simulate_run(run: Run) -> Samples:
    """Simulate a run.

    The loop is compiled and holds no interpreter lock, so threads run side by side.

    Parameters
    ----------
    run : Run
        The run.

    Returns
    -------
    Samples

    Raises
    ------
    InvalidValue, UnknownName, StrokeExceeded, UnusableEstimate
        As from :func:`execute`.
    fuzzy2.errors.InvalidValue, fuzzy2.errors.UnsupportedRule
        As from :func:`execute`.
    """
    run.check()
    robot = _robot(run.parameters)
    t, desired = _desired(run.trajectory, run.parameters, run.duration, run.period)
    plant, measured, added = robot.parameters.as_array(), None, nothing_added(18)
    # One stream for each use of noise (that of rules is 0), so that runs of one seed can be paired
    # whatever else they draw.
    noise = np.random.default_rng([run.seed, 1])
    ratio = 10.0 ** (-run.snr_db / 20.0)
    noisy = run.snr_db < math.inf
    if run.reading == "measurement" and noisy:
        recorded = _record(run.parameters)
        state = np.concatenate([recorded.heights, recorded.speeds], axis=1)
        measured = ratio * run.noise.amplitudes(state) * noise.standard_normal((len(t), 6))
    elif run.reading == "online" and noisy:
        amplitudes = run.noise.output_amplitudes(_record(run.parameters))
        added = ratio * amplitudes * noise.standard_normal((len(t), 18))
    elif run.reading == "plant":
        plant = mismatched(robot.parameters, ratio, run.payload, noise).as_array()
    wiring = unbounded(run.period, np.full(3, run.encoder_resolution), run.delay, measured)
    controller, said = _controller(run, robot, added)
    track = new_track(t, desired, said)
    steps = ClosedFormSteps(plant, 1, run._drive())
    state = np.concatenate([desired.heights[0], np.zeros(3)])
    done = compiled_loop(controller, steps, wiring, track, state).samples
    heights, speeds = (track.states[:done, i : i + 3].copy() for i in (0, 3))
    flags = (
        reported(track.wrote[:done])
        if said
        else {"covered": np.ones(done, bool), "fell_back": np.zeros(done, bool)}
    )
    result = Result(
        t[:done],
        heights,
        speeds,
        Motion(*(array[:done] for array in desired)),
        track.applied[:done].copy(),
        _tips(robot, heights),
        covered=flags["covered"],
        fell_back=flags["fell_back"],
    )
    return Samples(result, len(t))


def measure(samples: Samples, run: Run) -> dict[str, float]:
    """Return the metrics of a simulated run by name, see :func:`execute`."""
    result = samples.result
    finite = bool(np.isfinite(result.torque).all()) if len(result.t) else False
    diverged = len(result.t) < samples.steps or not finite
    error = result.desired.heights - result.heights
    tip_error = np.linalg.norm(result.desired.tip - result.tip, axis=1)
    lower, upper = _robot(run.parameters).stroke
    values = (
        (
            sum_of_squared_errors(result),
            integral_of_squared_error(result),
            *np.sqrt((error**2).mean(axis=0)),
            *np.abs(error).max(axis=0),
            np.sqrt((tip_error**2).mean()),
            largest_tip_error(result),
            np.trapezoid((result.torque**2).sum(axis=1), result.t),
            np.abs(result.torque).max(),
        )
        if not diverged
        else (math.nan,) * 12
    )
    assert result.covered is not None
    assert result.fell_back is not None
    outside = bool(((result.heights < lower) | (result.heights > upper)).any())
    shares = (
        (result.covered.mean(), result.fell_back.mean()) if len(result.t) else (math.nan, math.nan)
    )
    values += (*shares, outside, diverged, result.t[-1] if len(result.t) else 0.0)
    return dict(zip(METRICS, map(float, values), strict=True))


def mismatched(
    parameters: Parameters, ratio: float, payload: float, rng: np.random.Generator
) -> Parameters:
    """Return parameters that are off by a ratio, with a payload on the star.

    Parameters
    ----------
    parameters : Parameters
        What the controller believes.
    ratio : float
        q of the table in :mod:`psp3.study.run`; 0 changes nothing.
    payload : float
        Mass on the star besides the random one [kg].
    rng : numpy.random.Generator
        Source of random numbers.

    Returns
    -------
    changed : Parameters
        Masses and inertias times exp(q ε), the star's mass plus both payloads.
    """
    names = ("nut_mass", "ball_mass", "ball_axial_inertia", "ball_transverse_inertia", "star_mass")
    factors = np.exp(ratio * rng.standard_normal(len(names) + 3)).tolist()
    changed = {
        name: getattr(parameters, name) * factor
        for name, factor in zip(names, factors, strict=False)
    }
    inertia = tuple(
        moment * factor
        for moment, factor in zip(parameters.star_inertia, factors[len(names) :], strict=True)
    )
    changed["star_mass"] += payload + PAYLOAD_PER_MISMATCH * ratio * abs(
        float(rng.standard_normal())
    )
    return replace(parameters, star_inertia=inertia, **changed)


def _controller(run: Run, robot: PSP3, added: Array) -> tuple[NamedTuple, int]:
    """Return the controller of a run as loops take it, and how many numbers it says of a step."""
    model = robot.parameters.as_array()
    if run.controller in CLASSICAL:
        kp, kv = TABLE_6_1["PD" if run.controller.startswith("pd") else "CTC"]
        if run.controller == "feed-forward":
            kp = kv = 0.0
        table, kind = closed_form_table(model), CLASSICAL[run.controller]
        return classical(kind, kp, kv, table, Widths.of_motors(3), added=added), 0
    if run.reading == "inputs" and run.snr_db < math.inf:
        controller = _learned_from_noisy_inputs(run.canonical())
    else:
        controller = trained(run, robot, np.random.default_rng([run.seed, 0])).controller
    exact = NO_MODEL if run.outside == "clamp" else closed_form_table(model)
    return FuzzyRun(controller, exact, added), step_width(3) - 3


def trained(run: Run, robot: PSP3, rng: np.random.Generator) -> FuzzyComputedTorque:
    """Return the trained controller of a run of a fuzzy one.

    ``rng`` is the source of the noise on what is recorded.
    """
    variation = (
        float(mean_variation_from_snr(run.snr_db))
        if run.mean_variation is None
        else run.mean_variation
    )
    controller = FuzzyComputedTorque(
        run.controller,
        robot,
        kp=TABLE_6_1["CTC"][0],
        kv=TABLE_6_1["CTC"][1],
        n_terms=run.n_terms,
        learner=run.learner,
        snr_db=run.snr_db if run.reading in ("parameters", "inputs") else math.inf,
        mean_variation=variation,
        levels=run.levels,
        reduction=run.reduction,
        outside=run.outside,
        term_width=run.term_width,
        defuzzify=run.defuzzify,
    )
    return controller.learn(_record(run.parameters), run.samples, rng, run.noise)


def _tips(robot: PSP3, heights: Array) -> Array:
    return robot.forward_kinematics(heights).tip


# Robots, desired motions and records are the same for all runs of a study, and cost more than a
# run.


@lru_cache(maxsize=8)
def _robot(parameters: str) -> PSP3:
    return load("psp3", parameters=parameters)


@lru_cache(maxsize=32)
def _desired(
    trajectory: str, parameters: str, duration: float, period: float
) -> tuple[Array, Motion]:
    robot = _robot(parameters)
    t = period * np.arange(int(duration / period * (1.0 + 1e-12) + 1e-9) + 1, dtype=np.float64)
    motion = TRAJECTORIES[trajectory](robot)(t)
    check_stroke(robot, t, motion)
    for array in (t, *motion):
        # Results of all runs hold them.
        array.setflags(write=False)
    return t, motion


@lru_cache(maxsize=64)
def _try_to_learn(
    parameters: str,
    learner: str,
    n_terms: int,
    samples: int,
    kind: str = "t1",
    mean_variation: float | None = 0.0,
    width: float = 1.0,
) -> None:
    """Raise what learning raises.

    Which rules have samples depends on inputs alone, and those are the same under all noise but
    that of the reading ``"inputs"``, for which see :func:`_learned_from_noisy_inputs`.
    """
    controller = FuzzyComputedTorque(
        kind,
        _robot(parameters),
        learner=learner,
        n_terms=n_terms,
        mean_variation=mean_variation,
        term_width=width,
    )
    controller.learn(_record(parameters), samples)


@lru_cache(maxsize=8)
def _learned_from_noisy_inputs(run: Run) -> Fuzzy:
    """Return the controller that learned from noisy inputs; the check of a run needs it, too."""
    return trained(run, _robot(run.parameters), np.random.default_rng([run.seed, 0])).controller


@lru_cache(maxsize=8)
def _record(parameters: str) -> Record:
    robot = _robot(parameters)
    return record(robot, TRAJECTORIES[FIRST_TRAJECTORY](robot))

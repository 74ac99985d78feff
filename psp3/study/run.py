r"""One run of a study: its fields, and the values that they may have.

A controller tracks a trajectory under a noise, and its errors are measured
(:mod:`psp3.study.execution`). The fields of :class:`Run` determine a run completely, so a run can
be repeated anywhere from its row in a table of results. The thesis does not say where its noise
acts. A reading is one interpretation, and there are five:

=============  =====================================================================================
reading        what a signal-to-noise ratio S means (q = 10^(−S/20) is the ratio of amplitudes)
=============  =====================================================================================
parameters     white noise on the recorded M, C and G from which rules are learned; the other
               controllers never see it
inputs         white noise on the recorded inputs from which rules are learned (differences of
               heights and speeds of the 3-PSP), M, C and G being exact; the other controllers never
               see it
measurement    white noise on measured positions and speeds at run time, seen by servo and estimator
online         white noise on the controller's M, C and G at run time
plant          every mass and inertia of the robot is off by a factor exp(q ε), and on the 3-PSP a
               payload of 5 kg · q abs(ε) rides on the star
=============  =====================================================================================

The power of a signal is its mean square over the recorded training run, mean included, element by
element. The thesis defines neither this power nor which elements are noisy, and its comparison has
another outcome under other definitions: the fields ``snr_reference`` and ``noisy_entries`` choose
among them.

Further fields, which no signal-to-noise ratio scales, give the plant a payload, wrong masses,
drives with friction and motor inertia, encoders with a finite resolution, separate measurement
noise, a delay and a start beside the path.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import cache, lru_cache
from itertools import islice
from operator import attrgetter
from typing import Any, get_args, get_type_hints

import numpy as np

from fuzzy2.errors import printable
from fuzzy2.learning.noise import mean_variation_from_snr
from fuzzy2.learning.partition import KINDS
from fuzzy2.support.markup import Markup, element
from psp3.checks import (
    MOST,
    MOST_SEEDS,
    checked_count,
    checked_not_negative,
    checked_number,
    checked_positive,
    known_name,
)
from psp3.description.parts import ROBOTS
from psp3.drives.drive import Drive
from psp3.errors import InvalidValue, UnknownName, UnknownRobot
from psp3.fuzzy_control.computed_torque import (
    ORDERS,
    OUTSIDE,
    REDUCTIONS,
    SAMPLES,
    checked_snr,
)
from psp3.fuzzy_control.records import ENTRIES, REFERENCES
from psp3.fuzzy_control.rule_bases import LEARNERS
from psp3.loading import ENDINGS
from psp3.published import DURATION, TABLE_6_1_TERMS, THESIS_SAMPLING_PERIOD
from psp3.simulation.metrics import METRICS as METRICS
from psp3.study.paths import DRAWN, names_of_paths
from psp3.three_psp.parameters import PARAMETER_SETS

CLASSICAL = ("feed-forward", "pd", "pd-gravity", "ctc", "ctc-integral", "lqr", "lqr-stiff")
"""Names of the controllers that do not learn: open loop, PD, PD with gravity, computed torque with
the exact model, the same with an integral of the error, and linear-quadratic regulators about as
stiff as computed torque and ten times as stiff.
"""

ADAPTIVE = {"adaptive-t1": "t1", "adaptive-it2": "it2"}
"""Names of the controllers whose rules adapt, and the kinds of their rules."""

FUZZY = (*KINDS, *ADAPTIVE)
"""Names of the controllers that learn rules."""

TYPE_1 = ("t1", "adaptive-t1")
"""Names of the controllers whose rules are of type 1 and have no mean variation."""

CONTROLLERS = (*CLASSICAL, *FUZZY)
"""Names of the built-in controllers. Any other is named by its location, ``"module:Name"``."""

READINGS = ("parameters", "measurement", "online", "plant", "inputs")
"""Names of the readings of noise."""

OF_PLANT = (
    "payload",
    "coulomb_friction",
    "viscous_friction",
    "motor_inertia",
    "encoder_resolution",
    "delay",
    "payload_from",
    "mass_mismatch",
    "position_noise",
    "speed_noise",
    "initial_error",
    "initial_speed_error",
)
"""Fields that say how the plant differs from the controllers' model: none is negative, and all are
zero by default.
"""

DRAWN_BY_SEED = (
    "mass_mismatch",
    "position_noise",
    "speed_noise",
    "initial_error",
    "initial_speed_error",
)
"""Fields for which the seed draws random numbers."""

OF_LEARNING = (
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
"""Fields that concern only controllers that learn rules."""

LEAST_SNR_OF_PLANT = -20.0
"""Least signal-to-noise ratio under the reading ``"plant"`` [dB]: masses are off by factors up to
exp(±40).
"""

MOST_STEPS = 10_000_000
"""Number of control periods of the longest run."""

LARGEST_INTEGER = 2**63 - 1
"""Largest integer that a field may hold, which is SQLite's limit."""

Value = str | int | float | None


@dataclass(frozen=True, slots=True, repr=False)
class Run:
    """The settings that determine a run.

    The constructor checks nothing; :meth:`check` does, and so does
    :func:`psp3.study.execution.execute` before it begins.

    Parameters
    ----------
    controller : str
        One of ``CONTROLLERS``, or ``"module:Name"``: a callable that takes the robot and returns a
        controller, or an estimator with ``fit(X, Y)`` and ``predict(X)``, see
        :mod:`psp3.study.entries`.
    reading : str
        One of ``READINGS``.
    snr_db : float
        Signal-to-noise ratio [dB]; infinite for none.
    seed : int
        Seed of the noise. Runs of one seed see the same noise whatever the controller, and at every
        signal-to-noise ratio it differs only in amplitude, so controllers can be compared in pairs.
    trajectory : str, optional
        A name in :mod:`psp3.study.paths`; by default the first one of the robot, which is
        ``"helix"`` for the 3-PSP and ``"sway"`` for any other robot.
    learner, n_terms, mean_variation, levels, reduction, outside, term_width, samples
        See :class:`psp3.FuzzyComputedTorque`. The learner that the thesis cites, table look-up, is
        ``"strict"``. The default is ``"strongest"`` with 209 samples and two terms per input for
        the 3-PSP, and ``"least-squares"`` without a grid for any other robot.
    payload : float
        Mass that no controller models [kg]: at the center of the 3-PSP's star, and at the frame
        ``tip`` of any other robot.
    coulomb_friction, viscous_friction, motor_inertia, lead
        Drive of each motor, see :class:`psp3.drives.drive.Drive` [N], [N s/m], [kg m²], [m per
        revolution].
    encoder_resolution : float
        Travel of a joint per count of its encoder [m or rad], see :func:`psp3.simulate`.
    delay : int
        Number of control periods by which the forces are delayed, see :func:`psp3.simulate`.
    parameters : str
        Name of the 3-PSP's parameter set.
    duration, period : float
        Length of the run and control period [s].
    snr_reference : str
        Power that the signal-to-noise ratio refers to, one of
        :data:`psp3.fuzzy_control.records.REFERENCES`: a signal's mean square, its variance, or 1 in
        its unit. Ignored under the reading ``"plant"``.
    noisy_entries : str
        Which of M, C and G are noisy under the readings ``"parameters"`` and ``"online"``, one of
        :data:`psp3.fuzzy_control.records.ENTRIES`.
    defuzzify : str
        Whether M, C and G are defuzzified (``"first"``) or the fuzzy torque is (``"last"``), see
        :class:`psp3.FuzzyComputedTorque`. It matters only for ``"gt2"`` with two α-planes or more:
        for all others the torque is the same number either way.
    robot : str
        Name of a robot or path of its file, as for :func:`psp3.load`.
    kp, kv : float, optional
        Gains, in the units that the controller takes. The defaults are those of Table 6.1 for the
        3-PSP, and critically damped ones for any other robot
        (:func:`psp3.control.default_gains.default_gains`).
    learned_on : str, optional
        The trajectory whose record the rules are learned from, and which sets the scale of the
        noise; by default the first one of the robot.
    learning_seed : int, optional
        Seed of the noise on the record that rules are learned from; ``seed`` by default. If all
        runs share it, they share one controller.
    payload_from : float
        Time at which the robot picks up the payload [s].
    mass_mismatch : float
        q of the reading ``"plant"``, to be combined with another reading.
    position_noise, speed_noise : float
        Standard deviations of white noise on measured positions [m or rad] and speeds.
    initial_error, initial_speed_error : float
        Standard deviations of the errors of positions and speeds at the start [m or rad, per s].
    """

    controller: str = "it2"
    reading: str = "parameters"
    snr_db: float = math.inf
    seed: int = 0
    trajectory: str | None = None
    learner: str | None = None
    n_terms: int | None = None
    mean_variation: float | None = None
    levels: int = 5
    reduction: str = "alpha_planes"
    outside: str = "clamp"
    term_width: float = 1.0
    samples: int | None = None
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
    robot: str = "psp3"
    kp: float | None = None
    kv: float | None = None
    learned_on: str | None = None
    learning_seed: int | None = None
    payload_from: float = 0.0
    mass_mismatch: float = 0.0
    position_noise: float = 0.0
    speed_noise: float = 0.0
    initial_error: float = 0.0
    initial_speed_error: float = 0.0

    def __repr__(self) -> str:
        """Return the fields that differ from their defaults, as in a constructor call."""
        changed = [
            f"{field.name}={getattr(self, field.name)!r}"
            for field in fields(self)
            if field.name != "controller" and getattr(self, field.name) != field.default
        ]
        return f"Run({', '.join([repr(self.controller), *changed])})"

    def _repr_html_(self) -> Markup:
        """Return the HTML that a notebook shows."""
        return element("code", printable(repr(self)))

    def __post_init__(self) -> None:
        # Equal numbers must give equal runs, so NumPy's numbers, common in grids, become Python's,
        # and 20 becomes 20.0. Anything else stays as it is, and the check refuses it.
        for value in _floats_of(self):
            if type(value) is not float and value is not None:
                self._take_numbers()
                return
        for value in _others_of(self):
            if isinstance(value, np.generic):
                self._take_numbers()
                return

    def _take_numbers(self) -> None:
        """Convert NumPy's numbers to Python's, and integers to floats in float fields."""
        for name in _TYPES:
            value = getattr(self, name)
            plain = value.item() if isinstance(value, np.generic) else value
            if name in _FLOATS and type(plain) is int:
                # A value that is not a float stays as it is, and the check refuses it.
                with suppress(OverflowError):
                    plain = float(plain)
            object.__setattr__(self, name, plain)

    def check(self) -> None:
        """Raise an error if a field is invalid; nothing is loaded, moved or learned.

        Raises
        ------
        UnknownName, UnknownRobot
            If a name is unknown.
        InvalidValue
            If a number is out of range.
        """
        self._check_names()
        if checked_snr(self.snr_db) < LEAST_SNR_OF_PLANT and self.reading == "plant":
            raise InvalidValue(
                "snr_db", self.snr_db, f"at least {LEAST_SNR_OF_PLANT:g} under the reading 'plant'"
            )
        for (name, least), value in zip(_LEAST, _counts_of(self), strict=True):
            is_fine = type(value) is int and least <= value <= LARGEST_INTEGER
            if not is_fine and checked_count(name, value, least) > LARGEST_INTEGER:
                raise InvalidValue(name, value, "less than 2**63")
        for name, least in (("learning_seed", 0), ("n_terms", 1), ("samples", 2)):
            value = getattr(self, name)
            if value is not None and checked_count(name, value, least) > LARGEST_INTEGER:
                raise InvalidValue(name, value, "less than 2**63")
        for name in _POSITIVE:
            checked_positive(name, getattr(self, name))
        for name, value in zip(_NOT_NEGATIVE, _amounts_of(self), strict=True):
            is_fine = type(value) is float and 0.0 <= value < math.inf
            if not is_fine and not (value is None and name in _OPTIONAL):
                checked_not_negative(name, value)
        _check_times(self.duration, self.period)
        if self.motor_inertia > 0.0 or self.lead is not None:
            self.drive  # noqa: B018 # raises what is wrong with it
        if self.mass_mismatch > 0.0 and self.reading == "plant":
            raise InvalidValue(
                "mass_mismatch",
                self.mass_mismatch,
                "0 under the reading 'plant', whose snr_db says how far masses are off",
            )

    def _check_names(self) -> None:
        _check_robot(self.robot, self.parameters)
        if not _is_place(self.controller):
            _check_name("controller", self.controller, CONTROLLERS)
        for what, name, known in (
            ("reading", self.reading, READINGS),
            ("reduction", self.reduction, REDUCTIONS),
            ("treatment of inputs outside of the trained range", self.outside, OUTSIDE),
            ("reference of the signal-to-noise ratio", self.snr_reference, REFERENCES),
            ("choice of noisy entries", self.noisy_entries, ENTRIES),
            ("order of defuzzification", self.defuzzify, ORDERS),
        ):
            if type(name) is not str or name not in known:
                _check_name(what, name, known)
        if self.learner is not None:
            _check_name("learner", self.learner, LEARNERS)
        paths = names_of_paths(self.robot)
        for path in (self.trajectory, self.learned_on):
            if path is not None:
                _check_name("trajectory", path, paths)
        if self.learned_on in DRAWN:
            raise InvalidValue(
                "learned_on", self.learned_on, "a trajectory that does not depend on the seed"
            )

    @property
    def drive(self) -> Drive:
        """Drive of each motor."""
        return Drive(self.coulomb_friction, self.viscous_friction, self.motor_inertia, self.lead)

    @property
    def learns(self) -> bool:
        """Whether the controller learns from a record."""
        return self.controller not in CLASSICAL

    def canonical(self) -> Run:
        """Return the same run with all irrelevant fields at their defaults.

        The mean variation and the trajectories that are used by default are filled in.

        Runs with the same canonical form have the same results, so a study does them once.
        """
        changed = self.canonical_changes()
        return replace(self, **changed) if changed else self  # type: ignore[arg-type]

    def canonical_changes(self) -> dict[str, Value]:
        """Return the fields that :meth:`canonical` changes, with their values there."""
        changed: dict[str, Value] = {}
        if self.trajectory is None:
            changed["trajectory"] = names_of_paths(self.robot)[0]
        self._drop_learning(changed)
        if self.controller == "feed-forward":
            changed |= {"kp": None, "kv": None}
        if self.motor_inertia == 0.0:
            # The lead matters only for the motor's inertia; friction is given at the joints.
            changed["lead"] = None
        if self.payload == 0.0:
            changed["payload_from"] = 0.0
        reading = self.reading
        if self._sees_no_noise():
            reading = "parameters"
            changed |= {"snr_db": math.inf, "reading": reading, "snr_reference": "mean-square"}
            changed["noisy_entries"] = "all"
        if not self.counts_seed:
            changed["seed"] = 0
        if reading not in ("parameters", "online"):
            changed["noisy_entries"] = "all"
        if reading == "plant":
            changed["snr_reference"] = "mean-square"
        # Noise at run time is scaled by the record, too.
        is_recorded = self.learns or reading in ("measurement", "online")
        known = names_of_paths(self.robot)[0] if self.learned_on is None else self.learned_on
        changed["learned_on"] = known if is_recorded else None
        if self._sees_no_noise() or not self._is_noise_of_records:
            changed["learning_seed"] = None
        return {name: value for name, value in changed.items() if getattr(self, name) != value}

    @property
    def variation_follows_noise(self) -> bool:
        """Whether the signal-to-noise ratio sets the mean variation."""
        return self.mean_variation is None and (
            self.controller in FUZZY and self.controller not in TYPE_1
        )

    @property
    def counts_seed(self) -> bool:
        """Whether the results depend on the seed."""
        is_drawn_once = self._is_noise_of_records and self.learning_seed is not None
        return (
            not (self._sees_no_noise() or is_drawn_once)
            or any(getattr(self, name) for name in DRAWN_BY_SEED)
            or self.trajectory in DRAWN
        )

    @property
    def _is_noise_of_records(self) -> bool:
        return self.reading in ("parameters", "inputs")

    def _drop_learning(self, changed: dict[str, Value]) -> None:
        """Add the canonical values of the learning fields to ``changed``."""
        if self.controller in CLASSICAL or _is_place(self.controller):
            kept = ("samples",) if _is_place(self.controller) else ()
            changed.update((name, DEFAULTS[name]) for name in OF_LEARNING if name not in kept)
            return
        is_ours = self.robot == "psp3"
        if self.learner is None:
            changed["learner"] = "strongest" if is_ours else "least-squares"
        if self.samples is None and is_ours:
            changed["samples"] = SAMPLES
        if self.n_terms is None and is_ours:
            changed["n_terms"] = TABLE_6_1_TERMS
        if self.controller in TYPE_1:
            changed["mean_variation"] = 0.0
        elif self.variation_follows_noise:
            changed["mean_variation"] = variation_of(self.snr_db)
        if self.controller != "gt2":
            dropped: tuple[str, ...] = ("levels", "reduction", "defuzzify")
        elif self.reduction == "gaussian":
            dropped = ("levels", "defuzzify")
        elif self.levels == 1:
            # With one α-plane both orders give its middle, by the same sums.
            dropped = ("defuzzify",)
        else:
            dropped = ()
        changed.update((name, DEFAULTS[name]) for name in dropped)

    def _sees_no_noise(self) -> bool:
        if self.snr_db == math.inf:
            return True
        if self.reading in ("parameters", "inputs"):
            return self.controller in CLASSICAL
        if self.reading == "measurement":
            return self.controller == "feed-forward"
        if self.reading == "online":
            # PD with gravity uses only G of the exact model.
            is_without_gravity = self.noisy_entries == "mass-coriolis"
            return self.controller == "pd" or (
                self.controller == "pd-gravity" and is_without_gravity
            )
        return False

    def __str__(self) -> str:
        default = Run()
        changed = [
            f"{name}={value!r}"
            for name, value in contents(self).items()
            if name == "controller" or bool(value != getattr(default, name))
        ]
        return f"Run({', '.join(changed)})"


@cache
def field_types() -> dict[str, type[str] | type[int] | type[float]]:
    """Return the type of every field of :class:`Run`, without None."""
    hints = get_type_hints(Run)
    return {
        field.name: next(iter(get_args(hints[field.name])), hints[field.name])
        for field in fields(Run)
    }


def values_of_field(name: str, given: Any) -> list[Value]:
    """Return the value or values given for a field of runs as a list.

    Raises
    ------
    UnknownName
        If a run has no such field.
    InvalidValue
        If a value does not have the field's type, or there are too many values.
    """
    known_name("field of a run", name, field_types())
    single = str | bytes | np.ma.MaskedArray
    is_list = isinstance(given, Iterable) and not isinstance(given, single)
    try:
        several = list(islice(given, MOST_SEEDS + 1)) if is_list else [given]
    except TypeError:  # an array without dimensions
        several = [given]
    if len(several) > MOST_SEEDS:
        raise InvalidValue(name, given, f"at most {MOST_SEEDS:,} values")
    return [_of_type(name, field_types()[name], value) for value in several]


def _of_type(name: str, kind: type[str] | type[int] | type[float], value: Any) -> Value:
    """Return a value in the type of its field; NumPy's numbers become Python's."""
    plain = value.item() if isinstance(value, np.generic) else value
    if plain is None and DEFAULTS[name] is None:
        return None
    if kind is float:
        return checked_number(name, plain, "a number")
    is_too_large = isinstance(plain, int) and abs(plain) > MOST
    if not isinstance(plain, kind) or isinstance(plain, bool) or is_too_large:
        wanted = "an integer of at most 63 bits" if is_too_large else "an integer"
        raise InvalidValue(name, plain, "a text" if kind is str else wanted)
    return plain


def contents(run: Run) -> dict[str, Any]:
    """Return the values of a run's fields by name, each in the type of its field."""
    return dict(zip(field_types(), values_of(run), strict=True))


_TYPES = {field.name: str(field.type).split(" | ")[0] for field in fields(Run)}
DEFAULTS: dict[str, Value] = {field.name: field.default for field in fields(Run)}  # type: ignore[misc]
_OPTIONAL = tuple(name for name, value in DEFAULTS.items() if value is None)
_FLOATS = tuple(name for name, kind in _TYPES.items() if kind == "float")
_OTHERS = tuple(name for name in _TYPES if name not in _FLOATS)
_LEAST = (("seed", 0), ("levels", 1), ("delay", 0))
_POSITIVE = ("duration", "period", "term_width")
_NOT_NEGATIVE = (
    "mean_variation",
    "kp",
    "kv",
    *(name for name in OF_PLANT if _TYPES[name] == "float"),
)

AMOUNTS = tuple(name for name in _NOT_NEGATIVE if name != "motor_inertia")
"""Fields that are never negative and do not interact with others: the check compares them with no
other field, and the canonical form asks only whether they are given and whether they are zero.
"""

values_of = attrgetter(*_TYPES)
"""Returns the values of a run's fields as a tuple, in the order of the fields."""

_floats_of, _others_of = attrgetter(*_FLOATS), attrgetter(*_OTHERS)
_counts_of = attrgetter(*(name for name, _ in _LEAST))
_amounts_of = attrgetter(*_NOT_NEGATIVE)


@lru_cache(maxsize=10_000)
def variation_of(snr_db: float) -> float:
    """Return the mean variation for a signal-to-noise ratio [dB]."""
    return float(mean_variation_from_snr(snr_db))


def _is_place(controller: object) -> bool:
    """Return whether a name is the location of a controller."""
    if type(controller) is not str or ":" not in controller:
        return False
    module, _, name = controller.partition(":")
    return name.isidentifier() and all(part.isidentifier() for part in module.split("."))


def _check_name(what: str, name: object, known: tuple[str, ...]) -> None:
    if not isinstance(name, str) or name not in known:
        raise UnknownName(what, name, known)


def _check_robot(robot: object, parameters: object) -> None:
    if not isinstance(robot, str) or not (robot in ROBOTS or robot.lower().endswith(ENDINGS)):
        raise UnknownRobot(robot, ROBOTS)
    known = tuple(PARAMETER_SETS) if robot == "psp3" else ("default",)
    _check_name("parameter set", parameters, known)


def _check_times(duration: float, period: float) -> None:
    if not period <= duration <= MOST_STEPS * period:
        raise InvalidValue(
            "duration", duration, f"at least one and at most {MOST_STEPS:,} periods of {period} s"
        )
    every = round(THESIS_SAMPLING_PERIOD / period)
    if abs(every * period - THESIS_SAMPLING_PERIOD) > 1e-9 * THESIS_SAMPLING_PERIOD:
        raise InvalidValue(
            "period",
            period,
            f"{THESIS_SAMPLING_PERIOD} s, at which errors are summed, or an integer fraction of it",
        )

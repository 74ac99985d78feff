r"""The controller of chapter 5.

Computed torque with M, C and G estimated by a fuzzy system from four differences.

.. math:: \tau = \alpha\,(\ddot a_d + k_v \dot e + k_p e) + \beta, \qquad
          \alpha = M, \quad \beta = C \dot a + G

M, C and G are fuzzy numbers, the type-reduced outputs of one rule base; so are :math:`\alpha`,
:math:`\beta` and the torque, which the thesis defuzzifies last. Intervals and Gaussian numbers are
affine (Theorems 1.4, 1.5): their crisp torque is the same when M, C and G are defuzzified first,
which is what :meth:`FuzzyComputedTorque.torque` does unless it is told otherwise. Numbers by
α-planes are of no such kind. Their torque depends on the order, and ``defuzzify="last"`` takes the
thesis's: the centroid (eq. 1.68) of the fuzzy torque. Either way it is one compiled call.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.files.json_files import from_json, to_json
from fuzzy2.learning.noise import mean_variation_from_snr
from fuzzy2.learning.partition import KINDS
from fuzzy2.learning.wang_mendel import LEARNERS, WangMendel
from fuzzy2.numbers.affine import GaussianNumber, IntervalNumber
from fuzzy2.reduction.general import cut_centroid
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.support.compiled import only_for
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System
from psp3.checks import (
    Array,
    checked_count,
    checked_not_negative,
    checked_number,
    checked_positive,
    one_row,
)
from psp3.control.controller import Widths
from psp3.errors import (
    InvalidControllerFile,
    InvalidValue,
    NotTrained,
    UnknownName,
    UnusableEstimate,
)
from psp3.fuzzy_control import kernels
from psp3.fuzzy_control.records import (
    INPUT_NAMES,
    NOISE_OF_THE_STUDY,
    OUTPUT_NAMES,
    Record,
    RecordNoise,
    differences,
    record,
    unpack,
)
from psp3.loading import load
from psp3.published import DURATION
from psp3.three_psp.parameters import Parameters
from psp3.three_psp.robot import PSP3
from psp3.trajectories.motion import Motion
from psp3.trajectories.trajectory import Trajectory

FORMAT = "psp3-fuzzy-computed-torque-1"
"""Written into every controller file; a file with another mark is refused."""

OUTSIDE = ("clamp", "crisp")
"""What to do outside of the trained range: take the nearest inputs in it, or the exact M, C and
G.
"""

REDUCTIONS = ("alpha_planes", "gaussian")
"""Type reductions of the general type-2 controller."""

ORDERS = ("first", "last")
"""When to defuzzify: M, C and G before the torque is computed, or the fuzzy torque."""

LEAST_SNR = -100.0
"""Least signal-to-noise ratio [dB]: noise of a hundred thousand times the signal."""

FuzzyNumbers = IntervalNumber | GaussianNumber

_SYSTEMS = dict(zip(KINDS, (Type1System, IntervalType2System, GeneralType2System), strict=True))
_NO_PLANES, _NO_MOMENTS = np.empty((2, 0)), np.empty((2, 0, kernels.OUTPUTS))
_ROWS = ("heights", "speeds", "desired heights", "desired speeds", "desired accelerations")


class _Named(np.ndarray[Any, np.dtype[np.float64]]):
    """An array whose columns have names, so that errors of learning speak of Δq12 and not of x1."""

    columns = INPUT_NAMES


class FuzzyComputedTorque:
    r"""Computed torque with learned M, C and G: type-1, interval type-2 or general type-2.

    Parameters
    ----------
    kind : {"it2", "t1", "gt2"}
        Kind of the estimators: interval type-2 (Gaussian terms of uncertain mean, center of sets:
        the thesis's), type-1 (the same with mean variation zero), or general type-2 (Gaussian
        secondary grades: the thesis's future work).
    robot : PSP3, optional
        The robot to learn from; ``psp3.load("psp3")`` by default.
    kp, kv : float
        Gains of the servo, 10 [1/s²] and 1 [1/s] in Table 6.1.
    n_terms : int
        Terms of every input; two make 16 rules.
    learner : str
        How rules are learned, see :class:`fuzzy2.WangMendel`; by default every rule takes the
        sample that fires it most.
    snr_db : float
        Signal-to-noise ratio of the recorded M, C and G [dB]: noise of that power is added to the
        samples, and the mean variation follows from it. Infinite by default.
    mean_variation : float, optional
        Distance of the terms' smallest and largest mean from the middle as a share of each input's
        range; by default :func:`fuzzy2.mean_variation_from_snr` of ``snr_db``, which is 0 without
        noise.
    levels : int
        α-planes of a general type-2 system, each reduced exactly.
    reduction : {"alpha_planes", "gaussian"}
        Of a general type-2 system. By the Gaussian corollary the torque is that of ``"t1"``,
        whatever the uncertainty, and only its spread is new: cheap monitoring.
    outside : {"clamp", "crisp"}
        What to do outside of the range of the training inputs: take the nearest inputs within, or
        the exact M, C and G.
    term_width : float
        What the standard deviations of the terms are multiplied with after the rules are learned.
        Wider terms average over more rules, in a type-1 controller too: what type-2 gains is to be
        compared with that.
    defuzzify : {"first", "last"}
        What becomes crisp. First, M, C and G do; by α-planes each is then the average of its cuts'
        middles, weighted with their levels. Last, the fuzzy torque does, by its centroid
        (eq. 1.68), as in the thesis. Only α-planes make a difference of it, and whether an estimate
        can be used is asked of the averages in either order.

    Attributes
    ----------
    system_ : fuzzy2 system
        What was learned: 4 inputs, 18 outputs in the order of
        :data:`psp3.fuzzy_control.records.OUTPUT_NAMES`. M is symmetric, because its lower triangle
        is its upper one.
    ranges_ : (2, 4) ndarray
        Smallest and largest training inputs.
    fallback_ : (18,) ndarray
        Average over the rules. It takes the place of an estimate that is not finite, or whose M is
        not positive definite.

    Raises
    ------
    InvalidValue, UnknownName
        If a parameter is not what it must be.

    Notes
    -----
    Source: thesis chapter 5, Figs. 47 and 48. The text says that defuzzifying first is right for
    interval systems only; it is for Gaussian numbers as well. For other shapes it is not: the
    centroid of a sum is not the sum of the centroids.
    """

    system_: FuzzySystem
    ranges_: Array
    fallback_: Array

    def __init__(  # noqa: PLR0913 (public: everything that makes a controller is named here)
        self,
        kind: str = "it2",
        robot: PSP3 | None = None,
        *,
        kp: float = 10.0,
        kv: float = 1.0,
        n_terms: int = 2,
        learner: str = "strongest",
        snr_db: float = math.inf,
        mean_variation: float | None = None,
        levels: int = 5,
        reduction: str = "alpha_planes",
        outside: str = "clamp",
        term_width: float = 1.0,
        defuzzify: str = "first",
    ) -> None:
        for what, name, known in (
            ("kind of controller", kind, KINDS),
            ("learner", learner, LEARNERS),
            ("reduction", reduction, REDUCTIONS),
            ("way outside of the trained range", outside, OUTSIDE),
            ("order of defuzzification", defuzzify, ORDERS),
        ):
            if name not in known:
                raise UnknownName(what, name, known)
        # The method of that name defuzzifies a number.
        self.order = defuzzify
        self.kind, self.learner, self.reduction, self.outside = kind, learner, reduction, outside
        self.kp, self.kv = checked_not_negative("kp", kp), checked_not_negative("kv", kv)
        self.n_terms, self.levels = (
            checked_count("n_terms", n_terms),
            checked_count("levels", levels),
        )
        self.snr_db = checked_snr(snr_db)
        by_rule = float(mean_variation_from_snr(self.snr_db))
        self.mean_variation = (
            by_rule
            if mean_variation is None
            else checked_not_negative("mean_variation", mean_variation)
        )
        if kind == "t1":
            self.mean_variation = 0.0
        self.term_width = checked_positive("term_width", term_width)
        if robot is not None and not isinstance(robot, PSP3):
            raise InvalidValue("robot", robot, 'a robot, such as psp3.load("psp3")')
        self.robot = load("psp3") if robot is None else robot
        self._controller: kernels.Fuzzy | None = None
        self._parameters = self.robot.parameters.as_array()
        self.reset()

    def __repr__(self) -> str:
        trained = "not trained" if self._controller is None else f"{len(self.system_.rules)} rules"
        return (
            f"{type(self).__name__}({self.kind!r}, kp={self.kp:g}, kv={self.kv:g}, "
            f"mean_variation={self.mean_variation:.3g}, {trained})"
        )

    # Learning

    def fit(
        self,
        trajectory: Trajectory,
        duration: float = DURATION,
        samples: int = 209,
        rng: np.random.Generator | None = None,
    ) -> Self:
        """Learn as in chapter 5.

        Track a trajectory with the crisp controller of the same gains, record, and learn from
        samples.

        Parameters
        ----------
        trajectory : Trajectory
            The path to learn on; the thesis's is a helix.
        duration : float
            Length of the training run [s].
        samples : int
            Number of samples, spread evenly over the recorded inputs.
        rng : numpy.random.Generator, optional
            Source of the noise on the samples; a new one by default. Not used at an infinite
            signal-to-noise ratio.

        Returns
        -------
        FuzzyComputedTorque
            The controller itself.

        Raises
        ------
        InvalidValue
            If an input does not change on the trajectory, terms are so narrow that no rule fires on
            a part of it, or a parameter is not what it must be.
        fuzzy2.errors.UnsupportedRule
            If no sample fires some rule by more than 0.001.
        UnusableEstimate
            If the average mass matrix is not positive definite.
        """
        return self.learn(
            record(self.robot, trajectory, duration, kp=self.kp, kv=self.kv), samples, rng
        )

    def learn(
        self,
        recorded: Record,
        samples: int = 209,
        rng: np.random.Generator | None = None,
        noise: RecordNoise = NOISE_OF_THE_STUDY,
    ) -> Self:
        """Learn from a record; see :meth:`fit`. ``noise`` says what the ratio ``snr_db`` means."""
        chosen = recorded.sample(samples)
        inputs, outputs = recorded.inputs[chosen], recorded.outputs[chosen]
        if math.isfinite(self.snr_db):
            rng = np.random.default_rng() if rng is None else rng
            if not isinstance(rng, np.random.Generator):
                raise InvalidValue(
                    "rng", rng, "a numpy.random.Generator, such as numpy.random.default_rng(0)"
                )
            inputs, outputs = noise.added(recorded, chosen, self.snr_db, rng)
        learner = WangMendel(
            self.n_terms,
            self.kind,
            self.mean_variation,
            self.learner,
            # Table look-up is published with completion; what no sample says is no model else.
            "nearest" if self.learner == "strict" else "refuse",
            reduction=self.reduction,
            levels=self.levels,
        )
        system = learner.fit(inputs.view(_Named), outputs).system_
        system = system.replace(output_names=OUTPUT_NAMES)
        if self.term_width != 1.0:
            system = _widened(system, self.term_width)
            uncovered = (system.coverage(inputs) == 0.0).mean()
            if uncovered > 0.0:
                wanted = (
                    f"great enough for a rule to fire everywhere on the path; at {uncovered:.0%} "
                    "of the samples none does"
                )
                raise InvalidValue("term_width", self.term_width, wanted)
        self._take(system, np.stack([inputs.min(axis=0), inputs.max(axis=0)]))
        return self

    def _take(self, system: FuzzySystem, ranges: Array) -> None:
        fallback = np.asarray(system.consequents, dtype=float).mean(axis=0)
        mass = unpack(fallback)[0]
        if not np.isfinite(fallback).all() or np.linalg.eigvalsh(mass)[0] <= 0.0:
            raise UnusableEstimate(mass)
        self.system_, self.ranges_, self.fallback_ = system, ranges, fallback
        kind, product, planes, moments = kernels.INTERVAL, False, _NO_PLANES, _NO_MOMENTS
        if isinstance(system, GeneralType2System):
            if system.reduction == "gaussian":
                kind, product = kernels.COROLLARY, system.grade_t_norm == "product"
                moments = np.stack(system.moments)
            else:
                kind = kernels.CENTROID if self.order == "last" else kernels.PLANES
                planes = np.stack([system.alphas, system.widths])
        assert system.table is not None
        self._controller = kernels.Fuzzy(
            *(kind, float(self.kp), float(self.kv), OUTSIDE.index(self.outside), int(product)),
            *map(_floats, (ranges, fallback, planes, system.table, moments)),
        )
        self._packed = kernels.packed(self._controller)
        self.reset()
        row = np.zeros(3)
        only_for(
            kernels.control_step,
            self._packed,
            self._parameters,
            row,
            row,
            row,
            row,
            row,
            self._step.copy(),
        )

    @property
    def controller(self) -> kernels.Fuzzy:
        """The trained controller as :mod:`psp3.fuzzy_control.kernels` takes it."""
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        return self._controller

    # Control

    def reset(self) -> None:
        """Forget the last call; what was learned stays."""
        self._step = np.full(kernels.STEP, np.nan)

    numbers_said = kernels.STEP - 3

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller as the compiled loop takes it, or None, see :func:`steer`."""
        if type(self) is not FuzzyComputedTorque or widths != Widths.of_motors(3):
            return None
        if self._controller is None:
            return None
        return kernels.FuzzyRun(self._controller, self._parameters, kernels.NOTHING_ADDED)

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Be as after the last of the steps, and return what is reported of all."""
        self._step = steps[-1].copy() if len(steps) else self._step
        return kernels.reported(steps)

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the crisp torque, of shape (3,) [N].

        Defuzzified first or last, as ``defuzzify`` said.

        Parameters
        ----------
        t : float
            Time [s]; not used.
        heights, speeds : (3,) array_like
            Nut heights [m] and speeds [m/s].
        desired : Motion
            Desired heights, speeds and accelerations, (3,) each.

        Returns
        -------
        (3,) ndarray
            Screw forces.

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        InvalidArray
            If heights, speeds or the desired motion are not three finite numbers each.
        UnreachablePose
            If the exact model takes over, and the heights are no pose that the robot can take.
        """
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        # A new array in every call: the torque is a view of it, and stays what it is.
        step = np.empty(kernels.STEP)
        rows = (heights, speeds, desired.heights, desired.speeds, desired.accelerations)
        try:
            done = kernels.control_step(self._packed, self._parameters, *rows, step)
        except TypeError:
            done = -1
        if done != 1:
            # Not contiguous rows of three finite floats: lists will do, and copies of rows that are
            # read-only; the rest is refused.
            a, v, a_d, v_d, acc_d = (
                np.array(one_row(name, row, 3)) for name, row in zip(_ROWS, rows, strict=True)
            )
            if (
                kernels.control_step(self._packed, self._parameters, a, v, a_d, v_d, acc_d, step)
                != 1
                and self.outside == "crisp"
            ):
                self.robot.forward_kinematics(a)
        self._step = step
        torque: Array = step[:3]
        return torque

    @property
    def torque_interval(self) -> Array:
        """Ends of the torque interval of the last call (3, 2) [N].

        The lowest α-plane's for α-planes; (mean, sigma) by the corollary.
        """
        return self._step[3:9].reshape(2, 3).T.copy()

    @property
    def covered(self) -> bool:
        """Whether the inputs of the last call were within the trained range."""
        return bool(self._step[9] > 0.0)

    @property
    def fell_back(self) -> bool:
        """Whether the last estimate was unusable, and the average over the rules took its place."""
        return bool(self._step[10] > 0.0)

    def _inputs(self, heights: ArrayLike, speeds: ArrayLike) -> Array:
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        inputs = differences(heights, speeds)
        return np.clip(inputs, *self.ranges_) if self.outside == "clamp" else inputs

    def estimate(self, heights: ArrayLike, speeds: ArrayLike) -> tuple[Array, Array, Array]:
        """Return the crisp estimates of M, C and G.

        Parameters
        ----------
        heights, speeds : (..., 3) array_like
            Nut heights [m] and speeds [m/s].

        Returns
        -------
        M, C, G : (..., 3, 3), (..., 3, 3), (..., 3) ndarray
            As the fuzzy system gives them, inputs clamped to the trained range if ``outside`` says
            so; no fallback.

        Raises
        ------
        NotTrained, InvalidArray
            As from :meth:`torque`.
        """
        inputs = self._inputs(heights, speeds)
        return unpack(np.asarray(self.system_(inputs)))

    def estimated_numbers(
        self, heights: ArrayLike, speeds: ArrayLike
    ) -> tuple[FuzzyNumbers, FuzzyNumbers, FuzzyNumbers]:
        """Return the estimates of M, C and G as arrays of fuzzy numbers, the type-reduced outputs.

        Parameters
        ----------
        heights, speeds : (..., 3) array_like
            Nut heights [m] and speeds [m/s].

        Returns
        -------
        M, C, G : IntervalNumber or GaussianNumber
            Of the shapes of :meth:`estimate`; by α-planes with the planes as a first dimension
            more, in the order of ``system_.alphas``.

        Raises
        ------
        NotTrained, InvalidArray
            As from :meth:`torque`.
        """
        inputs = self._inputs(heights, speeds)
        if not isinstance(self.system_, GeneralType2System):
            ends = self.system_.type_reduced(inputs)
        elif self.system_.reduction == "gaussian":
            mean, sigma = np.moveaxis(self.system_.type_reduced(inputs), -1, 0)
            grades: Any = self.system_.grade_t_norm
            means, sigmas = unpack(mean), unpack(sigma)
            numbers = [GaussianNumber(m, s, grades) for m, s in zip(means, sigmas, strict=True)]
            return numbers[0], numbers[1], numbers[2]
        else:
            ends = np.moveaxis(self.system_.alpha_cuts(inputs), -2, 0)
        left, right = unpack(ends[..., 0]), unpack(ends[..., 1])
        intervals = [
            IntervalNumber(0.5 * (low + high), 0.5 * (high - low))
            for low, high in zip(left, right, strict=True)
        ]
        return intervals[0], intervals[1], intervals[2]

    def torque_number(self, heights: ArrayLike, speeds: ArrayLike, desired: Motion) -> FuzzyNumbers:
        r"""Return the torque as a fuzzy number.

        It is :math:`\alpha\,(\ddot a_d + k_v \dot e + k_p e) + \beta` in fuzzy arithmetic.

        Parameters
        ----------
        heights, speeds : (3,) array_like
            Nut heights [m] and speeds [m/s].
        desired : Motion
            Desired heights, speeds and accelerations, (3,) each.

        Returns
        -------
        IntervalNumber or GaussianNumber
            Of shape (3,) [N]; by α-planes (L, 3), a row for each plane.

        Raises
        ------
        NotTrained, InvalidArray
            As from :meth:`torque`.
        """
        rows = (heights, speeds, desired.heights, desired.speeds, desired.accelerations)
        a, v, *wanted = (one_row(name, row, 3) for name, row in zip(_ROWS, rows, strict=True))
        M, C, G = self.estimated_numbers(a, v)
        servo = wanted[2] + self.kv * (wanted[1] - v) + self.kp * (wanted[0] - a)
        alpha_part: Any = M @ servo
        number: FuzzyNumbers = alpha_part + C @ v + G
        return number

    def defuzzify(self, number: FuzzyNumbers) -> Array:
        r"""Return the crisp torque of a number.

        Its middle or mean. Over α-planes, :math:`\sum_l \alpha_l c_l / \sum_l \alpha_l`, which is
        what defuzzifying M, C and G first comes to, or with ``defuzzify="last"`` the centroid
        (eq. 1.68), see ``fuzzy2.reduction.general.cut_centroid``.

        Parameters
        ----------
        number : IntervalNumber or GaussianNumber
            As from :meth:`torque_number`.

        Returns
        -------
        (3,) ndarray
            Screw forces [N].

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        """
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        if (
            isinstance(number, GaussianNumber)
            or not isinstance(self.system_, GeneralType2System)
            or self.system_.reduction == "gaussian"
        ):
            return number.defuzzify()
        alphas = self.system_.alphas
        if self.order == "last":
            return cut_centroid(alphas, np.moveaxis(number.interval(), 0, -2))
        return np.asarray(alphas @ number.defuzzify() / alphas.sum())

    # Files

    def save(self, path: str | Path) -> Path:
        """Write the trained controller as JSON.

        The fuzzy system, gains, ranges and the parameters of the robot it was trained for.

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        """
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        content = {
            "format": FORMAT,
            "kind": self.kind,
            "kp": self.kp,
            "kv": self.kv,
            "outside": self.outside,
            "defuzzify": self.order,
            "learner": self.learner,
            "n_terms": self.n_terms,
            "mean_variation": self.mean_variation,
            "term_width": self.term_width,
            "inputs": INPUT_NAMES,
            "outputs": OUTPUT_NAMES,
            "snr_db": self.snr_db if math.isfinite(self.snr_db) else "inf",
            "ranges": self.ranges_.tolist(),
            "robot": self.robot.parameters.as_dict(),
            "system": to_json(self.system_),
        }
        write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", path)
        return Path(path)

    @classmethod
    def load(cls, path: str | Path, robot: PSP3 | None = None) -> FuzzyComputedTorque:
        """Read a controller that :meth:`save` wrote.

        Parameters
        ----------
        path : path
            The file.
        robot : PSP3, optional
            The robot it is meant for; by default one with the parameters in the file.

        Returns
        -------
        FuzzyComputedTorque

        Raises
        ------
        InvalidControllerFile
            If the file is missing, malformed or of another version, or the controller was trained
            for other parameters of the robot, or for other inputs or outputs or in another order.
        """
        try:
            content = json.loads(read_text(path))
            return cls._from(content, robot, path)
        except InvalidControllerFile:
            raise
        except OSError as error:
            raise InvalidControllerFile(
                path, f"cannot be read ({error.strerror or error})"
            ) from error
        except (ValueError, TypeError, OverflowError, RecursionError) as error:
            raise InvalidControllerFile(
                path, f"is not a whole controller file ({error})"
            ) from error
        except KeyError as error:
            raise InvalidControllerFile(path, f"lacks {error.args[0]!r}") from error

    @classmethod
    def _from(cls, content: Any, robot: PSP3 | None, path: str | Path) -> FuzzyComputedTorque:
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            found = content.get("format") if isinstance(content, dict) else type(content).__name__
            raise InvalidControllerFile(
                path, f"has format {found!r}, this version reads {FORMAT!r}"
            )
        for what, names in (("inputs", INPUT_NAMES), ("outputs", OUTPUT_NAMES)):
            if tuple(content[what]) != names:
                raise InvalidControllerFile(
                    path,
                    f"has the {what} {', '.join(content[what])}, this version needs "
                    f"{', '.join(names)}",
                )
        parameters = Parameters(
            **{name: content["robot"][name] for name in Parameters().as_dict() | content["robot"]}
        )
        if robot is not None and robot.parameters != parameters:
            given = robot.parameters.as_dict()
            other = [
                f"{name} {value} (yours {given[name]})"
                for name, value in parameters.as_dict().items()
                if given[name] != value
            ]
            raise InvalidControllerFile(
                path,
                f"was trained for a robot with {', '.join(other)}; load it without a robot, or "
                "train anew",
            )
        system = from_json(content["system"])
        ranges = np.asarray(content["ranges"], dtype=float)
        kind, n_terms, snr = content["kind"], content["n_terms"], content["snr_db"]
        if not isinstance(system, FuzzySystem) or type(system) is not _SYSTEMS.get(kind):
            raise InvalidControllerFile(
                path, f"has kind {kind!r} and holds {type(system).__name__}"
            )
        if (system.input_names, system.output_names) != (INPUT_NAMES, OUTPUT_NAMES):
            raise InvalidControllerFile(
                path, "holds a fuzzy system of other inputs or outputs than the file says"
            )
        if np.shape(system.consequents) != (len(system.rules), len(OUTPUT_NAMES)):
            raise InvalidControllerFile(
                path, "has consequents that are not a number for each rule and output"
            )
        if any(len(terms) != n_terms for terms in system.inputs):
            raise InvalidControllerFile(
                path,
                f"has inputs of {[len(terms) for terms in system.inputs]} terms, and n_terms "
                f"{n_terms!r}",
            )
        if (
            ranges.shape != (2, 4)
            or not np.isfinite(ranges).all()
            or not (ranges[0] < ranges[1]).all()
        ):
            raise InvalidControllerFile(
                path, "has ranges that are not four smallest and four largest inputs"
            )
        if system.table is None:
            raise InvalidControllerFile(
                path, "holds a fuzzy system that the compiled loop cannot evaluate"
            )
        options: dict[str, Any] = {}
        if isinstance(system, GeneralType2System):
            options = {"levels": system.levels, "reduction": system.reduction}
        controller = cls(
            kind,
            load("psp3", parameters=parameters) if robot is None else robot,
            kp=content["kp"],
            kv=content["kv"],
            n_terms=n_terms,
            learner=content["learner"],
            snr_db=math.inf if snr == "inf" else snr,
            mean_variation=checked_not_negative("mean_variation", content["mean_variation"]),
            term_width=content["term_width"],
            outside=content["outside"],
            # Files of version 1 that lack it are of controllers that knew one order only.
            defuzzify=content.get("defuzzify", "first"),
            **options,
        )
        controller._take(system, ranges)
        return controller


def _widened(system: FuzzySystem, width: float) -> FuzzySystem:
    """Return the system with the standard deviations of its terms multiplied.

    All else is as it is.
    """
    options: dict[str, Any] = {
        "input_names": system.input_names,
        "output_names": system.output_names,
        "term_names": system.term_names,
    }
    if isinstance(system, GeneralType2System):
        options |= {"reduction": system.reduction, "levels": system.levels}
    terms = [[_wider(term, width) for term in terms] for terms in system.inputs]
    return type(system)(terms, system.rules, system.consequents, system.t_norm, **options)


def _wider(term: Any, width: float) -> Any:
    if isinstance(term, GaussianType2Set):
        return GaussianType2Set(_wider(term.principal, width), term.sigma)
    return type(term)(term.mean, width * term.sigma)


def _floats(values: ArrayLike) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def checked_snr(snr_db: object) -> float:
    """Return a signal-to-noise ratio in decibels.

    Raise :class:`InvalidValue` if it is not a number of at least ``LEAST_SNR``.
    """
    return checked_number(
        "snr_db",
        snr_db,
        f"a number of decibels, at least {LEAST_SNR:g}, or inf for no noise",
        LEAST_SNR,
    )

r"""The controller of chapter 5.

It is computed torque with M, C and G estimated by fuzzy systems: for the 3-PSP by one system from
four differences, and for any other robot from positions and speeds.

.. math:: \tau = \alpha\,(\ddot a_d + k_v \dot e + k_p e) + \beta, \qquad
          \alpha = M, \quad \beta = C \dot a + G

M, C and G are fuzzy numbers, the type-reduced outputs of one rule base; so are :math:`\alpha`,
:math:`\beta` and the torque, which the thesis defuzzifies last. For intervals and Gaussian numbers
arithmetic is affine (Theorems 1.4, 1.5): the crisp torque is the same when M, C and G are
defuzzified first, which :meth:`FuzzyComputedTorque.torque` does by default. For numbers by α-planes
the torque depends on the order, and ``defuzzify="last"`` takes the thesis's order: the centroid
(eq. 1.68) of the fuzzy torque. Either way a step is one compiled call.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.learning.noise import mean_variation_from_snr
from fuzzy2.learning.partition import KINDS
from fuzzy2.numbers.affine import GaussianNumber, IntervalNumber
from fuzzy2.reduction.general import cut_centroid
from fuzzy2.support.compiled import only_for
from fuzzy2.support.described import Described
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.system import FuzzySystem
from psp3.checks import (
    Array,
    checked_count,
    checked_kind,
    checked_not_negative,
    checked_number,
    checked_positive,
    checked_random,
    checked_truth,
    finite_rows,
    known_name,
    listed,
    one_row,
    overflow_refused,
)
from psp3.control.controller import Widths
from psp3.errors import InvalidArray, InvalidValue, NotTrained, UnusableEstimate
from psp3.fuzzy_control import controller_files, kernels, rule_bases
from psp3.fuzzy_control.numbers import unpack
from psp3.fuzzy_control.records import (
    NOISE_OF_THE_STUDY,
    Record,
    RecordNoise,
    learning_inputs,
    ranges_of_moving,
    record,
)
from psp3.fuzzy_control.rule_bases import CORIOLIS, LEARNERS, Place, RuleOptions
from psp3.loading import load
from psp3.published import DURATION, TABLE_6_1_TERMS
from psp3.robots.robot import Robot
from psp3.trajectories.motion import Motion
from psp3.trajectories.trajectory import Trajectory

OUTSIDE = ("clamp", "crisp")
"""What to do outside of the trained range: clamp the inputs to it, or use the exact M, C and G.
"""

REDUCTIONS = ("alpha_planes", "gaussian")
"""Type reductions of the general type-2 controller."""

ORDERS = ("first", "last")
"""What to defuzzify: first M, C and G, before the torque is computed, or last the fuzzy torque."""

LEAST_SNR = -100.0
"""Least signal-to-noise ratio [dB]: the noise is a hundred thousand times the signal."""

SAMPLES = 209
"""Number of samples that a single rule base is learned from, as in the thesis."""

MOST_SAMPLES = 2000
"""Number of samples that several rule bases are learned from, unless the record has fewer."""

FuzzyNumbers = IntervalNumber | GaussianNumber

_ROWS = ("positions", "speeds", "desired positions", "desired speeds", "desired accelerations")


class FuzzyComputedTorque(Described):
    r"""Computed torque with learned M, C and G: type-1, interval type-2 or general type-2.

    Parameters
    ----------
    kind : {"it2", "t1", "gt2"}
        Kind of the estimators: interval type-2 (Gaussian terms of uncertain mean, center of sets:
        the thesis's), type-1 (the same with mean variation zero), or general type-2 (Gaussian
        secondary grades: the thesis's future work).
    robot : Robot, optional
        The robot to learn from, whose n coordinates are its motors; ``psp3.load("psp3")`` by
        default. ``robot.learning_inputs`` lists the inputs of its dynamics. If M and G depend on
        fewer inputs than C, they have a rule base of their own.
    kp, kv : float
        Gains of the servo, 10 [1/s²] and 1 [1/s] in Table 6.1.
    n_terms : int, optional
        Number of terms of every input, on a grid of rules. If one rule base is enough, as for the
        3-PSP, the default is two, which makes 16 rules. Otherwise the default is no grid. Of
        several rule bases, those whose grid would have more than 256 rules have no grid either.
    rules : int, optional
        Number of rules of every base without a grid, 32 by default. Each rule is centered on a
        sample, and these samples cover the record evenly.
    learner : str, optional
        How rules are learned, see :class:`fuzzy2.WangMendel`, or ``"least-squares"``: its ridge
        least squares, with a ridge that generalized cross-validation chooses. The default is
        ``"strongest"`` for a single rule base, as for the 3-PSP: every rule takes the sample that
        fires it most. For several it is ``"least-squares"``.
    coriolis : {"rules", "mass"}
        Source of C: rules of its own, or the derivative of M
        (:mod:`psp3.fuzzy_control.christoffel_kernels`), which needs no further rules and makes
        :math:`\dot M - 2 C` skew-symmetric.
    snr_db : float
        Signal-to-noise ratio of the recorded M, C and G [dB]: noise of that power is added to the
        samples, and the mean variation follows from it. Infinite by default.
    mean_variation : float, optional
        Distance of each term's smallest and largest mean from the middle, as a share of the input's
        range. The default is :func:`fuzzy2.mean_variation_from_snr` of ``snr_db``, which is 0
        without noise.
    levels : int
        Number of α-planes of a general type-2 system, each reduced exactly.
    reduction : {"alpha_planes", "gaussian"}
        Type reduction of a general type-2 system. With the Gaussian corollary the torque is that of
        ``"t1"`` whatever the uncertainty, and only the spread is new: a cheap monitor.
    outside : {"clamp", "crisp"}
        What to do outside of the range of the training inputs: clamp the inputs to it, or use the
        exact M, C and G.
    term_width : float
        Factor on the standard deviations of the terms after the rules are learned. Wider terms
        average over more rules, also in a type-1 controller, which is a fair comparison for the
        gain of type-2.
    defuzzify : {"first", "last"}
        When to defuzzify. ``"first"`` defuzzifies M, C and G; with α-planes, each is the average of
        the middles of its cuts, weighted with their levels. ``"last"`` defuzzifies the fuzzy torque
        with its centroid (eq. 1.68), as in the thesis. The order matters only with α-planes. In
        either order, the averages decide whether an estimate is usable.

    Attributes
    ----------
    systems_ : tuple of fuzzy2 systems
        The learned systems: for the 3-PSP one system of 4 inputs and 18 outputs, otherwise one for
        M and G and one for C, if C has rules. The names of outputs are those of
        :func:`psp3.fuzzy_control.numbers.output_names`. M is symmetric, because only its upper
        triangle is learned.
    ranges_ : (2, p) ndarray
        Smallest and largest training value of every input.
    fallback_ : (K,) ndarray
        Average over the rules. It replaces an estimate that is not finite, or whose M is not
        positive definite.

    Raises
    ------
    InvalidValue, UnknownName
        If a parameter is invalid.

    Notes
    -----
    Source: thesis chapter 5, Figs. 47 and 48. The text says that only interval systems may be
    defuzzified first; Gaussian numbers may, too. Other shapes may not, because the centroid of a
    sum is not the sum of the centroids.
    """

    systems_: tuple[FuzzySystem, ...]
    ranges_: Array
    fallback_: Array

    def __init__(  # noqa: PLR0913 (public: everything that makes a controller is named here)
        self,
        kind: str = "it2",
        robot: Robot | None = None,
        *,
        kp: float = 10.0,
        kv: float = 1.0,
        n_terms: int | None = None,
        rules: int | None = None,
        learner: str | None = None,
        coriolis: str = "rules",
        snr_db: float = math.inf,
        mean_variation: float | None = None,
        levels: int = 5,
        reduction: str = "alpha_planes",
        outside: str = "clamp",
        term_width: float = 1.0,
        defuzzify: str = "first",
    ) -> None:
        if robot is not None and not isinstance(robot, Robot):
            raise InvalidValue("robot", robot, 'a robot, such as psp3.load("psp3")')
        self.robot: Any = load("psp3") if robot is None else robot
        self.inputs = learning_inputs(self.robot)
        self.joints = len(self.robot.coordinates)
        for what, name, known in (
            ("kind of controller", kind, KINDS),
            ("learner", "strongest" if learner is None else learner, LEARNERS),
            ("origin of C", coriolis, CORIOLIS),
            ("reduction", reduction, REDUCTIONS),
            ("treatment of inputs outside of the trained range", outside, OUTSIDE),
            ("order of defuzzification", defuzzify, ORDERS),
        ):
            known_name(what, name, known)
        self.places: tuple[Place, ...] = rule_bases.places_of_bases(
            self.inputs, self.joints, coriolis
        )
        says_all = len(self.places) == 1 and coriolis == "rules"
        self.learner = learner or ("strongest" if says_all else "least-squares")
        self.samples = SAMPLES if says_all else MOST_SAMPLES
        self._most_grid_rules = math.inf if says_all else rule_bases.MOST_GRID_RULES
        # The name ``defuzzify`` is taken by the method that defuzzifies a number.
        self.order = defuzzify
        self.kind, self.coriolis, self.reduction, self.outside = kind, coriolis, reduction, outside
        self.kp, self.kv = checked_not_negative("kp", kp), checked_not_negative("kv", kv)
        if n_terms is None and says_all:
            n_terms = TABLE_6_1_TERMS
        self.n_terms = None if n_terms is None else checked_count("n_terms", n_terms)
        self.levels = checked_count("levels", levels)
        self.rules = None if rules is None else checked_count("rules", rules)
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
        self._controller: kernels.Fuzzy | None = None
        self._model: Any = kernels.NO_MODEL
        self.reset()

    def _facts(self) -> dict[str, Any]:
        rules = None if self._controller is None else sum(len(s.rules) for s in self.systems_)
        return {
            "kind": self.kind,
            "robot": self.robot,
            "kp": self.kp,
            "kv": self.kv,
            "learner": self.learner,
            "mean_variation": self.mean_variation,
            "rules": "not trained" if rules is None else rules,
        }

    def __repr__(self) -> str:
        numbers = [] if self._controller is None else [len(s.rules) for s in self.systems_]
        trained = f"{' + '.join(map(str, numbers))} rules" if numbers else "not trained"
        return (
            f"{type(self).__name__}({self.kind!r}, kp={self.kp:g}, kv={self.kv:g}, "
            f"mean_variation={self.mean_variation:.3g}, {trained})"
        )

    # Learning

    def fit(
        self,
        trajectory: Trajectory,
        duration: float = DURATION,
        samples: int | None = None,
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
        samples : int, optional
            Number of samples, spread evenly over the recorded inputs; by default 209 if one rule
            base is enough, otherwise 2000 or as many as there are.
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
            If an input does not change on the trajectory, if terms are so narrow that no rule fires
            on a part of it, or if a parameter is invalid.
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
        samples: int | None = None,
        rng: np.random.Generator | None = None,
        noise: RecordNoise = NOISE_OF_THE_STUDY,
    ) -> Self:
        """Learn from a record; see :meth:`fit`. ``noise`` defines what ``snr_db`` refers to."""
        checked_kind(
            "recorded", recorded, Record, "a record, such as of psp3.fuzzy_control.records.record"
        )
        if tuple(recorded.input_names) != self.inputs.names:
            wanted = f"one of {self.robot.title}, with the inputs {', '.join(self.inputs.names)}"
            raise InvalidValue("recorded", ", ".join(recorded.input_names), wanted)
        checked_random(rng)
        checked_kind("noise", noise, RecordNoise, "a RecordNoise")
        if samples is None:
            samples = self.samples
            if samples == MOST_SAMPLES:
                samples = min(samples, len(recorded.t))
        chosen = recorded.sample(samples)
        inputs, outputs = recorded.inputs[chosen], recorded.outputs[chosen]
        if math.isfinite(self.snr_db):
            rng = np.random.default_rng() if rng is None else rng
            inputs, outputs = noise.added(recorded, chosen, self.snr_db, rng)
        systems = rule_bases.learned_systems(
            self._options, self.places, self.inputs.names, inputs, outputs, self.joints
        )
        self._take(systems, np.stack([inputs.min(axis=0), inputs.max(axis=0)]))
        return self

    def learn_from_motion(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        accelerations: ArrayLike,
        forces: ArrayLike,
        positive_definite: bool = True,
    ) -> Self:
        r"""Learn from a motion and its forces; M, C and G need not be known.

        The forces are linear in the consequents of all rules, which are found by ridge least
        squares (:mod:`psp3.fuzzy_control.force_learning`), whatever ``learner`` is.

        Parameters
        ----------
        positions, speeds, accelerations : (N, n) array_like
            A motion of the motors [m or rad, and per s, s²], as of
            :func:`psp3.identification.excitation.exciting_motion`, of a Fourier series fitted to
            the measurements, or of :func:`psp3.trajectories.measured_motion`. All N samples are
            used, so noise averages out.
        forces : (N, n) array_like
            Measured forces of the motors [N or N m].
        positive_definite : bool
            Whether the M of every rule must be positive definite; then every estimate of M is.

        Returns
        -------
        FuzzyComputedTorque
            The controller itself.

        Raises
        ------
        InvalidArray, InvalidValue
            If an array is not finite numbers of that shape, or an input does not change.
        UnusableEstimate
            If the mass matrix that fits all forces best is not positive definite.
        """
        given = zip(
            ("positions", "speeds", "accelerations", "forces"),
            (positions, speeds, accelerations, forces),
            strict=True,
        )
        arrays = [finite_rows(name, rows, self.joints) for name, rows in given]
        if arrays[0].ndim != 2 or len(arrays[0]) < 2:
            raise InvalidArray("positions", f"(N, {self.joints}), N at least 2", positions)
        for name, array in zip(("speeds", "accelerations", "forces"), arrays[1:], strict=True):
            if array.shape != arrays[0].shape:
                raise InvalidArray(name, f"{arrays[0].shape}, one row for each position", array)
        is_definite = checked_truth("positive_definite", positive_definite)
        inputs = self.inputs.of(arrays[0], arrays[1])
        ranges_of_moving(inputs, self.inputs.names, "positions and speeds")
        a, v, w, force = arrays
        with overflow_refused("the sizes of positions, speeds, accelerations and forces"):
            systems = rule_bases.systems_from_motion(
                *(self._options, self.places, self.inputs, (a, v, w), force),
                *(self.coriolis == "mass", is_definite),
            )
        self._take(systems, np.stack([inputs.min(axis=0), inputs.max(axis=0)]))
        return self

    @property
    def _options(self) -> RuleOptions:
        return RuleOptions(
            *(self.kind, self.n_terms, self.rules, self.mean_variation, self.learner),
            *(self.reduction, self.levels, self.term_width, self._most_grid_rules),
        )

    def terms_of(self, place: Place) -> int:
        """Return the number of terms of every input of a rule base."""
        checked_kind("place", place, Place, "one of places")
        return rule_bases.terms_of_input(self._options, len(place.columns))[0]

    def _take(self, systems: Sequence[FuzzySystem], ranges: Array) -> None:
        """Become trained: take the systems of all rule bases and the ranges (2, p) of inputs."""
        table = rule_bases.controller_table(
            *(systems, self.places, self.inputs, ranges, self.joints),
            *((self.kp, self.kv), OUTSIDE.index(self.outside), self.order),
            self.coriolis == "mass",
        )
        mass = unpack(table.fallback)[0]
        if not np.isfinite(table.fallback).all() or np.linalg.eigvalsh(mass)[0] <= 0.0:
            raise UnusableEstimate(mass)
        self.systems_, self.ranges_, self.fallback_ = tuple(systems), ranges, table.fallback
        self._controller, self._packed = table, kernels.packed(table)
        self._model = kernels.NO_MODEL
        if self.outside == "crisp":
            self._model = self.robot.compiled_table()
            if self._model is None:
                wanted = "'clamp': this robot has no compiled dynamics that could take over"
                raise InvalidValue("outside", self.outside, wanted)
        self.reset()
        row = np.array(self.robot.reference)
        rows = (row, 0.0 * row, row, 0.0 * row, 0.0 * row)
        if self.outside == "clamp":
            only_for(kernels.clamped_step, self._packed, *rows, self._step.copy())
        else:
            only_for(kernels.control_step, self._packed, self._model, *rows, self._step.copy())

    def with_systems(self, systems: Sequence[FuzzySystem]) -> Self:
        """Return a controller with other consequents in the systems of its rule bases.

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        InvalidValue
            If their number is not that of the rule bases.
        UnusableEstimate
            If the average mass matrix is not positive definite.
        """
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        wanted = f"a list of fuzzy systems, {len(self.places)}: one for each of systems_"
        given = listed("systems", systems, wanted)
        is_one = [isinstance(system, FuzzySystem) for system in given]
        if len(given) != len(self.places) or not all(is_one):
            raise InvalidValue("systems", systems, wanted)
        other = copy.copy(self)
        other._take(given, self.ranges_)
        return other

    def _stepped(self, rows: tuple[Array, Array, Array, Array, Array], step: Array) -> int:
        """Write a step, and return the kernel's return value."""
        if self.outside == "clamp":
            return kernels.clamped_step(self._packed, *rows, step)
        return kernels.control_step(self._packed, self._model, *rows, step)

    @property
    def system_(self) -> FuzzySystem:
        """The learned system, if there is only one.

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        InvalidValue
            If there are several; take ``systems_``.
        """
        self.controller  # noqa: B018 # raises NotTrained
        if len(self.systems_) > 1:
            raise InvalidValue("system_", len(self.systems_), "one system; take systems_")
        return self.systems_[0]

    @property
    def controller(self) -> kernels.Fuzzy:
        """The trained controller as :mod:`psp3.fuzzy_control.kernels` takes it."""
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        return self._controller

    # Control

    def reset(self) -> None:
        """Forget the last call; the learned rules stay."""
        self._step = np.full(kernels.step_width(self.joints), np.nan)

    @property
    def numbers_said(self) -> int:
        """Numbers that a compiled step writes after the n forces."""
        return kernels.step_width(self.joints) - self.joints

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        if type(self) is not FuzzyComputedTorque or widths != Widths.of_motors(self.joints):
            return None
        if self._controller is None:
            return None
        return self.run_table()

    def run_table(self, added: Array | None = None) -> kernels.FuzzyRun:
        """Return the trained controller for one loop.

        ``added`` (N, K) is noise to add to its estimates of M, C and G at each sample.
        """
        nothing = kernels.nothing_added(self.controller.fallback.size)
        model = kernels.NO_MODEL if self.outside == "clamp" else self.robot.compiled_table()
        return kernels.FuzzyRun(self.controller, model, nothing if added is None else added)

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Take the state after the last step, and return the reports of all steps."""
        self._step = steps[-1].copy() if len(steps) else self._step
        return kernels.reported(steps)

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the crisp torque, of shape (n,) [N or N m].

        It is defuzzified first or last, as ``defuzzify`` says.

        Parameters
        ----------
        t : float
            Time [s]; not used.
        heights, speeds : (n,) array_like
            Positions [m or rad] and speeds [m/s or rad/s]; for the 3-PSP those of its nuts.
        desired : Motion
            Desired positions, speeds and accelerations, (n,) each.

        Returns
        -------
        (n,) ndarray
            Forces of the motors.

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        InvalidArray
            If positions, speeds or the desired motion are not n finite numbers each.
        UnreachablePose
            If the exact model takes over, and the robot cannot reach a pose of these heights.
        """
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        # A new array in every call, because the returned torque is a view of it.
        step = np.empty(3 * self.joints + 2)
        checked_kind("desired", desired, Motion, "a Motion, what a trajectory returns at a time")
        rows = (heights, speeds, desired.positions, desired.speeds, desired.accelerations)
        try:
            done = self._stepped(rows, step)
        except TypeError:
            done = -1
        if done != 1:
            # The arguments are not contiguous writable rows of n finite floats: lists and read-only
            # rows are copied, and all else is refused.
            copies: Any = tuple(
                np.array(one_row(name, row, self.joints))
                for name, row in zip(_ROWS, rows, strict=True)
            )
            done = self._stepped(copies, step)
            if done != 1 and self.outside == "crisp":
                self.robot.mass_matrix(copies[0])
        self._step = step
        torque: Array = step[: self.joints]
        return torque

    @property
    def torque_interval(self) -> Array:
        """Ends of the torque interval of the last call (n, 2) [N or N m].

        With α-planes it is that of the lowest plane; with the corollary it is (mean, sigma).
        """
        n = self.joints
        return self._step[n : 3 * n].reshape(2, n).T.copy()

    @property
    def covered(self) -> bool:
        """Whether the inputs of the last call were within the trained range."""
        return bool(self._step[-2] > 0.0)

    @property
    def fell_back(self) -> bool:
        """Whether the average over the rules replaced the last estimate, which was unusable."""
        return bool(self._step[-1] > 0.0)

    def _inputs(self, heights: ArrayLike, speeds: ArrayLike) -> tuple[Array, Array]:
        """Return the inputs (..., p) of the rules, clamped if needed, and the speeds (..., n)."""
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        a, v = np.broadcast_arrays(
            finite_rows("heights", heights, self.joints), finite_rows("speeds", speeds, self.joints)
        )
        inputs = self.inputs.of(a, v)
        return (np.clip(inputs, *self.ranges_) if self.outside == "clamp" else inputs), v

    def _numbers(self, inputs: Array, speeds: Array, said: Sequence[Array]) -> Array:
        """Return the outputs of the bases, (..., m) each, as numbers (..., K), with a derived C."""
        leading = said[0].shape[:-1]
        numbers = np.zeros((*leading, self.controller.fallback.size))
        for place, outputs in zip(self.places, said, strict=True):
            numbers[..., place.outputs] = outputs
        if self.coriolis == "mass":
            derived = np.empty((*inputs.shape[:-1], numbers.shape[-1]))
            for row in np.ndindex(inputs.shape[:-1]):
                rule_bases.write_derived_coriolis(
                    self.controller, inputs[row], speeds[row], derived[row]
                )
            n = self.joints
            coriolis = slice(n * (n + 1) // 2, -n)
            numbers[..., coriolis] = derived[..., coriolis]
        return numbers

    def estimate(self, heights: ArrayLike, speeds: ArrayLike) -> tuple[Array, Array, Array]:
        """Return the crisp estimates of M, C and G.

        Parameters
        ----------
        heights, speeds : (..., n) array_like
            Positions [m or rad] and speeds [m/s or rad/s]; for the 3-PSP those of its nuts.

        Returns
        -------
        M, C, G : (..., n, n), (..., n, n), (..., n) ndarray
            The estimates of the fuzzy systems, without the fallback. Inputs are clamped to the
            trained range if ``outside`` says so.

        Raises
        ------
        NotTrained, InvalidArray
            As from :meth:`torque`.
        """
        inputs, v = self._inputs(heights, speeds)
        said = [
            np.asarray(system(inputs[..., place.columns]))
            for system, place in zip(self.systems_, self.places, strict=True)
        ]
        return unpack(self._numbers(inputs, v, said))

    def estimated_numbers(
        self, heights: ArrayLike, speeds: ArrayLike
    ) -> tuple[FuzzyNumbers, FuzzyNumbers, FuzzyNumbers]:
        """Return the estimates of M, C and G as arrays of fuzzy numbers, the type-reduced outputs.

        Parameters
        ----------
        heights, speeds : (..., n) array_like
            Positions [m or rad] and speeds [m/s or rad/s]; for the 3-PSP those of its nuts.

        Returns
        -------
        M, C, G : IntervalNumber or GaussianNumber
            Numbers of the shapes of :meth:`estimate`; with α-planes there is an additional first
            dimension for the planes, in the order of ``systems_[0].alphas``.

        Raises
        ------
        NotTrained, InvalidArray
            As from :meth:`torque`.
        """
        inputs, v = self._inputs(heights, speeds)
        by_cuts = self.controller.kind in (kernels.PLANES, kernels.CENTROID)
        ends: list[list[Array]] = [[], []]
        for system, place in zip(self.systems_, self.places, strict=True):
            asked = inputs[..., place.columns]
            if by_cuts:
                assert isinstance(system, GeneralType2System)
                said = np.moveaxis(system.alpha_cuts(asked), -2, 0)
            else:
                said = system.type_reduced(asked)
            ends[0].append(said[..., 0])
            ends[1].append(said[..., 1])
        left, right = (unpack(self._numbers(inputs, v, said)) for said in ends)
        if self.controller.kind == kernels.COROLLARY:
            first: Any = self.systems_[0]
            # A derived C is crisp.
            deviations = (right[0], 0.0 * right[1], right[2]) if self.coriolis == "mass" else right
            gaussian = [
                GaussianNumber(m, s, first.grade_t_norm)
                for m, s in zip(left, deviations, strict=True)
            ]
            return gaussian[0], gaussian[1], gaussian[2]
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
        heights, speeds : (n,) array_like
            Positions [m or rad] and speeds [m/s or rad/s]; for the 3-PSP those of its nuts.
        desired : Motion
            Desired positions, speeds and accelerations, (n,) each.

        Returns
        -------
        IntervalNumber or GaussianNumber
            Numbers of shape (n,) [N or N m]; with α-planes (L, n), a row for each plane.

        Raises
        ------
        NotTrained, InvalidArray
            As from :meth:`torque`.
        """
        checked_kind("desired", desired, Motion, "a Motion, what a trajectory returns at a time")
        rows = (heights, speeds, desired.positions, desired.speeds, desired.accelerations)
        a, v, *wanted = (
            one_row(name, row, self.joints) for name, row in zip(_ROWS, rows, strict=True)
        )
        M, C, G = self.estimated_numbers(a, v)
        servo = wanted[2] + self.kv * (wanted[1] - v) + self.kp * (wanted[0] - a)
        alpha_part: Any = M @ servo
        number: FuzzyNumbers = alpha_part + C @ v + G
        return number

    def defuzzify(self, number: FuzzyNumbers) -> Array:
        r"""Return the crisp torque of a number.

        It is the middle or mean of the number. With α-planes it is :math:`\sum_l \alpha_l c_l /
        \sum_l \alpha_l`, which equals defuzzifying M, C and G first, or with ``defuzzify="last"``
        the centroid (eq. 1.68), see ``fuzzy2.reduction.general.cut_centroid``.

        Parameters
        ----------
        number : IntervalNumber or GaussianNumber
            As from :meth:`torque_number`.

        Returns
        -------
        (n,) ndarray
            Forces of the motors [N or N m].

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        """
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        wanted = "a number, as torque_number returns it"
        checked_kind("number", number, (IntervalNumber, GaussianNumber), wanted)
        first = self.systems_[0]
        if (
            isinstance(number, GaussianNumber)
            or not isinstance(first, GeneralType2System)
            or first.reduction == "gaussian"
        ):
            return number.defuzzify()
        alphas = first.alphas
        if self.order == "last":
            return cut_centroid(alphas, np.moveaxis(number.interval(), 0, -2))
        return np.asarray(alphas @ number.defuzzify() / alphas.sum())

    # Files

    def save(self, path: str | Path) -> Path:
        """Write the trained controller as JSON.

        The file holds the fuzzy systems, gains, ranges and the identity of the robot.

        Raises
        ------
        NotTrained
            If nothing was learned yet.
        """
        if self._controller is None:
            raise NotTrained(type(self).__name__)
        return controller_files.save(self, path)

    @classmethod
    def load(cls, path: str | Path, robot: Robot | None = None) -> FuzzyComputedTorque:
        """Read a controller that :meth:`save` wrote.

        Parameters
        ----------
        path : path
            The file.
        robot : Robot, optional
            The robot of the controller. By default it is the 3-PSP with the parameters in the file,
            or the robot of the package with the name in the file.

        Returns
        -------
        FuzzyComputedTorque

        Raises
        ------
        InvalidControllerFile
            If the file is missing, malformed or of another version, or if the controller was
            trained for another robot, for other parameters, or for inputs or outputs that differ or
            are in another order.
        """
        read: FuzzyComputedTorque = controller_files.load(cls, path, robot)
        return read


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

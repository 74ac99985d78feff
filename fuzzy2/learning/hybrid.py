r"""Hybrid learning of Takagi–Sugeno–Kang systems: least squares inside, Gauss–Newton outside.

For given premises :math:`\theta` the best coefficients follow from linear least squares,

.. math:: c(\theta) = \arg\min_c \lVert y - \Phi(\theta)\, c \rVert^2 + \lambda N \lVert c \rVert^2,

so only the premises are searched (variable projection). The search takes Levenberg–Marquardt steps
for :math:`\lVert y - \Phi(\theta)\, c(\theta) \rVert^2`, with Kaufman's derivative

.. math:: (I - \Phi (\Phi^T \Phi + \lambda N I)^{-1} \Phi^T)\,
          \frac{\partial \Phi}{\partial \theta}\, c.

This is the hybrid rule of ANFIS, with a second-order step in place of the gradient step of its
backward pass. The computations use a singular value decomposition of the basis.

Sources: J.-S. R. Jang, "ANFIS: adaptive-network-based fuzzy inference system", IEEE Transactions on
Systems, Man, and Cybernetics 23(3), 1993; G. H. Golub and V. Pereyra, "The differentiation of
pseudo-inverses and nonlinear least squares problems whose variables separate", SIAM Journal on
Numerical Analysis 10(2), 1973; L. Kaufman, "A variable projection method for solving separable
nonlinear least squares problems", BIT 15, 1975.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fuzzy2.learning.premises import End, Grades, Premises
from fuzzy2.support.checks import Array

FIRST_DAMPING = 1e-3
SWITCHES = 4
"""Least-squares solutions of an interval system, each at the switch points of the last one."""
MOST_TRIALS = 12
"""Number of damped steps that are tried before learning ends."""
LONGEST_STEP = 3.0
"""Longest step of a mean, in standard deviations of its input, and of the logarithm of a spread."""
LEAST_INNER_GAIN = 1e-3
"""Fall of the objective below which the consequents of an interval system have converged."""
AS_GOOD = 1.3
"""Held-out errors below this multiple of the smallest one do not stop learning.

This holds only for interval systems, whose error jumps as switch points change. The mean of a
hundred squares is only known to about a seventh.
"""
LEAST_GAIN = 1e-7
"""Relative fall of the objective below which learning has converged."""
WIDEST = 10.0
"""Greatest absolute logarithm of the ratio between a spread and that of its input."""


@dataclass(frozen=True)
class Data:
    """Samples in units of their standard deviations: X (N, p), y (N, m) and weights (N,)."""

    X: Array
    y: Array
    weights: Array

    @property
    def with_constant(self) -> Array:
        """The inputs with a column of ones before them, (N, p + 1)."""
        return np.concatenate([np.ones((len(self.X), 1)), self.X], axis=1)

    def error(self, predicted: Array) -> float:
        """Return the mean squared error over outputs and weighted samples."""
        squares = ((predicted - self.y) ** 2).mean(axis=1)
        return float(self.weights @ squares / self.weights.sum())


@dataclass(frozen=True)
class Output:
    """Least squares of one output: coefficients, residual, and their basis."""

    coefficients: Array
    """Coefficients, (R, p + 1)."""
    z: Array
    """Consequents at the samples, (N, R)."""
    ends: list[End]
    left: Array
    """Left singular vectors of the weighted basis, (N, k)."""
    shrink: Array
    r"""Filter factors :math:`s^2 / (s^2 + \lambda N)`, (k,)."""
    residual: Array
    """Weighted residuals, (N,)."""
    cost: float


@dataclass(frozen=True)
class State:
    """Premises with the best consequents for them."""

    parameters: Array
    grades: Grades
    outputs: list[Output]

    @property
    def cost(self) -> float:
        """The objective, summed over the outputs."""
        return sum(output.cost for output in self.outputs)

    @property
    def coefficients(self) -> Array:
        """Coefficients of the consequents, (R, m, p + 1)."""
        return np.stack([output.coefficients for output in self.outputs], axis=1)


@dataclass(frozen=True)
class History:
    """History of :meth:`Learner.learn`."""

    state: State
    """The best state, by the validation samples if there are any."""
    training_errors: list[float]
    validation_errors: list[float]
    best_epoch: int
    """The last epoch that is as good as the best one, by the validation samples."""
    stopped_early: bool


class Learner:
    """Hybrid learning from given premises and samples."""

    def __init__(self, premises: Premises, data: Data, ridge: float) -> None:
        self.premises, self.data = premises, data
        self._constant = data.with_constant
        self._root = np.sqrt(data.weights)[:, np.newaxis]
        self._penalty = ridge * float(data.weights.sum())

    def solved(self, parameters: Array, coefficients: Array | None = None) -> State:
        """Return the best consequents for premises.

        For an interval system they are better than the given consequents, as far as the switch
        points allow.
        """
        grades = self.premises.grades(parameters, self.data.X)
        if not self.premises.is_interval:
            ends = self.premises.ends(grades, None)
            return State(parameters, grades, self._least_squares(ends))
        assert coefficients is not None
        columns = range(self.data.y.shape[1])
        outputs = [self._for_switches(grades, coefficients[:, j], j) for j in columns]
        return State(parameters, grades, outputs)

    def _for_switches(self, grades: Grades, coefficients: Array, j: int) -> Output:
        """Return consequents of an interval system's output that are better than given ones.

        Least squares for the current switch points give a descent direction, but the step may pass
        other switch points. It is then shortened.
        """
        current = self._evaluated(grades, coefficients, j)
        for _ in range(SWITCHES):
            goal = self._least_squares(current.ends, j)[0].coefficients
            for part in (1.0, 0.5, 0.25, 0.125):
                tried = current.coefficients + part * (goal - current.coefficients)
                new = self._evaluated(grades, tried, j)
                if new.cost < current.cost:
                    break
            else:
                break
            gain, current = current.cost - new.cost, new
            if gain < LEAST_INNER_GAIN * current.cost:
                break
        left, shrink = self._decomposed(self.premises.basis(current.ends, self._constant))[:2]
        return replace(current, left=left, shrink=shrink)

    def _evaluated(self, grades: Grades, coefficients: Array, j: int) -> Output:
        """Return an output with given coefficients, at the switch points of these coefficients."""
        z = self._constant @ coefficients.T
        ends = self.premises.ends(grades, z)
        predicted = np.mean([(end.shares * z).sum(axis=1) for end in ends], axis=0)
        residual = self._root[:, 0] * (self.data.y[:, j] - predicted)
        cost = float(residual @ residual + self._penalty * (coefficients**2).sum())
        empty = np.empty((len(z), 0))
        return Output(coefficients, z, ends, empty, empty[0], residual, cost)

    def _decomposed(self, basis: Array) -> tuple[Array, Array, Array]:
        """Return left singular vectors, filter factors, and the matrix from targets to c."""
        weighted = self._root * basis
        if weighted.shape[0] < weighted.shape[1]:
            # If there are fewer samples than coefficients, the inner products of the rows suffice.
            squares, left = np.linalg.eigh(weighted @ weighted.T)
            squares = np.maximum(squares, 0.0)
            inverse = left / (squares + self._penalty)
            return left, squares / (squares + self._penalty), weighted.T @ (inverse @ left.T)
        left, values, right = np.linalg.svd(weighted, full_matrices=False)
        filtered = values / (values**2 + self._penalty)
        return left, values * filtered, right.T @ (filtered[:, np.newaxis] * left.T)

    def _least_squares(self, ends: list[End], only: int | None = None) -> list[Output]:
        basis = self.premises.basis(ends, self._constant)
        left, shrink, inverse = self._decomposed(basis)
        found = []
        for j in range(self.data.y.shape[1]) if only is None else (only,):
            target = self._root[:, 0] * self.data.y[:, j]
            flat = inverse @ target
            coefficients = flat.reshape(-1, self._constant.shape[1])
            residual = target - self._root[:, 0] * (basis @ flat)
            cost = float(residual @ residual + self._penalty * (flat @ flat))
            z = self._constant @ coefficients.T
            found.append(Output(coefficients, z, ends, left, shrink, residual, cost))
        return found

    def predicted(self, state: State, X: Array) -> Array:
        """Return the outputs (N, m) of a state at any inputs, in units of the samples' outputs."""
        grades = self.premises.grades(state.parameters, X)
        constant = np.concatenate([np.ones((len(X), 1)), X], axis=1)
        columns = []
        for output in state.outputs:
            z = constant @ output.coefficients.T
            ends = self.premises.ends(grades, z)
            columns.append(np.mean([(end.shares * z).sum(axis=1) for end in ends], axis=0))
        return np.stack(columns, axis=1)

    def learn(
        self, start: State, most_epochs: int, validation: Data | None, patience: int
    ) -> History:
        """Improve a state until it no longer gets better or the validation samples stop it."""
        as_good = AS_GOOD if self.premises.is_interval else 1.0
        state, damping, best, best_epoch = start, FIRST_DAMPING, start, 0
        training = [self.data.error(self.predicted(state, self.data.X))]
        checked = (
            [] if validation is None else [validation.error(self.predicted(state, validation.X))]
        )
        stopped = False
        for epoch in range(1, most_epochs + 1):
            found = self._step(state, damping)
            if found is None:
                stopped = True
                break
            new, damping = found
            gain = (state.cost - new.cost) / state.cost if state.cost > 0.0 else 0.0
            state = new
            training.append(self.data.error(self.predicted(state, self.data.X)))
            if validation is None:
                best, best_epoch = state, epoch
            else:
                checked.append(validation.error(self.predicted(state, validation.X)))
                if checked[-1] < min(checked[:-1]):
                    best = state
                if checked[-1] <= as_good * min(checked):
                    best_epoch = epoch
                elif epoch - best_epoch >= patience:
                    stopped = True
                    break
            if gain < LEAST_GAIN:
                stopped = epoch < most_epochs
                break
        if checked:
            good = as_good * min(checked)
            best_epoch = max(k for k, error in enumerate(checked) if error <= good)
        return History(best, training, checked, best_epoch, stopped)

    def _step(self, state: State, damping: float) -> tuple[State, float] | None:
        """Return a better state and the next damping; None if no better state is found nearby."""
        count = len(state.parameters)
        curvature, descent = np.zeros((count, count)), np.zeros(count)
        for output in state.outputs:
            slopes = self._root * self.premises.slopes(
                state.parameters, state.grades, output.ends, output.z
            )
            explained = output.left.T @ slopes
            curvature += slopes.T @ slopes - explained.T @ (
                output.shrink[:, np.newaxis] * explained
            )
            descent += slopes.T @ output.residual
        diagonal = np.diag(curvature)
        floor = 1e-12 * diagonal.max(initial=0.0)
        if not floor > 0.0:
            return None  # no parameter has an effect any more
        diagonal = np.maximum(diagonal, floor)
        for _ in range(MOST_TRIALS):
            step = np.linalg.solve(curvature + damping * np.diag(diagonal), descent)
            longest = np.abs(step).max()
            if longest > LONGEST_STEP:
                step *= LONGEST_STEP / longest
            parameters = state.parameters + step
            if (np.abs(parameters[count // 2 :]) < WIDEST).all():
                new = self.solved(parameters, state.coefficients)
                if new.cost < state.cost:
                    return new, max(damping / 3.0, 1e-12)
            damping *= 4.0
        return None

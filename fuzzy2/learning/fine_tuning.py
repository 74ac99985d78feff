r"""Gradient fine-tuning of a system's means, spreads and consequents.

The objective is the mean squared error of the crisp output :math:`y = (y_l + y_r)/2`, each output
in units of its standard deviation :math:`s_j` over the samples, so that outputs with different
units have equal weight:

.. math:: E = \frac{1}{N m} \sum_{n=1}^{N} \sum_{j=1}^{m}
          \left(\frac{y_{nj} - \hat y_{nj}}{s_j}\right)^2

Its gradient is analytic, see :mod:`fuzzy2.learning.tunable_system`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.samples import LEAST_RANGE, check_scale
from fuzzy2.learning.tunable_system import TunableSystem
from fuzzy2.support.checks import (
    Array,
    finite_rows,
    generator,
    of_kind,
    positive,
    real,
    reals,
    whole_number,
)
from fuzzy2.systems.system import FuzzySystem

_FIRST_DECAY, _SECOND_DECAY, _TINY = 0.9, 0.999, 1e-8  # of Adam, as published


class FineTuning(NamedTuple):
    """Result of :func:`fine_tune`."""

    system: FuzzySystem
    """A new system, the one with the smallest validation error."""
    training_errors: Array
    """Objective over the training samples before the first and after every epoch, (E + 1,)."""
    validation_errors: Array
    """Objective over the validation samples, (E + 1,)."""
    best_epoch: int
    """Epoch after which the system was best; 0 stands for the given system."""
    stopped_early: bool
    """Whether the validation error stopped falling before the epochs were used up."""


def fine_tune(
    system: FuzzySystem,
    X: ArrayLike,
    y: ArrayLike,
    rng: np.random.Generator,
    *,
    learning_rate: float = 0.01,
    most_epochs: int = 500,
    patience: int = 50,
    validation_share: float = 0.2,
) -> FineTuning:
    """Return a system with the same rules that fits samples better.

    Means, spreads and consequents are tuned; the rules are kept.

    The method is Adam on all training samples at once. Means are measured in units of the input's
    range over the samples, spreads in relative units, and consequents in units of the output's
    standard deviation, so one learning rate suits all. Type-1 terms stay type-1, and crisp
    consequents stay crisp. The two means (or standard deviations, or ends) of an uncertain term or
    consequent move independently, but never past each other.

    Parameters
    ----------
    system : Type1System or IntervalType2System
        Initial system, which is not changed. Its terms must be Gaussians, possibly with an
        uncertain mean or standard deviation, and its consequents numbers, intervals or linear
        functions. The t-norm must be the product or the minimum, and the type reduction center of
        sets.
    X : (N, p) array_like, mapping or data frame
        Inputs of the samples. Named columns are matched with the system's inputs, as in
        ``system(X)``.
    y : (N,) or (N, m) array_like, mapping or data frame
        Outputs of the samples. Several named columns are matched with the names of the outputs.
    rng : numpy.random.Generator
        Chooses the validation samples.
    learning_rate : float
        Approximate largest change of a parameter per epoch, in the units above; at most 1.
    most_epochs : int
        Greatest number of epochs.
    patience : int
        Epochs without a smaller validation error after which tuning stops.
    validation_share : float
        Share of the samples, in (0, 1), that are not used for learning but for early stopping; at
        least one sample.

    Returns
    -------
    FineTuning
        The best system, and the errors after every epoch. The validation error of the system is
        never above that of the given one.

    Raises
    ------
    NotApplicable
        If the system has parts that cannot be tuned.
    InvalidValue
        If the samples are not finite or have wrong shapes, if no rule fires at one of them, or if
        an option is outside its range.

    Notes
    -----
    Adam: D. P. Kingma and J. Ba, "Adam: a method for stochastic optimization", ICLR 2015.
    """
    inputs, outputs = _samples(system, X, y)
    if positive("learning_rate", learning_rate) > 1.0:
        raise InvalidValue(
            "learning_rate", learning_rate, "at most 1, a step as wide as the range of the samples"
        )
    for name, value in (("most_epochs", most_epochs), ("patience", patience)):
        whole_number(name, value, 1)
    between = "between 0 and 1, both excluded"
    if not 0.0 < real("validation_share", validation_share, between) < 1.0:
        raise InvalidValue("validation_share", validation_share, between)
    generator("rng", rng)
    order = rng.permutation(len(inputs))
    held_back = min(max(1, round(validation_share * len(inputs))), len(inputs) - 1)
    validation, training = order[:held_back], order[held_back:]

    tunable = TunableSystem(
        system,
        input_scales=_scales(np.ptp(inputs, axis=0)),
        output_scales=_scales(outputs.std(axis=0)),
    )
    parameters = best = tunable.parameters
    # Indices stay in the order of the samples, so that an error names the right one.
    tunable.error(parameters, inputs, outputs)
    first, second = np.zeros_like(parameters), np.zeros_like(parameters)
    error, gradient = tunable.objective(parameters, inputs[training], outputs[training])
    smallest = tunable.error(parameters, inputs[validation], outputs[validation])
    training_errors, validation_errors, best_epoch = [error], [smallest], 0
    for epoch in range(1, most_epochs + 1):
        first = _FIRST_DECAY * first + (1.0 - _FIRST_DECAY) * gradient
        second = _SECOND_DECAY * second + (1.0 - _SECOND_DECAY) * gradient**2
        step = (
            first
            / (1.0 - _FIRST_DECAY**epoch)
            / (np.sqrt(second / (1.0 - _SECOND_DECAY**epoch)) + _TINY)
        )
        parameters = tunable.admissible(parameters - learning_rate * step)
        try:
            # parameters that overflow make invalid terms, which are refused
            with np.errstate(over="ignore", invalid="ignore"):
                error, gradient = tunable.objective(parameters, inputs[training], outputs[training])
                validation_error = tunable.error(
                    parameters, inputs[validation], outputs[validation]
                )
        except InvalidValue:  # the steps were so large that no rule fires at some sample any more
            break
        training_errors.append(error)
        validation_errors.append(validation_error)
        if validation_error < smallest:
            smallest, best, best_epoch = validation_error, parameters, epoch
        elif epoch - best_epoch >= patience:
            break
    epochs = len(training_errors) - 1
    return FineTuning(
        tunable.system(best),
        np.array(training_errors),
        np.array(validation_errors),
        best_epoch,
        epochs < most_epochs,
    )


def _samples(system: FuzzySystem, X: ArrayLike, y: ArrayLike) -> tuple[Array, Array]:
    of_kind("system", system, FuzzySystem, "a fuzzy system")
    inputs = system._ordered_inputs(X)
    # The index of a Series names samples, not outputs.
    is_column = getattr(y, "ndim", None) == 1
    outputs = reals("y", y) if is_column else system._ordered_outputs(y)
    if outputs.ndim == 1:
        outputs = outputs[:, np.newaxis]
    fits = inputs.ndim == 2 and inputs.shape[1] == len(system.inputs)
    finite_rows("X", inputs, fits, f"(N, {len(system.inputs)})")
    if len(inputs) < 2:
        raise InvalidValue(
            "X", inputs.shape, "at least 2 samples, to learn from one and validate with the other"
        )
    shape = (len(inputs), system.n_outputs)
    finite_rows("y", outputs, outputs.shape == shape, f"{shape}, one row for each of X")
    check_scale("y", outputs)
    return inputs, outputs


def _scales(widths: Array) -> Array:
    """Return the widths, with 1 for those that are zero or too small to divide by."""
    return np.where(widths > LEAST_RANGE, widths, 1.0)

r"""Noise with a given signal-to-noise ratio, and the mean variation of type-2 terms for it.

The mean variation is how uncertain the means of type-2 terms should be for records with that noise.

The footprints that a type-2 system needs become wider with the noise of the data from which its
rules are learned. Without noise, type-1 terms are right and the width is zero. The rule of
:func:`mean_variation_from_snr` is a choice, not a theorem. It is zero for infinite ratios,
proportional to the amplitude of weak noise, and levels off for strong noise, because terms much
wider than their spacing no longer distinguish inputs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array, binary_exponent, reals

GREATEST_MEAN_VARIATION = 0.4
"""Share of an input's range that the mean variation approaches as noise grows."""

HALFWAY_SNR = 30.0
"""Signal-to-noise ratio [dB] of half the greatest mean variation."""


def mean_variation_from_snr(snr_db: ArrayLike) -> Array:
    r"""Return the mean variation of type-2 terms for records with a signal-to-noise ratio.

    .. math:: \nu(S) = \frac{0.4}{1 + 10^{(S - 30)/20}} = 0.4\,\frac{q}{q + q_{30}}, \qquad
              q = 10^{-S/20}, \quad q_{30} = 10^{-30/20}

    with S in decibels and the ratio q of noise amplitude to signal amplitude. It is 0.30, 0.34 and
    0.36 at 20, 15 and 10 dB. It is proportional to the amplitude of weak noise, and 0 at an
    infinite ratio.

    Parameters
    ----------
    snr_db : (...,) array_like
        Signal-to-noise ratio [dB]; may be infinite.

    Returns
    -------
    (...,) array
        Mean variation, the distance of a term's smallest and largest mean from the middle one, as a
        share of the input's range.

    Raises
    ------
    InvalidValue
        If a ratio is not a number.

    Notes
    -----
    The two constants are chosen so that the noise levels of Table 6.3 (20, 15 and 10 dB) lead to
    mean variations of 0.3 to 0.4. With these, the computed-torque controller of chapter 5, learned
    by firing-weighted averages from records with that noise, has 0.3 to 0.6 of the type-1
    controller's squared error (at 0.3: 0.57, 0.47, 0.44; at 0.4: 0.48, 0.33, 0.28; ten seeds).
    """
    ratios = _numbers("snr_db", snr_db)
    # the power of a huge ratio is infinite, and the variation is then 0
    with np.errstate(over="ignore"):
        return np.asarray(
            GREATEST_MEAN_VARIATION / (1.0 + 10.0 ** ((ratios - HALFWAY_SNR) / 20.0))
        )[()]


def snr_from_mean_variation(mean_variation: ArrayLike) -> Array:
    r"""Return the signal-to-noise ratio that leads to a mean variation.

    It is the inverse of :func:`mean_variation_from_snr`.

    .. math:: S(\nu) = 30 + 20 \log_{10}\left(\frac{0.4}{\nu} - 1\right)

    Parameters
    ----------
    mean_variation : (...,) array_like
        Distance of a term's smallest and largest mean from the middle one as a share of the input's
        range, in [0, 0.4].

    Returns
    -------
    (...,) array
        Signal-to-noise ratio [dB]; infinite for 0, minus infinite for 0.4.

    Raises
    ------
    InvalidValue
        If a mean variation is outside [0, 0.4].
    """
    variations = _numbers("mean_variation", mean_variation)
    if not ((variations >= 0.0) & (variations <= GREATEST_MEAN_VARIATION)).all():
        raise InvalidValue(
            "mean_variation",
            variations,
            f"in [0, {GREATEST_MEAN_VARIATION}], what the rule gives for some ratio",
        )
    with np.errstate(divide="ignore", over="ignore"):
        logarithms = np.log10(GREATEST_MEAN_VARIATION / variations - 1.0)
        # The quotient overflows long before its logarithm would.
        beyond = np.log10(GREATEST_MEAN_VARIATION) - np.log10(variations)
        logarithms = np.where(np.isposinf(logarithms), beyond, logarithms)
        return np.asarray(HALFWAY_SNR + 20.0 * logarithms)[()]


def add_noise(signal: ArrayLike, snr_db: float, rng: np.random.Generator) -> Array:
    r"""Return a signal with white Gaussian noise with a given signal-to-noise ratio added.

    .. math:: y_t = x_t + \sqrt{P\,10^{-S/10}}\;\varepsilon_t, \qquad
              P = \frac{1}{N} \sum_t x_t^2, \quad \varepsilon_t \sim N(0, 1)

    The power P of the signal is its mean square, not its variance, so it includes the mean.

    Parameters
    ----------
    signal : (N, ...) array_like
        Samples along the first axis; every column is a separate signal with its own power.
    snr_db : float
        Signal-to-noise ratio S [dB]; infinity adds nothing.
    rng : numpy.random.Generator
        Source of random numbers. An infinite ratio draws as many as a finite one, so that runs of
        different ratios are comparable.

    Returns
    -------
    (N, ...) array
        A new array.

    Raises
    ------
    InvalidValue
        If the signal is empty or not finite, or is not finite after adding the noise; if the ratio
        is NaN or minus infinity; or if ``rng`` is not a Generator.
    """
    samples = reals("signal", signal)
    if samples.ndim == 0 or samples.size == 0 or not np.isfinite(samples).all():
        raise InvalidValue("signal", samples, "finite samples along the first axis")
    ratio = _numbers("snr_db", snr_db)
    if ratio.ndim or ratio == -np.inf:
        raise InvalidValue("snr_db", snr_db, "one number above minus infinity")
    if not isinstance(rng, np.random.Generator):
        raise InvalidValue(
            "rng", rng, "a numpy.random.Generator, such as numpy.random.default_rng(0)"
        )
    noise = _root_mean_square(samples) * 10.0 ** (-ratio / 20.0)
    with np.errstate(over="ignore"):
        noisy = np.asarray(samples + noise * rng.standard_normal(samples.shape))
    if not np.isfinite(noisy).all():
        raise InvalidValue("signal", samples, "so small that it is finite with the noise, too")
    return noisy


def _root_mean_square(samples: Array) -> Array:
    """Return the root mean square of every column, whatever its magnitude."""
    columns = samples.reshape(len(samples), -1)
    # Each column is scaled by its own power of two, because columns may have very different
    # magnitudes.
    exponents = np.array([binary_exponent(column) for column in columns.T], dtype=int)
    roots = np.sqrt(np.mean(np.ldexp(columns, -exponents) ** 2, axis=0))
    return np.asarray(np.ldexp(roots, exponents).reshape(samples.shape[1:]))


def _numbers(name: str, values: ArrayLike) -> Array:
    numbers = reals(name, values)
    if np.isnan(numbers).any():
        raise InvalidValue(name, numbers, "numbers, not NaN")
    return numbers

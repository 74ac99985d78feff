r"""Torque intervals that contain a given share of torques.

The interval of a type-2 controller (:attr:`psp3.FuzzyComputedTorque.torque_interval`) shows how far
its rules disagree, not how wrong they are. With one number for each joint, learned from torques
that were measured or computed with an exact model, it becomes an interval of guaranteed coverage.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.bounds.conformal import check_count, checked_share, conformal_bound
from psp3.checks import Array, as_floats
from psp3.errors import InvalidArray, InvalidValue, UnknownName

SCALES = ("interval", "constant")
"""Choices of the scaled width: the interval's own width, or one width for all states."""


class ConformalIntervals:
    r"""Intervals that contain a given share of torques, about the middles of given intervals.

    .. math:: \Big[ m - r, m + r \Big], \qquad m = \tfrac12 (\underline\tau + \overline\tau), \quad
              r = q\, \tfrac12 (\overline\tau - \underline\tau) \text{ or } r = q

    where q is, for each joint, the conformal bound of :math:`|\tau - m|`, either in units of the
    half-width or absolute (:func:`psp3.bounds.conformal_bound`). The interval contains a new torque
    of one joint with a probability of at least ``share`` if state and torque are exchangeable with
    those given. Samples of one run are not independent. Use random states, or whole runs like the
    future ones; many runs are better than long ones. If a controller fell back on its average
    (:attr:`psp3.FuzzyComputedTorque.fell_back`), its interval has no width to scale.

    Parameters
    ----------
    torques : (N, n) array_like
        Torques [N or N m], measured or computed with an exact model.
    intervals : (N, n, 2) array_like
        Intervals at the same states.
    share : float
        Share of the torques of each joint that the intervals contain, in (0, 1).
    scale : {"interval", "constant"}
        What q multiplies: the given half-widths, or 1, which gives one half-width for all states.

    Attributes
    ----------
    factor : (n,) ndarray
        The number q of each joint: a factor, or a half-width [N or N m].

    Raises
    ------
    InvalidArray
        If arrays are not finite numbers of these shapes, or ends are not in ascending order.
    InvalidValue
        If there are too few torques for the share, or so many intervals have no width that no
        factor widens them enough.
    """

    def __init__(
        self,
        torques: ArrayLike,
        intervals: ArrayLike,
        share: float = 0.9,
        scale: str = "interval",
    ) -> None:
        if scale not in SCALES:
            raise UnknownName("scale", scale, SCALES)
        self.share, self.scale = checked_share(share), scale
        middle, half = _middle_and_half(intervals)
        if middle.ndim != 2:
            raise InvalidArray("intervals", "(N, n, 2)", intervals)
        measured = _torques(torques, middle.shape)
        check_count("torques", len(measured), self.share)
        self.factor = conformal_bound(self._scores(measured, middle, half), self.share)
        if not np.isfinite(self.factor).all():
            raise InvalidValue(
                "intervals",
                f"of no width at {np.mean(half == 0.0):.0%} of the states",
                "such as have a width, which a controller that fell back has not; take "
                'scale="constant"',
            )

    def __repr__(self) -> str:
        factors = ", ".join(f"{value:.3g}" for value in self.factor)
        return (
            f"{type(self).__name__}({100.0 * self.share:g} % of the torques, {self.scale}, "
            f"factor=[{factors}])"
        )

    def _scores(self, torques: Array, middle: Array, half: Array) -> Array:
        off = np.abs(torques - middle)
        if self.scale == "constant":
            return off
        # An interval of no width contains only its middle, whatever the factor.
        bare = half == 0.0
        with np.errstate(over="ignore"):  # intervals of almost no width, too
            scores: Array = np.where(
                bare, np.where(off > 0.0, np.inf, 0.0), off / np.where(bare, 1.0, half)
            )
        return scores

    def around(self, intervals: ArrayLike) -> Array:
        """Return intervals (..., n, 2) of the requested coverage, about the given ones' middles.

        Raises
        ------
        InvalidArray
            If intervals are not finite numbers of that shape in ascending order.
        """
        middle, half = self._of_joints(intervals)
        reach = self.factor * (half if self.scale == "interval" else np.ones_like(half))
        return np.stack([middle - reach, middle + reach], axis=-1)

    def holds(self, torques: ArrayLike, intervals: ArrayLike) -> NDArray[np.bool_]:
        """Return which torques (..., n) are in the new intervals about given ones, (..., n, 2).

        Raises
        ------
        InvalidArray
            As from :meth:`around`, or if torques are not of that shape.
        """
        middle, half = self._of_joints(intervals)
        measured = _torques(torques, middle.shape)
        # Decided by the scores of calibration, because the ends of intervals are rounded.
        return np.asarray(self._scores(measured, middle, half) <= self.factor)

    def _of_joints(self, intervals: ArrayLike) -> tuple[Array, Array]:
        middle, half = _middle_and_half(intervals)
        if middle.shape[-1:] != self.factor.shape:
            raise InvalidArray("intervals", f"(..., {len(self.factor)}, 2)", intervals)
        return middle, half


def _middle_and_half(intervals: ArrayLike) -> tuple[Array, Array]:
    ends = as_floats("intervals", intervals, "(..., n, 2)")
    if (
        ends.ndim < 2
        or ends.shape[-1] != 2
        or not np.isfinite(ends).all()
        or (ends[..., 0] > ends[..., 1]).any()
    ):
        raise InvalidArray("intervals", "(..., n, 2), left ends not above right ends", intervals)
    low, high = ends[..., 0], ends[..., 1]
    return 0.5 * (low + high), 0.5 * (high - low)


def _torques(torques: ArrayLike, shape: tuple[int, ...]) -> Array:
    measured = as_floats("torques", torques, str(shape))
    if measured.shape != shape or not np.isfinite(measured).all():
        raise InvalidArray("torques", str(shape), torques)
    return measured

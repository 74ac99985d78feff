r"""The torque interval as a monitor.

It raises an alarm if the interval is wider than under the conditions of training.

With every torque a type-2 controller also gives an interval, between whose ends its rules place the
torque (:attr:`psp3.FuzzyComputedTorque.torque_interval`). From runs under known conditions the
monitor learns the low-pass filtered width of this interval. It raises an alarm when the width
exceeds all but a given share of the learned widths. :mod:`psp3.study.detection` measures how well
this works, and compares it with other signals that the same monitor can watch.

The interval shows how far the rules disagree, and contains only few of the correct torques;
:class:`psp3.ConformalIntervals` turns it into intervals that contain a given share.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.support.described import Described
from psp3.checks import Array, as_floats, checked_number, checked_positive, listed
from psp3.errors import InvalidArray, InvalidValue, NoThreshold


def torque_width(interval: ArrayLike) -> Array:
    """Return the widths of torque intervals, added up over the screws.

    Parameters
    ----------
    interval : (..., n, 2) array_like
        Ends of the intervals [N].

    Returns
    -------
    (...,) ndarray
        Sums of the widths [N].

    Raises
    ------
    InvalidArray
        If the ends are not finite numbers of that shape in ascending order.
    """
    ends = as_floats("interval", interval, "(..., n, 2)")
    if (
        np.ndim(interval) < 2
        or ends.shape[-1] != 2
        or not np.isfinite(ends).all()
        or (ends[..., 0] > ends[..., 1]).any()
    ):
        raise InvalidArray("interval", "(..., n, 2), left ends not above right ends", interval)
    return np.asarray((ends[..., 1] - ends[..., 0]).sum(axis=-1))


class Monitor(Described):
    r"""An alarm for a signal that exceeds its level in normal operation.

    The signal s passes a first-order low-pass filter, :math:`T \dot y = s - y`. The alarm goes on
    when y exceeds the learned threshold, and off when y falls below the threshold by a share of it.
    This hysteresis prevents rapid switching.

    Parameters
    ----------
    quantile : float
        Share of the training samples of y at or below the threshold, in (0, 1]; 1 makes the
        greatest sample the threshold.
    hysteresis : float
        Share of the threshold by which y must fall below it for the alarm to go off, in [0, 1).
    time_constant : float
        T [s].

    Attributes
    ----------
    threshold_ : float
        Learned threshold, in the unit of the signal.

    Raises
    ------
    InvalidValue
        If a parameter is out of range.
    """

    threshold_: float

    def __init__(
        self, quantile: float = 0.999, hysteresis: float = 0.05, time_constant: float = 0.05
    ) -> None:
        self.quantile = checked_positive("quantile", quantile)
        if self.quantile > 1.0:
            raise InvalidValue("quantile", quantile, "above 0 and at most 1")
        self.hysteresis = checked_number("hysteresis", hysteresis, "at least 0 and below 1", 0.0)
        if self.hysteresis >= 1.0:
            raise InvalidValue("hysteresis", hysteresis, "at least 0 and below 1")
        self.time_constant = checked_positive("time_constant", time_constant)
        self.reset()

    def _facts(self) -> dict[str, Any]:
        return {
            "threshold": getattr(self, "threshold_", "not learned"),
            "quantile": self.quantile,
            "hysteresis": self.hysteresis,
            "time_constant": f"{self.time_constant:g} s",
        }

    def reset(self) -> None:
        """Forget the signal so far; the threshold stays.

        The filter starts again from the next value.
        """
        self._level, self._time, self._alarm = math.nan, math.nan, False

    def filtered(self, t: ArrayLike, signal: ArrayLike) -> Array:
        """Return a whole signal after the filter, which starts at the first value.

        Parameters
        ----------
        t : (N,) array_like
            Times in ascending order [s].
        signal : (N,) array_like
            Values at these times.

        Returns
        -------
        (N,) ndarray

        Raises
        ------
        InvalidArray
            If times or values are not rows of finite numbers of the same length, or the times do
            not ascend.
        """
        times, values = (
            as_floats(name, row, "(N,)") for name, row in (("t", t), ("signal", signal))
        )
        if (
            np.ndim(t) != 1
            or not times.size
            or not np.isfinite(times).all()
            or (np.diff(times) <= 0.0).any()
        ):
            raise InvalidArray("t", "(N,), finite and ascending", t)
        if values.shape != times.shape or np.ndim(signal) != 1 or not np.isfinite(values).all():
            raise InvalidArray(
                "signal", f"({times.size},), finite, one value for each time", signal
            )
        shares = -np.expm1(-np.diff(times) / self.time_constant)
        level, levels = float(values[0]), [float(values[0])]
        for share, value in zip(shares.tolist(), values[1:].tolist(), strict=True):
            level += share * (value - level)
            levels.append(level)
        return np.array(levels)

    def learn(self, runs: Iterable[tuple[ArrayLike, ArrayLike]]) -> Self:
        """Learn the threshold from runs in normal operation.

        Parameters
        ----------
        runs : iterable of (t, signal)
            Times and values of each run, see :meth:`filtered`.

        Returns
        -------
        Monitor
            The monitor itself, with :attr:`threshold_`.

        Raises
        ------
        InvalidValue
            If there is no run.
        InvalidArray
            As from :meth:`filtered`.
        """
        wanted = "a list of pairs, times and values of each run"
        levels = []
        for run in listed("runs", runs, wanted):
            pair = listed("runs", run, wanted)
            if len(pair) != 2:
                raise InvalidValue("runs", run, wanted)
            levels.append(self.filtered(*pair))
        if not levels:
            raise InvalidValue("runs", [], "at least one run")
        self.threshold_ = float(np.quantile(np.concatenate(levels), self.quantile))
        self.reset()
        return self

    def update(self, t: float, value: float) -> bool:
        """Take the next value, and return whether there is an alarm.

        Parameters
        ----------
        t : float
            Time, after that of the last call [s].
        value : float
            The signal now.

        Returns
        -------
        bool

        Raises
        ------
        NoThreshold
            If no threshold was learned.
        InvalidValue
            If time or value is not a finite number, or the time is not after the last one.
        """
        threshold = self._threshold()
        now, level = (
            checked_number(name, number, "a finite number", -np.finfo(float).max)
            for name, number in (("t", t), ("value", value))
        )
        for name, number in (("t", now), ("value", level)):
            if number == math.inf:
                raise InvalidValue(name, number, "a finite number")
        if now <= self._time:
            raise InvalidValue(
                "t",
                t,
                f"after the time of the last call, {self._time:.6g} s; reset() before another run",
            )
        if not math.isnan(self._level):
            level = self._level - math.expm1(-(now - self._time) / self.time_constant) * (
                level - self._level
            )
        self._level, self._time = level, now
        self._alarm = level > (self._lower(threshold) if self._alarm else threshold)
        return self._alarm

    def watch(self, t: ArrayLike, signal: ArrayLike) -> NDArray[np.bool_]:
        """Return at which samples of a recorded run there would have been an alarm, (N,).

        See :meth:`filtered` for its arguments.

        Raises
        ------
        NoThreshold
            If no threshold was learned.
        InvalidArray
            As from :meth:`filtered`.
        """
        threshold = self._threshold()
        levels = self.filtered(t, signal)
        # On above the threshold, off below the lower one. In between the last sample that was above
        # or below decides.
        decided = (levels > threshold) | (levels <= self._lower(threshold))
        last = np.maximum.accumulate(np.where(decided, np.arange(len(levels)), -1))
        return np.asarray((last >= 0) & (levels[last] > threshold))

    def _lower(self, threshold: float) -> float:
        return threshold - self.hysteresis * abs(threshold)

    def _threshold(self) -> float:
        if not hasattr(self, "threshold_"):
            raise NoThreshold(type(self).__name__)
        return self.threshold_

"""Draw the pictures of the page on bounds anew: tubes, and what the width of an interval is worth.

Run by ``make pictures``, or ``python docs/pictures/make_tubes.py``; half a minute.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from make_figures import MUTED, TEXT, VERMILLION, save
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import psp3
from fuzzy2.plots.style import style
from psp3.bounds import ConformalIntervals
from psp3.bounds.torque_intervals import SCALES

sys.path.append(str(Path(__file__).resolve().parents[1]))
from make_bounds import (
    AMPLITUDES,
    CALIBRATE,
    GAINS,
    HELD,
    Case,
    learned,
    learned_3psp,
    torques_near,
)

RUNS, SHOWN = 30, 10
"""Runs that calibrate, and others that are drawn."""

UNTIL, EVERY = 500, 10
"""Samples that are drawn: the first two seconds, one of so many."""


def draw_tube(axes: Axes, case: Case, coordinate: int, unit: str) -> None:
    """Draw the errors of one coordinate in runs that did not calibrate, within their tube."""
    tube = psp3.TrackingTube([case.run(seed, GAINS, case.path) for seed in range(RUNS)], *GAINS)
    new = [case.run(seed, GAINS, case.path) for seed in range(100, 100 + SHOWN)]
    whole = [run for run in new if run is not None]
    at = slice(0, UNTIL + 1, EVERY)
    reach = 1e3 * tube.around(whole[0])[at, coordinate]
    t = whole[0].t[at]
    for side in (reach, -reach):
        axes.plot(t, side, color=TEXT, linewidth=1.4)
    for run in whole:
        error = (run.desired.positions - run.positions)[at, coordinate]
        axes.plot(t, 1e3 * error, color=VERMILLION, linewidth=0.8)
    axes.set(title=case.robot.title, ylabel=f"error {coordinate + 1} [{unit}]", xlim=(0.0, t[-1]))


def tubes() -> None:
    """Draw the tubes of three robots that learned from noisy records."""
    figure = Figure(figsize=(6.4, 5.6), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    for axes, (case, unit) in zip(
        panels,
        (
            (learned_3psp(), "mm"),
            (learned("five_bar"), "mrad"),
            (learned("gough_stewart", "average"), "mm"),
        ),
        strict=True,
    ):
        draw_tube(axes, case, 0, unit)
    panels[-1].set_xlabel("time [s]")
    save(figure, "tubes")


def draw_widths(axes: Axes, case: Case, amplitude: float, title: str) -> None:
    """Draw how far torques are from the middles of their intervals over how wide these are."""
    known = torques_near(case.with_servo(0), case.path, amplitude, CALIBRATE, _source())
    torques, intervals = known
    half = 0.5 * np.diff(intervals)[:, 0, 0]
    off = np.abs(torques - intervals.mean(axis=-1))[:, 0]
    axes.plot(half, off, "o", color=VERMILLION, markersize=2.2, markeredgewidth=0.0)
    along = np.array([0.0, 1.05 * half.max()])
    for scale, dash in zip(SCALES, ("-", "--"), strict=True):
        q = ConformalIntervals(*known, HELD, scale).factor[0]
        reach = q * along if scale == "interval" else np.full(2, q)
        name = "factor × width" if scale == "interval" else "constant"
        axes.plot(along, reach, dash, color=TEXT, linewidth=1.4, label=name)
    axes.plot(along, along, ":", color=MUTED, linewidth=1.4, label="as it is")
    axes.set(title=title, xlim=along, ylim=(0.0, 1.1 * off.max()))


def _source() -> np.random.Generator:
    return np.random.default_rng(0)


def widths() -> None:
    """Draw what the width of a type-2 interval knows of the torque's error, of two robots."""
    figure = Figure(figsize=(6.4, 3.2), layout="constrained")
    first, second = figure.subplots(1, 2)
    draw_widths(first, learned_3psp(), 0.02, "3-PSP, screw 1")
    draw_widths(second, learned("five_bar"), AMPLITUDES["five_bar"], "five-bar, motor 1")
    first.set(xlabel="half-width [N]", ylabel="torque off the middle [N]")
    second.set(xlabel="half-width [N m]", ylabel="torque off the middle [N m]")
    first.legend(loc="upper left", fontsize=8)
    save(figure, "torque_widths")


if __name__ == "__main__":
    with style("light"):
        tubes()
        widths()

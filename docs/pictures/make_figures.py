"""Draw the figures of the documentation anew.

Run by ``make pictures``, or ``python docs/pictures/make_figures.py``.

Each is one SVG for light and dark pages: it follows the reader's color scheme, and has a ground of
its own, so that it can be read on any page. What lines and areas are is written beside them, and
never told by color alone.
"""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

import fuzzy2
import psp3
from fuzzy2.plots.style import CYCLES, GROUNDS, style
from psp3.three_psp.geometry import tip_reach

HERE = Path(__file__).parent
BLUE, VERMILLION, GREEN, PURPLE = CYCLES["light"][:4]
TEXT, MUTED = GROUNDS["light"][1:3]


INVISIBLE = 0.01
"""How far [pt] a line may move if points are left out of it: a hundredth of its width."""
POLYLINE = re.compile(r'(?<= d=")[ML\d.\s-]{400,}z?\s*(?=")')


def thinned(path: re.Match[str]) -> str:
    """Return a long polyline without the points that are not seen.

    Sets are sampled at hundreds of points, and what is straight between them needs two. Matplotlib
    leaves such points out of lines, but not out of filled areas.
    """
    pieces = []
    for piece in path[0].split("M")[1:]:
        points = np.array(re.findall(r"-?[\d.]+", piece), dtype=float).reshape(-1, 2)
        rows = (f"{x:.7g} {y:.7g}" for x, y in points[kept(points)])
        pieces.append("M " + "\nL ".join(rows) + ("\nz" if "z" in piece else ""))
    return "\n".join(pieces)


def kept(points: np.ndarray) -> np.ndarray:
    """Return which points (n, 2) a polyline needs, by the algorithm of Douglas and Peucker."""
    needed = np.zeros(len(points), bool)
    needed[[0, -1]] = True
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        between = points[first + 1 : last] - points[first]
        if not len(between):
            continue
        way = points[last] - points[first]
        # As far along the way as its ends allow, so that a point beyond an end is not left out.
        along = np.clip(between @ way / max(way @ way, 1e-30), 0.0, 1.0)
        distance = np.linalg.norm(between - along[:, np.newaxis] * way, axis=1)
        if distance.max() > INVISIBLE:
            middle = first + 1 + int(distance.argmax())
            needed[middle] = True
            spans += [(first, middle), (middle, last)]
    return needed


def save(figure: Figure, name: str) -> None:
    """Write a figure drawn in the light style as an SVG.

    Its colors change with the reader's scheme.
    """
    buffer = io.StringIO()
    figure.savefig(
        buffer, format="svg", metadata={"Date": None, "Creator": None, "Type": None, "Format": None}
    )
    light = (*GROUNDS["light"], *CYCLES["light"])
    dark = (*GROUNDS["dark"], *CYCLES["dark"])
    text = POLYLINE.sub(thinned, buffer.getvalue())
    for number, color in enumerate(light):
        text = re.sub(rf"(?<=[ \"':]){color}\b", f"var(--c{number})", text, flags=re.IGNORECASE)
    sheets = [
        ":root {" + " ".join(f"--c{n}: {color.lower()};" for n, color in enumerate(scheme)) + "}"
        for scheme in (light, dark)
    ]
    rules = f"<style>{sheets[0]} @media (prefers-color-scheme: dark) {{{sheets[1]}}}</style>"
    text = re.sub(r"(<svg\b[^>]*>)", rf"\1\n {rules}", text, count=1)
    (HERE / f"{name}.svg").write_text(
        re.sub(r"[ \t]+$", "", text, flags=re.MULTILINE), encoding="utf-8"
    )


def box(
    axes: Axes, x: float, y: float, text: str, width: float = 1.6, height: float = 0.62, **edge: Any
) -> tuple[float, float, float, float]:
    """Draw a box with a text in its middle and return its middle and half sizes."""
    options = {"edgecolor": MUTED, "facecolor": "none", "linewidth": 1.2, **edge}
    axes.add_patch(
        FancyBboxPatch(
            (x - width / 2, y - height / 2),
            width,
            height,
            boxstyle="round,pad=0,rounding_size=0.12",
            **options,
        )
    )
    axes.text(x, y, text, ha="center", va="center", fontsize=9.0)
    return x, y, width / 2, height / 2


def arrow(
    axes: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    text: str = "",
    offset: tuple[float, float] = (0.0, 0.14),
    **line: Any,
) -> None:
    """Draw an arrow with a text beside its middle."""
    options = {
        "arrowstyle": "-|>",
        "mutation_scale": 11.0,
        "color": TEXT,
        "linewidth": 1.2,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
        **line,
    }
    axes.add_patch(FancyArrowPatch(start, end, **options))
    if text:
        axes.text(
            (start[0] + end[0]) / 2 + offset[0],
            (start[1] + end[1]) / 2 + offset[1],
            text,
            ha="center",
            va="bottom",
            fontsize=9.0,
        )


def diagram(
    width: float, height: float, x: tuple[float, float], y: tuple[float, float]
) -> tuple[Figure, Axes]:
    """Return a figure for a diagram, without axes."""
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots()
    axes.set(xlim=x, ylim=y, aspect="equal")
    axes.axis("off")
    return figure, axes


def panel(width: float = 3.4, height: float = 3.2) -> tuple[Figure, Axes]:
    """Return a figure that fits a phone; on wider screens several stand side by side."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def note(axes: Axes, text: str, point: tuple[float, float], place: tuple[float, float]) -> None:
    """Write what something is, with a line that leads to it."""
    axes.annotate(
        text, point, xytext=place, fontsize=9.0, arrowprops={"arrowstyle": "-", "color": MUTED}
    )


def star() -> None:
    """Draw nuts and star from above, at home and tilted."""
    robot = psp3.load("psp3")
    azimuths = 2.0 * np.pi / 3.0 * np.arange(3)
    nuts = (
        1e3 * robot.parameters.screw_radius * np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    )
    tilted = robot.forward_kinematics(
        robot.inverse_kinematics(height=0.0, tilt=np.radians(30.0), azimuth=np.radians(200.0))
    ).center
    figure, axes = panel()
    axes.plot(*np.vstack([nuts, nuts[:1]]).T, color=MUTED, linestyle=":", linewidth=1.0)
    axes.plot(*nuts.T, "o", color=TEXT, markersize=7)
    for leg, nut in enumerate(nuts, start=1):
        axes.annotate(
            f"nut {leg}",
            nut,
            xytext=(0, 9 if leg != 3 else -15),
            textcoords="offset points",
            ha="center",
            fontsize=9,
        )
    for center, marker, label, color, line in (
        (np.zeros(3), "s", "home", BLUE, "--"),
        (tilted, "D", "tilt 30°", VERMILLION, "-"),
    ):
        for nut in nuts:
            axes.plot(*np.stack([nut, 1e3 * center[:2]]).T, line, color=color, linewidth=1.4)
        axes.plot(*(1e3 * center[:2]), marker + line, color=color, markersize=6, label=label)
    axes.legend(loc="upper right")
    axes.set(
        title="Star from above",
        xlabel="x [mm]",
        ylabel="y [mm]",
        aspect="equal",
        xlim=(-140, 250),
        ylim=(-195, 195),
    )
    save(figure, "star")


def parasitic_motion() -> None:
    """Draw where the center goes while the direction of tilt goes around."""
    robot, azimuths = psp3.load("psp3"), np.linspace(0.0, 2.0 * np.pi, 361)
    figure, axes = panel()
    for tilt, color, line in ((10.0, GREEN, ":"), (20.0, BLUE, "--"), (30.0, VERMILLION, "-")):
        heights = robot.inverse_kinematics(height=0.0, tilt=np.radians(tilt), azimuth=azimuths)
        centers = 1e3 * robot.forward_kinematics(heights).center
        axes.plot(*centers[:, :2].T, line, color=color)
        top = centers[np.argmax(centers[:, 1])][:2]
        axes.annotate(
            f"{tilt:.0f}°", top, xytext=(0, 2), textcoords="offset points", ha="center", fontsize=9
        )
    axes.set(
        title="Path of the center, by tilt",
        xlabel="x [mm]",
        ylabel="y [mm]",
        aspect="equal",
        xlim=(-16, 16),
        ylim=(-16, 17),
    )
    save(figure, "parasitic_motion")


def reach() -> None:
    """Draw how far the tip gets from the axis."""
    parameters, azimuths = psp3.load("psp3").parameters, np.linspace(0.0, 2.0 * np.pi, 361)
    radius = 1e3 * tip_reach(azimuths, parameters.screw_radius, parameters.tool_length)
    figure, axes = panel()
    axes.plot(radius * np.cos(azimuths), radius * np.sin(azimuths), color=PURPLE)
    axes.fill(radius * np.cos(azimuths), radius * np.sin(azimuths), color=PURPLE, alpha=0.15)
    note(axes, f"{radius[0]:.1f} mm\ntoward screw 1", (radius[0], 0.0), (27.0, 14.0))
    note(axes, f"{radius[180]:.1f} mm", (-radius[180], 0.0), (-52.0, -28.0))
    axes.plot(0.0, 0.0, "+", color=TEXT)
    axes.set(
        title="Reach of the tip",
        xlabel="x [mm]",
        ylabel="y [mm]",
        aspect="equal",
        xlim=(-60, 72),
        ylim=(-66, 66),
    )
    save(figure, "reach")


def loops() -> None:
    """Draw the tree and the two closures."""
    figure, axes = diagram(4.3, 5.4, (-0.9, 5.9), (-1.0, 7.6))
    box(axes, 2.5, 7.0, "base", 6.4, 0.8)
    rows = (
        "motor, nut $a_{}$",
        "ball, 1st $\\varphi_{}$",
        "ball, 2nd $\\theta_{}$",
        "ball, 3rd $\\lambda_{}$",
    )
    for x, leg in ((0.25, 2), (2.5, 1), (4.75, 3)):
        below = 6.6
        for number, words in enumerate(rows):
            y = 5.7 - 1.3 * number
            edge = {"edgecolor": VERMILLION, "linewidth": 2.2} if number == 0 else {}
            box(axes, x, y, words.format(leg), 1.7, 0.7, **edge)
            arrow(axes, (x, below), (x, y + 0.35))
            below = y - 0.35
        box(
            axes,
            x,
            0.5,
            f"slider $b_{leg}$,\none third\nof the star",
            1.5,
            1.15,
            edgecolor=BLUE,
            linewidth=2.2,
        )
        arrow(axes, (x, below), (x, 1.08))
    for start, end in ((1.0, 1.75), (3.25, 4.0)):
        arrow(
            axes,
            (start, 0.5),
            (end, 0.5),
            arrowstyle="<|-|>",
            linestyle="--",
            color=BLUE,
            linewidth=1.8,
        )
        axes.text((start + end) / 2, -0.2, "closure,\n6D", ha="center", va="top", fontsize=9.0)
    save(figure, "loops")


def complement() -> None:
    """Draw how speeds become twists, and forces come back."""
    figure, axes = diagram(3.9, 4.6, (-2.3, 3.2), (-0.8, 5.7))
    for y, words in (
        (5.0, "3 motors: speeds $\\dot a$"),
        (2.5, "15 joints: velocities $\\dot q$"),
        (0.0, "15 bodies: twists $t$"),
    ):
        box(axes, 0.0, y, words, 3.2, 0.9)
    for y, name in ((4.55, "L"), (2.05, "K")):
        arrow(axes, (-0.3, y), (-0.3, y - 1.6))
        axes.text(-0.45, y - 0.8, f"${name}$", ha="right", va="center", fontsize=10.0)
        arrow(axes, (0.3, y - 1.6), (0.3, y), linestyle="--", color=MUTED)
        axes.text(0.45, y - 0.8, f"${name}^T$", ha="left", va="center", fontsize=10.0)
    arrow(axes, (1.6, 5.0), (1.6, 0.0), connectionstyle="arc3,rad=-0.28")
    axes.text(2.45, 2.5, "$T$", ha="left", va="center", fontsize=10.0)
    axes.text(0.0, -0.62, "dashed: forces, the other way", ha="center", va="top", fontsize=9.0)
    save(figure, "complement")


def footprint() -> None:
    """Draw an interval type-2 set."""
    figure, axes = panel()
    interval = _band(axes)
    note(axes, "upper", (0.9, float(interval.upper(0.9))), (1.15, 0.72))
    note(axes, "lower", (0.25, float(interval.lower(0.25))), (-1.95, 0.62))
    axes.axvline(SLICE, color=TEXT, linestyle=":", linewidth=1.2)
    axes.text(SLICE + 0.04, 1.07, "slice", fontsize=9)
    axes.set_title("Footprint of uncertainty")
    save(figure, "footprint")


def vertical_slices() -> None:
    """Draw the secondary grades of an interval and of a general type-2 set at one point."""
    figure, axes = panel()
    low, high = INTERVAL.footprint(SLICE)
    axes.plot([0.0, low, low, high, high, 1.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0], color=BLUE)
    axes.text((low + high) / 2, 1.04, "interval", ha="center", fontsize=9)
    u = np.linspace(0.0, 1.0, 400)
    axes.plot(
        u,
        fuzzy2.GaussianType2Set(fuzzy2.Gaussian(0.0, 0.6), 0.11).secondary_grade(SLICE, u),
        "--",
        color=VERMILLION,
    )
    note(axes, "Gaussian", (0.7, 0.7), (0.86, 0.85))
    axes.set(
        title=f"Vertical slice at {SLICE}",
        xlabel="membership u",
        ylabel="secondary grade",
        ylim=(0.0, 1.18),
        xlim=(-0.05, 1.15),
    )
    save(figure, "vertical_slices")


def centroid() -> None:
    """Draw the centroid of an interval type-2 set, and an embedded set that has one of its ends."""
    figure, axes = panel()
    interval = _band(axes)
    left, right = interval.centroid()
    x = np.linspace(-2.2, 2.2, 600)
    axes.plot(
        x, np.where(x < left, interval.upper(x), interval.lower(x)), color=VERMILLION, linewidth=2.2
    )
    note(axes, "embedded set of the left\nend: upper, then lower", (-0.55, 0.85), (-2.15, 1.05))
    axes.plot([left, right], [0.04, 0.04], color=TEXT, linewidth=5.0, solid_capstyle="butt")
    note(axes, f"centroid\n[{left:.2f}, {right:.2f}]", (right - 0.05, 0.05), (1.0, 0.6))
    axes.set(title="Centroid: an interval", ylim=(0.0, 1.3))
    save(figure, "centroid")


INTERVAL, SLICE = fuzzy2.GaussianUncertainMean(mean=(-0.3, 0.3), sigma=0.5), 0.6


def _band(axes: Axes) -> fuzzy2.GaussianUncertainMean:
    x = np.linspace(-2.2, 2.2, 600)
    lower, upper = INTERVAL.footprint(x).T
    axes.fill_between(x, lower, upper, color=BLUE, alpha=0.2, linewidth=0.0)
    axes.plot(x, upper, color=BLUE)
    axes.plot(x, lower, "--", color=BLUE)
    axes.set(xlabel="x", ylabel="membership u", ylim=(0.0, 1.18))
    return INTERVAL


def fuzzy_computed_torque() -> None:
    """Draw the block diagram of the controller of chapter 5."""
    figure, axes = diagram(4.3, 5.4, (-1.7, 5.2), (-0.75, 7.9))
    blue = {"edgecolor": BLUE, "linewidth": 2.2}
    box(axes, 0.0, 7.3, "trajectory", 2.8, 0.8)
    box(axes, 0.0, 5.6, "servo\n$\\ddot a_d + k_v \\dot e + k_p e$", 2.8, 1.1)
    box(axes, 0.0, 3.7, "torque, fuzzy\n$\\alpha\\,(\\cdot) + \\beta$", 2.8, 1.1, **blue)
    box(axes, 0.0, 1.9, "defuzzify", 2.8, 0.8)
    box(axes, 0.0, 0.0, "robot", 2.8, 0.9)
    for start, end, words in (
        (6.9, 6.15, ""),
        (5.05, 4.25, ""),
        (3.15, 2.3, ""),
        (1.5, 0.45, "$\\tau$"),
    ):
        arrow(axes, (0.0, start), (0.0, end))
        axes.text(0.15, (start + end) / 2, words, ha="left", va="center", fontsize=9.0)
    box(axes, 3.5, 3.7, "fuzzy estimator\n16 rules,\n18 outputs", 2.2, 1.4, **blue)
    arrow(axes, (2.4, 3.7), (1.4, 3.7))
    axes.text(2.0, 3.95, "$M, C, G$\nfuzzy", ha="center", va="bottom", fontsize=9.0)
    box(axes, 3.5, 1.6, "differences\n$\\Delta q, \\Delta\\dot q$", 2.2, 1.1)
    arrow(axes, (3.5, 2.15), (3.5, 3.0))
    arrow(axes, (3.5, 0.0), (3.5, 1.05))
    axes.plot([1.4, 5.0, 5.0], [0.0, 0.0, 5.6], color=TEXT, linewidth=1.2)
    arrow(axes, (5.0, 5.6), (1.4, 5.6))
    axes.text(3.2, 5.7, "$a, \\dot a$ measured", ha="center", va="bottom", fontsize=9.0)
    save(figure, "fuzzy_computed_torque")


FIGURES = (
    star,
    parasitic_motion,
    reach,
    loops,
    complement,
    footprint,
    vertical_slices,
    centroid,
    fuzzy_computed_torque,
)


def main() -> None:
    """Write every figure beside this file."""
    with style("light"):
        for draw in FIGURES:
            draw()


if __name__ == "__main__":
    main()

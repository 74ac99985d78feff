"""Figures 34 to 36 and 40: poles, releases, and tracking by control-law partitioning."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from psp3.plots.panels import Panels, given_panels, muted
from psp3.thesis.chapter_4 import Desired, PartitionedControl, simulate_tracking
from psp3.thesis.chapter_4_systems import (
    DampingCase,
    MassSpringDamper,
    critical_damping,
    cubic_spring,
)

# One spring and one mass with three dampers: Figures 34 to 36 differ only in the damping.
RELEASED = {
    DampingCase.OVERDAMPED: MassSpringDamper(mass=1.0, damping=10.0, stiffness=4.0),
    DampingCase.UNDERDAMPED: MassSpringDamper(mass=1.0, damping=1.0, stiffness=4.0),
    DampingCase.CRITICALLY_DAMPED: MassSpringDamper(mass=1.0, damping=4.0, stiffness=4.0),
}
SIGNS = {
    DampingCase.OVERDAMPED: ">",
    DampingCase.UNDERDAMPED: "<",
    DampingCase.CRITICALLY_DAMPED: "=",
}


def _draw_poles(axes: Axes, system: MassSpringDamper) -> None:
    first, second = system.poles
    axes.axhline(0.0, color=muted(), linewidth=0.8)
    axes.axvline(0.0, color=muted(), linewidth=0.8)
    axes.axvspan(0.0, 2.0, color=rcParams["grid.color"], alpha=0.6, linewidth=0.0, zorder=0)
    axes.text(
        1.0,
        -2.75,
        "unstable",
        color=muted(),
        ha="center",
        va="bottom",
        fontsize="small",
        rotation=90.0,
    )
    (poles,) = axes.plot(
        system.poles.real,
        system.poles.imag,
        linestyle="none",
        marker="x",
        markersize=9.0,
        markeredgewidth=2.2,
        label="poles",
    )
    labels: list[tuple[complex, str]]
    if first == second:
        # Two poles in one place look like one cross, so a ring marks the double pole.
        axes.plot(
            first.real,
            0.0,
            marker="o",
            markersize=16.0,
            markerfacecolor="none",
            markeredgecolor=poles.get_color(),
        )
        labels = [(first, f"$s_1 = s_2 = {first.real:.3g}$")]
    elif first.imag == 0.0:
        labels = [(first, f"$s_1 = {first.real:.3g}$"), (second, f"$s_2 = {second.real:.3g}$")]
    else:
        labels = [
            (pole, f"$s_{n} = {pole.real:.3g} {pole.imag:+.3g}\\,i$")
            for n, pole in ((1, first), (2, second))
        ]
    for pole, label in labels:
        # The label of a pole near the imaginary axis is on the left, so it does not reach into the
        # unstable half plane.
        beside = pole.real > -1.0
        offset = (-8.0 if beside else 0.0, 12.0)
        side = "right" if beside else "center"
        axes.annotate(
            label,
            (pole.real, pole.imag),
            xytext=offset,
            textcoords="offset points",
            ha=side,
            va="bottom",
        )
    axes.set(xlim=(-11.0, 2.0), ylim=(-3.0, 3.0), xlabel="Re s [1/s]", ylabel="Im s [1/s]")


def _figure_of_release(axes: Sequence[Axes] | None, case: DampingCase) -> Panels:
    panels = given_panels(axes, 2) or tuple(
        Figure(figsize=(9.0, 3.4), layout="constrained").subplots(1, 2)
    )
    poles, response = panels
    system = RELEASED[case]
    _draw_poles(poles, system)
    poles.set_title(f"{case.capitalize()}: b² {SIGNS[case]} 4mk")
    t = np.linspace(0.0, 10.0, 501)
    if case is DampingCase.CRITICALLY_DAMPED:
        for other, dashes in ((DampingCase.OVERDAMPED, "--"), (DampingCase.UNDERDAMPED, ":")):
            response.plot(
                t,
                RELEASED[other].response(t, -1.0, 0.0).position,
                color=muted(),
                linestyle=dashes,
                linewidth=1.0,
                label=str(other),
            )
    (line,) = response.plot(t, system.response(t, -1.0, 0.0).position, label=str(case))
    response.plot(0.0, -1.0, marker="o", markersize=5.0, color=line.get_color())
    if case is DampingCase.UNDERDAMPED:
        # Amplitude of a release at rest: x0 sqrt(1 + (σ/ω)²).
        decay, frequency = -system.poles[1].real, system.poles[1].imag
        envelope = math.hypot(1.0, decay / frequency) * np.exp(-decay * t)
        for sign, label in ((1.0, "envelope"), (-1.0, None)):
            response.plot(
                t, sign * envelope, color=muted(), linestyle="--", linewidth=1.0, label=label
            )
    response.axhline(0.0, color=muted(), linewidth=0.8)
    response.set(
        xlim=(-0.2, 10.0), ylim=(-1.15, 1.15), xlabel="time t [s]", ylabel="position x [m]"
    )
    response.set_title(
        f"m = {system.mass:g} kg, b = {system.damping:g} N s/m, k = {system.stiffness:g} N/m"
    )
    response.legend(loc="upper right")
    return panels


def figure_34(axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the poles and the response of an overdamped system (Fig. 34).

    It is a mass-spring-damper released at x = −1 m, eq. 4.3 to 4.5.

    Parameters
    ----------
    axes : sequence of 2 Axes, optional
        For the poles and for the response; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        Poles [1/s] and response [m] over time [s].

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    return _figure_of_release(axes, DampingCase.OVERDAMPED)


def figure_35(axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the poles and the response of an underdamped system (Fig. 35).

    It is a mass-spring-damper released at x = −1 m, eq. 4.3 to 4.5.

    Parameters
    ----------
    axes : sequence of 2 Axes, optional
        For the poles and for the response; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        Poles [1/s] and response [m] over time [s].

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    return _figure_of_release(axes, DampingCase.UNDERDAMPED)


def figure_36(axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the poles and the response of a critically damped system (Fig. 36).

    It is a mass-spring-damper released at x = −1 m, eq. 4.3 to 4.5.

    The responses of Figures 34 and 35 are drawn beside it for comparison.

    Parameters
    ----------
    axes : sequence of 2 Axes, optional
        For the poles and for the response; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        Poles [1/s] and response [m] over time [s].

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    return _figure_of_release(axes, DampingCase.CRITICALLY_DAMPED)


class _Diagram:
    """A block diagram in axes without ticks and with equal scales."""

    def __init__(self, axes: Axes, width: float, height: float) -> None:
        self.axes, self.text = axes, str(rcParams["text.color"])
        axes.set(xlim=(0.0, width), ylim=(0.0, height), aspect="equal")
        axes.set_axis_off()

    def part(self, left: float, right: float, bottom: float, top: float, label: str) -> None:
        """Shade a part of the diagram and write its name over it."""
        size = {"width": right - left, "height": top - bottom}
        shade = FancyBboxPatch(
            (left, bottom),
            **size,
            boxstyle="round,pad=0,rounding_size=0.25",
            facecolor=rcParams["grid.color"],
            alpha=0.45,
        )
        shade.set(linewidth=0.0, zorder=0)
        self.axes.add_patch(shade)
        self.axes.text(
            (left + right) / 2.0,
            top + 0.15,
            label,
            ha="center",
            va="bottom",
            fontsize="small",
            color=muted(),
        )

    def block(self, x: float, y: float, width: float, label: str) -> None:
        """Draw a block with its center at (x, y)."""
        outline = FancyBboxPatch(
            (x - width / 2.0, y - 0.45),
            width,
            0.9,
            boxstyle="round,pad=0,rounding_size=0.12",
            linewidth=1.2,
        )
        outline.set(facecolor=rcParams["axes.facecolor"], edgecolor=self.text)
        self.axes.add_patch(outline)
        self.axes.text(x, y, label, ha="center", va="center")

    def sum(self, x: float, y: float) -> None:
        """Draw a summing point."""
        self.axes.add_patch(
            Circle(
                (x, y),
                0.28,
                facecolor=rcParams["axes.facecolor"],
                edgecolor=self.text,
                linewidth=1.2,
                zorder=2,
            )
        )
        self.axes.text(x, y, "+", ha="center", va="center_baseline", fontsize="small")

    def signal(self, *points: tuple[float, float], label: str = "", arrow: bool = True) -> None:
        """Draw a signal along the points; the label stands over the middle of its first leg."""
        xs, ys = zip(*points, strict=True)
        self.axes.plot(xs, ys, color=self.text, linewidth=1.2, solid_joinstyle="miter", zorder=1)
        if arrow:
            head = {
                "arrowstyle": "-|>",
                "color": self.text,
                "linewidth": 1.2,
                "shrinkA": 0.0,
                "shrinkB": 0.0,
            }
            self.axes.annotate("", points[-1], points[-2], arrowprops=head, zorder=1)
        if label:
            self.axes.text((xs[0] + xs[1]) / 2.0, ys[0] + 0.12, label, ha="center", va="bottom")

    def branch(self, x: float, y: float) -> None:
        """Mark the place where a signal branches."""
        self.axes.plot(x, y, marker="o", markersize=4.0, color=self.text)


def _draw_partitioned_controller(axes: Axes) -> None:
    diagram = _Diagram(axes, 20.0, 6.0)
    diagram.part(1.0, 6.4, 0.75, 5.1, "servo (eq. 4.16)")
    diagram.part(7.2, 11.9, 0.75, 5.1, "model (eq. 4.10)")
    diagram.part(12.9, 18.0, 3.3, 5.1, "system (eq. 4.9)")
    state = r"$x,\ \dot x$"
    # The desired motion enters on the left; each error has a sum, a gain, and a sum on the way to
    # f'.
    for y, desired, gain in ((2.85, r"$\dot x_d$", "$k_v$"), (1.5, "$x_d$", "$k_p$")):
        column = 1.7 if y > 2.0 else 2.5
        diagram.signal((0.0, y), (column - 0.28, y))
        axes.text(0.35, y + 0.12, desired, ha="center", va="bottom")
        diagram.sum(column, y)
        diagram.signal((column + 0.28, y), (3.7, y))
        axes.text(3.25, y + 0.1, r"$\dot e$" if y > 2.0 else "$e$", ha="center", va="bottom")
        diagram.block(4.25, y, 1.1, gain)
        diagram.signal((column, 0.3), (column, y - 0.28))
        axes.text(
            column + 0.16, y - 0.42, "\N{MINUS SIGN}", ha="left", va="center", fontsize="small"
        )
    diagram.signal((4.8, 1.5), (5.7, 1.5), (5.7, 2.57))
    diagram.signal((4.8, 2.85), (5.42, 2.85))
    diagram.sum(5.7, 2.85)
    diagram.signal((5.7, 3.13), (5.7, 3.92))
    diagram.signal((0.0, 4.2), (5.42, 4.2))
    axes.text(0.35, 4.32, r"$\ddot x_d$", ha="center", va="bottom")
    diagram.sum(5.7, 4.2)
    diagram.signal((5.98, 4.2), (7.6, 4.2), label=r"$f^{\,\prime}$")
    diagram.block(8.4, 4.2, 1.6, r"$\alpha(x)$")
    diagram.signal((9.2, 4.2), (10.57, 4.2))
    diagram.sum(10.85, 4.2)
    diagram.signal((11.13, 4.2), (13.2, 4.2), label="$F$")
    diagram.block(15.45, 4.2, 4.5, r"$m(x)\,\ddot x + f(x, \dot x) = F$")
    diagram.signal((17.7, 4.2), (20.0, 4.2))
    axes.text(19.3, 4.32, state, ha="center", va="bottom")
    diagram.block(10.85, 2.2, 1.7, r"$\beta(x, \dot x)$")
    diagram.signal((10.85, 2.65), (10.85, 3.92))
    # The state returns along the bottom.
    diagram.signal((18.6, 4.2), (18.6, 0.3), (1.7, 0.3), arrow=False)
    diagram.signal((10.85, 0.3), (10.85, 1.75))
    diagram.signal((8.4, 0.3), (8.4, 3.75))
    axes.text(14.7, 0.42, state, ha="center", va="bottom")
    for x, y in ((18.6, 4.2), (10.85, 0.3), (8.4, 0.3), (2.5, 0.3)):
        diagram.branch(x, y)


def figure_40(axes: Sequence[Axes] | None = None) -> Panels:
    r"""Draw the trajectory-tracking controller based on partitioning (Fig. 40).

    It also draws the controller's effect on two systems, eq. 4.9 to 4.18.

    A mass-spring-damper and a mass on a cubic spring start at rest in x = −1 m and follow a sine
    under the same servo gains. The forces differ, the errors do not: both are the closed form of
    :math:`\ddot e + k_v \dot e + k_p e = 0`, eq. 4.18.

    Parameters
    ----------
    axes : sequence of 7 Axes, optional
        For the diagram, and for position, error and force of the first system, then of the second;
        those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The diagram; position [m], error [m] and force [N] over time [s] of each system.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    panels = given_panels(axes, 7)
    if panels is None:
        figure = Figure(figsize=(9.0, 9.6), layout="constrained")
        mosaic = figure.subplot_mosaic("DD;ax;by;cz", height_ratios=[1.35, 1.0, 1.0, 1.0])
        panels = tuple(mosaic[name] for name in "Dabcxyz")
    _draw_partitioned_controller(panels[0])
    panels[0].set_title("Trajectory tracking by control-law partitioning")
    frequency, kp = math.pi / 2.0, 16.0
    kv = critical_damping(kp)

    def desired(t: float) -> Desired:
        return Desired(
            math.sin(frequency * t),
            frequency * math.cos(frequency * t),
            -(frequency**2) * math.sin(frequency * t),
        )

    systems = (
        (
            r"Mass-spring-damper, $f = b\,\dot x + k\,x$",
            MassSpringDamper(mass=1.0, damping=1.0, stiffness=20.0).system(),
        ),
        (
            r"Cubic spring, $f = b\,\dot x + k\,x^3$",
            cubic_spring(mass=1.0, damping=1.0, stiffness=20.0),
        ),
    )
    t = np.linspace(0.0, 6.0, 601)
    for (name, system), (position, error, force) in zip(
        systems, (panels[1:4], panels[4:7]), strict=True
    ):
        control = PartitionedControl.of(system, kp, kv)
        tracking = simulate_tracking(system, control, desired, t, position=-1.0, speed=0.0)
        expected = control.error_dynamics.response(
            t, tracking.error[0], tracking.error_speed[0]
        ).position
        position.plot(
            t, tracking.desired_position, color=muted(), linestyle="--", label="desired, $x_d$"
        )
        position.plot(t, tracking.position, label="x")
        position.set(ylabel="position [m]", ylim=(-1.2, 1.9))
        position.set_title(name)
        error.plot(t, tracking.error, label="simulated")
        error.plot(
            t[::20],
            expected[::20],
            linestyle="none",
            marker="o",
            markersize=4.0,
            markerfacecolor="none",
            label="eq. 4.18",
        )
        error.set(ylabel="error e [m]")
        force.plot(t, tracking.force, label="F")
        force.set(ylabel="force F [N]", xlabel="time t [s]", ylim=(-25.0, 25.0))
        for panel in (position, error):
            panel.legend(loc="upper right", ncols=2)
        for panel in (position, error, force):
            panel.axhline(0.0, color=muted(), linewidth=0.8)
            panel.set_xlim(0.0, 6.0)
    return panels

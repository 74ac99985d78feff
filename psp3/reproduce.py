"""The main job: run the thesis's comparison on the robot and set every number beside the printed one.

Everything is computed, nothing is copied: PD and CTC track a helix (Table 6.3, Figures 52 and 53), the dynamics of Table 5.1
is evaluated at its three configurations, and the three implementations of the dynamics are compared along the helix.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from psp3 import published
from psp3.arrays import Array
from psp3.controllers import PD, PID, ComputedTorque, Controller, GravityCompensatedPD
from psp3.loading import load
from psp3.metrics import THESIS_SAMPLING_PERIOD, integral_of_squared_error, largest_tip_error, rms_error, sum_of_squared_errors
from psp3.parameters import PARAMETER_SETS
from psp3.robot import PSP3
from psp3.simulation import Result, simulate
from psp3.trajectories import Helix

DURATION = 10.4
"""Length of the run [s]; the printed PD row, which is 4.48 · (T − 0.106 s)/10 s of sag, asks for this."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Table:
    """A table to show: title, column headings, rows of text, and a note in words."""

    title: str
    columns: list[str]
    rows: list[list[str]]
    note: str = ""


@dataclass
class Reproduction:
    """What :func:`reproduce` found: tables and verdicts, the simulations, numbers for a machine, and the files it wrote."""

    tables: list[Table] = field(default_factory=list)
    answer: list[str] = field(default_factory=list)
    results: dict[str, Result] = field(default_factory=dict)
    numbers: dict[str, Any] = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)


def reproduce(out: str | Path, quick: bool = False, progress: Progress | None = None) -> Reproduction:
    """Run the main job and write its figures, report, numbers and animation.

    Parameters
    ----------
    out : path
        Directory to write to; made if it does not exist.
    quick : bool
        Leave out the animation, and compare the three implementations at fewer poses.
    progress : callable, optional
        Called with a description, the number of steps done and the number of steps.

    Returns
    -------
    Reproduction
        Tables, results, numbers and the paths of ``report.html``, ``results.json``, the figures and ``animation.html``.

    Raises
    ------
    OSError
        If the directory cannot be written to; before anything is computed.
    """
    directory = Path(out)
    (directory / "figures").mkdir(parents=True, exist_ok=True)
    probe = directory / ".write-test"
    probe.write_text("")
    probe.unlink()

    steps: list[tuple[str, Callable[[], None]]] = []
    outcome = Reproduction()
    robot = load("psp3")
    steps.append(("simulating PD, CTC and two other controllers", lambda: _track(robot, outcome)))
    steps.append(("recomputing Tables 5.1 and 5.2", lambda: _tables_5(outcome)))
    steps.append(("comparing three implementations of the dynamics", lambda: _cross_check(robot, outcome, 11 if quick else 105)))
    steps.append(("drawing Figures 52 and 53", lambda: _figures(outcome, directory / "figures")))
    if not quick:
        steps.append(("recording the animation", lambda: _animation(robot, outcome, directory)))
    steps.append(("writing the report", lambda: _write(outcome, directory)))
    for done, (description, step) in enumerate(steps):
        if progress is not None:
            progress(description, done, len(steps))
        step()
    if progress is not None:
        progress("done", len(steps), len(steps))
    return outcome


def _verdict(computed: float, printed: float) -> str:
    """Say in words how a number compares with the printed one."""
    ratio = computed / printed
    if abs(ratio - 1.0) <= 0.05:
        return f"reproduced ({100 * (ratio - 1):+.1f} %)"
    if 1.0 / 3.0 <= ratio <= 3.0:
        return f"same order (× {ratio:.2f})"
    return f"not reproduced (× {ratio:.2g})"


def _track(robot: PSP3, outcome: Reproduction) -> None:
    helix = Helix(robot=robot)
    controllers: dict[str, Controller] = {
        "PD": PD(*published.TABLE_6_1["PD"]),
        "CTC": ComputedTorque(robot, *published.TABLE_6_1["CTC"]),
        "PD with gravity": GravityCompensatedPD(robot),
        "PID": PID(),
    }
    rows = []
    numbers: dict[str, dict[str, float | None]] = {}
    for name, controller in controllers.items():
        result = simulate(robot, controller, helix, DURATION)
        outcome.results[name] = result
        squares = sum_of_squared_errors(result)
        printed = published.TABLE_6_3.get(name)
        metrics = {
            "sum_of_squared_errors": squares,
            "integral_of_squared_error": integral_of_squared_error(result),
            "rms_error": rms_error(result),
            "largest_tip_error": largest_tip_error(result),
            "largest_torque": float(np.abs(result.torque).max()),
        }
        numbers[name] = {**metrics, "printed_sum_of_squared_errors": printed}
        rows.append(
            [
                name,
                "–" if printed is None else f"{printed:.4f}",
                f"{squares:.4f}",
                f"{metrics['integral_of_squared_error']:.5f}",
                f"{1e3 * metrics['rms_error']:.2f}",
                f"{1e3 * metrics['largest_tip_error']:.2f}",
                "not in the thesis" if printed is None else _verdict(squares, printed),
            ]
        )
    sag = robot.gravity(np.zeros(3)).mean() / published.TABLE_6_1["PD"][0]
    outcome.tables.append(
        Table(
            "Table 6.3: tracking error, classical controllers",
            ["controller", "printed SSE [m²]", "SSE [m²]", "∫‖e‖²dt [m² s]", "RMS ‖e‖ [mm]", "largest tip error [mm]", "verdict"],
            rows,
            f"Helix of radius 20 mm, period 2 s, rise 10 mm/s, started at rest, {DURATION} s, control at 2 ms. SSE sums one sample every "
            f"{THESIS_SAMPLING_PERIOD} s. The thesis names neither its helix nor its sampling, so orders of magnitude and ranking are "
            f"what can be compared. PD has no gravity term: every screw sags by G/kp = {1e3 * sag:.1f} mm, and that sag is the whole of "
            "its row. The CTC row is the start from rest; started on the path CTC has no error at all.",
        )
    )
    outcome.numbers["table_6_3"] = numbers
    pd, ctc = (sum_of_squared_errors(outcome.results[name]) for name in ("PD", "CTC"))
    outcome.answer.append(
        f"PD leaves {pd:.2f} m² and CTC {ctc:.4f} m² of summed squared error (printed: {published.TABLE_6_3['PD']} and "
        f"{published.TABLE_6_3['CTC']}): the ranking of Table 6.3 holds, and PD's row is its sag of {1e3 * sag:.0f} mm under gravity."
    )


def _compared(label: str, printed: Array, computed: Array, bar: float | None) -> list[list[str]]:
    """Rows of a matrix as printed and as computed; within ``bar`` they count as reproduced."""
    rows = []
    for number, (old, new) in enumerate(zip(np.atleast_2d(printed), np.atleast_2d(computed), strict=True), start=1):
        gap = float(np.abs(old - new).max())
        verdict = "not reproducible" if bar is None else f"{'reproduced' if gap <= bar else 'not reproduced'}, to {gap:.4f}"
        rows.append([label.format(number), *("  ".join(f"{value: .4f}" for value in values) for values in (old, new)), verdict])
    return rows


def _tables_5(outcome: Reproduction) -> None:
    robot = load("psp3", parameters="table_5_1")
    symmetric = load("psp3", parameters="default")
    heights, speeds = published.TABLE_5_1_HEIGHTS[1], published.TABLE_5_1_SPEEDS[1]
    M, C, G = robot.equation_of_motion(heights, speeds)
    mass_error = float(np.abs(M - published.TABLE_5_1_MASS).max())
    gravity_error = float(np.abs(G - published.TABLE_5_1_GRAVITY).max())
    default_error = float(np.abs(symmetric.mass_matrix(heights) - published.TABLE_5_1_MASS).max())
    # What no Coriolis matrix can escape: its column sums are the rate of the column sums of M.
    step = 1e-6
    rate = (robot.mass_matrix(heights + step * speeds) - robot.mass_matrix(heights - step * speeds)).sum(axis=0) / (2.0 * step)
    printed_columns = published.TABLE_5_1_CORIOLIS.sum(axis=0) - np.array([10.0, 0.0, 0.0]) + np.array([0.009, 0.0, 0.0])
    column_gap = float(np.abs(printed_columns - rate).max())
    rows = [
        *_compared("M row {} [kg]", published.TABLE_5_1_MASS, M, bar=0.0071),
        *_compared("G [N]", published.TABLE_5_1_GRAVITY, G, bar=0.02),
        *_compared("C row {} [kg/s]", published.TABLE_5_1_CORIOLIS, C, bar=None),
    ]
    outcome.tables.append(
        Table(
            "Table 5.1: dynamics at configuration 2, heights (0.15, 0.25, 0.15) m",
            ["", "printed", "computed", "verdict"],
            rows,
            "Parameter set table_5_1. The printed M and G are those of configuration 2 as printed, with the star inertia of Table 3.1 "
            "divided by ten and its large moment about an axis in the star's plane. A star with three equal arms cannot have that "
            f"inertia: with the symmetric star of the default parameters M differs by {default_error:.2f} kg. Printed C cannot be "
            "reproduced under any convention that was tried: C11 = 10.0159 is a misprint for 0.0159 and C31 = 0.0346 for 0.0436 "
            f"(then its rows sum to zero, as they must), and even so its column sums miss the rate of those of M by {column_gap:.3f} kg/s.",
        )
    )
    outcome.numbers["table_5_1"] = {
        "M": M.tolist(), "C": C.tolist(), "G": G.tolist(),
        "largest_mass_error": mass_error, "largest_gravity_error": gravity_error,
        "largest_mass_error_of_default_parameters": default_error, "printed_coriolis_column_sum_gap": column_gap,
    }  # fmt: skip

    a, v = published.TABLE_5_1_HEIGHTS, published.TABLE_5_1_SPEEDS
    differences = {
        "Δq12": a[:, 0] - a[:, 1], "Δq̇12": v[:, 0] - v[:, 1], "Δq13": a[:, 0] - a[:, 2],
        "Δq̇13": v[:, 0] - v[:, 2], "Δq23": a[:, 1] - a[:, 2], "Δq̇23": v[:, 1] - v[:, 2],
    }  # fmt: skip
    rows = []
    for name, values in differences.items():
        agree = np.isclose(values, published.TABLE_5_2[name], atol=1e-9)
        verdict = "reproduced" if agree.all() else f"contradicts configurations {' and '.join(str(i + 1) for i in np.flatnonzero(~agree))}"
        rows.append([name, f"{published.TABLE_5_2[name]: .2f}", "  ".join(f"{value: .2f}" for value in values), verdict])
    lifted = np.array([symmetric.mass_matrix(a[0] + shift) for shift in (-0.05, 0.05)])
    change = float(np.abs(lifted - symmetric.mass_matrix(a[0])).max())
    outcome.tables.append(
        Table(
            "Table 5.2: differences of heights [m] and speeds [m/s] in configurations 1, 2, 3",
            ["difference", "printed", "from Table 5.1", "verdict"],
            rows,
            "The third heights printed in configurations 2 and 3 contradict this table. What both tables are meant to show holds: "
            f"lifting all three nuts together changes M by {change:.1e} kg, so four differences are enough.",
        )
    )
    outcome.numbers["table_5_2"] = {name: values.tolist() for name, values in differences.items()}
    outcome.answer.append(
        f"Table 5.1 is reproduced in M (to {mass_error:.4f} kg) and G (to {gravity_error:.3f} N), not in C, whose printed values "
        "contradict the printed M."
    )


def _cross_check(robot: PSP3, outcome: Reproduction, samples: int) -> None:
    motion = Helix(robot=robot)(np.linspace(0.0, DURATION, samples))
    M, C, G = robot.equation_of_motion(motion.heights, motion.speeds)
    forces = np.einsum("nij,nj->ni", M, motion.accelerations) + np.einsum("nij,nj->ni", C, motion.speeds) + G
    rows, numbers = [], {}
    for name, title in (("pinocchio", "Pinocchio: RNEA and CRBA of the tree, projected"), ("noc", "natural orthogonal complement")):
        mass, coriolis, gravity = robot.dynamics(name).equation_of_motion(motion.heights, motion.speeds)
        other = np.einsum("nij,nj->ni", mass, motion.accelerations) + np.einsum("nij,nj->ni", coriolis, motion.speeds) + gravity
        gaps = [float(np.abs(x - y).max() / np.abs(x).max()) for x, y in ((M, mass), (C, coriolis), (G, gravity), (forces, other))]
        numbers[name] = dict(zip(("M", "C", "G", "forces"), gaps, strict=True))
        rows.append([title, *(f"{gap:.1e}" for gap in gaps)])
    outcome.tables.append(
        Table(
            "Closed form against two independent implementations, along the helix",
            ["implementation", "M", "C", "G", "forces"],
            rows,
            f"Largest difference over {samples} poses, relative to the largest entry.",
        )
    )
    outcome.numbers["cross_check"] = numbers
    worst = max(gap for gaps in numbers.values() for gap in gaps.values())
    outcome.answer.append(f"Closed form, Pinocchio and the thesis's natural orthogonal complement agree to {worst:.0e}.")


def _figures(outcome: Reproduction, directory: Path) -> None:
    from fuzzy2.style import style
    from psp3.plots import figure_52, figure_53

    with style():
        for name, draw, key in (("figure_52", figure_52, "PD"), ("figure_53", figure_53, "CTC")):
            path = directory / f"{name}.svg"
            figure = draw(outcome.results[key])[0].get_figure(root=True)
            assert figure is not None
            figure.savefig(path)
            outcome.files.append(path)


def _animation(robot: PSP3, outcome: Reproduction, directory: Path) -> None:
    from psp3.visualize import write_animation

    path = directory / "animation.html"
    write_animation(robot, {name: outcome.results[name] for name in ("PD", "CTC")}, path)
    outcome.files.append(path)


def _write(outcome: Reproduction, directory: Path) -> None:
    from psp3.report import write_report

    for name in ("PD", "CTC"):
        outcome.files.append(outcome.results[name].save(directory / f"{name.lower()}.npz"))
    outcome.numbers["parameters"] = {name: parameters.as_dict() for name, parameters in PARAMETER_SETS.items()}
    outcome.numbers["versions"] = {"python": platform.python_version()} | {
        name: version(name) for name in ("psp3", "pin", "numpy", "numba")
    }
    path = directory / "results.json"
    path.write_text(json.dumps(outcome.numbers, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    outcome.files.append(path)
    outcome.files.append(write_report(outcome, directory / "report.html"))

"""The main job of the package.

It runs the thesis's comparison on the robot and puts every number beside the printed one.

Everything is computed: the tables of chapters 5 and 6, Figures 49 and 51 to 64, and comparisons
that the thesis never showed. The runs behind them are one study, kept in a file, so a job that was
stopped resumes there.
"""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryFile

from fuzzy2.support.plain_data import plain
from fuzzy2.support.text_files import made_folder, write_text
from psp3.checks import MOST_SEEDS, checked_count
from psp3.fuzzy_control.records import record
from psp3.loading import load
from psp3.published import DURATION, THESIS_SAMPLING_PERIOD
from psp3.study import latency, study
from psp3.study.execution import simulate_run
from psp3.study.intervals import MEASURED_COVERAGE, MEASURED_COVERAGE_OF_TEN
from psp3.study.run import Run
from psp3.thesis import beyond, chapter_5, chapter_6, definitions, figure_64, opening
from psp3.thesis.findings import Reproduction
from psp3.thesis.plan import NOISY, Outcomes, Plan, Series, decibels
from psp3.three_psp.parameters import PARAMETER_SETS
from psp3.trajectories.paths import Helix

SEEDS = 30
"""Default number of seeds of Table 6.3."""

SIDE_BY_SIDE = ("type-1, 20 dB", "type-2, 20 dB")
"""Results that the animation shows."""

SLOW_STEPS, STEPS = 1000, 5000
"""Number of timed control steps, for controllers that take milliseconds and for the others."""

Progress = Callable[[str, int, int], None]


def reproduce(
    out: str | Path,
    quick: bool = False,
    progress: Progress | None = None,
    *,
    seeds: int = SEEDS,
    run_progress: study.Progress | None = None,
) -> Reproduction:
    """Run the main job and write its figures, report, numbers and animation.

    Parameters
    ----------
    out : path
        Directory to write to; made if it does not exist. Runs that its ``study.sqlite`` already
        holds are not repeated.
    quick : bool
        Leave out the animation, and use two seeds and a few values of everything. This checks in
        seconds that everything works.
    progress : callable, optional
        Called with a description, the number of steps done and the number of steps.
    seeds : int
        Seeds of Table 6.3 and of the comparison of learners; other comparisons take ten at most.
    run_progress : callable, optional
        Called with the number of runs in the file, the number of all runs, and the rate since the
        start [1/s].

    Returns
    -------
    Reproduction
        Tables, results, numbers and the paths of ``report.html``, ``results.json``, the figures,
        the study and ``animation.html``.

    Raises
    ------
    InvalidValue
        If ``seeds`` is not a whole number from 1 to a million.
    fuzzy2.errors.FileNotWritten
        If the directory cannot be written to; before anything is computed.
    InvalidStudyFile, StudyMismatch, StudyInUse
        If ``study.sqlite`` there is of another version, damaged or in use; before anything is
        computed.
    StudyInterrupted
        After Ctrl-C; what was done is kept.
    """
    checked_count("seeds", seeds, 1, MOST_SEEDS)
    directory = Path(out)
    made_folder(directory / "figures")
    # The probe file leaves nothing behind and cannot overwrite a file of the user.
    TemporaryFile(dir=directory).close()

    plan = Plan.of(seeds, quick)
    runs = study.Study(directory / "study.sqlite", plan.runs())
    outcome, curves = Reproduction(), dict[str, Series]()
    steps: list[tuple[str, Callable[[], None]]] = [
        ("running the study", lambda: _run_study(runs, outcome, quick, run_progress)),
        ("simulating the controllers that are drawn", lambda: _simulate(runs, plan, outcome)),
        (
            "recomputing Tables 6.1 and 6.3, and what the thesis never showed",
            lambda: curves.update(_chapter_6(runs, plan, outcome)),
        ),
        ("timing control steps for Table 6.2", lambda: _table_6_2(outcome, quick)),
        ("recomputing Tables 5.1 and 5.2", lambda: _chapter_5(outcome, 11 if quick else 105)),
        ("drawing the figures", lambda: _figures(outcome, curves, plan, directory / "figures")),
    ]
    if not quick:
        steps.append(("recording the animation", lambda: _animation(outcome, directory)))
    steps.append(("writing the report", lambda: _write(outcome, plan, directory)))
    for done, (description, step) in enumerate(steps):
        if progress is not None:
            progress(description, done, len(steps))
        step()
    if progress is not None:
        progress("done", len(steps), len(steps))
    return outcome


def _run_study(
    runs: study.Study, outcome: Reproduction, quick: bool, run_progress: study.Progress | None
) -> None:
    if quick:
        outcome.answer.append(
            "This was a quick look: two seeds and few values, which show that all works and no "
            "more."
        )
    runs.run(progress=run_progress)
    outcome.files.append(runs.path)


def _simulate(runs: study.Study, plan: Plan, outcome: Reproduction) -> None:
    seed = outcome.numbers["drawn_seed"] = chapter_6.typical_seed(Outcomes(runs.rows()), plan)
    drawn = {"PD": Run("pd"), "CTC": Run("ctc"), "PD with gravity": Run("pd-gravity")}
    for kind, label in (("t1", "type-1"), ("it2", "type-2")):
        drawn |= {
            f"{label}, {decibels(snr)} dB": Run(kind, snr_db=snr, seed=seed)
            for snr in (math.inf, *NOISY)
        }
    for name, run in drawn.items():
        outcome.results[name] = simulate_run(run).result


def _chapter_6(runs: study.Study, plan: Plan, outcome: Reproduction) -> dict[str, Series]:
    robot, results = load("psp3"), Outcomes(runs.rows())
    definitions.definitions(robot, results, plan, outcome)
    chapter_6.table_6_3(robot, results, plan, outcome)
    figure_64.type_2_against_type_1(results, plan, outcome)
    beyond.averaging(results, plan, outcome)
    beyond.learners(results, plan, outcome)
    beyond.breaking_noise(results, plan, outcome)
    beyond.readings(results, plan, outcome)
    chapter_6.answer_of_table_6_3(robot, results, plan, outcome)
    variations = beyond.mean_variations(results, plan, outcome)
    beyond.numbers_of_terms(results, plan, outcome)
    beyond.other_trajectories(results, plan, outcome)
    chapter_6.table_6_1(robot, outcome)
    return {
        "result": opening.errors_of_result(results, plan),
        "figure_64": figure_64.ratios_of_figure_64(results, plan),
        "mean_variation": variations,
    }


def _table_6_2(outcome: Reproduction, quick: bool) -> None:
    robot = load("psp3")
    helix = Helix(robot=robot)
    recorded = record(robot, helix)
    desired = helix(recorded.t)
    controllers = latency.controllers_of_table_6_2(robot, recorded)
    times: dict[str, latency.Latency] = {}
    for name, controller in controllers.items():
        steps = SLOW_STEPS if name in ("CTC, noc", "CTC, pinocchio") else STEPS
        times |= latency.measure_latencies(
            {name: controller}, recorded, desired, 100 if quick else steps
        )
    chapter_6.table_6_2(times, outcome)


def _chapter_5(outcome: Reproduction, poses: int) -> None:
    robot = load("psp3")
    chapter_5.tables_5_1_and_5_2(outcome)
    chapter_5.three_implementations(robot, outcome, poses)
    chapter_5.estimates(robot, record(robot, Helix(robot=robot)), outcome)


def _figures(outcome: Reproduction, curves: dict[str, Series], plan: Plan, directory: Path) -> None:
    from fuzzy2.plots.style import style
    from psp3.thesis.illustrations import draw_all

    with style():
        for drawing in draw_all(
            load("psp3"), outcome.results, outcome.numbers["drawn_seed"], curves, plan, directory
        ):
            outcome.drawings.append(drawing)
            outcome.files.append(drawing.path)


def _animation(outcome: Reproduction, directory: Path) -> None:
    from psp3.visualize.scene import write_animation

    path = directory / "animation.html"
    write_animation(load("psp3"), {name: outcome.results[name] for name in SIDE_BY_SIDE}, path)
    outcome.files.append(path)


def _write(outcome: Reproduction, plan: Plan, directory: Path) -> None:
    from psp3.thesis.report import write_report

    opening.opening(plan, outcome)
    for name in ("PD", "CTC"):
        outcome.files.append(outcome.results[name].save(directory / f"{name.lower()}.npz"))
    outcome.numbers["sentence"] = outcome.sentence
    outcome.numbers["answer"] = outcome.answer
    outcome.numbers["seeds"] = {"table_6_3": plan.seeds, "sweeps": plan.sweep_seeds}
    helix = Helix()
    outcome.numbers["settings"] = {
        "radius": helix.radius,
        "turn": helix.period,
        "rise": helix.rise,
        "duration": DURATION,
        "control_period": Run("pd").period,
        "sampling_period": THESIS_SAMPLING_PERIOD,
        "levels": plan.sweep_levels,
        "widths": plan.widths,
        "suited": plan.suited,
    }
    outcome.numbers["parameters"] = {
        name: parameters.as_dict() for name, parameters in PARAMETER_SETS.items()
    }
    outcome.numbers["versions"] = {"python": platform.python_version()} | {
        name: version(name) for name in ("psp3", "pin", "numpy", "numba")
    }
    outcome.numbers["measured_coverage"] = {
        "30 seeds": dict(MEASURED_COVERAGE),
        "10 seeds": dict(MEASURED_COVERAGE_OF_TEN),
    }
    path = directory / "results.json"
    write_text(
        json.dumps(plain(outcome.numbers), indent=2, ensure_ascii=False, allow_nan=False) + "\n",
        path,
    )
    outcome.files.append(path)
    outcome.files.append(write_report(outcome, directory / "report.html"))

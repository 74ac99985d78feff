"""The command that runs many simulations and compares them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from psp3.cli.option_groups import single_options
from psp3.cli.options import OUTPUT, PLANT, RUNS, SAMPLED, file_path, table_output, usage_error
from psp3.cli.output import cell_text, counted_progress, say, show_narrow
from psp3.cli.shared import refuse_workers_of_scheduler, resumable

if TYPE_CHECKING:
    from psp3.study.run import Run, Value
    from psp3.study.table import Table


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """The runs of a study."""

    controller: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help=(
                "Controller: feed-forward, pd, pd-gravity, ctc, ctc-integral, lqr, lqr-stiff, t1, "
                "it2, gt2, adaptive-t1 or adaptive-it2, or your own as MODULE:NAME; default pd, "
                "ctc, t1 and it2."
            ),
        ),
    ] = None
    reading: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="What is noisy: parameters (default), measurement, online, plant or inputs.",
        ),
    ] = None
    snr_reference: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="Reference of the signal-to-noise ratio: mean-square (default), variance or unit.",
        ),
    ] = None
    noisy_entries: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="Which of M, C and G are noisy: all (default), gravity or mass-coriolis.",
        ),
    ] = None
    snr: Annotated[
        list[float] | None,
        typer.Option(
            metavar="DB",
            rich_help_panel=RUNS,
            help="Signal-to-noise ratio (dB); default inf, 20, 15 and 10.",
        ),
    ] = None
    seeds: Annotated[
        int,
        typer.Option(
            min=1, metavar="COUNT", rich_help_panel=RUNS, help="Number of seeds, counted from 0."
        ),
    ] = 30
    trajectory: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="Path: helix (default; rules are learned on it), circle, line, fast-helix, "
            "fastest-helix, large-helix or waypoints; for robots other than the 3-PSP sway "
            "(default), fast-sway, small-sway or hold.",
        ),
    ] = None
    learner: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="How t1, it2 and gt2 learn their rules: strongest (default), strict (table "
            "look-up, as in the thesis), average or ridge.",
        ),
    ] = None
    terms: Annotated[
        list[int] | None,
        typer.Option(
            metavar="COUNT",
            rich_help_panel=RUNS,
            help="Terms of each input of t1, it2 and gt2, on a grid; default 2 for the 3-PSP, "
            "otherwise none.",
        ),
    ] = None
    mean_variation: Annotated[
        list[float] | None,
        typer.Option(
            metavar="SHARE",
            rich_help_panel=RUNS,
            help=(
                "Mean variation of it2 and gt2 as a share of each input's range; by default it "
                "follows the signal-to-noise ratio."
            ),
        ),
    ] = None
    defuzzify: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="What gt2 defuzzifies: first M, C and G (default), or last the torque, as in the "
            "thesis.",
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class PlantOptions:
    """How the plant differs from the controllers' model."""

    payload: Annotated[
        list[float] | None,
        typer.Option(
            metavar="KG",
            rich_help_panel=PLANT,
            help="Mass on the star that is not in the controller's model (kg).",
        ),
    ] = None
    coulomb_friction: Annotated[
        list[float] | None,
        typer.Option(metavar="N", rich_help_panel=PLANT, help="Dry friction of a nut (N)."),
    ] = None
    viscous_friction: Annotated[
        list[float] | None,
        typer.Option(
            metavar="N*S/M", rich_help_panel=PLANT, help="Viscous friction of a nut (N s/m)."
        ),
    ] = None
    motor_inertia: Annotated[
        list[float] | None,
        typer.Option(
            metavar="KG*M2",
            rich_help_panel=PLANT,
            help="Inertia of a motor with its screw (kg m²); needs --lead.",
        ),
    ] = None
    lead: Annotated[
        list[float] | None,
        typer.Option(
            metavar="M", rich_help_panel=PLANT, help="Travel of a nut in one turn of its screw (m)."
        ),
    ] = None
    encoder_resolution: Annotated[
        list[float] | None,
        typer.Option(
            metavar="M", rich_help_panel=PLANT, help="Height of a nut per count of its encoder (m)."
        ),
    ] = None
    delay: Annotated[
        list[int] | None,
        typer.Option(
            metavar="PERIODS",
            rich_help_panel=PLANT,
            help="Delay from measurement to force, in control periods.",
        ),
    ] = None


@single_options
def study(
    *,
    file: Annotated[
        Path,
        typer.Argument(
            parser=file_path,
            metavar="FILE",
            help="SQLite file of the results; made, resumed or extended.",
            show_default=False,
        ),
    ],
    robot: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="ROBOT",
            help="Robots of the package (psp3 info lists them) or their files; default the 3-PSP.",
            show_default=False,
        ),
    ] = None,
    runs: RunOptions,
    plant: PlantOptions,
    duration: Annotated[
        float,
        typer.Option(
            metavar="S",
            rich_help_panel=RUNS,
            help="Length of a run (s); it is the same for all runs in a file.",
        ),
    ] = float(SAMPLED),
    workers: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="COUNT",
            help="Number of runs at a time on this machine; default one per core.",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Address of a dask scheduler, tcp://HOST:PORT: its workers do the runs.",
        ),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            parser=table_output,
            metavar="FILE",
            rich_help_panel=OUTPUT,
            help="Write the fields and metrics of all runs as CSV in SI units.",
        ),
    ] = None,
) -> None:
    """Compare controllers over many seeds, with intervals.

    Options of runs can be given more than once: every combination is a run. Runs in FILE are not
    repeated, so the same command resumes a study that was stopped, and a larger number of seeds
    extends it.
    """
    refuse_workers_of_scheduler(workers, scheduler)
    from psp3.description.parts import ROBOTS

    if str(file) in ROBOTS:
        raise usage_error(f"give FILE first and then robots: psp3 study {file}.sqlite {file}")
    if csv is not None and csv.resolve() == file.resolve():
        raise usage_error("--csv would overwrite FILE; give it another name")
    from psp3.study.grids import grid
    from psp3.study.study import Study

    given = {
        "robot": robot,
        "reading": runs.reading,
        "trajectory": runs.trajectory,
        "learner": runs.learner,
        "n_terms": runs.terms,
        "mean_variation": runs.mean_variation,
        "snr_reference": runs.snr_reference,
        "noisy_entries": runs.noisy_entries,
        "defuzzify": runs.defuzzify,
        **vars(plant),
        # The last fields vary fastest, so consecutive runs differ only in controller and noise.
        "controller": runs.controller or ["pd", "ctc", "t1", "it2"],
        "snr_db": runs.snr or [math.inf, 20.0, 15.0, 10.0],
    }
    values = {name: choice for name, choice in given.items() if choice}
    outcome = Study(file, grid(**values, seed=range(runs.seeds), duration=duration))
    with resumable(file), counted_progress("runs") as progress:
        outcome.run(workers, scheduler, progress)
    rows = outcome.rows()
    for title, headings, cells, note in _study_tables(rows, runs.mean_variation is not None):
        show_narrow(title, headings, cells, note)
    if csv is not None:
        outcome.export(csv)
        say(csv)


OF_NOISE = ("reading", "snr_reference", "noisy_entries")
"""Fields that do not apply to runs without noise."""


def _setting(run: Run, name: str) -> Value:
    """Return the value of a field as a table shows it."""
    value: Value = None if name in OF_NOISE and math.isinf(run.snr_db) else getattr(run, name)
    return value


def _fixed_settings(found: dict[str, Value], headings: dict[str, str]) -> list[str]:
    """Return the fields that all runs share, except those left at their defaults."""
    from psp3.study.run import DEFAULTS

    fixed = ["no noise"] if found.get("reading", "") is None else []
    return fixed + [
        f"{headings[name]} {cell_text(value)}"
        for name, value in found.items()
        if value is not None and (name == "reading" or value != DEFAULTS[name])
    ]


def _study_tables(
    rows: Table, show_mean_variation: bool
) -> Iterator[tuple[str, list[str], list[list[str]], str]]:
    """Return the title, headings, rows and note of each table of a study.

    The first table has every setting, the second compares type-2 with type-1.
    """
    from psp3.study.intervals import coverage_in_words
    from psp3.study.statistics import Estimate, compare, summarize

    headings = {
        "robot": "robot",
        "controller": "controller",
        "reading": "reading",
        "snr_db": "SNR (dB)",
        "snr_reference": "SNR against",
        "noisy_entries": "noisy entries",
        "trajectory": "trajectory",
        "learner": "learner",
        "n_terms": "terms",
        "mean_variation": "mean variation",
        "defuzzify": "defuzzified",
        "payload": "payload (kg)",
        "coulomb_friction": "dry friction (N)",
        "viscous_friction": "viscous friction (N s/m)",
        "motor_inertia": "motor inertia (kg m²)",
        "lead": "lead (m)",
        "encoder_resolution": "encoder (m)",
        "delay": "delay (periods)",
    }
    summaries = summarize(rows)
    found = {name: {_setting(summary.run, name) for summary in summaries} for name in headings}
    if not show_mean_variation:
        del found["mean_variation"]
    for name in OF_NOISE:
        if len(found[name]) > 1:
            found[name].discard(None)
    names = [name for name, values in found.items() if name == "controller" or len(values) > 1]
    common = {name: next(iter(values)) for name, values in found.items() if name not in names}
    fixed = _fixed_settings(common, headings)
    are_lengths = all(summary.run.robot == "psp3" for summary in summaries)
    unit = "m²" if are_lengths else "m² or rad²"

    def settings(run: Any) -> list[str]:
        return [cell_text(_setting(run, name)) for name in names]

    def number(estimate: Estimate, factor: float = 1.0, unit: str = "") -> str:
        value, low, high = (
            cell_text(factor * x) for x in (estimate.value, estimate.low, estimate.high)
        )
        return f"{value}{unit} ({low} to {high})" if estimate.count > 1 else f"{value}{unit}"

    seeds = max(summary.diverged.count for summary in summaries)
    title = ", ".join([f"Sum of squared errors, one sample per 0.05 s ({unit})", *fixed])
    cells = [
        [
            *settings(summary.run),
            number(summary.mean),
            number(summary.median),
            number(summary.diverged, 100.0, " %"),
            str(summary.diverged.count),
        ]
        for summary in summaries
    ]
    shown = [headings[name] for name in names]
    note = (
        "In brackets 95 % intervals, from the bootstrap, for shares Wilson's; "
        f"{coverage_in_words('mean', 'median', seeds=seeds)}. Means and medians are over the "
        "seeds that did not diverge. Runs that do not depend on the seed are done once."
    )
    yield title, [*shown, "mean", "median", "diverged", "seeds"], cells, note
    cells = [
        [
            *settings(comparison.run),
            number(comparison.difference),
            number(comparison.ratio),
            number(comparison.ratio_of_geometric_means),
            str(comparison.difference.count),
        ]
        for name in ("it2", "gt2")
        for comparison in compare(rows, name, "t1")
    ]
    if cells:
        estimands = ("difference of means", "ratio of means", "ratio of geometric means")
        note = (
            "Paired by seed, over the seeds with which neither diverged: mean of type-2 minus "
            "type-1, ratio of their means, and ratio of their geometric means, which is the factor "
            "between typical runs. In brackets 95 % intervals; "
            f"{coverage_in_words(*estimands, seeds=seeds)}."
        )
        yield (
            "Type-2 beside type-1",
            [
                *shown,
                f"difference ({unit})",
                "ratio of means",
                "of geometric means",
                "seeds",
            ],
            cells,
            note,
        )

"""The command ``psp3``: everything this package does, from a terminal.

Only typer is imported here; each command imports what it needs when it runs, so that ``psp3 --help`` answers at once.
Results go to standard output, progress and errors to standard error. Lengths are meters, angles degrees.
"""

from __future__ import annotations

import io
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from psp3.controllers import Controller
    from psp3.fuzzy_computed_torque import FuzzyComputedTorque
    from psp3.robot import PSP3
    from psp3.simulation import Result
    from psp3.trajectories import Trajectory

USAGE, INTERRUPTED = 2, 130
"""Exit statuses: wrong usage or input, and Ctrl-C."""

RIGHT_ANGLE = 90.0
"""A star cannot be tilted that far [degrees]."""

FIGURE_FORMATS = (".pdf", ".png", ".svg")
SAMPLED = "10.4"
"""Default duration of a motion without an end of its own [s], that of the thesis's simulations."""

app = typer.Typer(
    name="psp3",
    add_completion=False,
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    help="Dynamics and control of the 3-PSP parallel robot.",
    epilog="Lengths are in meters and angles in degrees, lists are separated by commas. 'psp3 COMMAND --help' explains a command.",
)


class Triple(NamedTuple):
    """Three numbers of the command line, one for each screw or axis."""

    first: float
    second: float
    third: float


class Limit(NamedTuple):
    """One number for all screws, or three."""

    values: tuple[float, ...]


class ControllerName(StrEnum):
    """Controllers that the command line knows."""

    PD = "pd"
    PD_GRAVITY = "pd-gravity"
    PID = "pid"
    FEED_FORWARD = "feed-forward"
    CTC = "ctc"
    T1 = "t1"
    IT2 = "it2"
    GT2 = "gt2"


class ModelName(StrEnum):
    """Implementations of the equation of motion."""

    CLOSED_FORM = "closed_form"
    PINOCCHIO = "pinocchio"
    NOC = "noc"


class ParametersName(StrEnum):
    """Parameter sets."""

    DEFAULT = "default"
    TABLE_3_1 = "table_3_1"
    TABLE_5_1 = "table_5_1"


class InitialSpeed(StrEnum):
    """How a simulation starts."""

    REST = "rest"
    PATH = "path"


class Over(StrEnum):
    """Coordinates of a map of the workspace."""

    TILT = "tilt"
    TIP = "tip"


# What the options look like


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(number) for number in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a list of numbers separated by commas") from None


def _triple(text: str) -> Triple:
    numbers = _numbers(text)
    if len(numbers) != len(Triple._fields):
        raise typer.BadParameter(f"{text!r} has {len(numbers)} numbers; three are needed, separated by commas")
    return Triple(*numbers)


def _limit(text: str) -> Limit:
    numbers = _numbers(text)
    if len(numbers) not in (1, 3) or not all(math.isfinite(number) and number > 0.0 for number in numbers):
        raise typer.BadParameter(f"{text!r} is not one positive number or three, separated by commas")
    return Limit(numbers)


def _output(text: str) -> Path:
    """Refuse what cannot be written before anything is computed, not after."""
    path = Path(text)
    if path.is_dir():
        raise typer.BadParameter(f"{text} is a directory")
    if not path.parent.is_dir():
        raise typer.BadParameter(f"{text}: there is no directory {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise typer.BadParameter(f"{text} cannot be written to")
    return path


def _page_output(text: str) -> Path:
    if Path(text).suffix.lower() not in (".html", ".htm"):
        raise typer.BadParameter(f"{text}: the name of a page must end in .html")
    return _output(text)


def _csv_output(text: str) -> Path:
    return Path("-") if text == "-" else _output(text)


def _figure_output(text: str) -> Path:
    if Path(text).suffix.lower() not in FIGURE_FORMATS:
        raise typer.BadParameter(f"{text}: the name of a figure must end in {', '.join(FIGURE_FORMATS)}")
    return _output(text)


Parameters = Annotated[ParametersName, typer.Option(metavar="NAME", help="Parameter set: default, table_3_1 or table_5_1; see psp3 info.")]
Model = Annotated[
    ModelName | None, typer.Option(metavar="NAME", help="Where M, C and G come from: closed_form (unless given), pinocchio or noc.")
]
Heights = Annotated[Triple, typer.Option(parser=_triple, metavar="A1,A2,A3", help="Nut heights (m).")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.", show_default=False)]
FigureFile = Annotated[Path | None, typer.Option(parser=_figure_output, metavar="FILE", help="Draw to FILE: .pdf, .png or .svg.")]

MOTION, RUNS, PLANT, OUTPUT = "Desired motion", "Runs", "Plant, for --reading plant", "Output"
TrajectoryText = Annotated[
    str,
    typer.Option(
        metavar="NAME", rich_help_panel=MOTION, help="helix, circle, line, point-to-point, hold, or csv:FILE for a motion on file."
    ),
]
Radius = Annotated[
    float | None, typer.Option(metavar="M", rich_help_panel=MOTION, help="Radius of helix and circle (m); 0.02 unless given.")
]
TurnTime = Annotated[
    float | None, typer.Option(metavar="S", rich_help_panel=MOTION, help="Time for a turn of helix and circle (s); 2 unless given.")
]
Rise = Annotated[
    float | None, typer.Option(metavar="M/S", rich_help_panel=MOTION, help="Vertical speed of the helix (m/s); 0.01 unless given.")
]
StartHeight = Annotated[
    float | None,
    typer.Option(metavar="M", rich_help_panel=MOTION, help="Tip height where helix and circle start (m); 0.07, home, unless given."),
]
Start = Annotated[
    Triple | None,
    typer.Option(parser=_triple, metavar="X,Y,Z", rich_help_panel=MOTION, help="Tip where line and point-to-point start (m)."),
]
End = Annotated[
    Triple | None,
    typer.Option(parser=_triple, metavar="X,Y,Z", rich_help_panel=MOTION, help="Tip where line and point-to-point end (m)."),
]
TravelTime = Annotated[
    float | None, typer.Option(metavar="S", rich_help_panel=MOTION, help="Time that line and point-to-point take (s); 2 unless given.")
]
HoldTip = Annotated[
    Triple | None,
    typer.Option(parser=_triple, metavar="X,Y,Z", rich_help_panel=MOTION, help="Tip to hold (m); 0,0,0.07, home, unless given."),
]
Duration = Annotated[
    float | None,
    typer.Option(
        metavar="S", rich_help_panel=MOTION, help=f"Time in all (s); unless given until the motion ends, {SAMPLED} if it never does."
    ),
]
CsvFile = Annotated[
    Path | None,
    typer.Option(
        parser=_csv_output, metavar="FILE", rich_help_panel=OUTPUT, help="Write all samples as CSV, SI units; - is standard output."
    ),
]
OutputFigure = Annotated[
    Path | None, typer.Option(parser=_figure_output, metavar="FILE", rich_help_panel=OUTPUT, help="Draw to FILE: .pdf, .png or .svg.")
]
OutputJson = Annotated[bool, typer.Option("--json", rich_help_panel=OUTPUT, help="Print JSON and nothing else.", show_default=False)]


# What the commands share


def _usage(message: str) -> typer.BadParameter:
    return typer.BadParameter(message)


def _option_of(name: str) -> str:
    return "--" + name.replace("_", "-")


def _listed(names: Iterable[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def _only(chosen: str, given: dict[str, Any], allowed: Iterable[str]) -> dict[str, Any]:
    """Keep the options that were given; refuse those that mean nothing for what was chosen."""
    allowed = tuple(allowed)
    kept = {name: value for name, value in given.items() if value is not None}
    for name in kept:
        if name not in allowed:
            instead = f", which takes {_listed(map(_option_of, allowed))}" if allowed else ""
            raise _usage(f"{_option_of(name)} does not apply to {chosen}{instead}")
    return kept


def _load(parameters: ParametersName) -> PSP3:
    from psp3.loading import load

    return load("psp3", parameters=parameters.value)


def _trajectory(robot: PSP3, text: str, duration: float | None, given: dict[str, Any]) -> tuple[Trajectory, float]:
    """Return the motion that the options describe, and for how long it is wanted."""
    from psp3 import trajectories

    kind, _, file = text.partition(":")
    trajectory: Trajectory
    if kind == "csv":
        _only("--trajectory csv", given, ())
        if not file:
            raise _usage("--trajectory csv needs the name of a file: csv:FILE")
        trajectory = trajectories.FromCSV(file, robot=robot)
    elif file or kind not in ("helix", "circle", "line", "point-to-point", "hold"):
        raise _usage(f"--trajectory must be helix, circle, line, point-to-point, hold or csv:FILE, got {text!r}")
    elif kind == "hold":
        trajectory = trajectories.Hold(_only("--trajectory hold", given, ("tip",)).get("tip"), robot=robot)
    elif kind in ("helix", "circle"):
        allowed = ("radius", "turn_time", "start_height") + (("rise",) if kind == "helix" else ())
        options = _only(f"--trajectory {kind}", given, allowed)
        names = {"radius": "radius", "turn_time": "period", "start_height": "height", "rise": "rise"}
        shape = trajectories.Helix if kind == "helix" else trajectories.Circle
        trajectory = shape(robot=robot, **{names[name]: value for name, value in options.items()})
    else:
        options = {"travel_time": 2.0} | _only(f"--trajectory {kind}", given, ("start", "end", "travel_time"))
        missing = [_option_of(name) for name in ("start", "end") if name not in options]
        if missing:
            raise _usage(f"--trajectory {kind} needs {_listed(missing)}")
        segment = trajectories.Line if kind == "line" else trajectories.PointToPoint
        trajectory = segment(options["start"], options["end"], options["travel_time"], robot=robot)
    return trajectory, duration if duration is not None else trajectory.duration or float(SAMPLED)


def _table(title: str, *columns: str, note: str = "") -> Table:
    from rich import box
    from rich.table import Table

    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", title_style="bold", caption=note or None, caption_justify="left")
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number == 0 else "right", overflow="fold")
    return table


def _narrow_table(headings: list[str], rows: list[list[str]]) -> Table:
    """Return a table that breaks headings and sentences between words, and numbers never, so that it fits 80 columns."""
    import textwrap

    from rich import box
    from rich.table import Table
    from rich.text import Text

    def is_number(word: str) -> bool:
        return word.replace("\N{MINUS SIGN}", "-").lstrip("+-").replace(".", "", 1).replace("e-", "").isdigit()

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    cells = [[" ".join(cell.split()) for cell in row] for row in rows]
    for heading, column in zip(headings, zip(*cells, strict=True), strict=True):
        sentences = any(" " in cell and not all(map(is_number, cell.split())) for cell in column)
        longest = max(map(len, (*heading.split(), *(word for cell in column for word in (cell.split() if sentences else [cell])), "")))
        table.add_column(Text("\n".join(textwrap.wrap(heading, longest))), no_wrap=not sentences, min_width=longest)
    for row in cells:
        table.add_row(*map(Text, row))
    return table


def _show(*tables: Table) -> None:
    from rich.console import Console

    console = Console(highlight=False)
    for table in tables:
        console.print(table)


def _plain(value: Any) -> Any:
    """Turn arrays into lists and what JSON has no number for into null."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def _print_json(content: dict[str, Any]) -> None:
    import json

    typer.echo(json.dumps(_plain(content), allow_nan=False, ensure_ascii=False))


def _fixed(values: Any, digits: int = 6) -> list[str]:
    """Numbers as text with a fixed number of digits, without negative zeros."""
    return [f"{round(float(value), digits) + 0.0:.{digits}f}" if math.isfinite(value) else "∞" for value in values]


def _write_csv(path: Path, columns: dict[str, Any]) -> None:
    import csv

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    if path == Path("-"):
        typer.echo(text.getvalue(), nl=False)
    else:
        path.write_text(text.getvalue(), encoding="utf-8")


def _draw(path: Path, draw: Callable[[], Any]) -> None:
    from fuzzy2.style import style

    with style():
        draw()[0].get_figure(root=True).savefig(path)


@contextmanager
def _progress(description: str, total: float) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on standard error, if that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(description, total=total)
        yield lambda done: bar.update(task, completed=done)


def _version(wanted: bool) -> None:
    if wanted:
        from psp3 import __version__

        typer.echo(f"psp3 {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    context: typer.Context,
    _: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")] = False,
) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(USAGE)


# The commands


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(file_okay=False, metavar="DIR", help="Directory to write to; made if it does not exist.")] = Path(
        "results"
    ),
    seeds: Annotated[
        int, typer.Option(min=1, metavar="COUNT", help="Number of seeds of Table 6.3; other comparisons take 10 at most.")
    ] = 30,
    quick: Annotated[bool, typer.Option("--quick", help="A look in seconds: two seeds, no animation.", show_default=False)] = False,
) -> None:
    """Run the main job: the thesis's results, recomputed.

    Every number stands beside the printed one. Writes a report, figures, an animation and all numbers, and prints the main tables. Runs
    that DIR/study.sqlite holds are not repeated, so the same command goes on where it was stopped.
    """
    from rich.console import Console
    from rich.text import Text

    from psp3.errors import StudyInterrupted
    from psp3.reproduce import reproduce as run

    try:
        with _reproduce_progress() as (progress, run_progress):
            outcome = run(out, quick=quick, progress=progress, seeds=seeds, run_progress=run_progress)
    except StudyInterrupted as interrupt:
        typer.echo(f"{interrupt.done} of {interrupt.total} runs are in {out}; the same command goes on from there", err=True)
        raise typer.Exit(INTERRUPTED) from None
    console = Console(highlight=False)
    for content in outcome.tables:
        if content.detail:
            continue
        console.print(Text(content.title, style="bold"))
        console.print(_narrow_table(content.columns, content.rows))
        if content.note:
            console.print(Text(content.note, style="dim"))
        console.print()
    for sentence in outcome.answer:
        console.print(Text(f"• {sentence}"))
    hidden = sum(content.detail for content in outcome.tables)
    console.print(Text(f"• {hidden} more tables and {len(outcome.drawings)} figures are in the report."))
    console.print()
    for path in outcome.files:
        # Outside rich, which would break long paths.
        typer.echo(path if path.is_relative_to(out) else out / path.name)


@contextmanager
def _reproduce_progress() -> Iterator[tuple[Callable[[str, int, int], None], Callable[[int, int, float], None]]]:
    """Show the steps of the main job and the runs of its study on standard error; in a log each step is a line."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    errors = Console(stderr=True, highlight=False)
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as bar:
        task, runs = bar.add_task("", total=None), bar.add_task("runs", total=None, visible=False)

        def progress(description: str, done: int, total: int) -> None:
            bar.update(task, description=description, completed=done, total=total)
            if not errors.is_terminal and done < total:
                typer.echo(f"[{done + 1}/{total}] {description}", err=True)

        def run_progress(done: int, total: int, rate: float) -> None:
            bar.update(runs, description=f"runs, {rate:.0f} a second", completed=done, total=total, visible=done < total)

        yield progress, run_progress


@app.command()
def simulate(
    controller: Annotated[
        ControllerName | None,
        typer.Option(
            metavar="NAME",
            help="Controller: pd, pd-gravity, pid, feed-forward or ctc; t1, it2 or gt2, trained on the helix without noise.",
            show_default="ctc",
        ),
    ] = None,
    trained: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A controller that psp3 train wrote, in place of --controller.", show_default=False)
    ] = None,
    model: Model = None,
    kp: Annotated[
        float | None, typer.Option(metavar="GAIN", help="Proportional gain: N/m, 1/s² for ctc; 1000, 10 for ctc, unless given.")
    ] = None,
    kv: Annotated[
        float | None, typer.Option(metavar="GAIN", help="Derivative gain: N s/m, 1/s for ctc; 100, 1 for ctc, unless given.")
    ] = None,
    ki: Annotated[float | None, typer.Option(metavar="GAIN", help="Integral gain of pid: N/(m s); 2000 unless given.")] = None,
    torque_limit: Annotated[
        Limit | None, typer.Option(parser=_limit, metavar="N", help="Largest screw force (N), one number or three; none unless given.")
    ] = None,
    period: Annotated[float, typer.Option(metavar="S", help="Control period (s).")] = 0.002,
    initial_speed: Annotated[
        InitialSpeed, typer.Option(metavar="NAME", help="Speed at the start: rest, or path for that of the motion.")
    ] = InitialSpeed.REST,
    parameters: Parameters = ParametersName.DEFAULT,
    trajectory: TrajectoryText = "helix",
    radius: Radius = None,
    turn_time: TurnTime = None,
    rise: Rise = None,
    start_height: StartHeight = None,
    start: Start = None,
    end: End = None,
    travel_time: TravelTime = None,
    tip: HoldTip = None,
    duration: Duration = None,
    out: Annotated[
        Path | None, typer.Option(parser=_output, metavar="FILE", rich_help_panel=OUTPUT, help="Save the result as .npz, for psp3 view.")
    ] = None,
    csv: CsvFile = None,
    figure: OutputFigure = None,
    json: OutputJson = False,
) -> None:
    """Simulate a controller that tracks a motion of the tip.

    Without options: computed torque with the thesis's gains on the thesis's helix.
    """
    _check_outputs(csv, json)
    robot = _load(parameters)
    gains = {"kp": kp, "kv": kv, "ki": ki}
    if trained is None:
        controller = controller or ControllerName.CTC
        steering, settings = _controller(robot, controller, model, gains)
    else:
        _only("--trained, which has its own", gains | {"model": model, "controller": controller}, ())
        steering, settings = _from_file(robot, trained)
        controller = ControllerName(steering.kind)
    given = {
        "radius": radius, "turn_time": turn_time, "rise": rise, "start_height": start_height,
        "start": start, "end": end, "travel_time": travel_time, "tip": tip,
    }  # fmt: skip
    motion, seconds = _trajectory(robot, trajectory, duration, given)
    from psp3.errors import SimulationStopped
    from psp3.simulation import simulate as run

    title = f"{controller.value}, {trajectory}"

    def write(result: Result) -> dict[str, Path]:
        files = {"result": out, "csv": csv, "figure": figure}
        if out is not None:
            result.save(out)
        if csv is not None:
            _write_csv(csv, _samples(result))
        if figure is not None:
            from psp3.plots import figure_of_tracking

            _draw(figure, lambda: figure_of_tracking(result, title))
        return {name: path for name, path in files.items() if path is not None and path != Path("-")}

    try:
        with _progress("simulating", seconds) as progress:
            result = run(
                robot,
                steering,
                motion,
                seconds,
                period,
                initial_speeds=motion(0.0).speeds if initial_speed is InitialSpeed.PATH else None,
                torque_limit=None
                if torque_limit is None
                else torque_limit.values
                if len(torque_limit.values) == 3
                else torque_limit.values[0],
                progress=progress,
            )
    except SimulationStopped as error:
        files = write(error.result)
        kept = f"; the part until then is in {_listed(map(str, files.values()))}" if files else ""
        typer.echo(f"{_message(error)}{kept}", err=True)
        raise typer.Exit(USAGE) from error
    files = write(result)
    if csv == Path("-"):
        return
    metrics = _metrics(result)
    if json:
        content = {"controller": controller.value, **settings, "parameters": parameters.value, "trajectory": trajectory}
        content |= {"trajectory_options": {name: value for name, value in given.items() if value is not None}}
        content |= {"duration": float(result.t[-1]), "period": period, "samples": result.t.size, "initial_speed": initial_speed.value}
        content |= {"torque_limit": None if torque_limit is None else torque_limit.values}
        _print_json(content | {"metrics": metrics, "files": files})
        return
    table = _table(f"{title}, {result.t[-1]:g} s at {1e3 * period:g} ms", "", "value", "unit")
    squares = metrics["sum_of_squared_errors"]
    table.add_row("sum of squared errors, one sample per 0.05 s", "–" if squares is None else f"{squares:.6g}", "m²")
    table.add_row("integral of the squared error", f"{metrics['integral_of_squared_error']:.6g}", "m² s")
    table.add_row("root mean square of the error", f"{1e3 * metrics['rms_error']:.6g}", "mm")
    table.add_row("largest error of the tip", f"{1e3 * metrics['largest_tip_error']:.6g}", "mm")
    table.add_row("error of the tip at the end", f"{1e3 * metrics['final_tip_error']:.6g}", "mm")
    table.add_row("largest screw forces", "  ".join(_fixed(metrics["largest_forces"], 2)), "N")
    if "coverage" in metrics:
        table.add_row("steps inside the trained range", f"{100.0 * metrics['coverage']:.4g}", "%")
        table.add_row("steps that fell back on the average of the rules", f"{100.0 * metrics['fallbacks']:.4g}", "%")
    _show(table)
    for path in files.values():
        typer.echo(path)


def _check_outputs(csv: Path | None, json: bool) -> None:
    if json and csv == Path("-"):
        raise _usage("--json and --csv - both want standard output; give --csv a file")


def _controller(
    robot: PSP3, name: ControllerName, model: ModelName | None, gains: dict[str, float | None]
) -> tuple[Controller, dict[str, Any]]:
    """Return a controller and what there is to say about it."""
    from psp3 import controllers

    allowed = {ControllerName.PID: ("kp", "kv", "ki"), ControllerName.FEED_FORWARD: ()}.get(name, ("kp", "kv"))
    kept = _only(f"--controller {name.value}", gains, allowed)
    controller: Any
    if name in (ControllerName.T1, ControllerName.IT2, ControllerName.GT2):
        if model is not None:
            raise _usage(f"--model does not apply to --controller {name.value}, which learns its own")
        from psp3.fuzzy_computed_torque import FuzzyComputedTorque
        from psp3.trajectories import Helix

        controller = FuzzyComputedTorque(name.value, robot, **kept).fit(Helix(robot=robot))
        settings: dict[str, Any] = {"model": "learned"}
    elif name in (ControllerName.PD, ControllerName.PID):
        if model is not None:
            raise _usage(f"--model does not apply to --controller {name.value}, which uses none")
        controller = {ControllerName.PD: controllers.PD, ControllerName.PID: controllers.PID}[name](**kept)
        settings = {"model": None}
    else:
        chosen = model or ModelName.CLOSED_FORM
        kinds: dict[ControllerName, Callable[..., Any]] = {
            ControllerName.PD_GRAVITY: controllers.GravityCompensatedPD,
            ControllerName.FEED_FORWARD: controllers.FeedForward,
            ControllerName.CTC: controllers.ComputedTorque,
        }
        controller = kinds[name](robot.dynamics(chosen.value), **kept)
        settings = {"model": chosen.value}
    return controller, settings | {"gains": {gain: getattr(controller, gain) for gain in allowed}}


def _from_file(robot: PSP3, path: Path) -> tuple[FuzzyComputedTorque, dict[str, Any]]:
    """Return a trained controller and what there is to say about it."""
    from psp3.fuzzy_computed_torque import FuzzyComputedTorque

    controller = FuzzyComputedTorque.load(path, robot)
    return controller, {"model": str(path), "gains": {"kp": controller.kp, "kv": controller.kv}}


def _metrics(result: Result) -> dict[str, Any]:
    import numpy as np

    from psp3 import metrics
    from psp3.errors import InvalidValue

    try:
        squares = metrics.sum_of_squared_errors(result)
    except InvalidValue:
        # The control period does not divide 0.05 s.
        squares = None
    shares = {"coverage": result.covered, "fallbacks": result.fell_back}
    return {
        "sum_of_squared_errors": squares,
        "integral_of_squared_error": metrics.integral_of_squared_error(result),
        "rms_error": metrics.rms_error(result),
        "largest_tip_error": metrics.largest_tip_error(result),
        "final_tip_error": float(np.linalg.norm(result.desired.tip[-1] - result.tip[-1])),
        "largest_forces": np.abs(result.torque).max(axis=0),
        **{name: float(flags.mean()) for name, flags in shares.items() if flags is not None},
    }


def _samples(result: Result) -> dict[str, Any]:
    """Columns of a simulation's CSV file, named as those of :meth:`psp3.torques.ScrewForces.columns`."""
    columns = {"t": result.t, **dict(zip("xyz", result.tip.T, strict=True))}
    columns |= {f"desired_{name}": column for name, column in zip("xyz", result.desired.tip.T, strict=True)}
    for name, values in (
        ("a", result.heights),
        ("desired_a", result.desired.heights),
        ("speed", result.speeds),
        ("desired_speed", result.desired.speeds),
        ("force", result.torque),
    ):
        columns |= {f"{name}{k}": column for k, column in enumerate(values.T, start=1)}
    flags = {"covered": result.covered, "fell_back": result.fell_back}
    columns |= {name: values.astype(int) for name, values in flags.items() if values is not None}
    return columns


@app.command()
def train(
    file: Annotated[Path, typer.Argument(parser=_output, metavar="FILE", help="JSON file to write.", show_default=False)],
    kind: Annotated[str, typer.Option(metavar="NAME", help="it2 (interval type-2), t1 (type-1) or gt2 (general type-2).")] = "it2",
    learner: Annotated[str, typer.Option(metavar="NAME", help="How rules are learned: strongest, strict, average or ridge.")] = "strongest",
    terms: Annotated[int, typer.Option(metavar="COUNT", help="Terms of every input.")] = 2,
    snr: Annotated[
        float, typer.Option(metavar="DB", help="Signal-to-noise ratio of the recorded M, C and G (dB); inf adds no noise.")
    ] = math.inf,
    mean_variation: Annotated[
        float | None,
        typer.Option(metavar="SHARE", help="Mean variation as a share of each input's range; it follows --snr unless given."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, metavar="NUMBER", help="Of the noise.")] = 0,
    kp: Annotated[float, typer.Option(metavar="GAIN", help="Proportional gain (1/s²).")] = 10.0,
    kv: Annotated[float, typer.Option(metavar="GAIN", help="Derivative gain (1/s).")] = 1.0,
    parameters: Parameters = ParametersName.DEFAULT,
    trajectory: TrajectoryText = "helix",
    radius: Radius = None,
    turn_time: TurnTime = None,
    rise: Rise = None,
    start_height: StartHeight = None,
    start: Start = None,
    end: End = None,
    travel_time: TravelTime = None,
    tip: HoldTip = None,
    duration: Duration = None,
) -> None:
    """Train a fuzzy computed-torque controller and write it to a file.

    The crisp controller tracks a motion, the helix unless given; M, C and G are recorded and learned from.
    """
    import numpy as np

    from psp3.fuzzy_computed_torque import FuzzyComputedTorque
    from psp3.records import INPUT_NAMES, record, unpack

    robot = _load(parameters)
    given = {
        "radius": radius, "turn_time": turn_time, "rise": rise, "start_height": start_height,
        "start": start, "end": end, "travel_time": travel_time, "tip": tip,
    }  # fmt: skip
    motion, seconds = _trajectory(robot, trajectory, duration, given)
    controller = FuzzyComputedTorque(kind, robot, kp=kp, kv=kv, n_terms=terms, learner=learner, snr_db=snr, mean_variation=mean_variation)
    recorded = record(robot, motion, seconds, kp=kp, kv=kv)
    controller.learn(recorded, min(209, len(recorded.t)), np.random.default_rng(seed)).save(file)
    note = f"{len(controller.system_.rules)} rules, mean variation {controller.mean_variation:.3g}"
    table = _table(f"{kind}, learned on {trajectory}", "trained range", "least", "greatest", "unit", note=note)
    for name, low, high, unit in zip(INPUT_NAMES, *controller.ranges_, ("m", "m", "m/s", "m/s"), strict=True):
        table.add_row(name, f"{low:.4f}", f"{high:.4f}", unit)
    errors = _table("Estimates on the way", "", "RMS error, relative")
    estimates = controller.estimate(recorded.heights, recorded.speeds)
    for name, exact, estimate in zip("MCG", unpack(recorded.outputs), estimates, strict=True):
        errors.add_row(name, f"{np.sqrt(((estimate - exact) ** 2).mean() / (exact**2).mean()):.2%}")
    _show(table, errors)
    typer.echo(file)


@app.command()
def study(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="SQLite file of the results: begun, resumed or extended.", show_default=False)
    ],
    controller: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="Controller: feed-forward, pd, pd-gravity, ctc, t1, it2 or gt2; pd, ctc, t1 and it2 unless given.",
        ),
    ] = None,
    reading: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", rich_help_panel=RUNS, help="What is noisy: parameters (unless given), measurement, online or plant."),
    ] = None,
    snr: Annotated[
        list[float] | None,
        typer.Option(metavar="DB", rich_help_panel=RUNS, help="Signal-to-noise ratio (dB); inf, 20, 15 and 10 unless given."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, metavar="COUNT", rich_help_panel=RUNS, help="Number of seeds, from 0 on.")] = 30,
    trajectory: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="Path: helix (unless given), which is the one learned from, circle, line, fast-helix, fastest-helix, large-helix or "
            "waypoints.",
        ),
    ] = None,
    learner: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", rich_help_panel=RUNS, help="How t1, it2 and gt2 learn their rules; strongest unless given."),
    ] = None,
    terms: Annotated[
        list[int] | None,
        typer.Option(metavar="COUNT", rich_help_panel=RUNS, help="Terms of each input of t1, it2 and gt2; 2 unless given."),
    ] = None,
    mean_variation: Annotated[
        list[float] | None,
        typer.Option(
            metavar="SHARE",
            rich_help_panel=RUNS,
            help="Mean variation of it2 and gt2 as a share of each input's range; it follows the signal-to-noise ratio unless given.",
        ),
    ] = None,
    payload: Annotated[
        list[float] | None,
        typer.Option(metavar="KG", rich_help_panel=PLANT, help="Mass on the star that no controller knows of (kg)."),
    ] = None,
    coulomb_friction: Annotated[
        list[float] | None, typer.Option(metavar="N", rich_help_panel=PLANT, help="Dry friction of a nut (N).")
    ] = None,
    viscous_friction: Annotated[
        list[float] | None, typer.Option(metavar="N*S/M", rich_help_panel=PLANT, help="Viscous friction of a nut (N s/m).")
    ] = None,
    motor_inertia: Annotated[
        list[float] | None,
        typer.Option(metavar="KG*M2", rich_help_panel=PLANT, help="Inertia of a motor with its screw (kg m²); needs --lead."),
    ] = None,
    lead: Annotated[
        list[float] | None, typer.Option(metavar="M", rich_help_panel=PLANT, help="Travel of a nut in one turn of its screw (m).")
    ] = None,
    encoder_resolution: Annotated[
        list[float] | None, typer.Option(metavar="M", rich_help_panel=PLANT, help="Height of a nut per count of its encoder (m).")
    ] = None,
    delay: Annotated[
        list[int] | None, typer.Option(metavar="PERIODS", rich_help_panel=PLANT, help="Control periods from measurement to force.")
    ] = None,
    duration: Annotated[
        float, typer.Option(metavar="S", rich_help_panel=RUNS, help="Length of a run (s), the same in all a file.")
    ] = float(SAMPLED),
    workers: Annotated[
        int | None, typer.Option(min=1, metavar="COUNT", help="Runs at a time on this machine; one for each core unless given.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Address of a dask scheduler, tcp://HOST:PORT: its workers do the runs.")
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(parser=_output, metavar="FILE", rich_help_panel=OUTPUT, help="Write fields and metrics of all runs as CSV, SI units."),
    ] = None,
) -> None:
    """Compare controllers over many seeds, with intervals.

    Options of runs can be given more than once: every combination is a run. Runs that are in FILE are not repeated, so the same
    command resumes a study that was stopped, and one with more seeds extends it.
    """
    if workers is not None and scheduler is not None:
        raise _usage("--workers does not apply to --scheduler, which has its own")
    if csv is not None and csv.resolve() == file.resolve():
        raise _usage("--csv would overwrite FILE; give it another name")
    from psp3.errors import StudyInterrupted
    from psp3.study import Study, grid

    given = {"reading": reading, "trajectory": trajectory, "learner": learner, "n_terms": terms, "mean_variation": mean_variation}
    given |= {"payload": payload, "coulomb_friction": coulomb_friction, "viscous_friction": viscous_friction, "lead": lead}
    given |= {"motor_inertia": motor_inertia, "encoder_resolution": encoder_resolution, "delay": delay}
    given |= {"controller": controller or ["pd", "ctc", "t1", "it2"], "snr_db": snr or [math.inf, 20.0, 15.0, 10.0]}
    values = {name: choice for name, choice in given.items() if choice}
    outcome = Study(file, grid(**values, seed=range(seeds), duration=duration))
    try:
        with _study_progress() as progress:
            outcome.run(workers, scheduler, progress)
    except StudyInterrupted as interrupt:
        typer.echo(f"{interrupt.done} of {interrupt.total} runs are in {file}; the same command goes on from there", err=True)
        raise typer.Exit(INTERRUPTED) from None
    rows = outcome.rows()
    for title, headings, cells, note in _study_tables(rows, mean_variation is not None):
        from rich.console import Console
        from rich.text import Text

        console = Console(highlight=False)
        console.print(Text(title, style="bold"))
        console.print(_narrow_table(headings, cells))
        console.print(Text(note, style="dim"))
    if csv is not None:
        outcome.export(csv)
        typer.echo(csv)


@contextmanager
def _study_progress() -> Iterator[Callable[[int, int, float], None]]:
    """Show runs done, rate and remaining time on standard error: as a bar on a terminal, else as a line every tenth of the way."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True, highlight=False)
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
    tenths = -1
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = None

        def progress(done: int, total: int, rate: float) -> None:
            nonlocal task, tenths
            text = f"{rate:.1f} runs/s" if rate else ""
            if task is None:
                # Only now, so that runs of an earlier session do not count as speed.
                task = bar.add_task(text, total=total, completed=done)
            bar.update(task, completed=done, description=text)
            if not console.is_terminal and 10 * done // total > tenths:
                tenths = 10 * done // total
                remaining = f", {(total - done) / rate:.0f} s left" if rate and done < total else ""
                typer.echo(f"[{done}/{total}] {text}{remaining}".rstrip(), err=True)

        yield progress


def _study_tables(rows: list[dict[str, Any]], show_mean_variation: bool) -> Iterator[tuple[str, list[str], list[list[str]], str]]:
    """Title, headings, rows and note of the tables of a study: every setting, then type-2 beside type-1."""
    from psp3.statistics import Estimate, compare, summarize

    headings = {
        "controller": "controller", "reading": "reading", "snr_db": "SNR (dB)", "trajectory": "trajectory", "learner": "learner",
        "n_terms": "terms", "mean_variation": "mean variation", "payload": "payload (kg)",
        "coulomb_friction": "dry friction (N)", "viscous_friction": "viscous friction (N s/m)", "motor_inertia": "motor inertia (kg m²)",
        "lead": "lead (m)", "encoder_resolution": "encoder (m)", "delay": "delay (periods)",
    }  # fmt: skip
    summaries = summarize(rows)
    names = [name for name in headings if name == "controller" or len({getattr(summary.run, name) for summary in summaries}) > 1]
    if not show_mean_variation and "mean_variation" in names:
        names.remove("mean_variation")
    fixed = [f"{headings[name]} {_cell(getattr(summaries[0].run, name))}" for name in ("reading", "trajectory") if name not in names]

    def settings(run: Any) -> list[str]:
        return [_cell(getattr(run, name)) for name in names]

    def number(estimate: Estimate, factor: float = 1.0, unit: str = "") -> str:
        value, low, high = (_cell(factor * x) for x in (estimate.value, estimate.low, estimate.high))
        return f"{value}{unit} ({low} to {high})" if estimate.count > 1 else f"{value}{unit}"

    title = ", ".join(["Sum of squared errors, one sample per 0.05 s (m²)", *fixed])
    cells = [
        [
            *settings(summary.run),
            number(summary.mean), number(summary.median), number(summary.diverged, 100.0, " %"), str(summary.diverged.count),
        ]
        for summary in summaries
    ]  # fmt: skip
    shown = [headings[name] for name in names]
    note = (
        "In brackets 95 % intervals, by bootstrap and of shares Wilson's. Means and medians are over the seeds that did not diverge. What "
        "does not depend on the seed is done once."
    )
    yield title, [*shown, "mean", "median", "diverged", "seeds"], cells, note
    cells = [
        [*settings(comparison.run), number(comparison.difference), number(comparison.ratio), str(comparison.difference.count)]
        for name in ("it2", "gt2")
        for comparison in compare(rows, name, "t1")
    ]
    if cells:
        note = "Paired by seed, over the seeds with which neither diverged: mean of type-2 minus type-1, and ratio of their means."
        yield "Type-2 beside type-1", [*shown, "difference (m²)", "ratio", "seeds"], cells, note


def _cell(value: Any) -> str:
    if not isinstance(value, float):
        return str(value)
    return "∞" if value == math.inf else "–" if math.isnan(value) else f"{value:.3g}"


@app.command()
def torques(
    trajectory: TrajectoryText = "helix",
    radius: Radius = None,
    turn_time: TurnTime = None,
    rise: Rise = None,
    start_height: StartHeight = None,
    start: Start = None,
    end: End = None,
    travel_time: TravelTime = None,
    tip: HoldTip = None,
    duration: Duration = None,
    sampling_period: Annotated[float, typer.Option(metavar="S", help="Time between two samples (s).")] = 0.01,
    model: Model = None,
    parameters: Parameters = ParametersName.DEFAULT,
    csv: CsvFile = None,
    figure: OutputFigure = None,
    json: OutputJson = False,
) -> None:
    """Turn a motion of the tip into screw forces.

    The nut heights and their rates come on the way: the thesis's inverse dynamics, Figures 27, 28 and 31. Prints the extremes;
    all samples go to --csv, --json or --figure.
    """
    _check_outputs(csv, json)
    robot = _load(parameters)
    import numpy as np

    from psp3.arrays import checked_positive
    from psp3.torques import screw_forces

    for name, value in (("duration", duration), ("sampling period", sampling_period)):
        if value is not None:
            checked_positive(name, value)
    given = {
        "radius": radius, "turn_time": turn_time, "rise": rise, "start_height": start_height,
        "start": start, "end": end, "travel_time": travel_time, "tip": tip,
    }  # fmt: skip
    motion, seconds = _trajectory(robot, trajectory, duration, given)
    # The small excess keeps rounding from losing the last sample.
    times = sampling_period * np.arange(int(seconds / sampling_period * (1.0 + 1e-12) + 1e-9) + 1)
    forces = screw_forces(motion, times, robot.dynamics(model.value) if model is not None else None)
    files = {}
    if csv is not None:
        _write_csv(csv, forces.columns())
        files["csv"] = csv
    if figure is not None:
        from psp3.plots import figure_of_torques

        _draw(figure, lambda: figure_of_torques(forces))
        files["figure"] = figure
    if json:
        _print_json({**forces.columns(), "trajectory": trajectory, "parameters": parameters.value, "units": "SI"})
        return
    if csv == Path("-"):
        return
    table = _table(f"{trajectory}: {times.size} samples over {times[-1]:g} s", "", "", "1, x", "2, y", "3, z", "unit")
    for name, values, unit, factor in (
        ("tip", forces.motion.tip, "mm", 1e3),
        ("nut heights", forces.motion.heights, "mm", 1e3),
        ("nut speeds", forces.motion.speeds, "mm/s", 1e3),
        ("nut accelerations", forces.motion.accelerations, "m/s²", 1.0),
        ("screw forces", forces.forces, "N", 1.0),
    ):
        table.add_row(name, "least", *_fixed(factor * values.min(axis=0), 2), unit)
        table.add_row("", "greatest", *_fixed(factor * values.max(axis=0), 2), "")
    _show(table)
    for path in files.values():
        typer.echo(path)


@app.command()
def pose(
    heights: Annotated[
        Triple | None, typer.Option(parser=_triple, metavar="A1,A2,A3", help="Forward: the pose at these nut heights (m).")
    ] = None,
    tip: Annotated[Triple | None, typer.Option(parser=_triple, metavar="X,Y,Z", help="Inverse: the pose with the tip here (m).")] = None,
    height: Annotated[float | None, typer.Option(metavar="M", help="Inverse: height of the star's center (m); 0 with --tilt.")] = None,
    tilt: Annotated[
        float | None, typer.Option(metavar="DEGREES", help="Inverse: tilt of the star's axis (degrees); 0 with --height.")
    ] = None,
    azimuth: Annotated[
        float | None, typer.Option(metavar="DEGREES", help="Inverse: where the star leans to (degrees); 0 unless given.")
    ] = None,
    parameters: Parameters = ParametersName.DEFAULT,
    json: Json = False,
) -> None:
    """Solve the kinematics of one pose.

    Forward from --heights; inverse from --tip, or from --height, --tilt and --azimuth.
    """
    leaning = [value for value in (height, tilt, azimuth) if value is not None]
    if (heights is not None) + (tip is not None) + bool(leaning) != 1:
        raise _usage("give one of --heights, --tip, or --height with --tilt and --azimuth")
    if tilt is not None and not abs(tilt) < RIGHT_ANGLE:
        raise _usage(f"--tilt must be less than {RIGHT_ANGLE:g} degrees, got {tilt:g}")
    robot = _load(parameters)
    import numpy as np

    from psp3.workspace import map_at_heights

    if heights is not None:
        a = np.array(heights)
    elif tip is not None:
        a = robot.inverse_kinematics_tip(tip)
    else:
        a = robot.inverse_kinematics(height or 0.0, *np.radians([tilt or 0.0, azimuth or 0.0]))
    here, rotation = map_at_heights(robot, a), robot.forward_kinematics(a).rotation
    angles = np.degrees([here.tilt, here.azimuth])
    lower, upper = robot.stroke
    inside = bool(((a >= lower) & (a <= upper)).all())
    if json:
        content = {"heights": a, "center": here.center, "rotation": rotation, "arms": here.arms, "tip": here.tip}
        content |= {"tilt": angles[0], "azimuth": angles[1], "parasitic_motion": here.parasitic_motion, "tip_condition": here.tip_condition}
        _print_json(content | {"within_stroke": inside, "units": {"length": "m", "angle": "degrees"}})
        return
    table = _table("Pose", "", "1, x", "2, y", "3, z", "unit")
    for name, values in (("nut heights", a), ("arm lengths", here.arms), ("center of the star", here.center), ("tip", here.tip)):
        table.add_row(name, *_fixed(values), "m")
    table.add_row("axis of the star", *_fixed(rotation[:, 2]), "")
    table.add_section()
    for name, value, unit in (
        ("tilt", angles[0], "degrees"),
        ("azimuth", angles[1], "degrees"),
        ("parasitic motion", here.parasitic_motion, "m"),
        ("condition of the tip Jacobian", here.tip_condition, ""),
    ):
        table.add_row(name, f"{value + 0.0:.6g}", "", "", unit)
    if not inside:
        table.caption = f"Outside the stroke, {lower[0]:g} m to {upper[0]:g} m: the machine cannot take this pose."
    _show(table)


@app.command()
def dynamics(
    heights: Heights,
    speeds: Annotated[
        Triple | None, typer.Option(parser=_triple, metavar="V1,V2,V3", help="Nut speeds v (m/s); 0,0,0 unless given.")
    ] = None,
    accelerations: Annotated[
        Triple | None, typer.Option(parser=_triple, metavar="W1,W2,W3", help="Nut accelerations w (m/s²); 0,0,0 unless given.")
    ] = None,
    parameters: Parameters = ParametersName.DEFAULT,
    json: Json = False,
) -> None:
    """Evaluate the equation of motion at one state.

    Prints M, C, G and the screw forces. The forces are M w + C v + G at the heights, speeds v and accelerations w that are given.
    """
    robot = _load(parameters)
    rest = Triple(0.0, 0.0, 0.0)
    v, w = (rest if values is None else values for values in (speeds, accelerations))
    M, C, G = robot.equation_of_motion(heights, v)
    forces = robot.inverse_dynamics(heights, v, w)
    if json:
        _print_json(
            {
                "heights": heights, "speeds": v, "accelerations": w,
                "M": M, "C": C, "G": G, "forces": forces, "parameters": parameters.value, "units": "SI",
            }
        )  # fmt: skip
        return
    table = _table("Equation of motion", "", "1", "2", "3", "unit")
    for name, rows, unit in (("M", M, "kg"), ("C", C, "kg/s"), ("G", [G], "N"), ("forces", [forces], "N")):
        for number, row in enumerate(rows):
            table.add_row(name if number == 0 else "", *_fixed(row), unit if number == 0 else "")
        table.add_section()
    _show(table)


@app.command()
def workspace(
    over: Annotated[
        Over, typer.Option(metavar="NAME", help="tilt maps the orientations of the star, tip the tip positions within reach.")
    ] = Over.TILT,
    largest_tilt: Annotated[
        float | None, typer.Option(metavar="DEGREES", help="Over tilt: largest tilt (degrees), below 90; 60 unless given.")
    ] = None,
    resolution: Annotated[
        int, typer.Option(min=2, max=1000, metavar="N", help="Poses from the middle to the border; twice as many around.")
    ] = 60,
    parameters: Parameters = ParametersName.DEFAULT,
    figure: FigureFile = None,
    json: Json = False,
) -> None:
    """Map what the poses cost, and where they end.

    The map holds tilt, parasitic motion, arm lengths and conditioning. Prints the extremes; the whole map goes to --figure or --json.
    """
    if over is Over.TIP and largest_tilt is not None:
        raise _usage("--largest-tilt does not apply to --over tip, which ends where the tip folds")
    if largest_tilt is not None and not 0.0 < largest_tilt < RIGHT_ANGLE:
        raise _usage(f"--largest-tilt must be positive and less than {RIGHT_ANGLE:g} degrees, got {largest_tilt:g}")
    robot = _load(parameters)
    import numpy as np

    from psp3 import workspace as study

    around = np.radians(np.linspace(-180.0, 180.0, 2 * resolution + 1))
    outward = np.linspace(0.0, 1.0, resolution)[:, np.newaxis]
    if over is Over.TILT:
        poses = study.map_over_tilt(robot, np.radians(60.0 if largest_tilt is None else largest_tilt) * outward, around)
    else:
        poses = study.map_over_reach(robot, outward, around)
    # Multiples of 5 degrees hold the six directions in which everything is extreme.
    directions = np.radians(np.arange(-180.0, 181.0, 5.0))
    fold, border, ends = (study.fold_tilt(robot, directions), study.reach_boundary(robot, directions), study.largest_tilt(directions))
    reach = np.hypot(border[:, 0], border[:, 1])
    if figure is not None:
        from psp3.plots import figure_of_workspace

        _draw(figure, lambda: figure_of_workspace(robot, poses, over.value))
    if json:
        content: dict[str, Any] = {"over": over.value, "parameters": parameters.value, "units": {"length": "m", "angle": "degrees"}}
        content["border"] = {
            "azimuth": np.degrees(directions),
            "fold_tilt": np.degrees(fold),
            "largest_tilt": np.degrees(ends),
            "tip": border,
        }
        content["reach"] = {"least": reach.min(), "greatest": reach.max()}
        names = (
            "heights", "center", "parasitic_motion", "arms", "tip", "tip_condition", "mass_condition", "actuation_determinant", "travel",
        )  # fmt: skip
        content["map"] = {"tilt": np.degrees(poses.tilt), "azimuth": np.degrees(poses.azimuth)}
        _print_json(content | {"map": content["map"] | {name: getattr(poses, name) for name in names}})
        return
    which = f"tilt up to {np.degrees(poses.tilt.max()):g}°" if over is Over.TILT else "tip within reach"
    table = _table(f"Workspace: {which}", "", "least", "greatest", "unit")
    for name, values, unit, digits in (
        ("tilt", np.degrees(poses.tilt[~np.isnan(poses.travel)]), "degrees", 2),
        ("tip from the vertical axis", 1e3 * np.hypot(poses.tip[..., 0], poses.tip[..., 1]), "mm", 2),
        ("parasitic motion", 1e3 * poses.parasitic_motion, "mm", 2),
        ("arm lengths", 1e3 * poses.arms, "mm", 2),
        ("condition of the tip Jacobian", np.where(poses.tilt < fold.min(), poses.tip_condition, np.inf), "", 3),
        ("condition of the mass matrix", poses.mass_condition, "", 3),
        ("actuation determinant", poses.actuation_determinant, "m³", 5),
        ("vertical travel left by the stroke", 1e3 * poses.travel, "mm", 1),
    ):
        table.add_row(name, *_fixed([np.nanmin(values), np.nanmax(values)], digits), unit)
    table.add_section()
    for name, values, unit in (
        ("border: tilt at which the tip folds", np.degrees(fold), "degrees"),
        ("border: reach of the tip", 1e3 * reach, "mm"),
        ("border: tilt at which an arm vanishes", np.degrees(ends), "degrees"),
    ):
        table.add_row(name, *_fixed([values.min(), values.max()], 2), unit)
    _show(table)
    if figure is not None:
        typer.echo(figure)


@app.command()
def view(
    heights: Annotated[
        Triple | None, typer.Option(parser=_triple, metavar="A1,A2,A3", help="Show this pose (m); home unless given.")
    ] = None,
    result: Annotated[
        list[Path] | None, typer.Option(metavar="FILE", help="Show the motion that psp3 simulate --out saved; may be given more than once.")
    ] = None,
    controller: Annotated[
        list[ControllerName] | None,
        typer.Option(metavar="NAME", help="Simulate this controller, as psp3 simulate does, and show it; may be given more than once."),
    ] = None,
    trained: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE", help="Simulate a controller that psp3 train wrote, and show it; may be given more than once."),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(parser=_page_output, metavar="FILE", help="Write a page (.html) that any browser opens, and do not serve."),
    ] = None,
    port: Annotated[int, typer.Option(min=1, max=65000, help="Port to serve on; if it is taken, the next one.")] = 7000,
    parameters: Parameters = ParametersName.DEFAULT,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=MOTION,
            help="helix (unless given), circle, line, point-to-point, hold, or csv:FILE; without a controller shown as it is desired.",
        ),
    ] = None,
    radius: Radius = None,
    turn_time: TurnTime = None,
    rise: Rise = None,
    start_height: StartHeight = None,
    start: Start = None,
    end: End = None,
    travel_time: TravelTime = None,
    tip: HoldTip = None,
    duration: Duration = None,
) -> None:
    """Show the robot in the browser, at rest or in motion.

    Robots of several results and controllers stand side by side. Serves to this machine only, at 127.0.0.1, until Ctrl-C.
    """
    given = {
        "radius": radius, "turn_time": turn_time, "rise": rise, "start_height": start_height,
        "start": start, "end": end, "travel_time": travel_time, "tip": tip,
    }  # fmt: skip
    if heights is not None and result:
        raise _usage("give --heights or --result, not both")
    simulated = bool(controller or trained)
    if trajectory is None and not simulated:
        what = "a view without --trajectory, --controller or --trained"
        _only(what, given | {"duration": duration}, ())
    elif heights is not None:
        raise _usage("--heights is for a robot at rest: it does not apply to --trajectory, --controller or --trained")
    elif result and not simulated:
        raise _usage("--trajectory does not apply to --result, which has its own")
    robot = _load(parameters)
    from psp3.simulation import load_result

    # Files of the same name in different directories are told apart by their paths.
    paths = list(dict.fromkeys(result or []))
    stems = [path.stem for path in paths]
    motions: dict[str, Result | Trajectory] = {path.stem if stems.count(path.stem) == 1 else str(path): load_result(path) for path in paths}
    seconds = None
    if trajectory is not None or simulated:
        motion, seconds = _trajectory(robot, trajectory or "helix", duration, given)
        if simulated:
            motions |= _simulated(robot, controller or [], trained or [], motion, seconds)
        else:
            motions["desired"] = motion
    from psp3.visualize import Scene, Viewer

    def stage(scene: Scene) -> None:
        if motions:
            scene.animate(motions if len(motions) > 1 else next(iter(motions.values())), seconds)
        else:
            scene.show(heights if heights is not None else (0.0, 0.0, 0.0))

    if record is not None:
        page = Scene(robot)
        stage(page)
        page.write_html(record)
        typer.echo(record)
        return
    import threading

    with Viewer(robot, port) as viewer:
        stage(viewer)
        typer.echo(f"{viewer.url} shows the robot; Ctrl-C ends.")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            typer.echo(err=True)


def _simulated(
    robot: PSP3, names: Iterable[ControllerName], files: Iterable[Path], motion: Trajectory, seconds: float
) -> dict[str, Result]:
    """Simulate controllers on one motion, each once."""
    from psp3.simulation import simulate as run

    gains: dict[str, float | None] = {"kp": None, "kv": None, "ki": None}
    steering: dict[str, Controller] = {name.value: _controller(robot, name, None, gains)[0] for name in dict.fromkeys(names)}
    steering |= {str(path): _from_file(robot, path)[0] for path in files}
    results = {}
    for name, one in steering.items():
        with _progress(f"simulating {name}", seconds) as progress:
            results[name] = run(robot, one, motion, seconds, progress=progress)
    return results


@app.command()
def info(json: Json = False) -> None:
    """Show versions, joints, loops, reach, parameter sets and the other robots."""
    import platform
    from dataclasses import asdict
    from importlib.metadata import PackageNotFoundError, version

    import numpy as np

    from psp3 import __version__
    from psp3.loading import ROBOT_FILES, ROBOTS, load
    from psp3.loops import read_loops
    from psp3.parameters import PARAMETER_SETS

    versions = {"psp3": __version__, "python": platform.python_version()}
    for package in ("pin", "numpy", "scipy", "numba", "meshcat", "matplotlib", "typer", "rich"):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    robot = load("psp3")
    loops = read_loops(ROBOT_FILES / "psp3.yaml")
    (lower, *_), (upper, *_) = (bounds.tolist() for bounds in robot.stroke)
    least, greatest = robot.tip_reach(np.radians([0.0, 60.0])).tolist()
    joints = [
        {
            "name": str(name),
            "type": {"JointModelPZ": "slides along z", "JointModelPX": "slides along x"}.get(joint.shortname(), joint.shortname()),
            "actuated": name in robot.actuated,
            "lower": float(robot.model.lowerPositionLimit[joint.idx_q]),
            "upper": float(robot.model.upperPositionLimit[joint.idx_q]),
        }
        for name, joint in list(zip(robot.model.names, robot.model.joints, strict=True))[1:]
    ]
    sets = {name: asdict(numbers) | {"total_mass": numbers.total_mass} for name, numbers in PARAMETER_SETS.items()}
    if json:
        content = {"versions": versions, "files": str(ROBOT_FILES), "joints": joints, "stroke": {"lower": lower, "upper": upper}}
        content["loops"] = [{"frames": frames, "kind": kind} for frames, kind in zip(loops.frames, loops.kinds, strict=True)]
        _print_json(content | {"robots": ROBOTS, "tip_reach": {"least": least, "greatest": greatest}, "parameters": sets, "units": "SI"})
        return
    about = _table("Robot", "", "")
    about.show_header, about.columns[1].justify = False, "left"
    about.add_row("versions", ", ".join(f"{name} {number}" for name, number in versions.items()))
    about.add_row("files", str(ROBOT_FILES))
    about.add_row("actuated joints", ", ".join(robot.actuated))
    about.add_row("passive joints", ", ".join(str(joint["name"]) for joint in joints if not joint["actuated"]))
    about.add_row("loops", ", ".join(f"{one} = {other} ({kind})" for (one, other), kind in zip(loops.frames, loops.kinds, strict=True)))
    about.add_row("stroke", f"{lower:g} m to {upper:g} m")
    about.add_row("other robots", ", ".join(name for name in ROBOTS if name != "psp3") + " (psp3.load in Python)")
    about.add_row("reach of the tip", f"{1e3 * least:.1f} mm at azimuth 0°, {1e3 * greatest:.1f} mm at 60°, from the vertical axis")
    table = _table("Parameter sets", "", *sets)
    units = {"gravity": "m/s²", "total_mass": "kg", "screw_radius": "m", "tool_length": "m"}
    for name in next(iter(sets.values())):
        unit = units.get(name, "kg m²" if name.endswith("inertia") else "kg")
        cells = ["\n".join(f"{number:.6g}" for number in np.ravel(numbers[name])) for numbers in sets.values()]
        table.add_row(f"{name.replace('_', ' ')} ({unit})", *cells)
    _show(about, table)


# Start and end


def _message(error: Exception) -> str | None:
    """Return what a person needs to read of an error, in one line; None if it is none that a person made."""
    if hasattr(error, "format_message"):
        context = getattr(error, "ctx", None)
        command = "psp3" if context is None else context.command_path
        # The prefixes are typer's: what we say ourselves names its options, and the values that it refuses speak for themselves.
        text = error.format_message().removeprefix("Invalid value: ").replace("Value error, ", "").rstrip(".")
        return f"{command}: {' '.join(text.split())} (see {command} --help)"
    if isinstance(error, MemoryError):
        return "psp3: this takes more memory than there is; ask for less time or fewer samples"
    from fuzzy2.errors import Fuzzy2Error
    from psp3.errors import PSP3Error

    if isinstance(error, PSP3Error | Fuzzy2Error):
        return f"psp3: {' '.join(str(error).split())}"
    if isinstance(error, OSError):
        reason = error.strerror or str(error)
        return f"psp3: {error.filename}: {reason}" if error.filename is not None else f"psp3: {reason}"
    return None


def main() -> None:
    """Run the command line and exit: status 0, 2 for wrong usage or input, 130 for Ctrl-C."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Where the terminal knows no Greek a question mark is better than an error.
            stream.reconfigure(errors="replace")
    try:
        returned = app(prog_name="psp3", standalone_mode=False)
        status = returned if isinstance(returned, int) else 0
        sys.stdout.flush()
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has had enough. Python flushes once more at exit, which must not complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 1
    except Exception as error:
        message = _message(error)
        if message is None:
            raise
        typer.echo(message, err=True)
        status = USAGE
    if status == INTERRUPTED:
        typer.echo("psp3: interrupted", err=True)
    sys.exit(status)


if __name__ == "__main__":
    main()

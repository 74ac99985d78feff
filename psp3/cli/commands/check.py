"""The command that checks robot files, for newcomers with a file of their own."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from psp3.cli.compilation import one_off
from psp3.cli.options import USAGE, Json
from psp3.cli.output import as_options, error_message, new_table, print_json, show
from psp3.cli.robot_options import Free, RobotOptions

if TYPE_CHECKING:
    from psp3.robots.examination import Examination


@one_off
def check(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...",
            help=(
                "Robot files: .urdf, .xml (MJCF) or .sdf, or names of robots of the package. A "
                ".yaml file is the loop file of the URDF before it."
            ),
            show_default=False,
        ),
    ],
    actuated: Annotated[
        str | None,
        typer.Option(metavar="NAME,NAME", help="Motors; default those that the file names."),
    ] = None,
    free: Annotated[
        Free | None,
        typer.Option(
            metavar="NAME",
            help="Motions that no motor commands: lock (default), keep or refuse.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Report what robot files hold, and how to fix their problems.

    For each file: joints, motors and loops, mobility, held motions, redundancy and mismatch of the
    loops, and missing inertia; also MuJoCo's view of the same file, if it is installed. The status
    is 2 if a file cannot be loaded.
    """
    reports = [_report(one, loops, actuated, free) for one, loops in _with_loops(files)]
    if json:
        print_json({"files": [_plain(report) for report in reports]})
    else:
        for report in reports:
            _show(report)
    if any("error" in report for report in reports):
        raise typer.Exit(USAGE)


def _with_loops(files: list[str]) -> list[tuple[str, Path | None]]:
    """Return each file with the loop file that follows it."""
    pairs: list[tuple[str, Path | None]] = []
    for name in files:
        if Path(name).suffix.lower() in (".yaml", ".yml") and pairs and pairs[-1][1] is None:
            pairs[-1] = (pairs[-1][0], Path(name))
        else:
            pairs.append((name, None))
    return pairs


def _report(
    name: str, loops: Path | None, actuated: str | None, free: Free | None
) -> dict[str, Any]:
    """Return the report on a file, ready for JSON."""
    from psp3.robots.examination import examine

    with _warnings_kept() as warned:
        try:
            found = examine(
                RobotOptions(robot=name, loops=loops, actuated=actuated, free=free).load()
            )
        except Exception as error:
            message = error_message(error)
            if message is None:
                raise
            return {"file": name, "error": message.removeprefix("psp3: ")}
    return {"file": name, "found": found, "warnings": list(warned)}


def _plain(report: dict[str, Any]) -> dict[str, Any]:
    if "error" in report:
        return report
    found: Examination = report["found"]
    findings = [one._asdict() for one in found.findings]
    return {**report, "found": found._asdict() | {"findings": findings}}


@contextmanager
def _warnings_kept() -> Iterator[list[str]]:
    """Collect the package's warnings instead of printing them."""
    kept: list[str] = []

    class Keeper(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            # The findings already contain a robot's own warnings, but not a reader's warnings of
            # what it left out.
            if record.name.startswith("psp3.description"):
                kept.append(record.getMessage())

    package, keeper = logging.getLogger("psp3"), Keeper(logging.WARNING)
    before = package.propagate
    package.addHandler(keeper)
    package.propagate = False
    try:
        yield kept
    finally:
        package.propagate = before
        package.removeHandler(keeper)


def _show(report: dict[str, Any]) -> None:
    table = new_table(report["file"], "", "")
    table.show_header, table.columns[1].justify = False, "left"
    if "error" in report:
        table.add_row("refused", report["error"])
        show(table)
        return
    found: Examination = report["found"]
    for name, text in _rows(found):
        table.add_row(name, text)
    table.add_section()
    for warning in report["warnings"]:
        table.add_row("left out", warning)
    for what, remedy in found.findings:
        table.add_row("note", f"{what}: {as_options(remedy)}")
    if not report["warnings"] and not found.findings:
        table.add_row("problems", "none")
    show(table)


def _rows(found: Examination) -> list[tuple[str, str]]:
    length, angle, _ = found.mismatch
    others = found.coordinates if found.coordinates != found.motors else ()
    rows = [
        ("robot", found.title),
        ("bodies that move", f"{found.bodies}, {found.mass:.4g} kg, {found.size:.3g} m across"),
        ("motors", ", ".join(found.motors)),
        ("coordinates", ", ".join(others)),
        ("loops", "\n".join(f"{name} ({kind})" for name, kind in found.loops) or "none"),
        ("mobility", found.mobility),
        ("held", "\n".join(found.held)),
        ("redundant equations", str(found.redundant_equations)),
        ("mismatch of the loops", f"{length:.1g} m, {angle:.1g} rad"),
        ("MuJoCo", found.mujoco),
    ]
    return [(name, text) for name, text in rows if text]

"""Wrong values of every option and argument of the command line: status 2, and one line about them.

Which options there are is asked of the commands themselves, so that a new one is tried at once. Of
each the rest of the command is right, and its value is each of what people type by mistake. It is
refused before anything is computed: where computing begins stands a door (:data:`DOORS`), and what
comes through it was accepted. The error repeats the value, so that its place in a long command is
found.
"""

from __future__ import annotations

import contextlib
import io
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import pytest
import typer

from psp3.cli import entry as cli
from psp3.cli.app import app
from tests.misuse import PARTS, sample

WRONG = {
    "letters": "abc",
    "NaN": "nan",
    "infinite": "inf",
    "overflow": "1e999",
    "empty": "",
    "blank": " ",
    "negative": "-1",
    "zero": "0",
    "huge": "9" * 30,
    "5000 digits": "9" * 5000,
    "garbage": "garbage",
    "folder": "folder",
    "control": "a\x1b[2J\x07b",
    "lines": "a\nb",
    "no text": "a\udcffb",
}
"""What is typed by mistake. Garbage is a file that holds no text, and folder is one; what is no
text is what Python makes of bytes that are no UTF-8.
"""

BEGINNINGS = {
    "reproduce": "reproduce --quick",
    "simulate": "simulate",
    "train": "train new.json",
    "study": "study new.sqlite --controller pd --seeds 1",
    "benchmark": "benchmark pd-gravity --robot psp3 --seeds 1 --workers 1",
    "torques": "torques",
    "pose": "pose --height 0",
    "dynamics": "dynamics",
    "workspace": "workspace",
    "view": "view --record new.html",
    "check": "check psp3",
    "info": "info",
    "export c": "export c psp3 --out new",
    "export fmu": "export fmu psp3 --out new.fmu",
}

LINE = "--trajectory line --start 0,0,0.07 --end 0.01,0,0.07"
OF_MOTIONS = {
    "amplitude": "five_bar --trajectory sway",
    "radius": "--trajectory helix",
    "turn_time": "--trajectory helix",
    "rise": "--trajectory helix",
    "start_height": "--trajectory helix",
    "start": LINE,
    "end": LINE,
    "travel_time": LINE,
    "tip": "--trajectory hold",
    "duration": "--trajectory helix",
}
AFTER = {
    **{
        f"{command} {name}": words
        for command in ("simulate", "train", "torques", "view")
        for name, words in OF_MOTIONS.items()
    },
    "simulate ki": "--controller pid",
    "study motor_inertia": "--reading plant --lead 0.01",
    "study lead": "--reading plant --motor-inertia 0.01",
    **{
        f"study {name}": "--reading plant"
        for name in ("payload", "coulomb_friction", "viscous_friction")
    },
    "study encoder_resolution": "--reading plant",
    "study delay": "--reading plant",
    "study mean_variation": "--controller it2",
    "study defuzzify": "--controller gt2",
    "study learner": "--controller t1",
    "study terms": "--controller t1",
    "train mean_variation": "--kind it2",
    "export fmu motor_inertia": "--lead 0.01",
    "export fmu lead": "--motor-inertia 0.01",
    "workspace frame": "five_bar",
    "workspace task": "five_bar",
    "pose frame": "",
}
"""What else a command has to say where an option means something."""

WHOLE = {
    "benchmark entries": "benchmark {}",
    "benchmark scheduler": "benchmark pd-gravity --robot psp3 --seeds 1 --scheduler {}",
    "check files": "check {}",
    "check actuated": "check five_bar --actuated {}",
    "export c robot": "export c five_bar {} --out new",
    "export c thing": "export c {} --out new",
    "export fmu robot": "export fmu five_bar {} --out new.fmu",
    "export fmu thing": "export fmu {} --out new.fmu",
    "pose frame": "pose five_bar --frame {}",
    "pose height": "pose --height {}",
    "pose positions": "pose --heights {}",
    "pose tip": "pose --tip {}",
    "study file": "study {}",
    "study robot": "study new.sqlite {} --controller pd --seeds 1",
    "train file": "train {}",
    "train robot": "train new.json {}",
    "train loops": "train new.json five_bar {}",
    "view positions": "view --record new.html --positions {}",
    "view port": "view --port {}",
    "view robot": "view {} --record new.html",
    "view loops": "view five_bar {} --record new.html",
    **{
        f"{command} robot": f"{command} {{}}"
        for command in ("simulate", "torques", "dynamics", "workspace", "info", "pose")
    },
    **{
        f"{command} loops": f"{command} five_bar {{}}"
        for command in ("simulate", "torques", "dynamics", "workspace", "info", "pose")
    },
    **{
        f"{command} {name}": f"{command} five_bar --{name} {{}}"
        for command in ("simulate", "torques", "dynamics", "workspace", "info", "pose")
        for name in ("actuated", "free")
    },
    **{f"train {name}": f"train new.json five_bar --{name} {{}}" for name in ("actuated", "free")},
    **{
        f"view {name}": f"view five_bar --record new.html --{name} {{}}"
        for name in ("actuated", "free")
    },
    **{
        f"export c {name}": f"export c five_bar --out new --{name} {{}}"
        for name in ("actuated", "free", "loops")
    },
    **{
        f"export fmu {name}": f"export fmu five_bar --out new.fmu --{name} {{}}"
        for name in ("actuated", "free", "loops")
    },
}
"""Commands of which the value stands in the middle."""

A_NAME = tuple(kind for kind in WRONG if kind not in ("empty", "blank", "5000 digits"))
NUMBERS = ("zero", "negative", "huge")
TAKES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("csv", "file", "out"), A_NAME),
    **dict.fromkeys(("ki", "kp", "kv"), ("zero", "huge")),
    **dict.fromkeys((*OF_MOTIONS, "azimuth", "height", "tilt"), NUMBERS),
    "name": ("letters", "NaN", "infinite", "overflow", "zero", "huge", "garbage", "folder"),
    "seed": ("zero", "huge"),
    "torque_limit": ("huge",),
    "snr": ("zero", "negative", "huge", "infinite", "overflow", "5000 digits"),
    **dict.fromkeys(
        (
            "coulomb_friction",
            "delay",
            "encoder_resolution",
            "lead",
            "mean_variation",
            "motor_inertia",
            "payload",
            "viscous_friction",
        ),
        ("zero", "huge"),
    ),
}
"""By the name of an option, what is no mistake there: files that are written may have any name,
what is written in C any that is a word, and motions any size that the robot can make.
"""

DOORS = (
    "psp3.benchmark.benchmark.done_by",
    "psp3.benchmark.benchmark.execute",
    "psp3.export.fmu._written",
    "psp3.export.project.write_project",
    "psp3.kinematics.workspace.Workspace.distance",
    "psp3.robots.examination.examine",
    "psp3.simulation.tracking._Experiment.run",
    "psp3.study.study._Session.work",
    "psp3.thesis.replication._run_study",
    "psp3.three_psp.workspace.map_over_tilt",
    "psp3.trajectories.screw_forces.screw_forces",
    "psp3.visualize.scene.Scene.write_html",
    "psp3.visualize.viewer.SceneServer",
)
"""Where the work of a command begins, after its checks."""


class Started(Exception):
    """The command began to work."""


class Told(NamedTuple):
    """What became of a command: a status, or an exception, and what it said."""

    status: int | BaseException
    out: str
    err: str


class Option(NamedTuple):
    """An option or an argument of a command."""

    command: str
    name: str
    words: str

    @property
    def title(self) -> str:
        """Command and option."""
        return f"{self.command} {self.name}"

    def line(self, value: str) -> list[str]:
        """Return the words of a command with a value of the option."""
        return [value if word == "{}" else word for word in shlex.split(self.words)]


def options() -> Iterator[Option]:
    """Yield every option and argument that takes a value."""
    root: Any = typer.main.get_command(app)
    for name, command in root.commands.items():
        singles = getattr(command, "commands", None)
        found = {f"{name} {one}": it for one, it in singles.items()} if singles else {name: command}
        for title, single in found.items():
            for parameter in single.params:
                if not getattr(parameter, "is_flag", False):
                    yield Option(title, parameter.name, _words(title, parameter))


def _words(command: str, parameter: Any) -> str:
    title = f"{command} {parameter.name}"
    if title in WHOLE:
        return WHOLE[title]
    if parameter.param_type_name == "argument":
        raise AssertionError(f"{title}: say in WHOLE where it stands")
    return f"{BEGINNINGS[command]} {AFTER.get(title, '')} {parameter.opts[0]} {{}}"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty folder with garbage and a folder, where commands run; doors are closed."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "garbage").write_bytes(bytes(range(128, 256)))
    (tmp_path / "folder").mkdir()
    monkeypatch.setenv("COLUMNS", "80")
    for door in DOORS:
        monkeypatch.setattr(door, _open)
    return tmp_path


def _open(*_: object, **__: object) -> NoReturn:
    raise Started


def told(words: list[str]) -> Told:
    """Run a command in this process."""
    texts = [io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True) for _ in range(2)]
    before, sys.argv = sys.argv, ["psp3", *words]
    status: int | BaseException = 0
    try:
        with contextlib.redirect_stdout(texts[0]), contextlib.redirect_stderr(texts[1]):
            cli.main()
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else end
    except Exception as error:
        status = error
    finally:
        sys.argv = before
    out, err = (one.buffer.getvalue().decode() for one in texts)  # type: ignore[attr-defined]
    return Told(status, out, err)


def fault(option: Option, kind: str, value: str) -> str:
    """Return what is wrong with how a wrong value is told of, if anything is."""
    status, out, err = told(option.line(value))
    if isinstance(status, Started) or status == 0:
        return "" if kind in TAKES.get(option.name, ()) else f"taken: {out[-200:]}"
    if isinstance(status, BaseException):
        return f"{type(status).__name__}: {str(status)[:200]}"
    if option.command in REPORTS and out:
        is_told = status == 2 and "refused" in out and not err
        return "" if is_told else f"status {status}, {out[:100]!r}, {err[:300]!r}"
    if status != 2 or out:
        return f"status {status}, {out[:100]!r}, {err[:300]!r}"
    if err.count("\n") != 1 or not err[:-1].isprintable():
        return f"not one line: {err[:400]!r}"
    if len(err) > 2500:
        return f"{len(err)} characters"
    if option.title in APART and APART[option.title] in err:
        return ""
    if option.name in OF_MOTIONS and any(words in err for words in LEADS_AWAY):
        return ""
    return "" if repeats(option, value, err) else f"does not repeat it: {err[:300]}"


REPORTS = ("check",)
"""A command about files says of each what is wrong with it: refusals are its answer, in a table."""

APART = {"export c torque_limit": "does not apply to psp3, which is not a controller"}
"""What is said of an option that the rest of its command has no use for."""

LEADS_AWAY = ("asks for", "from the vertical axis", "could not be closed")
"""An error about where a motion leads says where and when that is."""


def repeats(option: Option, value: str, said: str) -> bool:
    """Tell whether an error says which value it is about; of an empty one, which option."""
    if not value.strip():
        place = "--" + option.name.replace("_", "-")
        return (
            repr(value) in said or repr("") in said or place in said or option.name.upper() in said
        )
    words = {value, value[:20], repr(value)[1:-1], value.replace("\n", " "), "a?b", "a\\udcffb"}
    with contextlib.suppress(ValueError, OverflowError):
        number = float(value)
        words |= {str(number), f"{number:g}"}
    return any(word in said for word in words)


def test_every_wrong_value_is_refused_in_one_line(folder: Path) -> None:
    """Of each option a sample, or everything with ``make misuse``, see :mod:`tests.misuse`."""
    before = sorted(folder.iterdir())
    faults = [
        f"{shlex.join(option.line('{}'))} = {kind}: {what}"
        for option in options()
        for kind, value in sample(option.title, WRONG.items(), PARTS)
        if (what := fault(option, kind, value))
    ]
    assert not faults, f"{len(faults)} faults:\n" + "\n".join(faults[:40])
    # The file of a study, and folders, are made before anything is computed.
    made = {path.name for path in folder.iterdir()} - {path.name for path in before}
    assert not [name for name in made if name.startswith("new") and name != "new.sqlite"]


def test_every_command_is_tried() -> None:
    tried = {option.command for option in options()}
    assert tried == set(BEGINNINGS)
    assert len(list(options())) > 130


def test_what_is_wrong_is_seen(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A value that is taken, a traceback, two lines, and one that does not say the value."""
    option = Option("pose", "height", "pose --height {}")

    def with_app(error: Exception | None) -> str:
        def broken(**_: object) -> None:
            if error is not None:
                raise error

        monkeypatch.setattr(cli, "app", broken)
        return fault(option, "letters", "abc")

    assert with_app(None).startswith("taken")
    assert with_app(RuntimeError("a defect")) == "RuntimeError: a defect"
    assert with_app(typer.BadParameter("no")).startswith("does not repeat it")
    assert with_app(typer.BadParameter("'abc' is no number")) == ""
    assert with_app(KeyboardInterrupt("abc")).startswith("status 130")  # type: ignore[arg-type]

"""The command line as a user meets it.

What it prints and writes, what it refuses and how, and what it leaves unloaded.
"""

from __future__ import annotations

import itertools
import json
import re
import subprocess
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn

import pytest
import typer

import psp3
from psp3.cli import app, options
from psp3.cli import entry as cli
from psp3.description.parts import ROBOTS
from tests.processes import ENVIRONMENT, PROCESSES, program
from tests.psp3.cli.answers import Run
from tests.psp3.cli.wrong_calls import WRONG_CALLS, WrongCall

COMMANDS = (
    "reproduce",
    "simulate",
    "train",
    "study",
    "benchmark",
    "torques",
    "pose",
    "dynamics",
    "workspace",
    "view",
    "check",
    "info",
    "warm-up",
    "export",
)

GROUPS = ("export c", "export fmu")
"""Commands of groups."""

HEAVY = {"numpy", "scipy", "numba", "matplotlib", "pinocchio", "meshcat", "coal", "yaml"}


# Help, and what it costs


@pytest.fixture(scope="module")
def helps() -> dict[str, tuple[str, list[str]]]:
    """Help of the program and of every command, and what was loaded when it had been shown.

    All in one process: what a command loads stays loaded, and the first that has it is to blame.
    """
    code = f"""
import contextlib, io, json, sys
from psp3.cli import entry as cli
found = {{}}
for name in {["", *COMMANDS, *GROUPS]!r}:
    sys.argv = ["psp3", *name.split(), "--help"]
    with contextlib.redirect_stdout(io.StringIO()) as shown:
        try:
            cli.main()
        except SystemExit as end:
            assert end.code == 0, end.code
    found[name] = shown.getvalue(), sorted({HEAVY!r} & set(sys.modules))
    if not name:
        # It draws frames, and takes longer to import than all else that this help needs.
        found[name][1].extend({{"rich"}} & set(sys.modules))
print(json.dumps(found))
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        encoding="utf-8",
        check=True,
    )
    found: dict[str, tuple[str, list[str]]] = json.loads(done.stdout)
    return found


@pytest.mark.parametrize("command", ["", *COMMANDS, *GROUPS])
def test_help_loads_nothing_heavy_and_fits_80_columns(
    helps: dict[str, tuple[str, list[str]]], command: str
) -> None:
    shown, loaded = helps[command]
    assert loaded == []
    assert max(map(len, shown.splitlines())) <= 80
    assert "Usage: psp3" in shown


def test_help_lists_every_command(psp3_command: Run) -> None:
    answer = psp3_command("--help")
    assert answer.status == 0
    assert all(f" {name} " in answer.out for name in COMMANDS)
    assert "angles in radians; options in degrees are marked DEGREES" in " ".join(
        answer.out.split()
    )


def test_no_command_is_wrong_usage_with_the_help(psp3_command: Run) -> None:
    answer = psp3_command()
    assert answer.status == 2
    assert "Commands" in answer.out


@pytest.mark.parametrize(
    ("line", "expected"), [("psp3 po", ["pose"]), ("psp3 simulate --initial", ["--initial-speed"])]
)
def test_the_shell_completes_commands_and_options(
    line: str, expected: list[str], psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As bash asks, with what ``psp3 --install-completion`` writes."""
    words = line.split()
    for name, value in (
        ("_PSP3_COMPLETE", "complete_bash"),
        ("COMP_WORDS", line),
        ("COMP_CWORD", str(len(words) - 1)),
    ):
        monkeypatch.setenv(name, value)
    answer = psp3_command()
    assert (answer.status, answer.out.split(), answer.err) == (0, expected, "")


@pytest.mark.parametrize("command", ["", *COMMANDS, *GROUPS])
def test_help_shows_no_type_of_python_and_every_name_whole(
    helps: dict[str, tuple[str, list[str]]], command: str
) -> None:
    shown = helps[command][0]
    assert re.findall(r"<\w+|\[?\d+<=x|x>=\d", shown) == []
    names = re.findall(r"^│ \*? *(--\S+)", shown, flags=re.MULTILINE)
    assert [name for name in names if name.endswith("…")] == []


@pytest.mark.parametrize("command", [*COMMANDS[:-1], *GROUPS])
def test_help_breaks_lines_where_the_terminal_ends(
    helps: dict[str, tuple[str, list[str]]], command: str
) -> None:
    """No word stands alone because the source code breaks its lines elsewhere."""
    text = helps[command][0].partition("╭")[0].partition("Usage")[2]
    lines = [line.strip() for line in text.splitlines()]
    for line, following in itertools.pairwise(lines):
        if line and following:
            assert len(line) + 1 + len(following.split()[0]) > 77, line


def test_version(psp3_command: Run) -> None:
    assert psp3_command("--version") == (0, f"psp3 {psp3.__version__}\n", "")


def test_every_option_says_what_it_is_and_in_which_unit() -> None:
    """Angle options are called DEGREES, and rich swallows text in square brackets.

    Neither may lose a unit.
    """
    units = {
        "M": "(m",
        "S": "(s)",
        "M/S": "(m/s)",
        "N": "(N",
        "X,Y,Z": "(m)",
        "A1,A2,…": "(m, rad)",
        "V1,V2,…": "(m/s, rad/s)",
        "W1,W2,…": "(m/s², rad/s²)",
    }
    units |= {"DEGREES": "(degrees)"}
    group: Any = typer.main.get_command(app.app)
    assert set(group.commands) == set(COMMANDS)
    checked = 0
    alone = [command for command in group.commands.values() if not hasattr(command, "commands")]
    grouped = [
        command
        for one in group.commands.values()
        for command in getattr(one, "commands", {}).values()
    ]
    assert [f"export {command.name}" for command in grouped] == list(GROUPS)
    for command in alone + grouped:
        for option in command.params:
            assert option.help, f"{command.name} {option.name} has no help"
            assert "[" not in option.help
            # The workspace's N is a number of poses.
            if option.metavar in units and option.name != "resolution":
                assert units[option.metavar] in option.help, (
                    f"{command.name} {option.name}: {option.help}"
                )
                checked += 1
    assert checked > 20


# What is refused, and how

OF_OTHER_ROBOTS = [
    ("pose delta --positions 0,0", "leg1_shoulder, leg2_shoulder, leg3_shoulder"),
    ("pose delta --tilt 3", "--tilt is an option of the 3-PSP and does not apply to delta"),
    ("pose delta --parameters default", "--parameters is an option of the 3-PSP"),
    ("pose psp3 --frame tip", "--frame is for other robots"),
    ("workspace delta --largest-tilt 3", "--largest-tilt is an option of the 3-PSP"),
    ("workspace delta --over x", "--over must be two of x, y, z"),
    ("workspace --over x", "--over must be tilt or tip for the 3-PSP, got 'x'"),
    ("simulate biped --controller it2", "a robot whose coordinates are its motors"),
    ("simulate delta --trajectory helix", "--trajectory helix is a motion of the 3-PSP's tip"),
    ("simulate delta --trajectory line", "--trajectory line needs --end"),
    ("simulate delta --amplitude -1", "amplitude must be finite and positive"),
    ("simulate delta --torque-limit 1,2", "--torque-limit 1,2 has 2 numbers; 3 are needed"),
    ("simulate delta --trained here.csv", "here.csv: "),
    ("simulate delta --model closed_form", "unknown dynamics model 'closed_form'"),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("nosuch", "No such command 'nosuch'"),
        ("simulat", "No such command 'simulat'"),
        ("--nosuch", "No such option: --nosuch"),
        ("pose", "psp3 pose: give one of --heights, --tip, or --height"),
        ("pose --heights 0,0,0 --tip 0,0,0.07", "give one of"),
        ("pose --heights 0,0,0 --azimuth 0", "give one of"),
        ("pose --heights 1,2", "--heights 1,2 has 2 numbers; 3 are needed"),
        ("pose --heights a,b,c", "'a,b,c' is not a list of numbers"),
        ("pose --heights 0,nan,0", "nan"),
        ("pose --heights -0.6,0,0.6", "arm lengths"),
        ("pose --tip 0.03,0,0.07", "robot reaches 23.9 mm"),
        ("pose --tilt 90", "--tilt must be less than 90 degrees, got 90"),
        ("pose --tilt nan", "got nan"),
        ("pose --tilt 75 --azimuth 30", "70.53"),
        ("dynamics --heights 0,0", "--positions 0,0 has 2 numbers; 3 are needed"),
        ("dynamics --heights 0,0,0 --speeds 0,0,inf", "speeds"),
        (
            "dynamics --heights 0,0,0 --parameters mine",
            "'mine' is not one of 'default', 'table_3_1', 'table_5_1'",
        ),
        ("simulate --controller fuzzy", "'fuzzy' is not one of 'pd'"),
        ("simulate --ki 3", "--ki does not apply to --controller ctc, which takes --kp and --kv"),
        (
            "simulate --controller feed-forward --kp 3",
            "--kp does not apply to --controller feed-forward",
        ),
        ("simulate --controller pd --model noc", "--model does not apply to --controller pd"),
        ("simulate --kp -1", "--kp must be finite and not negative, got -1.0"),
        ("simulate --radius 0.03", "tip [0.03"),
        ("simulate --radius -0.01", "radius must be"),
        ("simulate --start-height 0.5", "outside the stroke"),
        ("simulate --period 0", "period must be finite and positive, got 0.0"),
        ("simulate --period two", "'--period'"),
        ("simulate --duration -1", "duration must be finite and positive, got -1.0"),
        ("simulate --duration 1e15", "memory"),
        ("simulate --torque-limit 0", "'0' is not a list of positive numbers"),
        ("simulate --torque-limit 1,2", "--torque-limit 1,2 has 2 numbers; 3 are needed"),
        ("simulate --trajectory spiral", "--trajectory must be helix, circle"),
        ("simulate --trajectory helix:3", "--trajectory must be helix, circle"),
        ("simulate --trajectory line", "--trajectory line needs --start and --end"),
        (
            "simulate --trajectory hold --radius 0.01",
            "--radius does not apply to --trajectory hold, which takes --tip",
        ),
        (
            "simulate --trajectory circle --rise 0.01",
            "--rise does not apply to --trajectory circle",
        ),
        ("simulate --trajectory csv", "csv:FILE"),
        ("simulate --trajectory csv:none.csv", "none.csv: no such file"),
        (
            "simulate --trajectory csv:here.csv --radius 1",
            "--radius does not apply to --trajectory csv",
        ),
        ("simulate --out none/run.npz", "none/run.npz: there is no directory none"),
        ("simulate --out .", ". is a directory"),
        ("simulate --figure run.gif", "must end in .pdf, .png, .svg"),
        ("simulate --json --csv -", "both want standard output"),
        ("simulate more", "unknown robot 'more'"),
        ("simulate psp3 more.yaml", "LOOPS does not apply to the 3-PSP"),
        ("simulate psp3 more.yaml more", "(more)"),
        *OF_OTHER_ROBOTS,
        ("torques --sampling-period 0", "--sampling-period must be finite and positive, got 0.0"),
        ("torques --duration inf", "duration must be finite and positive, got inf"),
        ("torques --trajectory hold --tip 0,0,nan", "nan"),
        (
            "workspace --largest-tilt 90",
            "--largest-tilt must be positive and less than 90 degrees, got 90",
        ),
        ("workspace --over tip --largest-tilt 10", "--largest-tilt does not apply to --over tip"),
        ("workspace --resolution 1", "'--resolution'"),
        ("view --result none.npz --record page.html", "none.npz"),
        ("view --heights 0,0,0 --result run.npz", "give --positions or --result, not both"),
        ("view --port 0", "'--port'"),
        ("view --rise 0.01", "--rise does not apply to --trajectory circle"),
        ("view --heights 0,0,0 --radius 0.01", "--radius does not apply to --positions"),
        ("view --result run.npz --radius 0.01", "--radius does not apply to --result"),
        ("view --heights 0,0,0 --controller pd", "--positions is for a robot at rest"),
        (
            "view --result run.npz --trajectory helix",
            "--trajectory does not apply to --result, which has its own",
        ),
        ("view --controller none", "'--controller'"),
        ("view --trained none.json --duration 0.1 --record page.html", "none.json"),
        ("reproduce --out here.csv", "here.csv"),
        ("reproduce --out here.csv/results", "here.csv"),
    ],
)
def test_wrong_input_is_one_line_and_status_2(
    psp3_command: Run, arguments: str, message: str
) -> None:
    Path("here.csv").write_text("t,x,y,z\n0,0,0,0.07\n")
    answer = psp3_command(*arguments.split())
    assert (answer.status, answer.out) == (2, "")
    assert message in answer.err
    assert answer.err.count("\n") == 1
    assert answer.err.startswith("psp3")
    # Only what was there before is there now: nothing is half written.
    assert [path.name for path in Path.cwd().iterdir()] == ["here.csv"]


@pytest.mark.slow
@pytest.mark.parametrize("call", WRONG_CALLS, ids=lambda call: call.arguments)
def test_a_wrong_call_is_answered_by_the_value_and_a_remedy(
    psp3_command: Run, call: WrongCall
) -> None:
    Path("here.csv").write_text("t,x,y,z\n0,0,0,0.07\n")
    answer = psp3_command(*call.arguments.split())
    assert answer.status == 2
    # A group without a command shows its help, too.
    assert answer.out == "" or call.arguments == "export"
    assert answer.err.startswith("psp3")
    assert answer.err.count("\n") == 1
    assert call.value in answer.err
    assert call.remedy in answer.err
    assert [path.name for path in Path.cwd().iterdir()] == ["here.csv"]


def test_sixty_wrong_calls_are_tried() -> None:
    assert len({call.arguments for call in WRONG_CALLS}) >= 60


def test_output_that_fails_while_it_is_written_is_one_line_and_status_2(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> NoReturn:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    assert psp3_command("torques", "--duration", 0.1, "--csv", "run.csv") == (
        2,
        "",
        "psp3: run.csv: No space left on device; free space on its disk, or give another place\n",
    )


def test_errors_of_the_program_itself_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    """A defect needs its traceback: only what a user can mend becomes one line."""

    def broken(*_: object) -> NoReturn:
        raise RuntimeError("a defect")

    monkeypatch.setattr("psp3.cli.robot_options.RobotOptions.load", broken)
    monkeypatch.setattr(sys, "argv", ["psp3", "pose", "--heights", "0,0,0"])
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    with pytest.raises(RuntimeError, match="a defect"):
        cli.main()


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk_at_standard_output() -> None:
    """The whole program once, from its start to Python's own last flush."""
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "psp3.cli.entry", "info", "--json"],
            env=ENVIRONMENT,
            stdout=full,
            stderr=subprocess.PIPE,
            encoding="utf-8",
        )
    assert (done.returncode, done.stderr) == (2, "psp3: No space left on device\n")


def wait_until_told(parent: Connection) -> None:
    parent.recv()


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        ("workspace", "--resolution", "60", "--json"),
        ("info",),
        ("torques", "--csv", "-"),
        ("--help",),
    ],
)
def test_reader_that_leaves_early_is_no_error_to_speak_of(
    arguments: tuple[str, ...], tmp_path: Path
) -> None:
    ours, theirs = PROCESSES.Pipe()
    with program(*arguments, folder=tmp_path, prepare=wait_until_told, given=(theirs,)) as psp3:
        psp3.close_output()
        ours.send("that nobody reads")
        assert psp3.end() == (1, "", "")


def test_interrupt_is_one_line_and_status_130(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> NoReturn:
        raise KeyboardInterrupt

    monkeypatch.setattr("psp3.simulation.tracking.simulate", interrupted)
    assert psp3_command("simulate") == (130, "", "psp3: interrupted\n")


def test_terminal_without_greek_gets_replacements_instead_of_an_error(tmp_path: Path) -> None:
    environment = ENVIRONMENT | {"PYTHONIOENCODING": "ascii"}
    with program("info", folder=tmp_path, environment=environment) as psp3:
        status, out, _ = psp3.end()
    assert status == 0
    assert "kg m?" in out


def test_progress_goes_to_standard_error_of_a_terminal_only(psp3_command: Run) -> None:
    assert psp3_command("simulate", "--model", "pinocchio", "--duration", 0.1).err == ""


# Every robot, as somebody who has just installed the package tries it


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_answers_every_command(psp3_command: Run, name: str) -> None:
    """Or says in one line what it lacks, and what to do instead."""
    follows = "no motor commands" if name in ("gripper", "biped") else ""
    short = ("--duration", "0.01")
    for arguments, refusal in (
        (("info", name), ""),
        (("pose", name), "give one of --heights" if name == "psp3" else ""),
        (("dynamics", name), ""),
        (("torques", name, *short, "--figure", "t.png", "--csv", "t.csv"), follows and "simulate"),
        (
            ("simulate", name, *short, "--out", "r.npz", "--figure", "r.png", "--csv", "r.csv"),
            "",
        ),
        (("view", name, *short, "--record", "moving.html"), ""),
        (("view", name, "--controller", "ctc", *short, "--record", "ctc.html"), ""),
        (("view", name, "--result", "r.npz", "--record", "result.html"), ""),
        (("workspace", name, "--resolution", "2"), follows and "free='lock'"),
    ):
        answer = psp3_command(*arguments)
        # Warnings about the robot come first.
        assert "Traceback" not in answer.err, arguments
        assert answer.status == (options.USAGE if refusal else 0), (arguments, answer.err)
        if refusal:
            assert refusal in answer.err.splitlines()[-1], arguments
        else:
            assert max(map(len, answer.out.splitlines())) <= 80, arguments
    if follows:
        assert follows in " ".join(psp3_command("simulate", name, *short).out.split())

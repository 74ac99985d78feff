"""``psp3 view``: pages, and a viewer that serves until it is interrupted."""

from __future__ import annotations

import re
import urllib.request
from pathlib import Path

import pytest

from psp3.cli import options
from psp3.errors import InvalidValue
from tests.processes import ENVIRONMENT, program
from tests.psp3.cli.answers import Run


def test_recorded_page_holds_the_pose_or_the_motion(psp3_command: Run) -> None:
    for name in ("pd", "ctc"):
        psp3_command("simulate", "--controller", name, "--duration", 0.2, "--out", f"{name}.npz")
    assert psp3_command("view", "--heights", "-0.05,0,0.05", "--record", "pose.html") == (
        0,
        "pose.html\n",
        "",
    )
    assert (
        psp3_command(
            "view", "--result", "pd.npz", "--result", "ctc.npz", "--record", "motion.html"
        ).status
        == 0
    )
    still, moving = (
        Path(name).read_text(encoding="utf-8") for name in ("pose.html", "motion.html")
    )
    assert len(moving) > len(still) > 500_000
    # Robots that stand side by side carry their names.
    assert all(f'"text":"{name}"' in moving for name in ("pd", "ctc"))


def test_recorded_page_holds_the_controllers_or_the_trajectory(psp3_command: Run) -> None:
    """Two robots under their names, ghosts and forces.

    A trajectory alone has neither ghost nor force.
    """
    psp3_command("train", "learned.json", "--kind", "t1")
    options = (
        "--controller",
        "pd",
        "--controller",
        "it2",
        "--trained",
        "learned.json",
        "--radius",
        0.01,
        "--duration",
        0.2,
    )
    assert psp3_command("view", *options, "--record", "controllers.html") == (
        0,
        "controllers.html\n",
        "",
    )
    assert (
        psp3_command(
            "view", "--trajectory", "circle", "--duration", 0.2, "--record", "circle.html"
        ).status
        == 0
    )
    simulated, desired = (
        Path(name).read_text(encoding="utf-8") for name in ("controllers.html", "circle.html")
    )
    assert all(
        f'"text":"{name}"' in simulated for name in ("pd", "it2", "learned.json", "desired pose")
    )
    assert simulated.count('"about":"tip error"') == 3
    assert "/meshcat/robots/2/ghost/" in simulated
    assert all(f"/meshcat/robots/0/{part}" in desired for part in ("actual", "visuals/a1"))
    assert "/ghost/" not in desired
    assert "force/head" not in desired


@pytest.mark.parametrize("options", [(), ("--heights", "0.02,0,-0.02")])
def test_viewer_serves_until_interrupted(options: tuple[str, ...], tmp_path: Path) -> None:
    """And opens nothing if it is told so, though there is a browser."""
    browser = {"BROWSER": f"touch {tmp_path}/opened"}
    options = ("--no-browser", "--port", "7310", *options)
    with program("view", *options, folder=tmp_path, environment=ENVIRONMENT | browser) as psp3:
        url = psp3.out.readline().split()[0]
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", url)
        with urllib.request.urlopen(url) as page:
            assert b"<html" in page.read()[:200]
        psp3.interrupt()
        status, _, err = psp3.end()
    assert (status, err.strip()) == (0, "")
    assert list(tmp_path.iterdir()) == []


def test_viewer_opens_its_page_in_the_browser(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When it is served already: the browser finds it at once. Here it also presses Ctrl-C."""
    opened = []

    def open_and_interrupt(url: str) -> bool:
        with urllib.request.urlopen(url) as page:
            opened.append((url, page.status))
        raise KeyboardInterrupt

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", open_and_interrupt)
    answer = psp3_command("view", "--duration", 0.2, "--port", 7320)
    assert answer.status == 0
    assert opened == [(answer.out.split()[0], 200)]


def test_a_page_is_not_written_under_the_name_of_a_picture(psp3_command: Run) -> None:
    answer = psp3_command("view", "--record", "page.png")
    assert answer.status == options.USAGE
    assert "must end in .html" in answer.err
    assert not Path("page.png").exists()


def test_page_of_another_robot(psp3_command: Run) -> None:
    """It sways, in whole turns."""
    answer = psp3_command("view", "delta", "--record", "delta.html")
    assert answer == (0, "delta.html\n", "")
    page = Path("delta.html").read_text()
    assert "<title>delta</title>" in page
    seconds = [float(time) for time in re.findall(r'"times":\[0.0,.*?([\d.]+)\]', page)]
    assert set(seconds) == {10.0}


def test_a_robot_that_cannot_sway_is_shown_at_rest(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(**given: object) -> None:
        raise InvalidValue("amplitude", None, "given: it can hardly move")

    monkeypatch.setattr("psp3.trajectories.sway.Sway", refuse)
    assert psp3_command("view", "five_bar", "--record", "rest.html").status == 0
    assert '"animations":[]' in Path("rest.html").read_text()
    answer = psp3_command("view", "five_bar", "--trajectory", "sway", "--record", "none.html")
    assert answer.status != 0
    assert "hardly move" in answer.err

"""The live view: whom it listens to, and that an open page follows it."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import pytest
from selenium import webdriver

import psp3
from psp3.errors import InvalidValue
from psp3.visualize import Scene, Viewer
from tests.page_helpers import (
    HEIGHT,
    WIDTH,
    complaints,
    set_size,
    settle,
    star_center,
    wait_for,
)

ROBOT = psp3.load()


@pytest.fixture(scope="module")
def sagging() -> psp3.Result:
    helix = psp3.trajectories.Helix(radius=0.015, robot=ROBOT)
    return psp3.simulate(ROBOT, psp3.PD(), helix, duration=1.5)


def listening_addresses(port: int) -> list[str]:
    """Local addresses, in the kernel's notation, of all sockets that listen on a port."""
    addresses = []
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        for line in Path(table).read_text().splitlines()[1:]:
            address, number = line.split()[1].split(":")
            if int(number, 16) == port and line.split()[3] == "0A":
                addresses.append(address)
    return addresses


def port_of(viewer: Viewer) -> int:
    return int(viewer.url.rstrip("/").rsplit(":", 1)[1])


def test_the_viewer_listens_on_this_machine_only() -> None:
    with Viewer(ROBOT) as viewer:
        assert listening_addresses(port_of(viewer)) == ["0100007F"]


def test_closing_the_viewer_frees_its_port() -> None:
    # Far from where other viewers look for a port, so that none takes it meanwhile.
    with Viewer(ROBOT, 10_000 + os.getpid() % 20_000) as viewer:
        port = port_of(viewer)
        with urllib.request.urlopen(viewer.url) as page:
            assert b"MeshCat" in page.read()
    assert listening_addresses(port) == []
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(viewer.url)
    with Viewer(ROBOT, port) as again:
        assert port_of(again) == port


@pytest.mark.parametrize("address", ["127.0.0.1", "0.0.0.0"])
def test_a_port_that_is_taken_is_left_alone(address: str) -> None:
    with socket.create_server((address, 0)) as other:
        taken = other.getsockname()[1]
        with Viewer(ROBOT, taken) as viewer:
            assert taken < port_of(viewer) < taken + 100
            with urllib.request.urlopen(viewer.url) as page:
                assert page.status == 200


def test_ports_end_at_65535() -> None:
    """When the last one is taken, any free port is served."""
    with (
        contextlib.suppress(OSError),
        socket.create_server(("127.0.0.1", 65535)),
        Viewer(ROBOT, 65535) as viewer,
    ):
        assert 0 < port_of(viewer) < 65535
    for port in (-1, 65536):
        with pytest.raises(
            InvalidValue, match=f"port must be a whole number from 0 to 65535, got {port}"
        ):
            Viewer(ROBOT, port)


def test_a_viewer_knows_one_page(sagging: psp3.Result) -> None:
    with Viewer(ROBOT) as viewer, pytest.raises(urllib.error.HTTPError, match="404") as refused:
        urllib.request.urlopen(f"{viewer.url}../etc/passwd")
    refused.value.close()


def test_a_late_browser_receives_the_whole_scene(sagging: psp3.Result) -> None:
    """It is the scene of the file, command by command, without what was shown before."""

    def targets(commands: list[dict[str, Any]]) -> list[tuple[str, ...]]:
        return sorted(
            (command["type"], command.get("path", ""), command.get("property", ""))
            for command in commands
        )

    fresh = Scene(ROBOT)
    fresh.show([0.02, 0.0, -0.02])
    viewer = Viewer(ROBOT)
    viewer.show([0.1, 0.1, 0.1])
    viewer.animate(sagging)
    viewer.show([0.02, 0.0, -0.02])
    with urllib.request.urlopen(f"{viewer.url}commands") as stream:
        viewer.close()
        events = [json.loads(line.removeprefix(b"data: ")) for line in stream if line.strip()]
    assert events.pop() == {"type": "end"}
    assert events == json.loads(viewer._commands.as_json())
    assert targets(events) == targets(json.loads(fresh._commands.as_json()))


def test_an_open_page_follows_the_viewer(browser: webdriver.Chrome, sagging: psp3.Result) -> None:
    """A pose, a motion, another pose, and no complaint when the viewer closes."""

    def wait_until_shown(height: float, condition: str = "true") -> None:
        """Wait for the star to be at a height; the scene's y is up in a page."""
        wait_for(
            browser,
            f"""(() => {{
              if (typeof viewer === "undefined") return false;
              const star = viewer.scene_tree.find(["meshcat", "robots", "0", "visuals", "b1"]);
              viewer.scene.updateMatrixWorld(true);
              const there = viewer.scene.matrixWorld.clone().invert();
              const z = there.multiply(star.object.matrixWorld).elements[14];
              return Math.abs(z - {height}) < 1e-6 && ({condition});
            }})()""",
        )

    set_size(browser, WIDTH, HEIGHT)
    browser.get("about:blank")
    browser.get_log("browser")
    with Viewer(ROBOT) as viewer:
        viewer.show([0.1, 0.1, 0.1])
        browser.get(viewer.url)
        wait_until_shown(0.1)
        viewer.show([-0.2, -0.2, -0.2])
        wait_until_shown(-0.2)
        viewer.animate(sagging)
        wait_for(browser, "animator.playing && animator.duration > 1.4")
        viewer.show([0.3, 0.3, 0.3])
        wait_until_shown(0.3, "element('playback').hidden")
    settle(browser)
    assert star_center(browser)[2] == pytest.approx(0.3, abs=1e-6)
    assert complaints(browser) == []

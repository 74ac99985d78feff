"""The robot in the browser: what the page shows, that it moves as Pinocchio says, and whom the viewer listens to."""

from __future__ import annotations

import io
import json
import socket
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver

import psp3
from psp3.errors import InvalidArray, InvalidValue, UnreachablePose
from psp3.visualize import Scene, Viewer, write_animation

ROBOT = psp3.load()

WIDTH, HEIGHT = 640, 500
"""Size of the page [pixels]: small, since it is rendered in software."""

# The world of three.js has y up; the scene is turned into it.
PLACEMENT = """
const node = viewer.scene_tree.find(arguments[0]).object;
viewer.scene.updateMatrixWorld(true);
const matrix = viewer.scene.matrixWorld.clone().invert().multiply(node.matrixWorld);
return matrix.toArray();
"""


def simulated(controller: Any, radius: float = 0.015) -> psp3.Result:
    return psp3.simulate(ROBOT, controller, psp3.trajectories.Helix(radius=radius, robot=ROBOT), duration=1.5)


@pytest.fixture(scope="module")
def sagging() -> psp3.Result:
    """PD without gravity compensation: the robot sinks by several centimeters and stays below the path."""
    return simulated(psp3.PD())


@pytest.fixture
def show(browser: webdriver.Chrome, tmp_path: Path) -> Callable[[Scene], webdriver.Chrome]:
    """Write a scene to a file, open it and wait until it stands still on the screen."""

    def open_file(scene: Scene) -> webdriver.Chrome:
        scene.write_html(tmp_path / "scene.html")
        set_size(browser, WIDTH, HEIGHT)
        browser.get_log("browser")
        browser.get((tmp_path / "scene.html").as_uri())
        settle(browser)
        return browser

    return open_file


def set_size(browser: webdriver.Chrome, width: int, height: int) -> None:
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def settle(browser: webdriver.Chrome) -> None:
    """Stop the clock and let the page lay itself out: it sizes its picture in the next frame of the browser."""
    browser.execute_script("animator.pause()")
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    browser.execute_script("viewer.render()")


def picture(browser: webdriver.Chrome) -> np.ndarray:
    """Return the rendered scene, (height, width, 3), without the page's controls."""
    hide = "for (const part of [element('legend'), element('playback'), viewer.gui.domElement]) part.style.visibility = 'hidden'"
    browser.execute_script(f"{hide}; viewer.render()")
    return np.asarray(Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")).astype(int)


def robot_pixels(browser: webdriver.Chrome) -> np.ndarray:
    """Where the robot is: the pixels that change when it is hidden, its shadow aside."""
    set_visible = "for (const name of arguments[0]) viewer.scene_tree.find(name).object.visible = arguments[1]"
    browser.execute_script(set_visible, [["Ground"], ["Grid"]], False)
    with_robot = picture(browser)
    browser.execute_script(set_visible, [["meshcat", "robots"]], False)
    without = picture(browser)
    browser.execute_script(set_visible, [["Ground"], ["Grid"], ["meshcat", "robots"]], True)
    return np.abs(with_robot - without).max(axis=-1) > 12


def star_pixels(browser: webdriver.Chrome) -> np.ndarray:
    """Only the star is orange: much red, little blue."""
    image = picture(browser)
    return (image[..., 0] > 140) & (image[..., 0] - image[..., 2] > 110) & (image[..., 0] - image[..., 1] > 70)


def placement(browser: webdriver.Chrome, *path: str) -> np.ndarray:
    """Homogeneous transform of a node in base axes, as the browser has it."""
    return np.array(browser.execute_script(PLACEMENT, list(path))).reshape(4, 4).T


def star_center(browser: webdriver.Chrome, robot: int = 0) -> np.ndarray:
    return placement(browser, "meshcat", "robots", str(robot), "visuals", "b1")[:3, 3]


def complaints(browser: webdriver.Chrome) -> list[str]:
    """Errors and warnings on the console, but for a software renderer's remarks on its speed."""
    entries = [entry["message"] for entry in browser.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
    return [message for message in entries if "GL Driver Message" not in message]


def test_the_robot_fills_the_view(show: Callable[[Scene], webdriver.Chrome]) -> None:
    """At least 80 % of the height, all of it inside; MeshCat's default camera gives less than 10 %."""
    scene = Scene(ROBOT)
    scene.show([0.05, 0.0, -0.05])
    browser = show(scene)
    rows, columns = np.nonzero(robot_pixels(browser))
    assert rows.max() - rows.min() > 0.8 * HEIGHT
    assert columns.max() - columns.min() > 0.25 * WIDTH
    assert rows.min() > 3
    assert rows.max() < HEIGHT - 4
    assert abs(columns.min() + columns.max() - WIDTH) < 0.1 * WIDTH
    assert complaints(browser) == []


@pytest.mark.parametrize(("width", "height"), [(300, 500), (900, 300)])
def test_a_narrow_and_a_wide_page_show_all_of_the_robot(show: Callable[[Scene], webdriver.Chrome], width: int, height: int) -> None:
    scene = Scene(ROBOT)
    scene.show(np.zeros(3))
    browser = show(scene)
    set_size(browser, width, height)
    browser.refresh()
    settle(browser)
    rows, columns = np.nonzero(robot_pixels(browser))
    assert 3 < rows.min() < rows.max() < height - 4
    assert 3 < columns.min() < columns.max() < width - 4
    assert max(np.ptp(rows) / height, np.ptp(columns) / width) > 0.8


def test_a_pose_is_drawn_where_it_is(show: Callable[[Scene], webdriver.Chrome]) -> None:
    """Center and rotation of the star, read back from the browser, against forward kinematics; 1e-6 is its single precision."""
    heights = ROBOT.inverse_kinematics(height=0.1, tilt=np.radians(20.0), azimuth=2.0)
    scene = Scene(ROBOT)
    scene.show(heights)
    browser = show(scene)
    pose = ROBOT.forward_kinematics(heights)
    star = placement(browser, "meshcat", "robots", "0", "visuals", "b1")
    np.testing.assert_allclose(star[:3, 3], pose.center, atol=1e-6)
    np.testing.assert_allclose(star[:3, :3], pose.rotation, atol=1e-6)
    for leg in (1, 2, 3):
        nut = placement(browser, "meshcat", "robots", "0", "visuals", f"a{leg}")
        assert nut[2, 3] == pytest.approx(heights[leg - 1], abs=1e-6)


def test_the_motion_is_the_simulated_one(show: Callable[[Scene], webdriver.Chrome], sagging: psp3.Result) -> None:
    """In real time, at frames and between them; 2e-4 m is the interpolation error of 30 frames a second (a t²/8, a < 2 m/s²)."""
    scene = Scene(ROBOT)
    scene.animate(sagging)
    browser = show(scene)
    assert browser.execute_script("return animator.duration") == pytest.approx(1.5, abs=1e-3)
    for seconds in (0.0, 0.317, 0.9, 1.5):
        browser.execute_script("seek(arguments[0])", seconds)
        sample = np.argmin(np.abs(sagging.t - seconds))
        expected = ROBOT.forward_kinematics(sagging.heights[sample])
        star = placement(browser, "meshcat", "robots", "0", "visuals", "b1")
        np.testing.assert_allclose(star[:3, 3], expected.center, atol=3e-4)
        np.testing.assert_allclose(star[:3, :3], expected.rotation, atol=3e-3)
        target = placement(browser, "meshcat", "robots", "0", "target")[:3, 3]
        np.testing.assert_allclose(target, sagging.desired.tip[sample], atol=3e-4)
    assert complaints(browser) == []


def test_seeking_moves_the_star_on_the_screen(show: Callable[[Scene], webdriver.Chrome], sagging: psp3.Result) -> None:
    """It sinks by centimeters, so its pixels go down by tens; the columns do not move."""
    scene = Scene(ROBOT)
    scene.animate(sagging)
    browser = show(scene)
    rows = []
    for seconds in (0.0, 1.2):
        browser.execute_script("seek(arguments[0])", seconds)
        assert star_pixels(browser).sum() > 700
        rows.append(np.nonzero(star_pixels(browser))[0].mean())
    sunk = ROBOT.forward_kinematics(sagging.heights[[0, 600]]).center[:, 2]
    pixels_per_meter = np.ptp(np.nonzero(robot_pixels(browser))[0]) / 1.2
    assert rows[1] - rows[0] == pytest.approx((sunk[0] - sunk[1]) * pixels_per_meter, rel=0.35)
    assert rows[1] - rows[0] > 10


def test_it_plays_by_itself_and_stops_on_request(show: Callable[[Scene], webdriver.Chrome], sagging: psp3.Result) -> None:
    """Each step of the animation is as long as the time since the last one, however slowly the page is drawn; 2 ms is rounding."""
    scene = Scene(ROBOT)
    scene.animate(sagging)
    browser = show(scene)
    browser.refresh()
    assert browser.execute_script("return animator.playing")
    animation, wall = browser.execute_async_script(
        """
        const done = arguments[0], draw_frame = viewer.render, frames = [];
        viewer.render = () => {
          frames.push([animator.mixer.time, animator.clock.oldTime / 1000]);  // oldTime: wall clock at the step
          draw_frame();
          const [first, last] = [frames[0], frames[frames.length - 1]];
          if (last[1] - first[1] > 2) {
            viewer.render = draw_frame;
            done([last[0] - first[0], last[1] - first[1]]);
          }
        };
        """
    )
    assert animation == pytest.approx(wall, abs=0.002)
    assert wall > 2.0
    browser.execute_script("element('play').click()")
    before = star_center(browser)
    time.sleep(0.2)
    np.testing.assert_array_equal(star_center(browser), before)
    slider = "const s = element('seek'); s.value = 0.75; s.dispatchEvent(new Event('input'))"
    browser.execute_script(slider)
    browser.execute_script("viewer.render()")
    assert browser.execute_script("return element('time').textContent") == "0.75 s"
    np.testing.assert_allclose(star_center(browser), ROBOT.forward_kinematics(sagging.heights[375]).center, atol=3e-4)


def test_the_paths_of_the_tip_are_drawn(show: Callable[[Scene], webdriver.Chrome], sagging: psp3.Result) -> None:
    """The corners of the boxes around the two tubes are those of the paths, a radius further out."""
    scene = Scene(ROBOT)
    scene.animate(sagging)
    browser = show(scene)
    box = """const mesh = viewer.scene_tree.find(["meshcat", "robots", "0", arguments[0], "<object>"]).object;
    mesh.geometry.computeBoundingBox();
    return [mesh.geometry.boundingBox.min.toArray(), mesh.geometry.boundingBox.max.toArray()];"""
    for name, path in (("actual", sagging.tip), ("desired", sagging.desired.tip)):
        low, high = browser.execute_script(box, name)
        # The path's own box, and the radius of the tube, 1.4 or 2.8 mm.
        assert (np.array(low) < path.min(axis=0) + 2e-4).all()
        assert (np.array(low) > path.min(axis=0) - 3.2e-3).all()
        assert (np.array(high) > path.max(axis=0) - 2e-4).all()
        assert (np.array(high) < path.max(axis=0) + 3.2e-3).all()


def test_a_robot_at_rest_has_no_path_and_no_playback(show: Callable[[Scene], webdriver.Chrome]) -> None:
    scene = Scene(ROBOT)
    hold = psp3.trajectories.Hold(robot=ROBOT)
    scene.animate(psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), hold, duration=0.2))
    browser = show(scene)
    assert browser.execute_script("return element('playback').hidden")
    assert complaints(browser) == []
    scene.show(np.zeros(3))
    browser = show(scene)
    assert browser.execute_script("return element('playback').hidden")
    assert complaints(browser) == []


def test_two_robots_stand_side_by_side_under_their_names(show: Callable[[Scene], webdriver.Chrome], sagging: psp3.Result) -> None:
    """Names are text, whatever they hold."""
    names = ["</script><b>PD", "CTC"]
    scene = Scene(ROBOT)
    scene.animate(dict(zip(names, (sagging, simulated(psp3.ComputedTorque(ROBOT))), strict=True)))
    browser = show(scene)
    browser.execute_script("seek(1.2); viewer.render()")
    labels = browser.execute_script(
        "return labels.map(({element}) => [element.textContent, element.getBoundingClientRect().left, element.getBoundingClientRect().top])"
    )
    assert [label[0] for label in labels] == names
    left, right = np.array([label[1:] for label in labels])
    assert 0 < left[0] < right[0] < WIDTH - 30
    assert 0 < left[1] < 60
    columns = np.nonzero(robot_pixels(browser))[1]
    assert columns.min() > 3
    assert columns.max() < WIDTH - 4
    # PD has sunk, CTC has not, and PD is the robot on the left.
    star = star_pixels(browser)
    assert np.nonzero(star[:, : WIDTH // 2])[0].mean() > np.nonzero(star[:, WIDTH // 2 :])[0].mean() + 8
    assert complaints(browser) == []


def test_the_page_needs_no_network(show: Callable[[Scene], webdriver.Chrome], sagging: psp3.Result) -> None:
    scene = Scene(ROBOT)
    scene.animate(sagging)
    browser = show(scene)
    requests = browser.execute_script("return performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert [name for name in requests if not name.startswith("data:")] == []


def test_a_scene_in_a_notebook_is_the_page_in_a_frame(browser: webdriver.Chrome, tmp_path: Path) -> None:
    scene = Scene(ROBOT)
    scene.show(np.zeros(3))
    browser.get_log("browser")
    (tmp_path / "cell.html").write_text(f"<!DOCTYPE html><meta charset=utf-8><body>{scene._repr_html_()}</body>", encoding="utf-8")
    browser.get((tmp_path / "cell.html").as_uri())
    browser.switch_to.frame(0)
    try:
        settle(browser)
        np.testing.assert_allclose(star_center(browser), 0.0, atol=1e-6)
        browser.switch_to.default_content()
        assert complaints(browser) == []
    finally:
        browser.switch_to.default_content()


def test_a_file_of_ten_seconds_stays_small(tmp_path: Path) -> None:
    """MeshCat itself is 0.85 MB; two robots for 10.4 s add less than 0.6 MB."""
    result = psp3.simulate(ROBOT, psp3.PD(), psp3.trajectories.Helix(robot=ROBOT), duration=10.4)
    write_animation(ROBOT, {"PD": result, "PD again": result}, tmp_path / "animation.html")
    assert 0.85e6 < (tmp_path / "animation.html").stat().st_size < 1.45e6


@pytest.mark.parametrize(
    ("heights", "error"), [([0.0, np.nan, 0.0], InvalidArray), ([0.0, 0.0], InvalidArray), ([1.5, -1.5, 0.0], UnreachablePose)]
)
def test_heights_that_no_robot_has_are_refused(heights: list[float], error: type[Exception]) -> None:
    with pytest.raises(error):
        Scene(ROBOT).show(heights)


def test_results_without_a_sample_are_refused(sagging: psp3.Result) -> None:
    with pytest.raises(InvalidValue, match="one simulation result or more"):
        Scene(ROBOT).animate({})
    nothing = np.zeros((0, 3))
    empty = psp3.Result(np.zeros(0), nothing, nothing, psp3.trajectories.Motion(*4 * [nothing]), nothing, nothing)
    with pytest.raises(InvalidValue, match="'PD': 751, 'CTC': 0"):
        Scene(ROBOT).animate({"PD": sagging, "CTC": empty})


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
    with Viewer(ROBOT) as viewer:
        port = port_of(viewer)
        with urllib.request.urlopen(viewer.url, timeout=5) as page:
            assert b"MeshCat" in page.read()
    assert listening_addresses(port) == []
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(viewer.url, timeout=5)
    with Viewer(ROBOT, port) as again:
        assert port_of(again) == port


@pytest.mark.parametrize("address", ["127.0.0.1", "0.0.0.0"])
def test_a_port_that_is_taken_is_left_alone(address: str) -> None:
    with socket.create_server((address, 0)) as other:
        taken = other.getsockname()[1]
        with Viewer(ROBOT, taken) as viewer:
            assert taken < port_of(viewer) < taken + 100
            with urllib.request.urlopen(viewer.url, timeout=5) as page:
                assert page.status == 200


def test_a_viewer_knows_one_page(sagging: psp3.Result) -> None:
    with Viewer(ROBOT) as viewer, pytest.raises(urllib.error.HTTPError, match="404") as refused:
        urllib.request.urlopen(f"{viewer.url}../etc/passwd", timeout=5)
    refused.value.close()


def test_a_late_browser_receives_the_whole_scene(sagging: psp3.Result) -> None:
    """It is the scene of the file, command by command, and holds nothing of what was shown before."""

    def targets(commands: list[dict[str, Any]]) -> list[tuple[str, ...]]:
        return sorted((command["type"], command.get("path", ""), command.get("property", "")) for command in commands)

    fresh = Scene(ROBOT)
    fresh.show([0.02, 0.0, -0.02])
    viewer = Viewer(ROBOT)
    viewer.show([0.1, 0.1, 0.1])
    viewer.animate(sagging)
    viewer.show([0.02, 0.0, -0.02])
    with urllib.request.urlopen(f"{viewer.url}commands", timeout=5) as stream:
        viewer.close()
        events = [json.loads(line.removeprefix(b"data: ")) for line in stream if line.strip()]
    assert events.pop() == {"type": "end"}
    (listed,) = [line for line in viewer.html().splitlines() if line.endswith(".forEach(handle);")]
    assert events == json.loads(listed.removesuffix(".forEach(handle);"))
    assert targets(events) == targets(json.loads(fresh._commands.as_json()))


def test_an_open_page_follows_the_viewer(browser: webdriver.Chrome, sagging: psp3.Result) -> None:
    """A pose, a motion, another pose, and no complaint when the viewer closes."""

    def wait_until(condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < deadline
            time.sleep(0.05)

    def shown(height: float) -> bool:
        return bool(abs(star_center(browser)[2] - height) < 1e-6)

    browser.get("about:blank")
    browser.get_log("browser")
    with Viewer(ROBOT) as viewer:
        viewer.show([0.1, 0.1, 0.1])
        browser.get(viewer.url)
        wait_until(lambda: shown(0.1))
        viewer.show([-0.2, -0.2, -0.2])
        wait_until(lambda: shown(-0.2))
        viewer.animate(sagging)
        wait_until(lambda: bool(browser.execute_script("return animator.playing && animator.duration > 1.4")))
        viewer.show([0.3, 0.3, 0.3])
        wait_until(lambda: shown(0.3) and bool(browser.execute_script("return element('playback').hidden")))
    settle(browser)
    assert shown(0.3)
    assert complaints(browser) == []

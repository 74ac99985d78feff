"""The robot in the browser: what the page shows, and that it moves as Pinocchio says."""

from __future__ import annotations

import dataclasses
import re
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver

import psp3
from psp3.errors import InvalidArray, InvalidValue, UnreachablePose
from psp3.visualize import Scene, write_animation
from psp3.visualize.scene import _hull
from tests.page_helpers import (
    HEIGHT,
    SIZES,
    WIDTH,
    changed_pixels,
    complaints,
    open_file,
    open_scene,
    picture_of,
    placement,
    screenshot,
    settle,
    star_center,
    sticking_out,
    wait_for,
)

ROBOT = psp3.load()


def simulated(controller: Any, radius: float = 0.015) -> psp3.Result:
    return psp3.simulate(
        ROBOT, controller, psp3.trajectories.Helix(radius=radius, robot=ROBOT), duration=1.5
    )


@pytest.fixture(scope="module")
def sagging() -> psp3.Result:
    """PD without gravity compensation.

    The robot sinks by several centimeters and stays below the path.
    """
    return simulated(psp3.PD())


@pytest.fixture(scope="module")
def exact() -> psp3.Result:
    return simulated(psp3.ComputedTorque(ROBOT))


def legend(browser: webdriver.Chrome) -> list[str]:
    return list(
        browser.execute_script(
            "return [...element('legend').children].map((line) => line.textContent)"
        )
    )


# At rest


def test_the_robot_fills_the_view(browser: webdriver.Chrome) -> None:
    """At least 80 % of the height, all of it inside.

    MeshCat's default camera gives less than 10 %.
    """
    scene = Scene(ROBOT).show([0.05, 0.0, -0.05])
    open_scene(browser, scene)
    picture = screenshot(browser, "pose")
    rows, columns = np.nonzero(changed_pixels(browser, "robots"))
    assert np.ptp(rows) > 0.8 * HEIGHT
    assert np.ptp(columns) > 0.25 * WIDTH
    assert 3 < rows.min() < rows.max() < HEIGHT - 4
    assert 3 < columns.min() < columns.max() < WIDTH - 4
    assert abs(columns.min() + columns.max() - WIDTH) < 0.1 * WIDTH
    # Not the background only: dark plate, light columns, orange star.
    assert (picture.max(axis=-1) < 80).sum() > 1000
    assert (picture[..., 0] - picture[..., 2] > 110).sum() > 200
    assert legend(browser) == []
    assert complaints(browser) == []


@pytest.mark.parametrize(("width", "height"), [(300, 500), (700, 250)])
def test_a_narrow_and_a_wide_page_show_all_of_the_robot(
    browser: webdriver.Chrome, width: int, height: int
) -> None:
    open_scene(browser, Scene(ROBOT).show(np.zeros(3)), width, height)
    rows, columns = np.nonzero(changed_pixels(browser, "robots"))
    assert 3 < rows.min() < rows.max() < height - 4
    assert 3 < columns.min() < columns.max() < width - 4
    assert max(np.ptp(rows) / height, np.ptp(columns) / width) > 0.8


def test_a_pose_is_drawn_where_it_is_and_its_ghost_where_it_should_be(
    browser: webdriver.Chrome,
) -> None:
    """Center and rotation of the star, read back from the browser, against forward kinematics.

    1e-6 is its single precision.
    """
    heights, desired = (
        ROBOT.inverse_kinematics(height=z, tilt=np.radians(20.0), azimuth=2.0) for z in (0.1, 0.16)
    )
    open_scene(browser, Scene(ROBOT).show(heights, desired=desired, force=[60.0, 90.0, -40.0]))
    for group, of_group in (("visuals", heights), ("ghost", desired)):
        pose = ROBOT.forward_kinematics(of_group)
        path = (
            "meshcat",
            "robots",
            "0",
            *(("ghost", "visuals") if group == "ghost" else ("visuals",)),
        )
        star = placement(browser, *path, "b1")
        np.testing.assert_allclose(star[:3, 3], pose.center, atol=1e-6)
        np.testing.assert_allclose(star[:3, :3], pose.rotation, atol=1e-6)
        for leg in (1, 2, 3):
            nut = placement(browser, *path, f"a{leg}")
            assert nut[2, 3] == pytest.approx(of_group[leg - 1], abs=1e-6)
    assert legend(browser) == ["desired pose", "screw force, 10 cm for 50 N"]
    screenshot(browser, "pose_with_ghost_and_forces")
    assert complaints(browser) == []


def test_the_ghost_is_seen_through_and_hides_in_a_robot_that_is_there(
    browser: webdriver.Chrome,
) -> None:
    """6 cm above it covers hundreds of pixels, and the columns behind it still show.

    At the same pose it tints the odd edge pixel.
    """
    open_scene(browser, Scene(ROBOT).show(np.zeros(3), desired=np.full(3, 0.06)))
    ghost = changed_pixels(browser, "robots/0/ghost")
    assert ghost.sum() > 500
    behind = changed_pixels(browser, "robots/0/visuals/universe")
    assert (ghost & behind).sum() > 20
    open_scene(browser, Scene(ROBOT).show(np.zeros(3), desired=np.zeros(3)))
    assert changed_pixels(browser, "robots/0/ghost").sum() < 0.1 * ghost.sum()


def test_arms_slide_through_their_balls_in_view(browser: webdriver.Chrome) -> None:
    """The marks go outward through the ball by what the slider gives.

    b shrinks as the arm goes in.
    """
    poses = (np.zeros(3), ROBOT.inverse_kinematics(height=0.0, tilt=np.radians(30.0), azimuth=0.0))
    slid = []
    for heights in poses:
        open_scene(browser, Scene(ROBOT).show(heights))
        ball, star = (
            placement(browser, "meshcat", "robots", "0", "visuals", name)
            for name in ("lambda1", "b1")
        )
        slid.append(np.linalg.norm(ball[:3, 3] - star[:3, 3]))
        assert (
            changed_pixels(
                browser, *(f"robots/0/visuals/b1/star1_{mark}" for mark in range(3, 15))
            ).sum()
            > 40
        )
    arms = [ROBOT.forward_kinematics(heights).arms[0] for heights in poses]
    np.testing.assert_allclose(slid, arms, atol=1e-6)
    assert abs(arms[1] - arms[0]) > 0.02


@pytest.mark.parametrize(
    ("heights", "error"),
    [
        ([0.0, np.nan, 0.0], InvalidArray),
        ([0.0, 0.0], InvalidArray),
        ([1.5, -1.5, 0.0], UnreachablePose),
    ],
)
def test_heights_that_no_robot_has_are_refused(
    heights: list[float], error: type[Exception]
) -> None:
    scene = Scene(ROBOT)
    with pytest.raises(error):
        scene.show(heights)
    with pytest.raises(error):
        scene.show(np.zeros(3), desired=heights)
    assert "robots" not in scene.html()[-2000:]


def test_forces_are_as_many_numbers_as_a_robot_has_motors_that_slide() -> None:
    with pytest.raises(InvalidArray):
        Scene(ROBOT).show(np.zeros(3), force=[1.0, np.inf, 0.0])
    stewart = psp3.load("gough_stewart")
    Scene(stewart).show(stewart.reference, force=np.arange(6.0))
    with pytest.raises(InvalidArray):
        Scene(stewart).show(stewart.reference, force=np.zeros(3))
    five_bar = psp3.load("five_bar")
    Scene(five_bar).show(five_bar.reference, desired=five_bar.reference + 0.1)
    with pytest.raises(InvalidValue, match="sliding motors only"):
        Scene(five_bar).show(five_bar.reference, force=[1.0, 1.0])


@pytest.mark.parametrize("size", [1.0, 1e30])
def test_a_view_of_the_corners_contains_all_points(size: float) -> None:
    """Also where rounding makes the hull flat: of points that differ by less than a digit."""
    points = np.random.default_rng(0).normal(size=(20, 3))
    points[:, 2] = size + (points[:, 2] if size == 1.0 else 0.0)
    corners = _hull(points)
    assert (corners.min(axis=0) <= points.min(axis=0) + 5e-4).all()
    assert (corners.max(axis=0) >= points.max(axis=0) - 5e-4).all()


# In motion


def test_the_motion_is_the_simulated_one(browser: webdriver.Chrome, sagging: psp3.Result) -> None:
    """In real time, at frames and between them.

    3e-4 m is the interpolation error of 30 frames a second (a t²/8, a < 2 m/s²).
    """
    open_scene(browser, Scene(ROBOT).animate(sagging))
    assert browser.execute_script("return animator.duration") == pytest.approx(1.5, abs=1e-3)
    for seconds in (0.0, 0.317, 0.9, 1.5):
        browser.execute_script("seek(arguments[0])", seconds)
        sample = np.argmin(np.abs(sagging.t - seconds))
        for group, heights in (
            (("visuals",), sagging.heights),
            (("ghost", "visuals"), sagging.desired.heights),
        ):
            expected = ROBOT.forward_kinematics(heights[sample])
            star = placement(browser, "meshcat", "robots", "0", *group, "b1")
            np.testing.assert_allclose(star[:3, 3], expected.center, atol=3e-4)
            np.testing.assert_allclose(star[:3, :3], expected.rotation, atol=3e-3)
        target = placement(browser, "meshcat", "robots", "0", "target")[:3, 3]
        np.testing.assert_allclose(target, sagging.desired.tip[sample], atol=3e-4)
    assert legend(browser)[:3] == ["desired pose", "desired tip", "tip"]
    assert complaints(browser) == []


def test_arrows_are_as_long_as_the_forces(browser: webdriver.Chrome, sagging: psp3.Result) -> None:
    """From the nut to the point of the head, at the scale of the legend.

    A force between frames is interpolated, 2 N at most here.
    """
    open_scene(browser, Scene(ROBOT).animate(sagging))
    newtons = float(legend(browser)[3].removeprefix("screw force, 10 cm for ").removesuffix(" N"))
    for seconds in (0.0, 0.4, 1.1):
        browser.execute_script("seek(arguments[0])", seconds)
        force = sagging.torque[np.argmin(np.abs(sagging.t - seconds))]
        for leg in (1, 2, 3):
            nut = ("meshcat", "robots", "0", "visuals", f"a{leg}")
            head = placement(browser, *nut, "force", "head")
            point = head @ [0.0, 0.0, 0.045, 1.0]
            # Heads keep their shape, whichever way they point.
            np.testing.assert_allclose(
                np.linalg.norm(head[:3, :3], axis=0), abs(head[2, 2]), rtol=1e-5
            )
            length = point[2] - placement(browser, *nut)[2, 3] - 0.044 * head[2, 2]
            assert length * newtons / 0.1 == pytest.approx(force[leg - 1], abs=2.0)


def test_seeking_moves_the_star_on_the_screen(
    browser: webdriver.Chrome, sagging: psp3.Result
) -> None:
    """It sinks by centimeters, so its pixels go down by as many as the picture has for them.

    The columns do not move.
    """
    open_scene(browser, Scene(ROBOT).animate(sagging))
    rows = []
    for seconds in (0.0, 1.2):
        browser.execute_script("seek(arguments[0])", seconds)
        star = changed_pixels(browser, "robots/0/visuals/b1")
        assert star.sum() > 250
        rows.append(np.nonzero(star)[0].mean())
    screenshot(browser, "pd_after_1.2_s")
    sunk = ROBOT.forward_kinematics(sagging.heights[[0, 600]]).center[:, 2]
    pixels_per_meter = np.ptp(np.nonzero(changed_pixels(browser, "robots"))[0]) / 1.2
    assert rows[1] - rows[0] == pytest.approx((sunk[0] - sunk[1]) * pixels_per_meter, rel=0.35)
    assert rows[1] - rows[0] > 6


def test_closer_shows_all_that_moves_larger(
    browser: webdriver.Chrome, sagging: psp3.Result
) -> None:
    open_scene(browser, Scene(ROBOT).animate(sagging))
    far = changed_pixels(browser, "robots/0/visuals/b1").sum()
    browser.execute_script("element('distance').click()")
    assert browser.execute_script("return element('distance').textContent") == "Whole robot"
    star = changed_pixels(browser, "robots/0/visuals/b1")
    screenshot(browser, "pd_closer")
    rows, columns = np.nonzero(star)
    assert star.sum() > 2 * far
    assert 0 < rows.min() < rows.max() < HEIGHT - 1
    assert 0 < columns.min() < columns.max() < WIDTH - 1


def test_the_paths_of_the_tip_are_drawn(browser: webdriver.Chrome, sagging: psp3.Result) -> None:
    """The corners of the boxes around the two tubes are the paths', a radius further out."""
    open_scene(browser, Scene(ROBOT).animate(sagging))
    box = """const mesh = viewer.scene_tree.find(["meshcat", "robots", "0", arguments[0], \
"<object>"]).object;
    mesh.geometry.computeBoundingBox();
    return [mesh.geometry.boundingBox.min.toArray(), mesh.geometry.boundingBox.max.toArray()];"""
    for name, path in (("actual", sagging.tip), ("desired", sagging.desired.tip)):
        low, high = browser.execute_script(box, name)
        # The path's own box, and the radius of the tube, 1.4 or 2.8 mm.
        assert (np.array(low) < path.min(axis=0) + 2e-4).all()
        assert (np.array(low) > path.min(axis=0) - 3.2e-3).all()
        assert (np.array(high) > path.max(axis=0) - 2e-4).all()
        assert (np.array(high) < path.max(axis=0) + 3.2e-3).all()


def test_a_trajectory_is_followed_exactly_without_a_simulation(browser: webdriver.Chrome) -> None:
    helix = psp3.trajectories.Helix(robot=ROBOT)
    open_scene(browser, Scene(ROBOT).animate(helix, duration=2.0))
    browser.execute_script("seek(0.75)")
    np.testing.assert_allclose(
        star_center(browser), ROBOT.forward_kinematics(helix(0.75).heights).center, atol=3e-4
    )
    assert legend(browser) == ["tip"]
    with pytest.raises(InvalidValue, match="this Helix never rests"):
        Scene(ROBOT).animate(helix)


def test_a_robot_at_rest_has_no_path_and_no_playback(browser: webdriver.Chrome) -> None:
    hold = psp3.trajectories.Hold(robot=ROBOT)
    scene = Scene(ROBOT).animate(hold, 0.2)
    for _ in range(2):
        open_scene(browser, scene)
        assert browser.execute_script("return element('playback').hidden")
        assert complaints(browser) == []
        scene.show(np.zeros(3))
    assert browser.execute_script("return element('distance').hidden")


def test_two_robots_stand_side_by_side_under_their_names(
    browser: webdriver.Chrome, sagging: psp3.Result, exact: psp3.Result
) -> None:
    """Names are text, whatever they hold."""
    names = ["</script><b>PD", "CTC"]
    open_scene(browser, Scene(ROBOT).animate(dict(zip(names, (sagging, exact), strict=True))))
    browser.execute_script("seek(1.2); viewer.render()")
    labels = browser.execute_script(
        "return labels.map(({element}) => [element.firstChild.textContent, "
        "element.getBoundingClientRect().left, element.getBoundingClientRect().top])"
    )
    assert [label[0] for label in labels] == names
    left, right = np.array([label[1:] for label in labels])
    assert 0 < left[0] < right[0] < WIDTH - 30
    # Above the robots, and below the legend, which reaches over half of so small a page.
    assert 0 < left[1] < HEIGHT / 3
    columns = np.nonzero(changed_pixels(browser, "robots/0/visuals", "robots/1/visuals"))[1]
    assert 3 < columns.min() < columns.max() < WIDTH - 4
    # PD has sunk, CTC has not, and PD is the robot on the left.
    (pd_rows, pd_columns), (ctc_rows, ctc_columns) = (
        np.nonzero(changed_pixels(browser, f"robots/{number}/visuals/b1")) for number in (0, 1)
    )
    assert pd_rows.mean() > ctc_rows.mean() + 5
    assert pd_columns.max() < ctc_columns.min()
    screenshot(browser, "pd_beside_ctc")
    # Below each name its error. 1.2 s is a frame; what is shown is rounded.
    shown = browser.execute_script("return labels.map(({readout}) => readout.textContent)")
    for text, result in zip(shown, (sagging, exact), strict=True):
        error = 1e3 * np.linalg.norm(result.tip[600] - result.desired.tip[600])
        said = re.fullmatch(r"tip error (\d+\.\d+) mm", text)
        assert said, text
        assert float(said[1]) == pytest.approx(
            error, abs=0.51 * 10.0 ** -len(said[1].partition(".")[2])
        )
    browser.execute_script("seek(0); viewer.render()")
    assert browser.execute_script("return labels[0].readout.textContent") != shown[0]
    assert complaints(browser) == []


def test_a_robot_without_a_tip_shows_the_error_of_its_joints(sagging: psp3.Result) -> None:
    """Its tip is NaN, which no page could draw."""
    nowhere = np.full_like(sagging.tip, np.nan)
    without = dataclasses.replace(
        sagging, tip=nowhere, desired=sagging.desired._replace(tip=nowhere)
    )
    drawn = Scene(ROBOT).animate(without)._commands.as_json()
    assert "largest error of a joint" in drawn
    assert "robots/0/visuals" in drawn
    assert "robots/0/target" not in drawn


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_words_and_buttons_are_whole_and_apart_at_any_width(
    browser: webdriver.Chrome, sagging: psp3.Result, exact: psp3.Result, size: tuple[int, int]
) -> None:
    """Of two robots that move, where there is most to read."""
    open_scene(browser, Scene(ROBOT).animate({"type-1, 20 dB": sagging, "type-2": exact}), *size)
    assert not sticking_out(browser)
    boxes = browser.execute_script(
        "return [...document.querySelectorAll('.label, #legend, #playback, #distance')].map("
        "(one) => { const box = one.getBoundingClientRect();"
        "return [box.left, box.top, box.right, box.bottom]; })"
    )
    assert len(boxes) == 5
    for one, other in combinations(boxes, 2):
        assert one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]


def test_labels_of_slim_robots_are_not_cut_off(
    browser: webdriver.Chrome, sagging: psp3.Result, exact: psp3.Result
) -> None:
    """A name may be wider than its robot, and reach over an edge of the page."""
    names = "computed torque with a long name"
    results = {f"{names}, {k}": one for k, one in enumerate((sagging, exact))}
    open_scene(browser, Scene(ROBOT).animate(results), 500, 900)
    ends = browser.execute_script(
        "return labels.map(({element}) => { const box = element.getBoundingClientRect();"
        "return [box.left, box.right]; })"
    )
    assert len(ends) == 2
    for left, right in ends:
        assert 0.0 <= left < right <= 500.0


def test_results_without_a_sample_are_refused(sagging: psp3.Result) -> None:
    with pytest.raises(InvalidValue, match="one simulation result or more"):
        Scene(ROBOT).animate({})
    nothing = np.zeros((0, 3))
    empty = psp3.Result(
        np.zeros(0), nothing, nothing, psp3.trajectories.Motion(*4 * [nothing]), nothing, nothing
    )
    with pytest.raises(InvalidValue, match="'PD': 751, 'CTC': 0"):
        Scene(ROBOT).animate({"PD": sagging, "CTC": empty})


# In a file


def test_a_file_plays_by_itself_without_a_network_and_stops_on_request(
    browser: webdriver.Chrome, tmp_path: Path, sagging: psp3.Result
) -> None:
    """Each step of the animation is as long as the time since the last one.

    However slowly the page is drawn, also where the motion begins anew; 2 ms is rounding.
    """
    write_animation(ROBOT, sagging, tmp_path / "scene.html")
    open_file(browser, tmp_path / "scene.html")
    assert browser.execute_script("return animator.playing")
    requests = browser.execute_script(
        "return performance.getEntriesByType('resource').map((entry) => entry.name)"
    )
    assert [name for name in requests if not name.startswith("data:")] == []
    browser.execute_script("seek(0)")
    before = screenshot(browser)
    frames = browser.execute_async_script(
        """
        const done = arguments[0], draw_frame = viewer.render, frames = [];
        let began_anew = false;
        viewer.render = () => {
          // oldTime is what the wall clock showed at the step
          frames.push([animator.mixer.time, animator.clock.oldTime / 1000]);
          draw_frame();
          began_anew ||= frames.length > 1 && animator.time < 1;
          if (began_anew && frames.length > 5) { viewer.render = draw_frame; done(frames); }
        };
        seek(1.4);
        animator.play();
        """
    )
    # The first frame may be that of seek.
    animation, wall = np.diff(np.array(frames)[1:], axis=0).T
    np.testing.assert_allclose(animation, wall, rtol=0.0, atol=0.002)
    assert (wall > 0.0).all()
    browser.execute_script("element('play').click()")
    stopped = star_center(browser)
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    np.testing.assert_array_equal(star_center(browser), stopped)
    slider = "const s = element('seek'); s.value = 0.75; s.dispatchEvent(new Event('input'))"
    browser.execute_script(slider)
    moved = np.abs(screenshot(browser, "file_stopped_at_0.75_s") - before).max(axis=-1) > 30
    assert moved.sum() > 200
    assert browser.execute_script("return element('time').textContent") == "0.75 s"
    np.testing.assert_allclose(
        star_center(browser), ROBOT.forward_kinematics(sagging.heights[375]).center, atol=3e-4
    )
    assert complaints(browser) == []


def test_a_scene_in_a_notebook_is_the_whole_page_in_a_third_of_its_size(
    browser: webdriver.Chrome, tmp_path: Path, sagging: psp3.Result
) -> None:
    """A notebook may weigh 1.5 MB with all its outputs.

    No server is in reach of an exported one.
    """
    output = Scene(ROBOT).animate({"PD": sagging})._repr_html_()
    assert len(output) < 450_000
    browser.get_log("browser")
    (tmp_path / "cell.html").write_text(
        f"<!DOCTYPE html><meta charset=utf-8><body>{output}</body>", encoding="utf-8"
    )
    browser.get((tmp_path / "cell.html").as_uri())
    browser.switch_to.frame(0)
    try:
        wait_for(browser, "typeof animator !== 'undefined' && animator.duration > 1.4")
        settle(browser)
        browser.execute_script("seek(0.75)")
        np.testing.assert_allclose(
            star_center(browser), ROBOT.forward_kinematics(sagging.heights[375]).center, atol=3e-4
        )
        browser.switch_to.default_content()
        picture_of(browser, "notebook")
        assert complaints(browser) == []
    finally:
        browser.switch_to.default_content()


def test_a_file_of_ten_seconds_stays_small(tmp_path: Path) -> None:
    """MeshCat itself is 0.85 MB.

    Two robots for 10.4 s, with their ghosts and forces, add less than 0.9 MB.
    """
    result = psp3.simulate(ROBOT, psp3.PD(), psp3.trajectories.Helix(robot=ROBOT), duration=10.4)
    write_animation(ROBOT, {"PD": result, "PD again": result}, tmp_path / "animation.html")
    assert 0.85e6 < (tmp_path / "animation.html").stat().st_size < 1.75e6

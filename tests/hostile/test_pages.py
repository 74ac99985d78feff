"""Every page that the packages write, in a browser, with names that could be markup.

No script of a name runs, no element of one is there, and the page shows the name letter by letter.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from selenium import webdriver

import fuzzy2
import psp3
from fuzzy2.errors import printable
from psp3.benchmark.page import write_page
from psp3.collisions.model import CollisionModel
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.thesis.findings import Drawing, Reproduction, Table
from psp3.thesis.report import write_report
from psp3.trajectories.sway import Sway
from psp3.visualize import Scene, Viewer
from psp3.visualize.collision_scene import CollisionScene
from tests.hostile.names import FIGURES, HOSTILE, MARKS, SCRIPTS, TERMINAL
from tests.page_helpers import complaints, wait_for
from tests.psp3.benchmark.made import board_of

URDF = Path(psp3.__file__).parent / "urdf" / "five_bar.urdf"
IN_XML = [name for name in (*SCRIPTS, *MARKS, *FIGURES) if name == printable(name)]


def groups(names: Sequence[str], size: int) -> list[tuple[str, ...]]:
    return [tuple(names[k : k + size]) for k in range(0, len(names), size)]


LOOK = """
const all = [...document.querySelectorAll("*")];
return {
  title: document.title, ran: window.ran, shown: document.documentElement.textContent,
  values: all.flatMap((one) => [...one.attributes].map((each) => each.value)),
  handlers: all.flatMap((one) => [...one.attributes].map((each) => each.name))
    .filter((name) => name.startsWith("on")),
  foreign: all.filter((one) => one.matches("img[src=x], b, svg[onload], a[href^=javascript]"))
    .map((one) => one.outerHTML),
};
"""


def look(browser: webdriver.Chrome, names: Sequence[str], own: str = "") -> None:
    """Look at the page: the names are in it, as texts, and did nothing."""
    found = browser.execute_script(LOOK)
    assert found["ran"] is None
    assert found["handlers"] == []
    assert [one for one in found["foreign"] if not (own and one.startswith(own))] == []
    for name in names:
        assert printable(name) in found["shown"], name


def opened(browser: webdriver.Chrome, path: Path) -> None:
    browser.get_log("browser")
    browser.get(path.as_uri())


def robot_of(names: Sequence[str], folder: Path) -> ClosedLoopRobot:
    """Return a five-bar whose robot and two rods have other names, as a URDF brings them."""
    text = URDF.read_text(encoding="utf-8")
    for own, name in zip(("five_bar", "leg1_rod", "leg2_rod"), names, strict=False):
        text = text.replace(f'"{own}"', f'"{html.escape(name)}"')
    loops = URDF.with_suffix(".yaml").read_text(encoding="utf-8")
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    path.with_suffix(".yaml").write_text(loops, encoding="utf-8")
    return psp3.ClosedLoopRobot.from_urdf(
        path, path.with_suffix(".yaml"), URDF.with_suffix(".srdf")
    )


@pytest.mark.parametrize("names", groups(IN_XML, 3), ids=repr)
def test_a_robot_file_brings_no_script_into_a_scene(
    browser: webdriver.Chrome, tmp_path: Path, names: tuple[str, ...]
) -> None:
    robot = robot_of(names, tmp_path)
    path = tmp_path / "scene.html"
    Scene(robot).show(robot.reference).write_html(path)
    opened(browser, path)
    look(browser, [])
    assert browser.title == " ".join(names[0].split())
    assert complaints(browser) == []


@pytest.mark.parametrize("name", TERMINAL)
def test_the_title_of_a_scene_is_the_name_as_it_can_be_shown(
    browser: webdriver.Chrome, tmp_path: Path, name: str
) -> None:
    robot = psp3.load("five_bar")
    robot.model.name = name if name.isascii() else "\u202edesrever"
    path = tmp_path / "scene.html"
    Scene(robot).show(robot.reference).write_html(path)
    opened(browser, path)
    assert browser.title == printable(robot.title)


@pytest.mark.parametrize("names", groups(HOSTILE, 6), ids=repr)
def test_labels_of_motions_are_texts(
    browser: webdriver.Chrome, tmp_path: Path, names: tuple[str, ...]
) -> None:
    robot = psp3.load("five_bar")
    motions = {name: Sway(robot=robot) for name in names}
    path = tmp_path / "scene.html"
    Scene(robot).animate(motions, 0.1).write_html(path)
    opened(browser, path)
    look(browser, names)
    labels = browser.execute_script("return labels.map((one) => one.element.textContent)")
    assert labels == [printable(name) for name in names]
    assert complaints(browser) == []


def test_links_in_the_legend_are_texts(browser: webdriver.Chrome, tmp_path: Path) -> None:
    robot = robot_of(("five_bar", *SCRIPTS[:2]), tmp_path)
    path = tmp_path / "scene.html"
    scene = CollisionScene(robot, CollisionModel(robot, robot.visual_model))
    scene.show_nearest(robot.reference)
    scene.write_html(path)
    opened(browser, path)
    look(browser, [name for name in SCRIPTS[:2] if name in scene._commands.as_json()])
    assert complaints(browser) == []


def test_a_viewer_shows_names_as_texts(browser: webdriver.Chrome) -> None:
    robot = psp3.load("five_bar")
    names = [*SCRIPTS[:3], MARKS[0], TERMINAL[0]]
    with Viewer(robot, 0) as viewer:
        viewer.animate({name: Sway(robot=robot) for name in names}, 0.1)
        browser.get(viewer.url)
        wait_for(browser, f"typeof labels !== 'undefined' && labels.length === {len(names)}")
        look(browser, names)


def test_a_scene_in_a_notebook_is_a_world_of_its_own(
    browser: webdriver.Chrome, tmp_path: Path
) -> None:
    """The frame runs the scene, with no access to the notebook around it."""
    robot = psp3.load("five_bar")
    robot.model.name = SCRIPTS[0]
    shown = Scene(robot).show(robot.reference)._repr_html_()
    path = tmp_path / "notebook.html"
    path.write_text(f"<!doctype html><meta charset='utf-8'><title>book</title>{shown}", "utf-8")
    opened(browser, path)
    look(browser, [])
    browser.switch_to.frame(0)
    try:
        wait_for(browser, "typeof viewer !== 'undefined'")
        assert browser.execute_script("return document.title") == SCRIPTS[0]
        assert browser.execute_script("return window.origin") == "null"
        look(browser, [])
    finally:
        browser.switch_to.default_content()
    assert complaints(browser) == []


def test_what_notebooks_show_of_fuzzy_systems(browser: webdriver.Chrome, tmp_path: Path) -> None:
    names = list(HOSTILE)
    terms = [fuzzy2.Gaussian(float(k), 1.0) for k in range(len(names))]
    system = fuzzy2.Type1System(
        [terms, terms],
        [[k, k] for k in range(len(names))],
        [[term] for term in terms],
        input_names=names[:2],
        output_names=[names[2]],
        term_names=[names, names],
    )
    shown = system._repr_html_() + system.explain([0.3, 0.4])._repr_html_()
    path = tmp_path / "notebook.html"
    path.write_text(f"<!doctype html><meta charset='utf-8'><title>book</title>{shown}", "utf-8")
    opened(browser, path)
    look(browser, names, own="<b>")
    assert browser.title == "book"


def test_the_board_of_a_benchmark(browser: webdriver.Chrome, tmp_path: Path) -> None:
    errors = {"ctc": np.full((2, 2, 2), 1e-4)}
    errors |= {name: np.full((2, 2, 2), 1e-3 * (k + 1)) for k, name in enumerate(HOSTILE)}
    board = board_of(errors, (HOSTILE[0], f"ValueError: {HOSTILE[1]}"))
    opened(browser, write_page(board, tmp_path / "benchmark.html"))
    look(browser, HOSTILE)
    broken = "return [...document.images].filter((one) => !one.naturalWidth).length"
    assert browser.execute_script(broken) == 0, "a name makes no picture malformed"
    assert complaints(browser) == []


def test_the_report_of_the_thesis(browser: webdriver.Chrome, tmp_path: Path) -> None:
    picture = tmp_path / "one.svg"
    picture.write_text("<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'/>", "utf-8")
    names = list(HOSTILE)
    outcome = Reproduction(
        tables=[Table(name, [name], [[name]], note=name) for name in names], answer=names
    )
    outcome.drawings.append(Drawing(picture, names[0], names[1]))
    outcome.numbers["versions"] = {names[0]: names[1]}
    opened(browser, write_report(outcome, tmp_path / "report.html"))
    look(browser, names)
    assert complaints(browser) == []


def test_even_a_script_in_a_report_would_not_run(browser: webdriver.Chrome, tmp_path: Path) -> None:
    """The page's own policy, should an escape ever be forgotten."""
    from fuzzy2.support.markup import Markup
    from psp3.plots.page import page

    path = tmp_path / "page.html"
    path.write_text(page("Title", Markup("<script>window.ran='name'</script>")), "utf-8")
    opened(browser, path)
    assert browser.execute_script("return document.scripts.length") == 1
    assert browser.execute_script("return window.ran") is None
    browser.get_log("browser")

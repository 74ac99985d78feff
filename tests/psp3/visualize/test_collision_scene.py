"""The scene of the nearest links.

What is drawn is where it belongs, can be seen, and goes again.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from selenium import webdriver

import psp3
from psp3.collisions.model import collision_model
from psp3.errors import InvalidArray
from psp3.visualize.collision_scene import LINK_COLORS, CollisionScene
from tests.page_helpers import changed_pixels, complaints, open_file, open_scene, placement, settle

ROBOT = psp3.load()
MODEL = collision_model(ROBOT)
TILTED = ROBOT.inverse_kinematics(0.0, np.radians(33.0), 0.0)


def commands(scene: CollisionScene) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(scene._commands.as_json())
    return found


def legend(scene: CollisionScene) -> list[tuple[str, str]]:
    (stage,) = (command for command in commands(scene) if command["type"] == "stage")
    return [(entry["text"], entry["color"]) for entry in stage["legend"]]


def hidden(scene: CollisionScene) -> set[str]:
    """Return the bodies that are not shown."""
    properties = [
        c
        for c in commands(scene)
        if c["type"] == "set_property" and c["property"] == "visible" and not c["value"]
    ]
    return {
        c["path"].rpartition("/")[2]
        for c in properties
        if c["path"].startswith("/meshcat/robots/0/visuals/")
    }


def test_nearest_points_are_where_they_belong(browser: webdriver.Chrome) -> None:
    """To 1e-6 m, the browser's single precision; and seen through what is before them."""
    scene = CollisionScene(ROBOT, MODEL).show_nearest(TILTED)
    open_scene(browser, scene)
    nearest = MODEL.nearest(TILTED)
    for number, point in enumerate(nearest.points):
        assert_allclose(
            placement(browser, "meshcat", "robots", "0", "nearest", f"point{number}")[:3, 3],
            point,
            atol=1e-6,
        )
    for part, joint in enumerate(("a1", "lambda1")):
        drawn = placement(browser, "meshcat", "robots", "0", "nearest", str(part), "visuals", joint)
        assert_allclose(
            drawn, placement(browser, "meshcat", "robots", "0", "visuals", joint), atol=1e-6
        )
    browser.execute_script("look(true)")
    settle(browser)
    assert changed_pixels(browser, "robots/0/nearest/point0").sum() > 10
    assert complaints(browser) == []


def test_legend_says_which_links_and_how_far() -> None:
    scene = CollisionScene(ROBOT, MODEL).show_nearest(TILTED)
    apart = 1e3 * MODEL.nearest(TILTED).distance
    assert legend(scene)[:2] == [("nut1", LINK_COLORS[0]), ("ball_lambda1", LINK_COLORS[1])]
    assert legend(scene)[2][0] == f"nearest points, {apart:.1f} mm apart"
    scene.show_nearest(ROBOT.inverse_kinematics(0.0, np.radians(38.0), 0.0))
    assert legend(scene)[2][0].endswith("mm in each other")


def test_bodies_are_shown_by_their_shapes_instead_of_their_looks_and_back_again() -> None:
    """Another pose leaves nothing of the one before.

    Without nearest links nothing is left of them at all.
    """
    scene = CollisionScene(ROBOT, MODEL).show_nearest(TILTED)
    assert hidden(scene) == {"a1", "lambda1"}
    drawn = [
        c
        for c in commands(scene)
        if c["type"] == "set_object" and "/nearest/" in c["path"] and "point" not in c["path"]
    ]
    assert sum("/a1/" in c["path"] for c in drawn) == MODEL.links.count("nut1")
    scene.show_nearest(ROBOT.inverse_kinematics(0.0, np.radians(33.0), np.radians(120.0)))
    assert [text for text, _ in legend(scene)][:2] == ["nut2", "ball_lambda2"]
    assert hidden(scene) == {"a2", "lambda2"}
    scene.show(TILTED)
    assert hidden(scene) == set()
    assert not any("/nearest" in c.get("path", "") for c in commands(scene))


def test_a_file_opens_without_complaints(browser: webdriver.Chrome, tmp_path: Path) -> None:
    CollisionScene(ROBOT).show_nearest(TILTED).write_html(tmp_path / "nearest.html")
    open_file(browser, tmp_path / "nearest.html")
    settle(browser)
    assert complaints(browser) == []


def test_what_cannot_be_shown_leaves_the_scene_as_it_was() -> None:
    scene = CollisionScene(ROBOT, MODEL).show_nearest(TILTED)
    before = scene._commands.as_json()
    with pytest.raises(InvalidArray):
        scene.show_nearest([0.0, np.nan, 0.0])
    assert scene._commands.as_json() == before

"""``psp3 info``: what the robot is made of."""

from __future__ import annotations

import pytest

import psp3
from psp3.cli.commands.info import kind_of
from psp3.description.parts import ROBOTS
from tests.psp3.cli.answers import Run, words

ROBOT = psp3.load("psp3")


def test_info_names_what_the_robot_is_made_of(psp3_command: Run) -> None:
    found, text = psp3_command("info", "--json").json, words(psp3_command("info").out)
    assert [joint["name"] for joint in found["joints"]] == list(ROBOT.model.names)[1:]
    assert [joint["name"] for joint in found["joints"] if joint["actuated"]] == ["a1", "a2", "a3"]
    assert set(found["parameters"]) == set(psp3.PARAMETER_SETS)
    assert found["parameters"]["default"]["total_mass"] == pytest.approx(26.496)
    assert found["stroke"] == {"lower": -0.4, "upper": 0.4}
    assert found["loops"][0]["frames"] == ["star1_center", "star2_center"]
    assert found["versions"]["psp3"] == psp3.__version__
    assert found["robots"] == list(ROBOTS)
    for part in (
        "gough_stewart",
        "23.9 mm at azimuth 0°",
        "a1, a2, a3",
        "26.496",
        "0.4 m",
        "table_5_1",
    ):
        assert part in text


def test_info_about_another_robot(psp3_command: Run) -> None:
    found = psp3_command("info", "tricept", "--json").json
    robot = psp3.load("tricept")
    assert found["motors"] == list(robot.actuated)
    assert found["mass"] == pytest.approx(sum(one.mass for one in list(robot.model.inertias)[1:]))
    assert {one["role"] for one in found["joints"]} == {"motor", "follows"}
    assert "3 degrees of freedom" in " ".join(psp3_command("info", "tricept").out.split())


@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "psp3"])
def test_joints_are_named_whole_and_in_words_at_80_columns(name: str, psp3_command: Run) -> None:
    """None is broken over two lines, and none has a name of Pinocchio's, such as RUBX."""
    joints = psp3_command("info", name, "--json").json["joints"]
    lines = psp3_command("info", name).out.partition("Joints")[2].splitlines()
    for joint in joints:
        (line,) = (line for line in lines if line.split()[:1] == [joint["name"]])
        assert line.split()[1] == kind_of(joint["type"]).split()[0]
        assert kind_of(joint["type"]) in line


@pytest.mark.parametrize(
    ("name", "words_of_it"),
    [
        ("RX", "revolute x"),
        ("RUBZ", "revolute z"),
        ("PY", "prismatic y"),
        ("RevoluteUnboundedUnaligned", "revolute"),
        ("HelicalUnaligned", "helical"),
        ("SphericalZYX", "ball"),
        ("FreeFlyer", "floating"),
        ("Planar", "Planar"),
    ],
)
def test_kinds_of_joints(name: str, words_of_it: str) -> None:
    assert kind_of(name) == words_of_it

"""Implementations of the equation of motion by name, and what the thesis's cannot say."""

from __future__ import annotations

import pytest

import psp3
from psp3.errors import InvalidValue, UnknownName
from psp3.robots.implementations import DYNAMICS_MODELS, implementation, unknown_to_the_thesis


def test_every_name_has_an_implementation() -> None:
    robot = psp3.load("five_bar")
    made = [type(implementation(robot, name)).__name__ for name in DYNAMICS_MODELS]
    assert made == ["ClosedLoopRobot", "ProjectedDynamics", "NaturalOrthogonalComplement"]
    with pytest.raises(UnknownName, match="core, pinocchio, noc"):
        implementation(robot, "newton")


def test_what_the_thesis_has_no_word_for_is_named() -> None:
    assert unknown_to_the_thesis(psp3.load("five_bar")) == ""
    biped = psp3.load("biped")
    assert unknown_to_the_thesis(biped) == "a ball whose spin is held, springs, a floating base"
    with pytest.raises(InvalidValue, match="springs") as caught:
        implementation(biped, "noc")
    sentence = "robot must be a tree with closures at points or frames and nothing else"
    assert str(caught.value).startswith(sentence)
    assert "robot.dynamics('pinocchio') covers every robot" in str(caught.value)
    assert str(caught.value).endswith(
        "got 'biped with a ball whose spin is held, springs, a floating base'"
    )

"""MuJoCo's opinion of a file is ours, and where one of the two is wrong it is told."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from psp3.description import mujoco_opinion
from psp3.description.mujoco_opinion import mujoco_disagreements
from psp3.errors import InvalidRobotFile, MissingPackage
from tests.psp3.description.test_mjcf import GOOD

pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

BODIES = """<mujoco><compiler angle="radian"/><worldbody>
  <body name="base" pos="1 2 3" euler=".3 .2 .1"><freejoint/><geom size=".1" pos="0 1 0"/>
    <body name="arm" pos="0 0 1"><joint type="ball" pos="0 .1 0"/><geom type="box" size=".1 .2 .3"/>
      <body name="welded" pos="0 1 0" euler=".5 0 0"><geom type="box" size=".2 .1 .1"/>\
<site name="tip" pos="0 0 1"/></body>
      <body name="slider"><joint type="slide" ref=".2" axis="1 1 0"/>\
<geom type="capsule" size=".1 .2"/></body></body></body></worldbody></mujoco>"""


def written(directory: Path, text: str) -> Path:
    path = directory / "robot.xml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("text", [GOOD, BODIES])
def test_both_agree(tmp_path: Path, text: str) -> None:
    assert mujoco_disagreements(written(tmp_path, text)) == []


@pytest.mark.parametrize(
    ("change", "what", "name"),
    [
        (lambda model: setattr(model.inertias[2], "mass", 1.0), "mass", "arm"),
        (
            lambda model: setattr(model.inertias[2], "lever", np.ones(3)),
            "center of mass",
            "arm",
        ),
        (lambda model: setattr(model.inertias[3], "inertia", np.eye(3)), "inertia", "slider"),
        (
            lambda model: model.jointPlacements.__setitem__(2, pin.SE3.Identity()),
            "place",
            "arm",
        ),
    ],
)
def test_a_reader_that_is_wrong_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: object, what: str, name: str
) -> None:
    """Of a model that is changed after it is read: what, of which body, and both values."""
    read = mujoco_opinion.read_mjcf

    def changed(*arguments: object) -> object:
        parts = read(*arguments)  # type: ignore[arg-type]
        change(parts.model)  # type: ignore[operator]
        return parts

    monkeypatch.setattr(mujoco_opinion, "read_mjcf", changed)
    found = mujoco_disagreements(written(tmp_path, BODIES))
    assert (what, name) in [(one.what, one.name) for one in found]
    assert f"{what} of {name}: " in str(next(one for one in found if one.what == what))


def test_what_mujoco_refuses_is_told(tmp_path: Path) -> None:
    """A material whose texture is not there: drawn without it here."""
    text = GOOD.replace(
        "<worldbody>", '<asset><texture name="t" type="2d" file="no.png"/></asset><worldbody>'
    )
    (found,) = mujoco_disagreements(written(tmp_path, text))
    assert (found.what, found.ours) == ("file", "read")
    assert "no.png" in found.theirs
    assert str(found).startswith(f"MuJoCo refuses {tmp_path / 'robot.xml'}, which is read here: ")


def test_what_cannot_be_read_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidRobotFile, match="no such file"):
        mujoco_disagreements(tmp_path / "no.xml")
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingPackage, match="psp3\\[mujoco\\]"):
        mujoco_disagreements(written(tmp_path, GOOD))

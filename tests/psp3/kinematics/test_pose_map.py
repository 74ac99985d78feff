"""Files of maps.

What is written comes back bit for bit, and what is damaged is refused with the reason.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import psp3
from psp3.errors import InvalidArray, InvalidMapFile
from psp3.kinematics.pose_map import ALWAYS, RANGES, WHOLE, KinematicMap, Status
from psp3.kinematics.singularities import Measures
from psp3.kinematics.workspace import Workspace


@pytest.fixture(scope="module")
def poses() -> KinematicMap:
    """Make a map with poses out of reach, beyond limits, and usable ones."""
    space = Workspace(psp3.load("five_bar"), "tip", ("x", "z"), singular_below=0.02)
    return space.map({"x": np.linspace(-0.3, 0.3, 7), "z": np.linspace(-0.48, 0.0, 9)})


@pytest.fixture
def saved(poses: KinematicMap, tmp_path: Path) -> Path:
    return poses.save(tmp_path / "map.json")


def test_round_trip(poses: KinematicMap, saved: Path) -> None:
    """Every field, and every number to the last bit; NaN where there was NaN."""
    again = KinematicMap.load(saved)
    assert {Status.UNREACHABLE, Status.BEYOND_LIMIT, Status.USABLE} <= set(
        poses.status.ravel().tolist()
    )
    for field in fields(KinematicMap):
        if field.name in ("grid", "measures") or isinstance(getattr(poses, field.name), np.ndarray):
            continue
        assert getattr(again, field.name) == getattr(poses, field.name), field.name
    assert list(again.grid) == list(poses.grid)
    for name in poses.grid:
        np.testing.assert_array_equal(again.grid[name], poses.grid[name])
    for name, array in poses.arrays().items():
        np.testing.assert_array_equal(again.arrays()[name], array)
    assert again.status.dtype == poses.status.dtype


def test_infinite_numbers_survive(poses: KinematicMap, tmp_path: Path) -> None:
    """Without limits margins are infinite, and so is the condition in a singularity."""
    condition = poses.measures.condition.copy()
    condition[poses.reachable] = np.inf
    endless = replace(
        poses,
        margin=np.where(poses.reachable, np.inf, np.nan),
        measures=poses.measures._replace(condition=condition),
    )
    again = KinematicMap.load(endless.save(tmp_path / "map.json"))
    np.testing.assert_array_equal(again.margin, endless.margin)
    np.testing.assert_array_equal(again.measures.condition, condition)


def test_the_file_is_json_without_extensions(saved: Path) -> None:
    """NaN and Infinity are no JSON; other programs can read it."""

    def refuse(name: str) -> None:
        raise AssertionError(name)

    content = json.loads(saved.read_text(encoding="utf-8"), parse_constant=refuse)
    assert content["format"] == "psp3 map 1"
    assert set(content["arrays"]) == set(RANGES)


def test_reachable_and_usable(poses: KinematicMap) -> None:
    np.testing.assert_array_equal(poses.reachable, np.isfinite(poses.margin))
    np.testing.assert_array_equal(poses.usable, poses.status == 4)
    assert (poses.reachable >= poses.usable).all()


def test_tables_name_every_array(poses: KinematicMap) -> None:
    assert set(RANGES) == set(poses.arrays())
    assert set(ALWAYS) | set(WHOLE) <= set(RANGES)


def at(*keys: Any) -> Callable[[dict[str, Any], Any], None]:
    """Return a function that sets an entry of the content, or deletes it if the value is ``at``."""

    def change(content: dict[str, Any], value: Any) -> None:
        for key in keys[:-1]:
            content = content[key]
        if value is at:
            del content[keys[-1]]
        else:
            content[keys[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "value", "match"),
    [
        (at("format"), "psp3 map 2", "has format 'psp3 map 2'"),
        (at("format"), at, "has format None"),
        (at("robot"), at, "lacks 'robot'"),
        (at("color"), "red", "unknown 'color'"),
        (at("robot"), 3, "robot 3"),
        (at("frame"), None, "frame None"),
        (at("task"), "x", "task of type str"),
        (at("task"), [], "task that is none"),
        (at("task"), ["x", "x"], "task that is none"),
        (at("task"), ["up"], "task that is none"),
        (at("task"), [1], "task 1, not a text"),
        (at("task"), [["x"]], "not a text"),
        (at("task"), 7, "task of type int"),
        (at("over"), "moon", "over 'moon'"),
        (at("over"), ["task"], "over"),
        (at("units", "x"), at, "units lacks 'x'"),
        (at("units", "y"), "m", "unknown 'y'"),
        (at("units", "x"), "mm", "'mm'"),
        (at("units", "x"), ["m"], "the unit"),
        (at("units"), ["m", "m"], "units of type list"),
        (at("length"), 0.0, "length"),
        (at("length"), "long", "length 'long'"),
        (at("length"), True, "length 'True'"),
        (at("length"), 10**400, "length"),
        (at("singular_below"), -0.1, "singular_below"),
        (at("held"), None, "held of type NoneType"),
        (at("held"), {"y": "low"}, "held"),
        (at("grid"), {}, "grid without coordinates"),
        (at("grid"), [], "grid of type list"),
        (at("grid", "x"), [0.0], "two numbers or more"),
        (at("grid", "x"), "0 1", "of type str"),
        (at("grid", "x"), [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0], "ascending"),
        (at("grid", "x"), [0.0, None], "not a number"),
        (at("grid", "x"), [0.0, 1.0], "not a list of one entry"),
        (at("arrays"), [], "arrays of type list"),
        (at("arrays", "margin"), at, "arrays lacks 'margin'"),
        (at("arrays", "speed"), [], "unknown 'speed'"),
        (at("arrays", "margin"), [], "margin that is not a list"),
        (at("arrays", "margin"), 0.0, "margin that is not a list"),
        (at("arrays", "configuration"), [0.0], "configuration that is not a list"),
        (at("arrays", "configuration"), [], "configuration that is not a list"),
        (at("arrays", "status", 0), 5, "status outside"),
        (at("arrays", "status", 0), 0.5, "whole number"),
        (at("arrays", "status", 0), None, "status"),
        (at("arrays", "actuation", 40), -0.1, "actuation outside"),
        (at("arrays", "constraint", 40), 1.1, "constraint outside"),
        (at("arrays", "condition", 40), 0.9, "condition outside"),
        (at("arrays", "condition", 40), "-inf", "condition outside"),
        (at("arrays", "condition", 40), "NaN", "condition 'NaN'"),
        (at("arrays", "orientation", 40), 0.5, "orientation"),
        (at("arrays", "position", 120), "inf", "position outside"),
        (at("arrays", "mobility", 40), "many", "mobility 'many'"),
    ],
)
def test_damage_is_found_and_named(
    change: Callable[[Any, Any], None], value: Any, match: str, saved: Path
) -> None:
    content = json.loads(saved.read_text(encoding="utf-8"))
    change(content, value)
    saved.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(InvalidMapFile, match=match) as caught:
        KinematicMap.load(saved)
    assert str(saved) in str(caught.value)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("name", ["margin", "position", "configuration", "actuation"])
def test_values_are_there_exactly_where_poses_are(
    name: str, poses: KinematicMap, saved: Path
) -> None:
    """A number at a pose that is unreachable, and none at one that is reachable."""
    width = poses.arrays()[name].size // poses.status.size
    reached = np.flatnonzero(poses.reachable.ravel())[0]
    missed = np.flatnonzero(~poses.reachable.ravel())[0]
    for place, value in ((reached, None), (missed, 0.5)):
        content = json.loads(saved.read_text(encoding="utf-8"))
        content["arrays"][name][place * width] = value
        other = saved.with_name("other.json")
        other.write_text(json.dumps(content), encoding="utf-8")
        with pytest.raises(
            InvalidMapFile, match=f"has {name} where there is no pose, or none where there is one"
        ):
            KinematicMap.load(other)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (b"", "is not JSON"),
        (b"{", "is not JSON"),
        (b"[1, 2]", "has format 'list'"),
        (b"null", "has format 'NoneType'"),
        (b'{"format": "psp3 map 1", "length": NaN}', "NaN is not a number of JSON"),
        (b'{"format": "\xff"}', "not UTF-8"),
        (b"[" * 100_000, "is not JSON"),
    ],
)
def test_files_that_are_something_else(text: bytes, match: str, tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    path.write_bytes(text)
    with pytest.raises(InvalidMapFile, match=match):
        KinematicMap.load(path)


def test_missing_file_and_directory(tmp_path: Path) -> None:
    for path, reason in ((tmp_path / "nothing.json", "no such file"), (tmp_path, "is a directory")):
        with pytest.raises(InvalidMapFile, match=reason):
            KinematicMap.load(path)


def test_cut_short_anywhere(saved: Path) -> None:
    whole = saved.read_bytes()
    for share in (0.1, 0.5, 0.9, 0.999):
        saved.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InvalidMapFile):
            KinematicMap.load(saved)


VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=5),
    st.just([]),
    st.just({}),
)


@settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(data=st.data())
def test_any_damage_is_refused_or_harmless(
    data: st.DataObject, poses: KinematicMap, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Some entry anywhere becomes something else.

    The result is a map again, or the one error, never another one.
    """
    path = poses.save(tmp_path_factory.getbasetemp() / "fuzzed.json")
    content = copy.deepcopy(json.loads(path.read_text(encoding="utf-8")))
    place: Any = content
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = data.draw(st.sampled_from(keys))
        if isinstance(place[key], dict | list) and place[key] and data.draw(st.booleans()):
            place = place[key]
            continue
        place[key] = data.draw(VALUES)
        break
    path.write_text(json.dumps(content), encoding="utf-8")
    try:
        again = KinematicMap.load(path)
    except InvalidMapFile:
        return
    assert again.status.shape == tuple(values.size for values in again.grid.values())


def test_arrays_of_another_shape_are_no_map(poses: KinematicMap) -> None:
    with pytest.raises(InvalidArray, match="margin"):
        replace(poses, margin=poses.margin[:-1])
    with pytest.raises(InvalidArray, match="actuation"):
        replace(
            poses,
            measures=Measures(
                *(
                    np.zeros(3) if name == "actuation" else values
                    for name, values in poses.measures._asdict().items()
                )
            ),
        )

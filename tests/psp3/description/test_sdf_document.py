"""SDF files are read strictly, and only from where they may be."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import psp3
from psp3.description.sdf_document import SdfDocument
from psp3.errors import InvalidRobotFile

MODEL = '<sdf version="1.9"><model name="m"><link name="a"/></model></sdf>'


def document(directory: Path, text: str | bytes) -> SdfDocument:
    """Return a text, read."""
    path = directory / "robot.sdf"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return SdfDocument(path, (directory,))


@pytest.mark.parametrize(
    "text",
    [
        MODEL,
        f" \n\t{MODEL}",
        f"\n<?xml version='1.0'?>{MODEL}",
        MODEL.replace("<model", "<!-- a --- drawing -- of it --><model"),
        MODEL.encode("utf-16"),
        MODEL.replace("<link", "<drake:link_extra/><link"),
        MODEL.replace('"1.9"', '"1.4"'),
    ],
)
def test_what_the_format_allows_is_read(text: str | bytes, tmp_path: Path) -> None:
    root = document(tmp_path, text).root
    assert root.find("model/link") is not None


def test_literal_text_is_not_taken_for_a_comment(tmp_path: Path) -> None:
    text = MODEL.replace("<link", "<author><![CDATA[<!-- x -->]]></author><link")
    assert document(tmp_path, text).root.findtext("model/author") == "<!-- x -->"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "cannot be read as XML"),
        (MODEL[:-3], "cannot be read as XML"),
        (MODEL.encode() + b"\xff", "cannot be read as XML"),
        ('<!DOCTYPE sdf [<!ENTITY one "1">]>' + MODEL, "<!DOCTYPE>"),
        (MODEL.replace("<link", "&one;<link"), "cannot be read as XML"),
        (MODEL.replace("1.9", "1.3"), "1.4 or later, got '1.3'"),
        (MODEL.replace("1.9", "2.0"), "got '2.0'"),
        (MODEL.replace("1.9", "1.９"), "got '1.９'"),
        (MODEL.replace("sdf", "gazebo"), "outermost element must be <sdf>"),
        ("<a>" * 3000 + "</a>" * 3000, "nested deeper than"),
    ],
)
def test_what_is_wrong_is_named(text: str | bytes, said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile) as caught:
        document(tmp_path, text)
    assert said in caught.value.reason


@pytest.mark.parametrize(
    ("uri", "said"),
    [
        ("../other.sdf", "model_paths"),
        ("/etc/passwd", "model_paths"),
        ("model://../other", "model_paths"),
        ("nowhere.sdf", "is not there"),
        ("model://nowhere", "model_paths"),
        ("https://example.org/arm", "put the model beside"),
        ("folder", "model.config"),
        ("two.sdf", "holds 2 models"),
        ("", "lacks <uri>"),
    ],
)
def test_included_files_lie_beside_the_file(uri: str, said: str, tmp_path: Path) -> None:
    here = tmp_path / "here"
    (here / "folder").mkdir(parents=True)
    (tmp_path / "other.sdf").write_text(MODEL, encoding="utf-8")
    (here / "two.sdf").write_text(
        MODEL.replace("</sdf>", '<model name="n"><link name="a"/></model></sdf>'), encoding="utf-8"
    )
    path = here / "robot.sdf"
    path.write_text(
        f'<sdf version="1.9"><model name="m"><include><uri>{uri}</uri></include></model></sdf>',
        encoding="utf-8",
    )
    with pytest.raises(InvalidRobotFile) as caught:
        psp3.ClosedLoopRobot.from_sdf(path, ["j"])
    assert said in caught.value.reason


def test_a_file_that_includes_itself_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "robot.sdf"
    path.write_text(
        '<sdf version="1.9"><model name="m"><link name="a"/><include><uri>robot.sdf</uri></include>'
        "</model></sdf>",
        encoding="utf-8",
    )
    with pytest.raises(InvalidRobotFile, match="nested deeper than"):
        psp3.ClosedLoopRobot.from_sdf(path, ["j"])


def test_models_are_found_in_given_folders(tmp_path: Path) -> None:
    (tmp_path / "models" / "arm").mkdir(parents=True)
    (tmp_path / "models" / "arm" / "model.config").write_text(
        "<model><sdf>arm.sdf</sdf></model>", encoding="utf-8"
    )
    (tmp_path / "models" / "arm" / "arm.sdf").write_text(MODEL, encoding="utf-8")
    (tmp_path / "here").mkdir()
    path = tmp_path / "here" / "robot.sdf"
    path.write_text(
        '<sdf version="1.9"><model name="m"><include><uri>model://arm</uri></include><joint '
        'name="j" type="revolute"><parent>world</parent><child>m::a</child><axis/></joint></model>'
        "</sdf>",
        encoding="utf-8",
    )
    with pytest.raises(InvalidRobotFile, match=r"model_paths=\[\.\.\.\]"):
        psp3.ClosedLoopRobot.from_sdf(path, ["j"])
    robot = psp3.ClosedLoopRobot.from_sdf(path, ["j"], model_paths=[tmp_path / "models"])
    assert robot.actuated == ("j",)


def test_files_that_include_two_of_each_other_are_counted(tmp_path: Path) -> None:
    """Twenty files, of which each includes the next one twice, are a million."""
    for number in range(20):
        twice = "".join(
            f"<include><name>{name}</name><uri>{number + 1}.sdf</uri></include>" for name in "ab"
        )
        (tmp_path / f"{number}.sdf").write_text(
            f'<sdf version="1.9"><model name="m"><link name="l"/>{twice * (number < 19)}'
            "</model></sdf>"
        )
    with pytest.raises(InvalidRobotFile, match="one of more than 200 files"):
        psp3.ClosedLoopRobot.from_sdf(tmp_path / "0.sdf", ["j"])


@pytest.mark.parametrize("mark", ["<!--", "<![CDATA[", "<a>"])
def test_marks_that_never_end_take_no_time(tmp_path: Path, mark: str) -> None:
    """Looked for from each of a million, an end takes hours."""
    path = tmp_path / "robot.sdf"
    path.write_text(mark * 1_000_000)
    begun = time.process_time()
    with pytest.raises(InvalidRobotFile):
        psp3.ClosedLoopRobot.from_sdf(path, ["j"])
    assert time.process_time() - begun < 5.0

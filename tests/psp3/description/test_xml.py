"""XML files: what is read, and what is refused."""

from __future__ import annotations

import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from numpy.testing import assert_array_equal

from fuzzy2.support.bounded_files import LARGEST_TEXT, MOST_ELEMENTS
from psp3.description.xml import MOST_ATTRIBUTES, described, numbers, read_xml, unique_names
from psp3.errors import InvalidRobotFile

PATH = Path("some.xml")


def test_reads_the_outermost_element(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    path.write_text("<robot name='r'><link name='a'/></robot>")
    assert [child.tag for child in read_xml(path, "robot")] == ["link"]
    assert read_xml(path, None).tag == "robot"


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "cannot be read as XML"),
        (b"<robot", "cannot be read as XML"),
        (b"\xff\xfe\x00\xd8", "cannot be read as XML"),
        (b"<?xml version='1.0' encoding='klingon'?><robot/>", "cannot be read as XML"),
        (b"<mujoco/>", "must be <robot>, not <mujoco>"),
        (b"<!DOCTYPE robot [<!ENTITY mass '2'>]><robot name='&mass;'/>", "has a <!DOCTYPE>"),
        (b"<!DOCTYPE robot SYSTEM 'robot.dtd'><robot/>", "has a <!DOCTYPE>"),
        (b"<robot name='&mass;'/>", "undefined entity"),
    ],
)
def test_files_that_are_no_xml_or_of_another_kind_are_refused(
    tmp_path: Path, content: bytes, reason: str
) -> None:
    path = tmp_path / "a.xml"
    path.write_bytes(content)
    with pytest.raises(InvalidRobotFile, match=reason) as caught:
        read_xml(path, "robot")
    assert caught.value.path == path


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("<robot>" + "<a>" * 1_000_000, "<a> is nested deeper than 200 elements"),
        ("<robot>" + "<a/>" * (MOST_ELEMENTS + 1) + "</robot>", "more than 100000 elements"),
        (
            "<robot " + " ".join(f"a{k}=''" for k in range(MOST_ATTRIBUTES + 1)) + "/>",
            "<robot> has more than 100 attributes",
        ),
        ("<robot><" + "a" * 2000 + "/></robot>", "is longer than 1000 characters"),
        ("<robot/>" + " " * LARGEST_TEXT, "larger than 16 MiB"),
        ("<?xml version='1.0' encoding='utf-32'?><robot/>", "cannot be read as XML"),
    ],
    ids=range(6),
)
def test_files_that_no_robot_needs_are_refused_at_once(
    tmp_path: Path, content: str, words: str
) -> None:
    path = tmp_path / "a.xml"
    path.write_text(content)
    begun = time.process_time()
    with pytest.raises(InvalidRobotFile, match=words):
        read_xml(path, "robot")
    assert time.process_time() - begun < 5.0


def test_missing_files_and_directories_are_refused(tmp_path: Path) -> None:
    for path, reason in ((tmp_path / "no.xml", "no such file"), (tmp_path, "is a directory")):
        with pytest.raises(InvalidRobotFile, match=reason):
            read_xml(path, "robot")


def test_numbers_of_an_attribute() -> None:
    element = ElementTree.Element("joint", name="j", pos=" 1  -2e-3\t3 ")
    assert_array_equal(numbers(PATH, element, "pos", 3), [1.0, -2e-3, 3.0])
    assert_array_equal(numbers(PATH, element, "pos"), [1.0, -2e-3, 3.0])
    assert numbers(PATH, element, "axis", 3) is None


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (b" \r\n\t<?xml version='1.0'?><robot name='r'/>", "r"),
        ("\ufeff<robot name='ä'/>".encode(), "ä"),
        ("<?xml version='1.0' encoding='utf-16'?><robot name='ä'/>".encode("utf-16"), "ä"),
        ("<?xml version='1.0' encoding='latin-1'?><robot name='ä'/>".encode("latin-1"), "ä"),
        (b"<robot name='&#228;&amp;'/>", "ä&"),
    ],
)
def test_blanks_before_the_declaration_and_encodings(
    tmp_path: Path, content: bytes, name: str
) -> None:
    path = tmp_path / "a.xml"
    path.write_bytes(content)
    assert read_xml(path, "robot").get("name") == name


@pytest.mark.parametrize("text", ["", "1 2", "1 2 3 4", "1 2 x", "1 nan 2", "1 2 inf", "1,2,3"])
def test_other_than_so_many_finite_numbers_is_refused(text: str) -> None:
    with pytest.raises(InvalidRobotFile) as caught:
        numbers(PATH, ElementTree.Element("joint", name="j", pos=text), "pos", 3)
    assert caught.value.reason == f"<joint name='j'>: pos must be 3 finite numbers, got {text!r}"


@pytest.mark.parametrize(
    "word", ["0_2", "0x1p3", "１", "٣", "Infinity", "1e400", "1.", ".5", "+1E+2", "1d3", "--1", "."]
)
def test_a_number_is_what_c_and_python_both_take_for_one(word: str) -> None:
    """``1.``, ``.5`` and ``+1E+2`` are; what one of them alone reads is not."""
    element = ElementTree.Element("mass", value=f"\n{word} ")
    if word in ("1.", ".5", "+1E+2"):
        assert numbers(PATH, element, "value", 1) == float(word)
        return
    with pytest.raises(InvalidRobotFile, match="value must be 1 finite number"):
        numbers(PATH, element, "value", 1)


def test_no_other_blanks_than_those_of_xml_divide_numbers() -> None:
    element = ElementTree.Element("axis", xyz="1\u00a00 0")
    with pytest.raises(InvalidRobotFile, match="xyz must be 3 finite numbers"):
        numbers(PATH, element, "xyz", 3)


def test_elements_by_their_names() -> None:
    first, second = ElementTree.Element("a", name="x"), ElementTree.Element("a", name="y")
    assert unique_names(PATH, [first, second]) == {"x": first, "y": second}
    with pytest.raises(InvalidRobotFile, match="two of <a name='x'>"):
        unique_names(PATH, [first, first])
    with pytest.raises(InvalidRobotFile, match="a <a> has no name"):
        unique_names(PATH, [ElementTree.Element("a")])


def test_elements_are_described_by_tag_and_name() -> None:
    assert described(ElementTree.Element("a")) == "<a>"
    assert described(ElementTree.Element("a", name="x")) == "<a name='x'>"

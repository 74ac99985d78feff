"""SDF files changed at random are read whole, or refused by an error of ours.

Five thousand were tried when the reader was written (``count`` below); a few dozen stay.
"""

from __future__ import annotations

import copy
import logging
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from psp3.description.sdf import read_sdf
from psp3.errors import PSP3Error
from tests.psp3.description import sdf_mechanisms as made

MOST_SECONDS = 5.0
"""So much processor time one file may take."""

TEXTS: dict[str, Callable[[str], str]] = {
    "blanks": lambda text: f" \n\t{text}\r\n ",
    "other blanks": lambda text: f"\u00a0{text}\u2003",
    "underscore": lambda text: f"{text}_0",
    "hexadecimal": lambda text: "0x1p-2",
    "full width": lambda text: text.translate(str.maketrans("0123456789", "０１２３４５６７８９")),
    "comma": lambda text: text.replace(".", ","),
    "not a number": lambda text: "nan",
    "infinite": lambda text: "-inf",
    "too large": lambda text: "1e999",
    "huge": lambda text: "1e300",
    "tiny": lambda text: "1e-320",
    "zero": lambda text: "0 0 0",
    "Fortran": lambda text: f"{text}d0",
    "twice": lambda text: f"{text} {text}",
    "none": lambda text: "",
    "long": lambda text: "9" * 400,
    "world": lambda text: "world",
    "nested": lambda text: f"{text}::{text}",
    "model": lambda text: "__model__",
    "emoji": lambda text: f"{text}🤖",
}
"""What a text or an attribute is changed to."""

STRUCTURES = ("remove", "double", "move", "wrap", "misspell", "deep", "last", "attribute", "damage")


def mechanism(number: int) -> str:
    """Return one of several files with loops, couplings and nested models."""
    files = (
        made.sdf(*made.four_bar(damping=(0.3,), stiffness=(0.2,))),
        made.sdf(*made.rod("universal"), "1.6"),
        made.sdf(*made.floating()),
        made.sdf(*made.geared()),
        '<sdf version="1.9"><world name="w"><model name="g"><static>1</static><link name="a"/>'
        '</model><model name="m"><pose relative_to="g">1 0 0 0 0 0</pose><model name="n"><link '
        'name="a"/></model><link name="b"><pose relative_to="n::a">0 0 1 0 0 0</pose></link><frame '
        'name="f" attached_to="b"/><joint name="j" type="revolute"><parent>n::a</parent><child>f'
        '</child><axis><xyz expressed_in="__model__">0 1 0</xyz></axis></joint></model></world>'
        "</sdf>",
    )
    return files[number % len(files)]


def mutant(number: int) -> tuple[str, bytes]:
    """Return what was changed in a file, and the changed file."""
    rng = np.random.default_rng(number)
    root = ElementTree.fromstring(mechanism(number))
    elements = [item for item in root.iter() if item is not root]
    item = elements[int(rng.integers(len(elements)))]
    above = {child: parent for parent in root.iter() for child in parent}
    if rng.random() < 0.6:
        kind = list(TEXTS)[int(rng.integers(len(TEXTS)))]
        if item.attrib and rng.random() < 0.5:
            key = list(item.attrib)[int(rng.integers(len(item.attrib)))]
            item.set(key, TEXTS[kind](item.attrib[key]))
        else:
            item.text = TEXTS[kind](item.text or "1")
        return f"{kind} of {item.tag}", ElementTree.tostring(root)
    kind = STRUCTURES[int(rng.integers(len(STRUCTURES)))]
    if kind == "damage":
        content = bytearray(ElementTree.tostring(root))
        for _ in range(int(rng.integers(1, 4))):
            content[int(rng.integers(len(content)))] = int(rng.integers(256))
        return kind, bytes(content)
    parent = above[item]
    if kind == "deep":
        text = ElementTree.tostring(root, encoding="unicode")
        cut = text.rindex("</")
        return kind, (text[:cut] + "<model name='x'>" * 3000 + text[cut:]).encode()
    if kind == "attribute":
        item.set("extra", "1")
    elif kind == "misspell":
        item.tag += "s"
    elif kind == "double":
        parent.append(copy.deepcopy(item))
    else:
        parent.remove(item)
    if kind == "last":
        parent.append(item)
    elif kind == "wrap":
        ElementTree.SubElement(parent, "group").append(item)
    elif kind == "move":
        inside = set(item.iter())
        others = [other for other in root.iter() if other not in inside]
        others[int(rng.integers(len(others)))].append(item)
    return f"{kind} of {item.tag}", ElementTree.tostring(root)


def check(number: int, path: Path, told: list[str]) -> tuple[str, str]:
    """Return what becomes of a changed file, and what is wrong with it; nothing if all is well."""
    what, content = mutant(number)
    path.write_bytes(content)
    begun = time.process_time()
    told.clear()
    try:
        parts = read_sdf(path, [])
    except PSP3Error as error:
        return "refused", "" if str(error).strip() else f"{what}: refused without a word"
    except Exception as error:
        return "failed", f"{what}: {type(error).__name__}: {error}"
    if time.process_time() - begun > MOST_SECONDS:
        return "read", f"{what}: took too long"
    if what.split()[0] in ("wrap", "misspell", "attribute") and not told:
        return "read", f"{what}: lost without a word"
    model = parts.model
    numbers = [inertia.toDynamicParameters() for inertia in model.inertias]
    numbers += [place.homogeneous.ravel() for place in model.jointPlacements]
    finite = np.isfinite(np.concatenate(numbers)).all()
    return "told" if told else "read", "" if finite else f"{what}: not finite"


@contextmanager
def told_of() -> Iterator[list[str]]:
    """Yield a list of what is logged."""
    told: list[str] = []
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: told.append(record.getMessage())  # type: ignore[method-assign]
    logging.getLogger("psp3").addHandler(handler)
    try:
        yield told
    finally:
        logging.getLogger("psp3").removeHandler(handler)


@pytest.mark.parametrize("count", [60])
def test_changed_files_are_read_or_refused(count: int, tmp_path: Path) -> None:
    with told_of() as told:
        wrong = {
            number: found
            for number in range(count)
            if (found := check(number, tmp_path / "robot.sdf", told)[1])
        }
    assert not wrong

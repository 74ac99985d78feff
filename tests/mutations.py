"""XML files changed at random, by a seed, and what becomes of them when they are read.

Every reader of files must read a changed file as another program would, or refuse it with an error
of ours, in a few seconds. A mutant says what was changed, and whether that takes something away
which a reader must at least tell of.
"""

from __future__ import annotations

import copy
import logging
import re
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from psp3.errors import PSP3Error

MOST_SECONDS = 5.0
"""So much processor time a refusal may take."""

NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

FULL_WIDTH = str.maketrans("0123456789", "０１２３４５６７８９")
ARABIC = str.maketrans("0123456789", "٠١٢٣٤٥٦٧٨٩")

NUMBERS: dict[str, Callable[[str], str]] = {
    "blank behind": lambda text: f"{text} ",
    "blank before": lambda text: f"\t{text}",
    "other blanks": lambda text: f"\u00a0{text}\u2003",
    "underscore": lambda text: f"{text}_0",
    "underscore in it": lambda text: re.sub(r"(\d)", r"\1_", text, count=1) + "1",
    "hexadecimal": lambda text: "0x1p-2",
    "full width": lambda text: text.translate(FULL_WIDTH),
    "Arabic": lambda text: text.translate(ARABIC),
    "comma": lambda text: text.replace(".", ","),
    "not a number": lambda text: "nan",
    "infinite": lambda text: "-inf",
    "too large": lambda text: "1e999",
    "huge": lambda text: "1e300",
    "tiny": lambda text: "1e-320",
    "zero": lambda text: "0",
    "minus zero": lambda text: "-0.0",
    "other sign": lambda text: text[1:] if text.startswith("-") else f"-{text}",
    "plus": lambda text: text if text.startswith("-") else f"+{text}",
    "Fortran": lambda text: f"{text}d0",
    "capital": lambda text: f"{text}E0" if "e" not in text.lower() else text,
    "point": lambda text: f"{text}." if text.isdigit() else text,
    "twice": lambda text: f"{text} {text}",
    "none": lambda text: "",
    "unit": lambda text: f"{text}mm",
    "more digits": lambda text: f"{text}00000000000000000000" if "." in text else text,
    "long": lambda text: "9" * 400,
}
"""What a number is written as instead."""

NAMES: dict[str, Callable[[str], str]] = {
    "empty": lambda text: "",
    "blanks": lambda text: f" {text} ",
    "line": lambda text: f"{text}\n{text}",
    "markup": lambda text: f"{text}<&\"'>",
    "umlaut": lambda text: f"{text}äß",
    "emoji": lambda text: f"{text}🤖",
    "long": lambda text: text * 2000,
    "case": lambda text: text.swapcase(),
    "path": lambda text: f"../{text}/../",
    "reserved": lambda text: "universe",
    "world": lambda text: "world",
    "format": lambda text: "%s{0}${x}",
}
"""What a name is changed to."""


class Mutant(NamedTuple):
    """A changed file."""

    number: int
    what: str
    """What was changed."""
    content: bytes
    loses: bool = False
    """Whether an element or attribute is where no reader looks for it."""


class Outcome(NamedTuple):
    """What became of a mutant."""

    mutant: Mutant
    value: Any
    """What the reader returned; None of a refusal."""
    refused: PSP3Error | None
    failed: BaseException | None
    """Any other exception."""
    told: str
    """What was logged."""
    seconds: float
    """Processor time."""


def mutants(text: str, count: int, seed: int = 0) -> Iterator[Mutant]:
    """Yield changed XML files, the same for the same arguments."""
    root = ElementTree.fromstring(text)
    kinds = (_number, _number, _name, _structure, _structure, _attribute, _encoding)
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        kind = kinds[int(rng.integers(len(kinds)))]
        yield kind(root, rng)._replace(number=number)


def outcome(mutant: Mutant, path: Path, read: Callable[[Path], Any]) -> Outcome:
    """Write a mutant to a path, read it, and return what became of it."""
    path.write_bytes(mutant.content)
    told = _Told()
    logger = logging.getLogger("psp3")
    logger.addHandler(told)
    begun = time.process_time()
    value, refused, failed = None, None, None
    try:
        value = read(path)
    except PSP3Error as error:
        refused = error
    except Exception as error:
        failed = error
    finally:
        logger.removeHandler(told)
    seconds = time.process_time() - begun
    return Outcome(mutant, value, refused, failed, "; ".join(told.messages), seconds)


def faults(found: Outcome) -> str:
    """Say what is wrong with an outcome, whatever the format; nothing if it is as it should be."""
    if found.failed is not None:
        return f"{type(found.failed).__name__}: {found.failed}"
    if found.refused is not None and not str(found.refused).strip():
        return "refused without a word"
    if found.seconds > MOST_SECONDS:
        return f"took {found.seconds:.1f} s"
    if found.mutant.loses and found.refused is None and not found.told:
        return "lost without a word"
    return ""


class _Told(logging.Handler):
    """Keeps what is logged."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.messages.append(record.getMessage())


def _one(rng: np.random.Generator, items: list[Any]) -> Any:
    return items[int(rng.integers(len(items)))]


def _written(root: ElementTree.Element) -> bytes:
    return ElementTree.tostring(root, encoding="utf-8")


def _attributes(root: ElementTree.Element, numeric: bool) -> list[tuple[ElementTree.Element, str]]:
    return [
        (element, key)
        for element in root.iter()
        for key, value in element.attrib.items()
        if all(NUMBER.fullmatch(word) for word in value.split()) == numeric and value
    ]


def _number(root: ElementTree.Element, rng: np.random.Generator) -> Mutant:
    """Write one number in another way."""
    changed = copy.deepcopy(root)
    element, key = _one(rng, _attributes(changed, True))
    what = _one(rng, list(NUMBERS))
    words = element.attrib[key].split()
    place = int(rng.integers(len(words)))
    words[place] = NUMBERS[what](words[place])
    element.set(key, " ".join(words))
    return Mutant(0, f"{element.tag} {key}: {what}", _written(changed))


def _name(root: ElementTree.Element, rng: np.random.Generator) -> Mutant:
    """Change a word, or write another one of the file in its place."""
    changed = copy.deepcopy(root)
    words = _attributes(changed, False)
    element, key = _one(rng, words)
    if rng.random() < 0.4:
        other, its = _one(rng, words)
        what, value = f"that of {other.tag} {its}", other.attrib[its]
    else:
        what = _one(rng, list(NAMES))
        value = NAMES[what](element.attrib[key])
    element.set(key, value)
    return Mutant(0, f"{element.tag} {key}: {what}", _written(changed))


def _structure(root: ElementTree.Element, rng: np.random.Generator) -> Mutant:
    """Remove, double, move, wrap or misspell an element."""
    changed = copy.deepcopy(root)
    parent, child = _one(rng, [(parent, child) for parent in changed.iter() for child in parent])
    what = _one(rng, ["remove", "double", "move", "wrap", "misspell", "last", "deep", "text"])
    place = list(parent).index(child)
    if what == "deep":
        return Mutant(0, f"deep {child.tag}", _deep(root, child.tag), True)
    if what == "text":
        child.text, child.tail = "0.5 & more", "behind"
    elif what == "misspell":
        child.tag += "s"
    elif what == "double":
        parent.insert(place, copy.deepcopy(child))
    else:
        parent.remove(child)
    if what == "last":
        parent.append(child)
    elif what == "wrap":
        group = ElementTree.Element("group")
        group.append(child)
        parent.insert(place, group)
    elif what == "move":
        inside = set(child.iter())
        other = _one(rng, [element for element in changed.iter() if element not in inside])
        other.insert(int(rng.integers(len(other) + 1)), child)
    return Mutant(0, f"{what} {child.tag}", _written(changed), what in ("wrap", "misspell"))


def _deep(root: ElementTree.Element, tag: str) -> bytes:
    """Return the file with an element that hangs in thousands of others."""
    text = ElementTree.tostring(root, encoding="unicode")
    cut = text.rindex("</")
    nested = "<group>" * 3000 + f"<{tag}/>" + "</group>" * 3000
    return (text[:cut] + nested + text[cut:]).encode()


def _attribute(root: ElementTree.Element, rng: np.random.Generator) -> Mutant:
    """Remove, misspell or add an attribute."""
    changed = copy.deepcopy(root)
    element, key = _one(rng, _attributes(changed, bool(rng.random() < 0.5)))
    what = _one(rng, ["remove", "misspell", "case", "add"])
    if what == "add":
        element.set("extra", "1")
    else:
        value = element.attrib.pop(key)
        if what != "remove":
            element.set(f"{key}s" if what == "misspell" else key.upper(), value)
    loses = what != "remove" and element is not changed
    return Mutant(0, f"{what} {key} of {element.tag}", _written(changed), loses)


def _encoding(root: ElementTree.Element, rng: np.random.Generator) -> Mutant:
    """Write the file in other bytes, or damage them."""
    text = ElementTree.tostring(root, encoding="unicode")
    number = _one(rng, list(re.finditer(r'"(\d\S*?)"', text)))
    with_entity = f"{text[: number.start(1)]}&one;{text[number.end(1) :]}"
    doctype = f'<!DOCTYPE {root.tag} [<!ENTITY one "{number[1]}">]>'
    damaged = bytearray(text.encode())
    for _ in range(int(rng.integers(1, 4))):
        damaged[int(rng.integers(len(damaged)))] = int(rng.integers(256))
    cut = int(rng.integers(len(text)))
    declared = "<?xml version='1.0' encoding='{}'?>"
    contents = {
        "UTF-16": (declared.format("utf-16") + text).encode("utf-16"),
        "Latin 1": (declared.format("iso-8859-1") + text).encode("iso-8859-1", "xmlcharrefreplace"),
        "another than declared": (declared.format("utf-16") + text).encode(),
        "unknown": (declared.format("klingon") + text).encode(),
        "byte order mark": b"\xef\xbb\xbf" + text.encode(),
        "blanks before": b" \r\n" + (declared.format("utf-8") + text).encode(),
        "Windows lines": text.replace("\n", "\r\n").encode(),
        "entity": (doctype + with_entity).encode(),
        "entity of nobody": with_entity.encode(),
        "character reference": re.sub(
            r'"(\d)', lambda match: f'"&#{ord(match[1])};', text, count=20
        ).encode(),
        "comments": text.replace("><", "><!-- 1 --><").encode(),
        "processing": text.replace("><", "><?robot 1?><", 3).encode(),
        "cut": text[:cut].encode(),
        "damaged": bytes(damaged),
        "twice": (text + text).encode(),
        "zeros": text.encode() + bytes(7),
        "nothing": b"",
    }
    what = _one(rng, list(contents))
    return Mutant(0, what, contents[what])

"""XML files changed at random, by a seed.

Every reader of files must read a changed file as another program would, or refuse it with an error
of ours, in a few seconds. A mutant says what was changed, and whether that takes something away
which a reader must at least tell of.
"""

from __future__ import annotations

import copy
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from tests.hostile.mutant import LOST, Mutant
from tests.hostile.spelled_numbers import SPELLINGS

NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

NUMBERS: dict[str, Callable[[str], str]] = {
    **{name: function for name, (function, _) in SPELLINGS.items()},
    "blank behind": lambda text: f"{text} ",
    "blank before": lambda text: f"\t{text}",
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


def mutants(text: str, count: int, seed: int = 0) -> Iterator[Mutant]:
    """Yield changed XML files, the same for the same arguments."""
    root = ElementTree.fromstring(text)
    for number in range(count):
        yield mutant(root, np.random.default_rng([seed, number]))._replace(number=number)


def mutant(root: ElementTree.Element, rng: np.random.Generator) -> Mutant:
    """Return a changed XML file."""
    kinds = (_number, _number, _name, _structure, _structure, _attribute, _encoding)
    return kinds[int(rng.integers(len(kinds)))](root, rng)


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
        return Mutant(0, f"deep {child.tag}", _deep(root, child.tag), LOST)
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
    return Mutant(
        0, f"{what} {child.tag}", _written(changed), LOST * (what in ("wrap", "misspell"))
    )


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
    return Mutant(0, f"{what} {key} of {element.tag}", _written(changed), LOST * loses)


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

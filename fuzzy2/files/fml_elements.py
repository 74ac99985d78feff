"""Elements of an FML document, with their lines."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from xml.parsers import expat

from fuzzy2.errors import MalformedFile
from fuzzy2.files.fml_names import (
    ATTRIBUTES,
    NAMESPACE,
    OWN_INSTRUCTION,
    OWN_WORDS,
    TEXTS,
)
from fuzzy2.files.source import Source
from fuzzy2.support.number_text import number_of
from fuzzy2.systems.rules import unknown_name


@dataclass
class Element:
    """Element of a document, with its line number."""

    name: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""


class FmlElements(Source):
    """Elements of one document.

    ``own`` holds the words of the processing instruction for this package, which other programs
    ignore.
    """

    def __init__(self, source: str) -> None:
        super().__init__(source)
        self.own: dict[str, str] = {}

    def root(self, text: str) -> Element:
        """Return the root element of a document."""
        # The text is decoded already, so its encoding declaration no longer applies.
        parser = expat.ParserCreate("utf-8", namespace_separator="}")
        holder = Element("", {}, 0)
        open_elements = [holder]

        def start(name: str, attributes: dict[str, str]) -> None:
            namespace, _, local = name.rpartition("}")
            if namespace.strip().rstrip("/").lower() not in (
                "",
                NAMESPACE,
                f"https{NAMESPACE[4:]}",
            ):
                raise self.malformed(
                    parser.CurrentLineNumber,
                    f"expected elements of {NAMESPACE}, got one of {namespace}",
                )
            # Attributes of other namespaces, such as the location of a schema, are ignored.
            own = {key: value for key, value in attributes.items() if "}" not in key}
            element = Element(local, own, parser.CurrentLineNumber)
            self._check_attributes(element)
            open_elements[-1].children.append(element)
            open_elements.append(element)

        def end(name: str) -> None:
            self._check_content(open_elements.pop())

        def characters(text: str) -> None:
            open_elements[-1].text += text

        def instruction(target: str, data: str) -> None:
            if target == OWN_INSTRUCTION:
                self._take_instruction(data, parser.CurrentLineNumber)

        def doctype(*_: object) -> None:
            raise self.malformed(
                parser.CurrentLineNumber, "a document type declaration is not allowed"
            )

        parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = (
            start,
            end,
            characters,
        )
        parser.StartDoctypeDeclHandler = doctype
        parser.ProcessingInstructionHandler = instruction
        try:
            parser.Parse(text.encode("utf-8", "surrogatepass"), True)
        except expat.ExpatError as error:
            reason = expat.errors.messages[error.code]
            raise MalformedFile(
                self.source, f"line {error.lineno}, column {error.offset + 1}", reason
            ) from None
        return holder.children[0]

    def _check_attributes(self, element: Element) -> None:
        """Refuse unknown attributes, because a misspelled weight would otherwise be ignored."""
        # An element with an unknown name is refused where it is read.
        known = ATTRIBUTES.get(element.name, tuple(element.attributes))
        for name in element.attributes:
            if name not in known:
                raise self.malformed(
                    element.line, unknown_name(f"attribute of <{element.name}>", name, known)
                )

    def _check_content(self, element: Element) -> None:
        """Refuse text between elements, and elements within text."""
        if element.name in TEXTS and element.children:
            child = element.children[0]
            raise self.malformed(child.line, f"<{element.name}> holds a text, not <{child.name}>")
        text = element.text.strip()
        if element.name not in TEXTS and text:
            raise self.malformed(
                element.line, f"<{element.name}> holds no text, and has {text[:40]!r}"
            )

    def _take_instruction(self, data: str, line: int) -> None:
        """Store the words of the processing instruction for this package."""
        found = dict(re.findall(r'([^\s=]+)="([^"]*)"', data))
        rest = re.sub(r'[^\s=]+="[^"]*"', "", data).strip()
        if rest or self.own or not found.keys() <= set(OWN_WORDS):
            raise self.malformed(
                line, f"expected one instruction with {' and '.join(OWN_WORDS)}, got {data[:60]!r}"
            )
        self.own.update(found)

    def attribute(self, element: Element, name: str, default: str | None = None) -> str:
        """Return an attribute, which is required if it has no default."""
        value = element.attributes.get(name, default)
        if value is None:
            raise self.malformed(element.line, f"<{element.name}> has no attribute {name!r}")
        return value

    def number(self, element: Element, text: str) -> float:
        """Return a finite number."""
        # XML treats only these characters as blanks, but Python others as well.
        value = number_of(text.strip(" \t\r\n"))
        if not math.isfinite(value):
            raise self.malformed(element.line, f"expected a finite number, got {text[:40]!r}")
        return value

    def children(self, element: Element, *names: str) -> list[Element]:
        """Return the child elements, whose names must be among the given ones."""
        for child in element.children:
            if child.name not in names:
                wanted = " or ".join(f"<{name}>" for name in names)
                raise self.malformed(
                    child.line, f"expected {wanted} in <{element.name}>, got <{child.name}>"
                )
        return element.children

    def only(self, element: Element, *names: str) -> Element:
        """Return the only child element, whose name must be among the given ones."""
        children = self.children(element, *names)
        if len(children) != 1:
            wanted = " or ".join(f"<{name}>" for name in names)
            raise self.malformed(
                element.line, f"expected one {wanted} in <{element.name}>, got {len(children)}"
            )
        return children[0]

    def choice(
        self, element: Element, attribute: str, default: str, known: Mapping[str, str]
    ) -> str:
        """Return the meaning of a case-insensitive word."""
        name = self.attribute(element, attribute, default)
        if name.upper() not in known:
            raise self.refused(
                element.line, f"{attribute}={name!r}", f"known are {', '.join(known)}"
            )
        return known[name.upper()]

    def truth(self, element: Element, attribute: str) -> bool:
        """Return whether an attribute is true; it is false if missing."""
        value = self.attribute(element, attribute, "false")
        if value.lower() not in ("true", "false"):
            raise self.malformed(element.line, f"expected {attribute} true or false, got {value!r}")
        return value.lower() == "true"

    def named(self, element: Element, known: Iterable[str], kind: str) -> str:
        """Return a name that is known, with or without the blanks around it."""
        for name in (element.text, element.text.strip()):
            if name in known:
                return name
        raise self.malformed(element.line, unknown_name(kind, name, known))

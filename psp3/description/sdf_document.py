"""Read an SDF file as strictly as its format allows, with its numbers, poses and included files.

The specification (sdformat.org) says what each element means. Comments in the code that reads an
element say what changed between the versions.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path
from xml.parsers import expat

import numpy as np
import pinocchio as pin

from fuzzy2.support.bounded_files import content_of, not_read
from psp3.checks import Array
from psp3.description.xml import BLANKS, NUMBER, BoundedBuilder, Refused, described
from psp3.errors import InvalidRobotFile

OLDEST = 4
"""The oldest version that is read is 1.4."""

INFINITE = re.compile(r"[+-]?inf(?:inity)?", re.IGNORECASE)
"""How an infinite limit may be written."""

PASSED_OVER = {b"<!--": b"-->", b"<![CDATA[": b"]]>"}
"""Begin and end of comments, and of literal text, in which a comment mark has no meaning.

The parser of SDFormat's library allows ``--`` within a comment, which strict XML does not. Comments
with drawings contain it.
"""

MOST_FILES = 200
"""The largest number of included files. A file that is included several times counts each time."""

WRITE_OUT = "let SDFormat's own tool write it out (gz sdf --print FILE) and read that"
"""What an error message advises for elements that a tool expands."""


class SdfDocument:
    """An SDF file.

    Parameters
    ----------
    path : path
        The file.
    roots : sequence of path
        Folders from which it may include other files; ``model://`` addresses are searched in them.
    included_by : SdfDocument, optional
        The file that includes it.

    Attributes
    ----------
    root : Element
        The element ``<sdf>``.
    version : int
        The second part of its version: 6 for version 1.6.

    Raises
    ------
    InvalidRobotFile
        If it is missing, is not an SDF or is older than version 1.4, or if too many files are
        included.
    """

    def __init__(
        self, path: str | Path, roots: Sequence[Path], included_by: SdfDocument | None = None
    ) -> None:
        self.path, self.roots = Path(path), tuple(roots)
        # Counted over all files of a robot, because a file that is included ten times by a file
        # that is included ten times is read a hundred times.
        self._read: list[Path] = [] if included_by is None else included_by._read
        self._read.append(self.path)
        if len(self._read) > MOST_FILES:
            raise self.wrong(f"is one of more than {MOST_FILES} files that are included")
        self.root = _parsed(self.path)
        if self.root.tag == "robot":
            raise self.wrong("is a URDF: read it with from_urdf")
        if self.root.tag != "sdf":
            raise self.wrong(f"its outermost element must be <sdf>, not <{self.root.tag}>")
        version = self.root.get("version", "")
        found = re.fullmatch(r"1\.([0-9]{1,3})", version)
        if found is None or int(found[1]) < OLDEST:
            raise self.wrong(
                f"<sdf>: version must be 1.{OLDEST} or later, got {version!r}; SDFormat's own tool "
                "writes an older file anew (gz sdf --print FILE)"
            )
        self.version = int(found[1])

    def wrong(self, reason: str) -> InvalidRobotFile:
        """Return the error for a reason, with the path of this file."""
        return InvalidRobotFile(self.path, reason)

    def titled(self, element: ElementTree.Element) -> str:
        """Return how messages name an element: the nearest named element around it, and its tag."""
        above = {child: parent for parent in self.root.iter() for child in parent}
        owner = element
        while owner.get("name") is None and owner in above:
            owner = above[owner]
        own = "" if owner is element else f": <{element.tag}>"
        return described(element if owner.get("name") is None else owner) + own

    # What an element holds

    def text(self, element: ElementTree.Element, tag: str) -> str | None:
        """Return the stripped text of the only child with a tag; None if there is no such child."""
        children = element.findall(tag)
        if len(children) > 1:
            raise self.wrong(f"{self.titled(element)} has {len(children)} of <{tag}>")
        return (children[0].text or "").strip(BLANKS) if children else None

    def name(self, element: ElementTree.Element, what: str = "name") -> str:
        """Return the name of an element, which must have one."""
        name = element.get(what)
        if not name:
            raise self.wrong(f"a <{element.tag}> has no {what}")
        return name

    def numbers(
        self, element: ElementTree.Element, tag: str, *counts: int, infinite: bool = False
    ) -> Array | None:
        """Return the numbers in the only child with a tag; None if there is none."""
        text = self.text(element, tag)
        return None if text is None else self._numbers(element, tag, text, counts, infinite)

    def _numbers(
        self,
        element: ElementTree.Element,
        tag: str,
        text: str,
        counts: Sequence[int],
        infinite: bool = False,
    ) -> Array:
        words = re.split(f"[{BLANKS}]+", text) if text else []
        values = np.array(
            [
                float(word)
                if NUMBER.fullmatch(word) or (infinite and INFINITE.fullmatch(word))
                else math.nan
                for word in words[: max(counts) + 1]
            ]
        )
        wrong = np.isnan(values).any() or (not infinite and np.isinf(values).any())
        if wrong or values.size not in counts:
            finite = "" if infinite else "finite "
            raise self.wrong(
                f"{self.titled(element)}: <{tag}> must be {' or '.join(map(str, counts))} {finite}"
                f"number{'s' if tuple(counts) != (1,) else ''}, got {text[:60]!r}"
            )
        return values

    def number(
        self,
        element: ElementTree.Element,
        tag: str,
        default: float,
        *,
        infinite: bool = False,
    ) -> float:
        """Return the single number in a child."""
        value = self.numbers(element, tag, 1, infinite=infinite)
        return default if value is None else float(value[0])

    def is_true(self, element: ElementTree.Element, tag: str, default: bool = False) -> bool:
        """Return whether a child says true."""
        text = self.text(element, tag)
        return default if text is None else self._boolean(element, tag, text)

    def has_flag(self, element: ElementTree.Element, attribute: str) -> bool:
        """Return whether an attribute says true."""
        return self._boolean(element, attribute, element.get(attribute, "false"))

    def _boolean(self, element: ElementTree.Element, what: str, text: str) -> bool:
        if text.lower() not in ("true", "false", "1", "0"):
            raise self.wrong(
                f"{self.titled(element)}: {what} must be true or false, got {text[:60]!r}"
            )
        return text.lower() in ("true", "1")

    def pose(self, element: ElementTree.Element) -> tuple[pin.SE3, str]:
        """Return the pose of an element, and the name of the frame to which it is relative."""
        text = self.text(element, "pose")
        if text is None:
            return pin.SE3.Identity(), ""
        pose = element.find("pose")
        assert pose is not None
        # Before version 1.7 the attribute had another name, and seldom had an effect.
        relative_to = pose.get("relative_to" if self.version >= 7 else "frame", "")
        if not text:
            return pin.SE3.Identity(), relative_to
        form = pose.get("rotation_format", "euler_rpy")
        if form == "quat_xyzw":
            values = self._numbers(element, "pose", text, (7,))
            length = float(np.linalg.norm(values[3:]))
            if not 1e-6 < length < 1e6:
                raise self.wrong(f"{self.titled(element)}: <pose> has a quaternion of zeros")
            return pin.SE3(pin.Quaternion(values[3:] / length), values[:3]), relative_to
        if form != "euler_rpy":
            raise self.wrong(f"{self.titled(element)}: <pose> has the unknown format {form!r}")
        values = self._numbers(element, "pose", text, (6,))
        unit = math.pi / 180.0 if self.has_flag(pose, "degrees") else 1.0
        return pin.SE3(pin.rpy.rpyToMatrix(*(unit * values[3:])), values[:3]), relative_to

    # Included files

    def included(self, element: ElementTree.Element) -> tuple[SdfDocument, ElementTree.Element]:
        """Return the file that an ``<include>`` names, and the one model in it.

        Raises
        ------
        InvalidRobotFile
            If it lies outside the allowed folders, is missing or does not hold exactly one model.
        """
        uri = self.text(element, "uri")
        if not uri:
            raise self.wrong("an <include> lacks <uri>")
        path = self._file(uri)
        if path.is_dir():
            path = self._file_of_model(path)
        document = SdfDocument(path, self.roots, self)
        models = document.root.findall("model")
        if len(models) != 1:
            raise self.wrong(
                f"<include>: {uri!r} holds {len(models)} models; what is included must hold one"
            )
        return document, models[0]

    def _file(self, uri: str) -> Path:
        scheme, found, rest = uri.partition("://")
        if not found:
            candidates = [self.path.parent / uri]
        elif scheme == "model":
            candidates = [root / rest for root in self.roots]
        else:
            raise self.wrong(
                f"<include>: {uri[:80]!r} is not read from there: put the model beside the file "
                "and name it by its path"
            )
        for candidate in candidates:
            resolved = candidate.resolve()
            inside = any(resolved.is_relative_to(root.resolve()) for root in self.roots)
            if not inside:
                raise self.wrong(
                    f"<include>: {uri[:80]!r} lies outside the folder of the file: name its "
                    "folder in model_paths=[...]"
                )
            if resolved.exists():
                return resolved
        raise self.wrong(
            f"<include>: {uri[:80]!r} is not there; looked for in "
            f"{', '.join(str(candidate) for candidate in candidates)}: name the folder that holds "
            "it in model_paths=[...]"
        )

    def _file_of_model(self, folder: Path) -> Path:
        """Return the newest SDF that the ``model.config`` of a folder names."""
        config = folder / "model.config"
        if not config.is_file():
            raise self.wrong(f"<include>: {folder} has no model.config: name the SDF file in it")
        names = [
            (tuple(map(int, item.get("version", "1.0").split("."))), (item.text or "").strip())
            for item in _parsed(config).findall("sdf")
            if re.fullmatch(r"[0-9]{1,3}(\.[0-9]{1,3})+", item.get("version", "1.0"))
        ]
        path = (folder / max(names)[1]).resolve() if names else folder
        if not path.is_file() or not path.is_relative_to(folder):
            raise self.wrong(f"<include>: {config} names no SDF file in its folder")
        return path


def _parsed(path: Path) -> ElementTree.Element:
    """Return the outermost element of an XML file.

    Names with a prefix (``drake:joint``) stay as they are written, whether the prefix is declared
    or not. Comments need not be well-formed, as in SDFormat's library. A document type declaration
    is refused, because some parsers expand its entities and others drop them.
    """
    if not path.is_file():
        raise InvalidRobotFile(path, "is a directory" if path.is_dir() else "no such file")
    parser, builder = expat.ParserCreate(), BoundedBuilder()
    parser.StartElementHandler, parser.EndElementHandler = builder.start, builder.end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = builder.doctype  # type: ignore[assignment]
    parser.buffer_text = True
    try:
        data = _without_comments(content_of(path).lstrip(BLANKS.encode()))
        parser.Parse(data, True)
        return builder.close()
    except Refused as error:
        raise InvalidRobotFile(path, str(error)) from None
    except (OSError, expat.ExpatError, LookupError, ValueError, AssertionError) as error:
        raise InvalidRobotFile(path, not_read(error, "cannot be read as XML")) from error


def _without_comments(content: bytes) -> bytes:
    """Return a file without its comments, but with their line breaks, to keep line numbers."""
    parts, at = [], 0
    for found in re.finditer(b"<!--|<!\\[CDATA\\[", content):
        if found.start() < at:
            continue
        end = content.find(PASSED_OVER[found[0]], found.end())
        if end < 0:
            break
        end += len(PASSED_OVER[found[0]])
        passed = content[found.start() : end]
        literal = found[0] != b"<!--"
        parts += [content[at : found.start()], passed if literal else b"\n" * passed.count(b"\n")]
        at = end
    return b"".join([*parts, content[at:]])

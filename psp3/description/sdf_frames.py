"""Resolve the names and poses of an SDF file.

Every model and world is a scope of names: its links, joints, frames and nested models, and
``__model__`` or ``world``. A pose is relative to one of these frames, and each frame is attached to
a link. This module finds frames by name and computes their placements in the world, in the pose of
the file.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from typing import NamedTuple

import pinocchio as pin

from psp3.description.sdf_document import SdfDocument
from psp3.description.xml import described

MODEL = "__model__"
"""The format's name for the frame of the model around an element."""

DEEPEST_MODEL = 30
"""The deepest nesting of models, and of included models, that is read."""


class Frame(NamedTuple):
    """A link, joint, frame or model: everything that has a name and a pose."""

    scope: Scope
    """The scope that holds its name."""
    name: str
    """Its name in the scope."""
    kind: str
    """``link``, ``joint``, ``frame``, ``model`` or ``world``."""
    element: ElementTree.Element
    """The element that describes it."""
    document: SdfDocument
    """The file of the element."""
    pose: pin.SE3
    """Its pose in the frame of ``relative_to``."""
    relative_to: str
    """A name in the scope."""
    attached_to: str
    """The name in the scope of what it moves with; its own name if it is a link."""
    model: str
    """The name in the scope of the frame that the element calls ``__model__``."""

    @property
    def full_name(self) -> str:
        """Its name in the robot."""
        return self.scope.prefix + self.name


class Scope:
    """The names of a model, or of a world.

    Parameters
    ----------
    prefix : str
        Prefix of its names in the robot.
    outer : Scope, optional
        The scope around it.

    Attributes
    ----------
    frames : dict of str to Frame
        Its frames by name.
    inner : dict of str to Scope
        Nested models.
    is_static : bool
        Whether nothing in it moves.
    """

    def __init__(self, prefix: str, outer: Scope | None = None) -> None:
        self.prefix, self.outer = prefix, outer
        self.frames: dict[str, Frame] = {}
        self.inner: dict[str, Scope] = {}
        self.is_static = False
        self.placement_frame = ""

    @property
    def own(self) -> str:
        """The name of the scope's own frame."""
        return MODEL if MODEL in self.frames else "world"

    def find(self, name: str, user: Frame) -> Frame:
        """Return the frame with a name, as an element uses it."""
        name = user.model if name == MODEL else name
        if name in self.frames:
            return self.frames[name]
        head, nested, rest = name.partition("::")
        if nested and head in self.inner and rest != MODEL:
            return self.inner[head].find(rest, user._replace(model=MODEL))
        if name == "world":
            raise user.document.wrong(
                f"{described(user.element)}: the frame 'world' is known in a model as the <parent> "
                "of joints alone: leave attached_to or relative_to out for the frame of the model"
            )
        known = [known for known in self.frames if known != self.own]
        raise user.document.wrong(
            f"{described(user.element)}: there is no {name[:80]!r} in {self.title}; it has "
            f"{', '.join(known[:12]) or 'none'}{' and others' if len(known) > 12 else ''}"
        )

    @property
    def title(self) -> str:
        """Its name in an error message."""
        return f"model {self.prefix[:-2]!r}" if self.prefix else "the model"


class Described(NamedTuple):
    """The contents of a file, in its order, before the tree is built."""

    links: list[Frame]
    joints: list[Frame]
    frames: list[Frame]
    models: list[Frame]


class Reader:
    """Reads the scopes of a file."""

    def __init__(self) -> None:
        self.found = Described([], [], [], [])
        self._placements: dict[tuple[int, str], pin.SE3] = {}
        self._bodies: dict[tuple[int, str], Frame | None] = {}

    # Reading

    def world(self, element: ElementTree.Element, document: SdfDocument, bare: str) -> None:
        """Read a world; the names in one of its models get no prefix."""
        scope = Scope("")
        identity = pin.SE3.Identity()
        scope.frames["world"] = Frame(
            scope, "world", "world", element, document, identity, "", "world", "world"
        )
        self._fill(scope, element, document, "world", 0, bare)

    def model(
        self,
        element: ElementTree.Element,
        document: SdfDocument,
        outer: Scope,
        depth: int = 0,
        *,
        include: tuple[ElementTree.Element, SdfDocument] | None = None,
        bare: str = "",
        model: str = "",
    ) -> None:
        """Read a model in the scope around it, or an included model with its placement."""
        if depth > DEEPEST_MODEL:
            raise document.wrong(
                f"{described(element)} is nested deeper than {DEEPEST_MODEL} models"
            )
        where, told = (element, document) if include is None else include
        name = document.name(element)
        if include is not None:
            name = told.text(where, "name") or name
        pose, relative_to = document.pose(element)
        placement_frame = element.get("placement_frame", "")
        if include is not None and where.find("pose") is not None:
            pose, relative_to = told.pose(where)
            placement_frame = told.text(where, "placement_frame") or ""
        scope = Scope("" if name == bare else f"{outer.prefix}{name}::", outer)
        scope.placement_frame = placement_frame
        scope.is_static = outer.is_static or document.is_true(element, "static")
        if include is not None:
            scope.is_static = outer.is_static or told.is_true(where, "static", scope.is_static)
        frame = Frame(
            outer, name, "model", where, told, pose, relative_to, name, model or outer.own
        )
        self._put(outer, frame)
        outer.inner[name] = scope
        own = frame._replace(scope=scope, name=MODEL, element=element, document=document)
        scope.frames[MODEL] = own._replace(model=MODEL)
        self.found.models.append(frame)
        self._fill(scope, element, document, MODEL, depth)

    def _merged(
        self,
        include: ElementTree.Element,
        told: SdfDocument,
        scope: Scope,
        model: str,
        depth: int,
    ) -> None:
        """Read an included model whose names are merged into the scope around it."""
        document, element = told.included(include)
        if depth > DEEPEST_MODEL:
            raise document.wrong(f"{described(element)} is included deeper than {DEEPEST_MODEL}")
        name = told.text(include, "name") or document.name(element)
        proxy = f"_merged__{name}__model__"
        where = told, include
        if include.find("pose") is None:
            where = document, element
        pose, relative_to = where[0].pose(where[1])
        placement_frame = told.text(include, "placement_frame") or element.get(
            "placement_frame", ""
        )
        if placement_frame:
            raise told.wrong(
                f"<include>: {name!r} is merged by its frame {placement_frame!r}, which is not "
                "read; include it without merge, or give the pose of its model"
            )
        links = [link.get("name", "") for link in element.findall("link")]
        canonical = element.get("canonical_link") or (links[0] if links else "")
        if not canonical:
            raise told.wrong(f"<include>: {name!r} is merged, but has no link")
        self._put(
            scope,
            Frame(
                scope,
                proxy,
                "frame",
                include,
                told,
                pose,
                relative_to or model,
                canonical,
                model,
            ),
        )
        self._fill(scope, element, document, proxy, depth)

    def _fill(
        self,
        scope: Scope,
        element: ElementTree.Element,
        document: SdfDocument,
        model: str,
        depth: int,
        bare: str = "",
    ) -> None:
        """Read the contents of a model or world."""
        for item in element:
            if item.tag == "model":
                self.model(item, document, scope, depth + 1, bare=bare, model=model)
            elif item.tag == "include" and document.has_flag(item, "merge"):
                self._merged(item, document, scope, model, depth + 1)
            elif item.tag == "include":
                other, inner = document.included(item)
                self.model(
                    inner, other, scope, depth + 1, include=(item, document), bare=bare, model=model
                )
            elif item.tag in ("link", "joint", "frame"):
                self._item(scope, item, document, model)

    def _item(
        self, scope: Scope, item: ElementTree.Element, document: SdfDocument, model: str
    ) -> None:
        if item.tag == "frame" and document.version < 7:
            # Frames had no meaning before this version.
            return
        if item.tag == "link" and scope.own == "world":
            raise document.wrong(f"{described(item)} is in the <world>: put it in a <model>")
        name = document.name(item)
        if name in (MODEL, "world"):
            raise document.wrong(f"{described(item)} has a name that the format keeps for itself")
        pose, relative_to = document.pose(item)
        attached_to = name
        if item.tag == "joint":
            attached_to = document.text(item, "child") or ""
            relative_to = relative_to or attached_to
            if attached_to in ("", "world"):
                raise document.wrong(f"{described(item)}: <child> must be a link of a model")
        elif item.tag == "frame":
            attached_to = item.get("attached_to") or model
            relative_to = relative_to or attached_to
        frame = Frame(
            scope, name, item.tag, item, document, pose, relative_to or model, attached_to, model
        )
        self._put(scope, frame)
        kinds = {"link": self.found.links, "joint": self.found.joints, "frame": self.found.frames}
        kinds[item.tag].append(frame)

    def _put(self, scope: Scope, frame: Frame) -> None:
        known = scope.frames.get(frame.name)
        if known is None:
            scope.frames[frame.name] = frame
        elif frame.document.version >= 7 or known.kind == frame.kind or frame.kind == "model":
            raise frame.document.wrong(
                f"there are two of {frame.name!r}: {described(known.element)} and "
                f"{described(frame.element)}"
            )
        elif frame.kind == "link":
            # A joint could have the name of a link. Poses then refer to the link.
            scope.frames[frame.name] = frame

    # Placements

    def placement(self, frame: Frame, users: Sequence[Frame] = ()) -> pin.SE3:
        """Return the placement of a frame in the world, in the pose of the file."""
        key = id(frame.scope), frame.kind + frame.name
        if key in self._placements:
            return self._placements[key]
        if any((id(user.scope), user.kind + user.name) == key for user in users):
            raise frame.document.wrong(
                f"poses are relative to each other: {', '.join(user.name for user in users)}"
            )
        users = (*users, frame)
        if frame.kind == "world":
            place = pin.SE3.Identity()
        elif frame.kind == "model" and frame.name == MODEL:
            outer = frame.scope.outer
            assert outer is not None
            place = self._of_model(frame, outer, users)
        elif frame.kind == "model":
            place = self.placement(frame.scope.inner[frame.name].frames[MODEL], users)
        else:
            base = frame.scope.find(frame.relative_to, frame)
            place = self.placement(base, users) * frame.pose
        self._placements[key] = place
        return place

    def _of_model(self, frame: Frame, outer: Scope, users: Sequence[Frame]) -> pin.SE3:
        """Return the placement of a model's own frame, which a placement frame may determine."""
        scope = frame.scope
        as_outer = outer.frames[frame.attached_to]
        base = outer.find(frame.relative_to or as_outer.model, as_outer)
        place = self.placement(base, users) * frame.pose
        if not scope.placement_frame:
            return place
        # The placement frame's place in the model does not depend on the place of the model.
        at, inside = scope.find(scope.placement_frame, frame), pin.SE3.Identity()
        for _ in range(len(users) + sum(map(len, _all_frames(scope)))):
            if at is frame:
                return place * inside.inverse()
            if at.kind == "model" and at.name != MODEL:
                inner = at.scope.inner[at.name].frames[MODEL]
                if at.scope.inner[at.name].placement_frame:
                    break
                inside, at = at.pose * inside, at.scope.find(inner.relative_to or at.model, at)
                continue
            inside, at = at.pose * inside, at.scope.find(at.relative_to, at)
        raise frame.document.wrong(
            f"{described(frame.element)}: its placement_frame {scope.placement_frame!r} is not "
            "placed in the model"
        )

    def link(self, frame: Frame, users: Sequence[Frame] = ()) -> Frame | None:
        """Return the link that a frame moves with; None for the world."""
        key = id(frame.scope), frame.kind + frame.name
        if key in self._bodies:
            return self._bodies[key]
        if any((id(user.scope), user.kind + user.name) == key for user in users):
            raise frame.document.wrong(
                f"frames are attached to each other: {', '.join(user.name for user in users)}"
            )
        users = (*users, frame)
        if frame.kind == "world":
            body = None
        elif frame.kind == "link":
            body = frame
        elif frame.kind == "model":
            scope = frame.scope if frame.name == MODEL else frame.scope.inner[frame.name]
            body = None if scope.is_static else self._canonical(scope, users)
        else:
            body = self.link(frame.scope.find(frame.attached_to, frame), users)
        self._bodies[key] = body
        return body

    def _canonical(self, scope: Scope, users: Sequence[Frame]) -> Frame | None:
        """Return the link that a model's own frame moves with; by default the first."""
        own = scope.frames[MODEL]
        name = own.element.get("canonical_link", "")
        if name:
            return self.link(scope.find(name, own), users)
        for frame in scope.frames.values():
            if frame.kind == "link":
                return frame
        for inner in scope.inner.values():
            return self._canonical(inner, users)
        raise own.document.wrong(f"{described(own.element)} has no link")


def _all_frames(scope: Scope) -> list[dict[str, Frame]]:
    """Return the frames of a scope and of all scopes in it."""
    return [scope.frames, *(f for inner in scope.inner.values() for f in _all_frames(inner))]

"""Parts of an SDF file that are not read: an error if they change the robot, else a warning."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping, Sequence

from fuzzy2.support.logs import logger_named
from psp3.description.sdf_document import SdfDocument
from psp3.description.sdf_frames import Frame, Reader
from psp3.description.sdf_joints import Joint
from psp3.description.sdf_tree import Tree
from psp3.description.xml import described

logger = logger_named(__name__)

MECHANICAL = ("joint", "ball_constraint", "linear_bushing_rpy", "tendon_constraint", "link")
"""Elements of other formats, without their prefix, that change the robot if they are left out."""

MOST_NAMED = 10
"""The largest number of elements that one warning names."""

Words = Mapping[str, frozenset[str]]


def _words(**texts: str) -> Words:
    return {tag: frozenset(text.split()) for tag, text in texts.items()}


CHILDREN = _words(
    sdf="world model actor light",
    world="model include joint frame gravity physics audio wind magnetic_field atmosphere gui "
    "scene light actor plugin road spherical_coordinates state population",
    model="static self_collide allow_auto_disable enable_wind pose frame link joint model include "
    "plugin gripper model_state",
    link="gravity enable_wind self_collide kinematic must_be_base_link velocity_decay pose frame "
    "inertial collision visual sensor projector audio_sink audio_source battery light "
    "particle_emitter",
    velocity_decay="linear angular",
    inertial="mass pose frame inertia fluid_added_mass density auto_inertia_params",
    inertia="ixx iyy izz ixy ixz iyz",
    joint="parent child pose frame axis axis2 gearbox_ratio gearbox_reference_body thread_pitch "
    "screw_thread_pitch physics sensor",
    axis="xyz use_parent_model_frame initial_position dynamics limit mimic",
    axis2="xyz use_parent_model_frame initial_position dynamics limit mimic",
    dynamics="damping friction spring_reference spring_stiffness",
    limit="lower upper effort velocity stiffness dissipation",
    mimic="multiplier offset reference",
    include="uri pose name static placement_frame plugin namespace model_state",
    frame="pose",
    visual="geometry pose frame material cast_shadows laser_retro transparency visibility_flags "
    "meta plugin",
)
"""The children that the format allows in each element, whether they are read or not."""

_LEAVES = (
    "pose mass uri name static gravity parent child xyz lower upper effort velocity damping "
    "friction spring_reference spring_stiffness ixx iyy izz ixy ixz iyz gearbox_ratio kinematic "
    "thread_pitch screw_thread_pitch gearbox_reference_body multiplier offset reference "
    "placement_frame"
)
LEAVES = frozenset(re.findall("[a-z_]+", _LEAVES))
"""Elements that hold text alone."""

ATTRIBUTES = _words(
    sdf="version",
    world="name",
    model="name canonical_link placement_frame",
    link="name",
    joint="name type",
    frame="name attached_to",
    include="merge",
    inertial="auto",
    mimic="joint axis",
    pose="relative_to frame rotation_format degrees",
    xyz="expressed_in",
    visual="name",
)
"""The attributes that the format allows in each element."""


def refuse_extensions(reader: Reader) -> None:
    """Raise :class:`InvalidRobotFile` if a model holds a joint or link of another format."""
    for model in reader.found.models:
        for item in model.element.iter():
            prefix, is_foreign, tag = item.tag.partition(":")
            if is_foreign and tag in MECHANICAL:
                raise model.document.wrong(
                    f"{described(item)} is of {prefix}, not of SDF, and leaving it out would "
                    "change the robot: write it as an SDF joint, or give it in Python "
                    "(closures=[...])"
                )


def tell(document: SdfDocument, tree: Tree, joints: Sequence[Joint]) -> None:
    """Log what is left out, and which default of the format replaces what is missing."""
    found = tree.reader.found
    ignored = [
        f"{what} of ball joint {joint.name}"
        for joint in joints
        if joint.kind == "ball"
        for dynamics in joint.frame.element.findall("axis/dynamics")
        for tag, what in (("friction", "dry friction"), ("spring_stiffness", "spring"))
        if joint.frame.document.number(dynamics, tag, 0.0)
    ]
    ignored += [f"joint {name}, whose links are welded" for name in tree.still]
    for link in found.links:
        if tree.place(link).joint:
            ignored += [f"{what} of link {link.full_name}" for what in _unknown(link)]
    _warn(document, "the equation of motion does not know", ignored)
    _warn(document, "without <inertial>, so by the format of 1 kg and 1 kg m²", tree.unspecified)
    roots = [document.root, *(model.element for model in found.models)]
    _warn(document, "not of the format, and not read", _foreign(roots))


def _warn(document: SdfDocument, what: str, items: Sequence[str]) -> None:
    if items:
        more = f" and {len(items) - MOST_NAMED} more" if len(items) > MOST_NAMED else ""
        logger.warning("%s: %s: %s%s", document.path, what, ", ".join(items[:MOST_NAMED]), more)


def _unknown(link: Frame) -> list[str]:
    """Return the properties of a link that the equation of motion does not contain."""
    document, element = link.document, link.element
    found = []
    if not document.is_true(element, "gravity", True):
        found.append("lack of gravity")
    if document.is_true(element, "kinematic"):
        raise document.wrong(f"{described(element)} is kinematic, which is not supported")
    if document.is_true(element, "enable_wind"):
        found.append("wind")
    decay = element.find("velocity_decay")
    if decay is not None and any(document.number(decay, tag, 0.0) for tag in ("linear", "angular")):
        found.append("drag (velocity_decay)")
    if element.find("inertial/fluid_added_mass") is not None:
        found.append("added mass of a fluid")
    return found


def _foreign(roots: Sequence[ElementTree.Element]) -> list[str]:
    """Return elements and attributes that the format does not allow at their place, once each."""
    found = dict.fromkeys(what for root in roots for what in _strange(root))
    return list(found)


def _strange(root: ElementTree.Element) -> Iterator[str]:
    waiting = [root]
    while waiting:
        element = waiting.pop()
        if element.tag in ATTRIBUTES or element.tag in CHILDREN or element.tag in LEAVES:
            known = ATTRIBUTES.get(element.tag, frozenset())
            for name in element.keys():  # noqa: SIM118 - an element is no mapping
                if name not in known and not name.startswith("xmlns") and ":" not in name:
                    yield f"{name} of {described(element)[:80]}"
        children = CHILDREN.get(element.tag, frozenset())
        if element.tag not in CHILDREN and element.tag not in LEAVES:
            continue
        for child in element:
            if child.tag not in children:
                yield f"<{child.tag[:60]}> in {described(element)[:80]}"
            # Models are checked separately, together with those of included files.
            elif child.tag != "model":
                waiting.append(child)

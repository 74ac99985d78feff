"""Attributes and elements of MJCF, the format of MuJoCo, in the sections that are read.

They are from the schema of MuJoCo 4.0.0 (``mj_printSchema``). A word that is not listed is
misspelled or newer. It would have no effect, so it is logged as a warning.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator

from psp3.description.xml import described

SECTIONS = frozenset(
    {
        "actuator",
        "asset",
        "compiler",
        "contact",
        "custom",
        "default",
        "deformable",
        "equality",
        "extension",
        "include",
        "keyframe",
        "option",
        "sensor",
        "size",
        "statistic",
        "tendon",
        "visual",
        "worldbody",
    }
)
"""The sections that a file may hold."""

FREE = frozenset({"visual", "statistic", "sensor", "custom", "extension", "contact", "deformable"})
"""Sections that do not describe the mechanism; their words are not checked."""

ATTRIBUTES = {
    tag: frozenset(names.split())
    for tag, names in {
        "compiler": (
            "alignfree angle assetdir autolimits balanceinertia boundinertia boundmass "
            "conflict coordinate discardvisual eulerseq fitaabb fusestatic "
            "inertiafromgeom inertiagrouprange meshdir passthrough savecanonical "
            "savecompiled saveinertial settotalmass strippath texturedir usethread"
        ),
        "option": (
            "actuatorgroupdisable ccd_iterations ccd_tolerance cone density gravity "
            "impratio integrator iterations jacobian ls_iterations ls_tolerance "
            "magnetic noslip_iterations noslip_tolerance o_friction o_margin o_solimp "
            "o_solref sdf_initpoints sdf_iterations sleep_tolerance solver timestep "
            "tolerance viscosity wind"
        ),
        "mesh": (
            "builtin class content_type face file inertia material maxhullvert name "
            "normal params refpos refquat scale smoothnormal texcoord vertex"
        ),
        "material": (
            "class emission metallic name reflectance rgba roughness shininess specular "
            "texrepeat texture texuniform"
        ),
        "model": "content_type file name",
        "body": (
            "axisangle childclass euler fuse gravcomp mocap name pos quat simple sleep "
            "user xyaxes zaxis"
        ),
        "inertial": "axisangle diaginertia euler fullinertia mass pos quat xyaxes zaxis",
        "joint": (
            "active actuatorfrclimited actuatorfrcrange actuatorgravcomp armature axis "
            "class coef damping frictionloss group joint joint1 joint2 limited margin "
            "name polycoef pos range ref solimp solimpfriction solimplimit solref "
            "solreffriction solreflimit springdamper springref springyield stiffness "
            "type user"
        ),
        "freejoint": "align group name",
        "geom": (
            "adhesion axisangle castshadow class conaffinity condim contype density "
            "euler fitscale fluidcoef fluidshape friction fromto gap geom group hfield "
            "margin mass material mesh name pos priority quat rgba shellinertia "
            "sidesite size solimp solmix solref surfacevel type user xyaxes zaxis"
        ),
        "attach": "body frame model prefix",
        "site": (
            "axisangle class euler fromto group material mesh name pos quat rgba site "
            "size type user xyaxes zaxis"
        ),
        "frame": "axisangle childclass euler name pos quat xyaxes zaxis",
        "replicate": "childclass count euler offset sep",
        "connect": "active anchor body1 body2 class name site1 site2 solimp solref",
        "weld": (
            "active anchor body1 body2 class name relpose site1 site2 solimp solref torquescale"
        ),
        "fixed": (
            "actuatorfrclimited actuatorfrcrange armature class damping frictionloss "
            "group limited margin name range solimpfriction solimplimit solreffriction "
            "solreflimit springlength springyield stiffness user"
        ),
        "key": "act ctrl mpos mquat name plastic qpos qvel time",
        "default": "class",
        "equality": "active solimp solref",
        "tendon": (
            "active actuatorfrclimited actuatorfrcrange armature class damping "
            "frictionloss group limited margin material name polycoef range rgba solimp "
            "solimpfriction solimplimit solref solreffriction solreflimit springlength "
            "springyield stiffness tendon1 tendon2 user width"
        ),
        "adhesion": (
            "body class ctrlrange delay forcelimited forcerange gain group interp name nsample user"
        ),
        "cylinder": (
            "area armature bias class cranklength cranksite ctrllimited ctrlrange "
            "damping delay diameter forcelimited forcerange gear group interp joint "
            "jointinparent lengthrange name nsample refsite site slidersite tendon "
            "timeconst user"
        ),
        "damper": (
            "armature class cranklength cranksite ctrlrange damping delay forcelimited "
            "forcerange gear group interp joint jointinparent kv lengthrange name "
            "nsample refsite site slidersite tendon user"
        ),
        "dcmotor": (
            "armature class cogging controller cranklength cranksite ctrllimited "
            "ctrlrange damping delay gear group inductance input interp joint "
            "jointinparent lengthrange lugre motorconst name nominal nsample refsite "
            "resistance saturation site slidersite tendon thermal user"
        ),
        "general": (
            "actdim actearly actlimited actrange armature biasprm biastype body class "
            "cranklength cranksite ctrllimited ctrlrange damping delay dynprm dyntype "
            "ffrange forcelimited forcerange gainprm gaintype gear group inheritrange "
            "input interp joint jointinparent lengthrange name nsample refsite site "
            "slidersite tendon user velrange"
        ),
        "intvelocity": (
            "actlimited actrange armature class cranklength cranksite ctrllimited "
            "ctrlrange damping dampratio delay forcelimited forcerange gear group "
            "inheritrange interp joint jointinparent kp kv lengthrange name nsample "
            "refsite site slidersite tendon user"
        ),
        "motor": (
            "armature class cranklength cranksite ctrllimited ctrlrange damping delay "
            "forcelimited forcerange gear group interp joint jointinparent lengthrange "
            "name nsample refsite site slidersite tendon user"
        ),
        "muscle": (
            "armature class cranklength cranksite ctrllimited ctrlrange damping delay "
            "force forcelimited forcerange fpmax fvmax gear group interp joint "
            "jointinparent lengthrange lmax lmin name nsample range scale slidersite "
            "tausmooth tendon timeconst user vmax"
        ),
        "orientation": (
            "class ctrlrange dampratio delay forcelimited forcerange group input interp "
            "joint kp kv name nsample refsite site user"
        ),
        "pid": (
            "armature class cranklength cranksite ctrllimited ctrlrange damping "
            "dampratio delay ffrange forcelimited forcerange gear group imax "
            "inheritrange input interp joint jointinparent ki kp kv lengthrange name "
            "nsample posrange refsite site slewmax slidersite tendon user velrange"
        ),
        "position": (
            "armature class cranklength cranksite ctrllimited ctrlrange damping "
            "dampratio delay forcelimited forcerange gear group inheritrange interp "
            "joint jointinparent kp kv lengthrange name nsample refsite site slidersite "
            "tendon timeconst user"
        ),
        "velocity": (
            "armature class cranklength cranksite ctrllimited ctrlrange damping delay "
            "forcelimited forcerange gear group interp joint jointinparent kv "
            "lengthrange name nsample refsite site slidersite tendon user"
        ),
    }.items()
}
"""Allowed attributes by element; elements that share a name share one set."""

HOLDERS = {
    tag: frozenset(names.split())
    for tag, names in {
        "default": (
            "adhesion camera cylinder damper dcmotor default equality general geom "
            "include intvelocity joint light material mesh motor muscle orientation "
            "pair pid position site tendon texture velocity"
        ),
        "asset": "hfield include material mesh model skin texture",
        "equality": "connect flex flexstrain include joint tendon weld",
        "tendon": "fixed include spatial",
        "actuator": (
            "adhesion cylinder damper dcmotor general include intvelocity motor muscle "
            "orientation pid plugin position velocity"
        ),
        "keyframe": "include key",
        "fixed": "include joint",
        "compiler": "include lengthrange",
        "option": "flag include",
    }.items()
}
"""Allowed children of some sections and elements."""


def unknown_words(root: ElementTree.Element) -> Iterator[str]:
    """Yield a description of each word that the format does not have, for a warning."""
    for section in root:
        if section.tag not in SECTIONS:
            yield f"the section {described(section)}"
        elif section.tag not in FREE:
            yield from _unknown_in(section)


def _unknown_in(element: ElementTree.Element) -> Iterator[str]:
    known, held = ATTRIBUTES.get(element.tag), HOLDERS.get(element.tag)
    if known is not None:
        for name in element.attrib:
            if name not in known:
                yield f"attribute {name!r} of {described(element)}"
    for child in element:
        # In <default>, <equality> and <tendon> are elements without children, not sections.
        if held is not None and len(element) and child.tag not in held:
            yield f"{described(child)} in {described(element)}"
        else:
            yield from _unknown_in(child)

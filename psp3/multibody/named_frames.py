"""Find frames of a tree by name. A body and a joint may have the same name."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin

from psp3.checks import is_text
from psp3.errors import UnknownName

KINDS = {
    "body": (pin.FrameType.BODY,),
    "frame": (pin.FrameType.OP_FRAME, pin.FrameType.SENSOR),
    "joint": (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT),
}
"""Kinds of frames that may share a name; without a prefix, a name means the first one that exists.
"""


def frames_named(model: pin.Model, name: str) -> list[int]:
    """Return the numbers of all frames that a name may mean, in order of preference.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    name : str
        A name, with the prefix ``body:``, ``frame:`` or ``joint:`` to select the kind.
    """
    kinds: Sequence[str] = tuple(KINDS)
    before, colon, after = name.partition(":")
    if colon and before in KINDS and not model.existFrame(name):
        name, kinds = after, (before,)
    types = [one for kind in kinds for one in KINDS[kind]]
    return [int(model.getFrameId(name, one)) for one in types if model.existFrame(name, one)]


def frame_number(model: pin.Model, name: str) -> int:
    """Return the number of the frame with a name.

    If several frames have the name, a body comes before an added frame, and an added frame before a
    joint; ``joint:arm`` means the frame of the joint ``arm``.

    Raises
    ------
    UnknownName
        If the model has no such frame; the error lists the known ones.
    """
    numbers = frames_named(model, name) if is_text(name) else []
    if not numbers:
        raise UnknownName("frame", name, [frame.name for frame in model.frames])
    return numbers[0]

"""Frames of a tree by their names, where a body and a joint may have the same one."""

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
"""Kinds of frames that may have one name, in the order in which a name alone means them."""


def frames_named(model: pin.Model, name: str) -> list[int]:
    """Return the numbers of all frames that a name may mean, the likeliest first.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    name : str
        A name, or one after ``body:``, ``frame:`` or ``joint:``, which means this kind alone.
    """
    kinds: Sequence[str] = tuple(KINDS)
    before, colon, after = name.partition(":")
    if colon and before in KINDS and not model.existFrame(name):
        name, kinds = after, (before,)
    types = [one for kind in kinds for one in KINDS[kind]]
    return [int(model.getFrameId(name, one)) for one in types if model.existFrame(name, one)]


def frame_number(model: pin.Model, name: str) -> int:
    """Return the number of the frame of a name.

    Where several have it, a body comes before a frame that was added, and that before a joint;
    ``joint:arm`` means the frame of the joint ``arm``.

    Raises
    ------
    UnknownName
        If the model has no such frame; the error lists the known ones.
    """
    numbers = frames_named(model, name) if is_text(name) else []
    if not numbers:
        raise UnknownName("frame", name, [frame.name for frame in model.frames])
    return numbers[0]

"""Compare how MuJoCo reads an MJCF file with how this package reads it.

MuJoCo compiles the file itself. Both readers must agree on the mass and inertia of everything that
moves independently, and on the places of bodies and sites.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.description.mjcf import read_mjcf
from psp3.description.mjcf_expansion import spelled_out
from psp3.description.mjcf_tree import MjcfJoint, plain_mjcf
from psp3.errors import MissingPackage

AGREEMENT = 1e-6
"""Two numbers agree if they differ by at most this share of the larger one, or of the robot's size.
Rounding errors of both readers are below 1e-12, but MuJoCo stores mesh vertices in single
precision.
"""

REFUSED = "file"
"""What MuJoCo refuses, instead of reading it otherwise."""


class Disagreement(NamedTuple):
    """A quantity that the two readers of a file give differently."""

    what: str
    """``file``, ``mass``, ``center of mass``, ``inertia`` or ``place``."""
    name: str
    """Name of the body or site."""
    ours: Any
    """The value that this package reads, in the axes of the world."""
    theirs: Any
    """The value that MuJoCo compiles."""

    def __str__(self) -> str:
        if self.what == REFUSED:
            return f"MuJoCo refuses {self.name}, which is read here: {self.theirs}"
        return f"{self.what} of {self.name}: {self.ours} here, {self.theirs} by MuJoCo"


def mujoco_disagreements(path: str | Path) -> list[Disagreement]:
    """Compare an MJCF file as this package reads it with the model that MuJoCo compiles.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    list of Disagreement
        Empty if both agree; a single one of kind ``file`` if MuJoCo refuses a file that this
        package reads.

    Raises
    ------
    InvalidRobotFile
        If this package cannot read it.
    MissingPackage
        If MuJoCo is not installed.
    """
    try:
        import mujoco
    except ImportError as error:
        raise MissingPackage("mujoco", "mujoco", error) from error
    plain = plain_mjcf(spelled_out(path))
    model = read_mjcf(path, []).model
    try:
        engine = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        return [Disagreement(REFUSED, str(path), "read", " ".join(str(error).split()))]
    data, ours = mujoco.MjData(engine), model.createData()
    found = []
    # Compare the reference pose, and a pose in which every joint has moved.
    for amount in (0.0, 0.3):
        velocity = amount * np.cos(np.arange(model.nv))
        q = pin.integrate(model, pin.neutral(model), velocity)
        data.qpos[:] = _positions(plain.joints, model, q)
        mujoco.mj_kinematics(engine, data)
        mujoco.mj_comPos(engine, data)
        pin.framesForwardKinematics(model, ours, q)
        found += _places(plain.bodies, model, ours, engine, data)
        if amount == 0.0:
            found += _inertias(plain.bodies, model, ours, engine, data)
        if found:
            break
    return found


def _positions(joints: tuple[MjcfJoint, ...], model: pin.Model, q: Array) -> Array:
    """Return MuJoCo's coordinates of a configuration."""
    parts = []
    for item in joints:
        joint = model.joints[model.getJointId(item.name)]
        own = q[joint.idx_q : joint.idx_q + joint.nq]
        if item.kind == "free":
            x, y, z, *turn = pin.SE3ToXYZQUAT(item.placement * pin.XYZQUATToSE3(own))
            parts.append([x, y, z, turn[3], *turn[:3]])
        elif item.kind == "ball":
            parts.append([own[3], *own[:3]])
        else:
            parts.append([own[0] + item.reference])
    return np.concatenate([np.zeros(0), *parts])


def _places(
    bodies: tuple[str, ...], model: pin.Model, ours: Any, engine: Any, data: Any
) -> list[Disagreement]:
    import mujoco

    compared = [
        (name, pin.FrameType.BODY, data.xpos[number], data.xmat[number])
        for number, name in enumerate(bodies)
    ]
    for number in range(engine.nsite):
        name = mujoco.mj_id2name(engine, mujoco.mjtObj.mjOBJ_SITE, number)
        if name:
            place = data.site_xpos[number], data.site_xmat[number]
            compared.append((name, pin.FrameType.OP_FRAME, *place))
    size = max(1.0, float(np.abs(data.xpos).max(initial=0.0)))
    found = []
    for name, kind, position, rotation in compared:
        place = ours.oMf[model.getFrameId(name, kind)]
        gap = np.abs(place.translation - position).max() / size
        turn = np.abs(place.rotation.ravel() - rotation).max()
        if not max(gap, turn) <= AGREEMENT:
            found.append(Disagreement("place", name, place.translation, position.copy()))
    return found


def _inertias(
    bodies: tuple[str, ...], model: pin.Model, ours: Any, engine: Any, data: Any
) -> list[Disagreement]:
    """Compare the sums over bodies that do not move relative to each other."""
    total: dict[int, pin.Inertia] = {}
    for number in range(1, engine.nbody):
        own = pin.Inertia(
            float(engine.body_mass[number]), np.zeros(3), np.diag(engine.body_inertia[number])
        )
        place = pin.SE3(data.ximat[number].reshape(3, 3), data.xipos[number])
        root = int(engine.body_weldid[number])
        total[root] = total.get(root, pin.Inertia.Zero()) + place.act(own)
    found = []
    for root, theirs in total.items():
        if root == 0 or engine.body_mocapid[root] >= 0:
            # Fixed bodies need no inertia, and this package gives them none.
            continue
        name = bodies[root]
        joint = model.frames[model.getFrameId(name, pin.FrameType.BODY)].parentJoint
        inertia = ours.oMi[joint].act(model.inertias[joint])
        size = max(1.0, float(np.abs(theirs.lever).max()))
        largest = float(np.abs(theirs.inertia).max())
        for what, one, other, scale in (
            ("mass", inertia.mass, theirs.mass, theirs.mass),
            ("center of mass", inertia.lever, theirs.lever, size),
            ("inertia", inertia.inertia, theirs.inertia, largest),
        ):
            if not np.abs(np.subtract(one, other)).max() <= AGREEMENT * scale:
                found.append(Disagreement(what, name, one, other))
    return found

"""Drake reads SDF files to the same places, mass matrices and gravity, where it is installed.

Only trees that stand on the world: of a loop Drake would need its own kind of constraint.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.description.sdf import read_sdf
from tests.psp3.description import sdf_mechanisms as made

drake = pytest.importorskip(
    "pydrake.all", reason="Drake (pip install drake) is no part of the tests' extras"
)


def chain(version: str) -> str:
    """Return a chain of all joints that Drake knows with one axis."""
    links = [
        made.link("one", made.place(0.1, 0.2, 0.3, 0.4, -0.5, 0.6)),
        made.link("two", made.place(0.3, -0.2, 0.5, 0.1, 0.2, -0.6)),
        made.link("three", made.place(-0.1, 0.6, 0.4, 0.9, 0.0, 0.3)),
        made.link("four", made.place(0.2, 0.2, 0.9)),
    ]
    joints = [
        made.Hung("first", "revolute", "", "one", made.place(0.1, 0.0, 0.2), (made.OBLIQUE,)),
        made.Hung(
            "second",
            "prismatic",
            "one",
            "two",
            made.place(0.2, 0.1, 0.2, 0.3, 0.1, 0.0),
            ((1.0, 2.0, 0.0),),
        ),
        made.Hung("weld", "fixed", "two", "three", made.place(0.0, 0.0, 0.0)),
        made.Hung("third", "continuous", "three", "four", made.place(0.3, 0.3, 0.3), (made.Z,)),
    ]
    return made.sdf(links, joints, version)


FRAMES = """<sdf version="1.9"><model name="m"><pose>1 2 3 0.1 0.2 0.3</pose>
<model name="n" placement_frame="f"><pose relative_to="a">0.1 0 0.2 0.3 0 0.5</pose>
<link name="b"><pose degrees="true">0 0 1 30 20 10</pose></link>
<frame name="f" attached_to="b"><pose>0.2 0.1 0 0 0.4 0</pose></frame></model>
<link name="a"><pose>0 0.5 0 0.4 0 0</pose></link>
<link name="c"><pose relative_to="n::f">0.3 0 0.1 0 0 0.2</pose></link>
<joint name="first" type="revolute"><parent>world</parent><child>a</child><axis>
<xyz expressed_in="__model__">1 1 0</xyz></axis></joint>
<joint name="second" type="revolute"><parent>a</parent><child>n::f</child><axis>
<xyz expressed_in="n::b">0 1 0.5</xyz></axis></joint>
<joint name="third" type="prismatic"><pose relative_to="first">0 0 0.3 0.5 0 0</pose>
<parent>n::b</parent><child>c</child><axis><xyz>0 1 0</xyz></axis></joint>
</model></sdf>"""


@pytest.mark.parametrize("text", [chain("1.6"), chain("1.9"), FRAMES], ids=["1.6", "1.9", "frames"])
def test_trees_are_those_of_drake(text: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.sdf"
    path.write_text(text, encoding="utf-8")
    model = read_sdf(path, []).model
    plant: Any = drake.MultibodyPlant(0.0)
    drake.Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    rng = np.random.default_rng(0)
    q, order = rng.uniform(-0.5, 0.5, model.nq), []
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_velocities():
            number = model.joints[model.getJointId(joint.name())].idx_q
            order.append((joint.velocity_start(), number))
    order = [number for _, number in sorted(order)]
    plant.SetPositions(context, q[order])
    # Rounding of 1e-16 times lengths of a few meters and the few products of each entry.
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    for name in {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}:
        body = plant.GetBodyByName(name.rpartition("::")[2])
        place = plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4()
        ours = data.oMf[model.getFrameId(name, pin.FrameType.BODY)].homogeneous
        assert_allclose(ours, place, atol=1e-13)
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    assert_allclose(mass[np.ix_(order, order)], plant.CalcMassMatrix(context), atol=1e-13)
    gravity = pin.computeGeneralizedGravity(model, data, q)
    assert_allclose(gravity[order], -plant.CalcGravityGeneralizedForces(context), atol=1e-12)

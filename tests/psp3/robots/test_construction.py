"""Motors and closures by name."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_array_equal

from psp3.errors import InvalidValue, UnknownName
from psp3.multibody.equations import Hinge
from psp3.robots.construction import CLOSURE_KINDS, motor_matrix, named_closures


def two_joints() -> pin.Model:
    model = pin.Model()
    for name in ("one", "two"):
        joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Random(), name)
        model.addFrame(pin.Frame(f"end_{name}", joint, 0, pin.SE3.Random(), pin.FrameType.OP_FRAME))
    return model


def test_a_motor_drives_its_joint_and_a_tendon_several() -> None:
    matrix = motor_matrix(two_joints(), ["two", "pull"], {"pull": {"one": 0.5, "two": -0.2}})
    assert_array_equal(matrix, [[0.0, 0.5], [1.0, -0.2]])
    with pytest.raises(UnknownName, match="three"):
        motor_matrix(two_joints(), ["pull"], {"pull": {"three": 1.0}})


def test_a_motor_on_a_joint_of_several_freedoms_is_refused() -> None:
    """It would drive the first of them."""
    model = two_joints()
    model.addJoint(0, pin.JointModelTranslation(), pin.SE3.Identity(), "slides")
    with pytest.raises(InvalidValue, match=r"one degree of freedom.*'slides'"):
        motor_matrix(model, ["slides"], {})
    with pytest.raises(InvalidValue, match="'slides'"):
        motor_matrix(model, ["pull"], {"pull": {"one": 0.5, "slides": -0.2}})


def test_a_frame_that_is_joined_to_the_world_stays_where_it_is() -> None:
    model, q = two_joints(), np.array([0.3, -0.4])
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    for kind in CLOSURE_KINDS:
        one, other = named_closures(
            model, [("end_one", "world", kind), ("end_one", "end_two", kind)], q
        )
        assert (one.name, other.name) == ("end_one-world", "end_one-end_two")
        assert (one.joint2_id, other.joint2_id) == (0, 2)
        where = data.oMf[model.getFrameId("end_one")]
        assert np.allclose(one.joint2_placement.homogeneous, where.homogeneous)
        assert isinstance(one, Hinge) == (kind == "hinge")

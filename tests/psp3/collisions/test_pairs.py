"""Which pairs of links are looked at.

The rule, by what joins the bodies, and what an SRDF excludes.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import pinocchio as pin
import pytest

import psp3
from psp3.collisions.pairs import pairs_to_check
from psp3.description.srdf import Exclusion, excluded_by_srdf
from psp3.errors import UnknownName
from tests.helpers import four_bar_closed_with_3d, four_bar_closed_with_6d

ROBOT = psp3.load()

LINKS = ["base", *(f"{name}{leg}" for leg in (1, 2, 3) for name in ("nut", "ball_lambda", "star"))]

JOINTS = [
    0,
    *(ROBOT.model.getJointId(f"{name}{leg}") for leg in (1, 2, 3) for name in ("a", "lambda", "b")),
]


def named(pairs: list[tuple[int, int]]) -> set[frozenset[str]]:
    return {frozenset((LINKS[i], LINKS[j])) for i, j in pairs}


def test_pairs_of_the_3_psp() -> None:
    """By the words of the rule: the three thirds of the star are one body.

    It slides in every ball joint; nuts slide on the base.
    """
    pairs, exclusions = pairs_to_check(ROBOT, LINKS, JOINTS)
    star = {f"star{leg}" for leg in (1, 2, 3)}
    touching = set()
    for leg in (1, 2, 3):
        touching |= {
            frozenset(("base", f"nut{leg}")),
            *(frozenset((f"ball_lambda{leg}", third)) for third in star),
        }
    touching |= {frozenset(pair) for pair in combinations(star, 2)}
    everything = {frozenset(pair) for pair in combinations(LINKS, 2)}
    assert named(pairs) == everything - touching
    assert {frozenset((one, other)) for one, other, _ in exclusions} == touching
    reasons = {frozenset((one, other)): reason for one, other, reason in exclusions}
    assert reasons[frozenset(("base", "nut2"))] == "joined by joint 'a2'"
    assert reasons[frozenset(("ball_lambda3", "star1"))] == "joined by joint 'b3'"
    assert reasons[frozenset(("star1", "star2"))] == "one rigid body"


def test_the_true_limits_are_looked_at() -> None:
    """The bushing in the frame of its own nut, and the arms beside the columns."""
    pairs, _ = pairs_to_check(ROBOT, LINKS, JOINTS)
    for leg in (1, 2, 3):
        assert {
            frozenset((f"nut{leg}", f"ball_lambda{leg}")),
            frozenset(("base", f"star{leg}")),
        } <= named(pairs)


@pytest.mark.parametrize(
    ("build", "reason"),
    [
        (four_bar_closed_with_3d, "joined at a point by a loop"),
        (four_bar_closed_with_6d, "one rigid body"),
    ],
)
def test_what_a_loop_joins(build: object, reason: str) -> None:
    """Coupler (joint 2) and the last body of the other side.

    The base and the coupler, which nothing joins, are looked at.
    """
    parts = build()  # type: ignore[operator]
    robot = psp3.ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
    last = robot.model.njoints - 1
    pairs, exclusions = pairs_to_check(robot, ["base", "coupler", "end"], [0, 2, last])
    assert (0, 1) in pairs
    assert Exclusion("coupler", "end", reason) in exclusions


def test_what_is_welded_in_any_order_is_one_body() -> None:
    """The thirds of the star, with the second weld between the third and what was welded before."""
    model, welds = ROBOT.model, ROBOT.constraint_models
    ends = [
        (
            welds[0].joint2_id,
            welds[0].joint2_placement,
            welds[1].joint2_id,
            welds[1].joint2_placement,
        ),
        (
            welds[0].joint1_id,
            welds[0].joint1_placement,
            welds[0].joint2_id,
            welds[0].joint2_placement,
        ),
    ]
    other = pin.StdVec_RigidConstraintModel()
    for end in ends:
        other.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_6D, model, *end, pin.ReferenceFrame.LOCAL
            )
        )
    robot = psp3.ClosedLoopRobot(model, other, ROBOT.actuated, ROBOT.q0)
    assert pairs_to_check(robot, LINKS, JOINTS)[0] == pairs_to_check(ROBOT, LINKS, JOINTS)[0]


def test_a_link_has_no_pair_with_itself() -> None:
    pairs, exclusions = pairs_to_check(ROBOT, ["nut1", "nut1"], [1, 1])
    assert pairs == []
    assert exclusions == []


def test_excluded_pairs_are_left_out_with_their_reason(tmp_path: Path) -> None:
    srdf = tmp_path / "some.srdf"
    srdf.write_text(
        '<robot name="psp3"><disable_collisions link1="base" link2="star1" reason="Never"/>'
        '<disable_collisions link1="star2" link2="base"/></robot>'
    )
    excluded = excluded_by_srdf(srdf)
    assert excluded == [
        Exclusion("base", "star1", "Never"),
        Exclusion("star2", "base", "excluded by the SRDF"),
    ]
    without, _ = pairs_to_check(ROBOT, LINKS, JOINTS)
    pairs, exclusions = pairs_to_check(ROBOT, LINKS, JOINTS, excluded)
    assert named(without) - named(pairs) == {
        frozenset(("base", "star1")),
        frozenset(("base", "star2")),
    }
    assert set(excluded) <= set(exclusions)


def test_an_excluded_link_must_exist() -> None:
    with pytest.raises(UnknownName, match="nut4"):
        pairs_to_check(ROBOT, LINKS, JOINTS, [Exclusion("nut4", "base", "?")])

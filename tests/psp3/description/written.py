"""Robots written to files."""

from __future__ import annotations

from pathlib import Path


def link(name: str, *visuals: str) -> str:
    shapes = "".join(f"<visual><geometry>{visual}</geometry></visual>" for visual in visuals)
    inertia = "<inertia ixx='0.02' ixy='0' ixz='0' iyy='0.03' iyz='0' izz='0.04'/>"
    return (
        f"<link name='{name}'><inertial><origin xyz='0.1 0.02 -0.03'/><mass "
        f"value='2'/>{inertia}</inertial>{shapes}</link>"
    )


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    xyz: str = "0 0 0",
    axis: str = "0 0 1",
    limit: str = "",
) -> str:
    limit = limit or "lower='-3' upper='3'"
    return (
        f"<joint name='{name}' type='{kind}'><origin xyz='{xyz}'/><parent "
        f"link='{parent}'/><child link='{child}'/><axis xyz='{axis}'/><limit {limit} effort='7' "
        "velocity='5'/></joint>"
    )


def written(path: Path, *parts: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<robot name='r'>{''.join(parts)}</robot>", encoding="utf-8")
    return path


LOOPS = (
    "closed_loop: [[end, other]]\ntype: ['{kind}']\nname_mot: [crank]\njoint_name: [{names}]\n"
    "joint_type: [{kinds}]\n"
)

HINGES = {"crank": "0 0 0", "coupler": "0.2 0 0", "rocker": "0.45 0 0"}


def four_bar(directory: Path, *, hinge: str, crank: str = "revolute") -> Path:
    """Write a planar four-bar linkage in the plane z = 0.

    Closed at ``end`` and ``other``, with a fourth hinge of a kind in it or fixed.
    """
    names = ("base", "one", "two", "three", "end", "other")
    joints = [
        joint("crank", "base", "one", crank, HINGES["crank"]),
        # It turns with the crank, again and again.
        joint("coupler", "one", "two", xyz=HINGES["coupler"], limit="lower='-99' upper='99'"),
        joint("rocker", "base", "three", xyz=HINGES["rocker"]),
        joint("tip", "two", "end", hinge, "0.35 0 0"),
        joint("top", "three", "other", "fixed", "0.4 0 0"),
    ]
    return written(directory / "four_bar.urdf", *map(link, names), *joints)


def loop_file(directory: Path, kind: str = "6d", **replaced: str) -> Path:
    path = directory / "loops.yaml"
    path.write_text(
        LOOPS.format(kind=kind, names=", ".join(replaced), kinds=", ".join(replaced.values()))
    )
    return path


HOME = (
    "<group_state name='home' group='g'><joint name='crank' value='1.0'/><joint name='coupler' "
    "value='-0.6'/>"
)


def home(directory: Path, tip: bool = True) -> Path:
    last = "<joint name='rocker' value='1.2'/>" + ("<joint name='tip' value='0.8'/>" if tip else "")
    return written(directory / "r.srdf", f"{HOME}{last}</group_state>")

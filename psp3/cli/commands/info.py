"""The command that shows a robot, or the installed versions."""

from __future__ import annotations

import re
from typing import Any

from psp3.cli.compilation import one_off
from psp3.cli.joint_tables import joint_rows
from psp3.cli.option_groups import single_options
from psp3.cli.options import Json
from psp3.cli.output import new_table, plain_number, print_json, show
from psp3.cli.robot_options import RobotOptions

KINDS = {
    "Revolute": "revolute",
    "Prismatic": "prismatic",
    "Helical": "helical",
    "Spherical": "ball",
    "FreeFlyer": "floating",
}
"""Joints in words, by how Pinocchio's names of them begin."""

LETTERS = {"R": "revolute", "P": "prismatic", "H": "helical"}
"""Joints along or about an axis of their frame, which Pinocchio names by letters."""


def kind_of(name: str) -> str:
    """Return what a joint is in one or two words, which fit a line of 80 letters."""
    along = re.fullmatch(r"([RPH])(?:UB)?([XYZ])", name)
    if along:
        return f"{LETTERS[along[1]]} {along[2].lower()}"
    return next((words for begin, words in KINDS.items() if name.startswith(begin)), name)


@single_options
@one_off
def info(*, robot: RobotOptions, json: Json = False) -> None:
    """Show a robot: joints, motors, loops and mobility; without one, versions and the 3-PSP."""
    if robot.is_of_thesis:
        _show_of_thesis(robot, json)
        return
    from psp3.robots.examination import examine

    which = robot.load()
    found = examine(which)
    rows = joint_rows(which, which.q0)
    lower, upper = which.model.lowerPositionLimit, which.model.upperPositionLimit
    joints: list[dict[str, Any]] = [
        {
            "name": row.joint,
            "type": joint.shortname().removeprefix("JointModel"),
            "role": row.role,
            "reference": row.values,
            "unit": row.unit,
            "lower": lower[joint.idx_q : joint.idx_q + joint.nq],
            "upper": upper[joint.idx_q : joint.idx_q + joint.nq],
        }
        for row, joint in zip(rows, list(which.model.joints)[1:], strict=True)
    ]
    if json:
        findings = [one._asdict() for one in found.findings]
        print_json({**found._asdict(), "findings": findings, "joints": joints, "units": "SI"})
        return
    about = new_table(found.title, "", "")
    about.show_header, about.columns[1].justify = False, "left"
    for name, text in (
        ("bodies that move", f"{found.bodies}, {found.mass:.4g} kg"),
        ("motors", ", ".join(found.motors)),
        ("coordinates", ", ".join(found.coordinates)),
        ("loops", ", ".join(f"{name} ({kind})" for name, kind in found.loops) or "none"),
        ("mobility", found.mobility),
        ("held", "; ".join(found.held) or "nothing"),
        ("files", ", ".join(str(path) for path in (which.urdf, which.srdf) if path) or "–"),
    ):
        about.add_row(name, text)
    turned = any("quaternion" in one["unit"] for one in joints)
    table = new_table(
        "Joints",
        *("", "type", "role", "reference", "lower", "upper", "unit"),
        note="The orientation of a ball or of a floating base is a quaternion." if turned else "",
    )
    table.pad_edge = False
    for one in joints:
        table.add_row(
            one["name"],
            kind_of(one["type"]),
            one["role"],
            *(
                "\n".join(plain_number(value, 4) for value in one[key])
                for key in ("reference", "lower", "upper")
            ),
            one["unit"].replace("quaternion", "").rstrip(", "),
        )
    show(about, table)


def _show_of_thesis(options: RobotOptions, json: bool) -> None:
    import platform
    from dataclasses import asdict
    from importlib.metadata import PackageNotFoundError, version

    import numpy as np

    from psp3.description.loop_file import read_loops
    from psp3.description.parts import ROBOT_FILES, ROBOTS
    from psp3.three_psp.parameters import PARAMETER_SETS
    from psp3.version import __version__

    versions = {"psp3": __version__, "python": platform.python_version()}
    for package in ("pin", "numpy", "scipy", "numba", "meshcat", "matplotlib", "typer", "rich"):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    robot = options.load_of_thesis()
    loops = read_loops(ROBOT_FILES / "psp3.yaml")
    (lower, *_), (upper, *_) = (bounds.tolist() for bounds in robot.stroke)
    least, greatest = robot.tip_reach(np.radians([0.0, 60.0])).tolist()
    joints = [
        {
            "name": str(name),
            "type": {"JointModelPZ": "slides along z", "JointModelPX": "slides along x"}.get(
                joint.shortname(), joint.shortname()
            ),
            "actuated": name in robot.actuated,
            "lower": float(robot.model.lowerPositionLimit[joint.idx_q]),
            "upper": float(robot.model.upperPositionLimit[joint.idx_q]),
        }
        for name, joint in list(zip(robot.model.names, robot.model.joints, strict=True))[1:]
    ]
    sets = {
        name: asdict(numbers) | {"total_mass": numbers.total_mass}
        for name, numbers in PARAMETER_SETS.items()
    }
    if json:
        content = {
            "versions": versions,
            "files": str(ROBOT_FILES),
            "joints": joints,
            "stroke": {"lower": lower, "upper": upper},
        }
        content["loops"] = [
            {"frames": frames, "kind": kind}
            for frames, kind in zip(loops.frames, loops.kinds, strict=True)
        ]
        print_json(
            content
            | {
                "robots": ROBOTS,
                "tip_reach": {"least": least, "greatest": greatest},
                "parameters": sets,
                "units": "SI",
            }
        )
        return
    about = new_table("Robot", "", "")
    about.show_header, about.columns[1].justify = False, "left"
    about.add_row("versions", ", ".join(f"{name} {number}" for name, number in versions.items()))
    about.add_row("files", str(ROBOT_FILES))
    about.add_row("actuated joints", ", ".join(robot.actuated))
    about.add_row(
        "passive joints", ", ".join(str(joint["name"]) for joint in joints if not joint["actuated"])
    )
    about.add_row(
        "loops",
        ", ".join(
            f"{one} = {other} ({kind})"
            for (one, other), kind in zip(loops.frames, loops.kinds, strict=True)
        ),
    )
    about.add_row("stroke", f"{lower:g} m to {upper:g} m")
    about.add_row(
        "other robots",
        ", ".join(name for name in ROBOTS if name != "psp3") + " (psp3 info NAME)",
    )
    about.add_row(
        "reach of the tip",
        (
            f"{1e3 * least:.1f} mm at azimuth 0°, {1e3 * greatest:.1f} mm at 60°, from the "
            "vertical axis"
        ),
    )
    table = new_table("Parameter sets", "", *sets)
    units = {"gravity": "m/s²", "total_mass": "kg", "screw_radius": "m", "tool_length": "m"}
    for name in next(iter(sets.values())):
        unit = units.get(name, "kg m²" if name.endswith("inertia") else "kg")
        cells = [
            "\n".join(f"{number:.6g}" for number in np.ravel(numbers[name]))
            for numbers in sets.values()
        ]
        table.add_row(f"{name.replace('_', ' ')} ({unit})", *cells)
    show(about, table)

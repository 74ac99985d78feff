"""The command that says what is installed and which robots there are."""

from __future__ import annotations

from psp3.cli.options import Json
from psp3.cli.output import new_table, print_json, show


def info(json: Json = False) -> None:
    """Show versions, joints, loops, reach, parameter sets and the other robots."""
    import platform
    from dataclasses import asdict
    from importlib.metadata import PackageNotFoundError, version

    import numpy as np

    from psp3.description.loop_file import read_loops
    from psp3.description.parts import ROBOT_FILES, ROBOTS
    from psp3.loading import load
    from psp3.three_psp.parameters import PARAMETER_SETS
    from psp3.version import __version__

    versions = {"psp3": __version__, "python": platform.python_version()}
    for package in ("pin", "numpy", "scipy", "numba", "meshcat", "matplotlib", "typer", "rich"):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    robot = load("psp3")
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
        ", ".join(name for name in ROBOTS if name != "psp3") + " (psp3.load in Python)",
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

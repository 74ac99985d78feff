"""Good arguments of what psp3 offers for robots, from loading to simulating; see tests.misuse."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import psp3
from psp3 import bounds, closure, collisions, drives, simulation, symbolic
from psp3 import trajectories as paths
from psp3.collisions.model import collision_model
from psp3.dynamics.linearization import discretize
from psp3.identification.base_parameters import base_parameters
from psp3.identification.physical_consistency import bodies
from psp3.identification.regressor import parameter_names, regressor, standard_parameters
from psp3.identification.unknowns import all_parameters, equal_bodies
from psp3.kinematics import frames
from psp3.kinematics.pose_map import Status
from psp3.kinematics.task_space import square_task
from psp3.three_psp import geometry, workspace
from psp3.trajectories.fourier_series import FourierSeries
from tests.misuse import Call, parameters_of
from tests.psp3.bounds.synthetic import constant

FILES = Path(psp3.__file__).parent / "urdf"

ANY_TEXT = ("text",)
ANYTHING = ("*",)
A_NUMBER = ("true",)
OF_ROWS = ("column",)
"""A column is as many rows of one number each."""

POSES = {"psp3": np.array([0.11, 0.02, 0.03]), "five_bar": np.array([-0.5, 0.7])}


@functools.cache
def robot(name: str) -> Any:
    return psp3.load(name)


def state(name: str) -> dict[str, Any]:
    """Return positions, speeds, and accelerations or forces."""
    n = len(POSES[name])
    speeds = np.array([0.1, -0.2, 0.3])[:n]
    return {"speeds": speeds, "accelerations": 3.0 * speeds, "forces": 100.0 * speeds}


TAKEN = {
    # Fewer are those of the first coordinates, and a column is as many rows of the first.
    "allocated_forces": {"forces": ("one entry too few", "column")},
    "actuator_forces": {"accelerations": ("one entry too few", "column")},
}


def methods_of_a_robot(name: str) -> Iterator[tuple[str, Call]]:
    """Yield methods of a robot whose arguments are known by their names."""
    one = robot(name)
    kind = type(one).__name__
    good = {
        "positions": POSES[name],
        "heights": POSES[name],
        "path": np.stack([POSES[name], POSES[name] + 0.01]),
        "guess": None,
        "frame": "tip",
        "q": one.configuration(POSES[name]),
        "v": one.velocity(POSES[name], state(name)["speeds"]),
        "name": "noc",
        "drive": drives.Drive(1.0, 2.0),
        "height": 0.02,
        "tilt": 0.1,
        "azimuth": 0.4,
        "tip": one.tip(POSES[name]),
        "point": one.tip(POSES[name]),
        "velocity": np.array([0.1, 0.2, 0.3]),
        "acceleration": np.array([0.1, 0.2, 0.3]),
        **state(name),
    }
    for method in dir(one):
        if method.startswith(("_", "from_")) or not callable(getattr(type(one), method, None)):
            continue
        if method == "motion_of_tip" and not one.has_inverse_of_tip:
            continue
        function = getattr(one, method)
        names = parameters_of(function)
        if names:
            yield (
                f"{kind}.{method}",
                Call(function, {part: good[part] for part in names}, TAKEN.get(method, {})),
            )


def of_loading(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield what makes robots: of names, of files and of parts in memory."""
    five_bar, machine = robot("five_bar"), robot("psp3")
    title = {"reads": lambda made: made.q0}
    none = dict.fromkeys(("closures", "model_paths", "coordinates"), ("empty",))
    # An empty mapping, too, and no name of a motor.
    none |= {"joint_type": ("empty",), "actuated": ("empty",)}
    yield "load", Call(psp3.load, {"name": "five_bar", "parameters": "default"}, **title)
    choice = {"free": "lock", "coordinates": None, "closures": ()}
    from_urdf = {"urdf": FILES / "five_bar.urdf", "loops": FILES / "five_bar.yaml"}
    from_urdf |= {"srdf": FILES / "five_bar.srdf", "actuated": None, **choice}
    yield (
        "ClosedLoopRobot.from_urdf",
        Call(
            psp3.ClosedLoopRobot.from_urdf,
            from_urdf,
            # Without poses it begins with the neutral one.
            {**none, "srdf": ("None",), "loops": ("None",)},
            **title,
        ),
    )
    from_mjcf = {"mjcf": FILES / "gripper.xml", "actuated": None, "joint_type": None, **choice}
    from_mjcf["free"] = "keep"
    yield (
        "ClosedLoopRobot.from_mjcf",
        Call(psp3.ClosedLoopRobot.from_mjcf, from_mjcf, none, **title),
    )
    from_sdf = {"sdf": folder / "arm.sdf", "actuated": ("hinge",), "model_paths": (), **choice}
    yield "ClosedLoopRobot.from_sdf", Call(psp3.ClosedLoopRobot.from_sdf, from_sdf, none, **title)
    parts = {
        "model": five_bar.model,
        "constraint_models": list(five_bar.constraint_models),
        "actuated": five_bar.actuated,
        "q0": five_bar.q0,
        "visual_model": None,
    }
    more = {"equations": (), "springs": None, "tendons": None, **choice}
    may_be_empty = dict.fromkeys(("equations", "closures", "coordinates"), ("empty",))
    may_be_empty["constraint_models"] = ("empty",)
    may_be_empty["q0"] = ("None",)
    yield (
        "ClosedLoopRobot",
        Call(psp3.ClosedLoopRobot, {**parts, **more}, may_be_empty, **title),
    )
    own = {
        "model": machine.model,
        "constraint_models": list(machine.constraint_models),
        "actuated": machine.actuated,
        "q0": machine.q0,
        "visual_model": machine.visual_model,
        "parameters": psp3.Parameters(),
    }
    yield "PSP3", Call(psp3.PSP3, own, {**may_be_empty, "visual_model": ("None",)}, **title)
    numbers = {**psp3.Parameters().as_dict()}
    yield "Parameters", Call(psp3.Parameters, numbers)
    yield "to_mjcf", Call(psp3.to_mjcf, {"robot": five_bar})
    carried = {"robot": five_bar, "mass": 1.5, "inertia": (0.1, 0.1, 0.1), "frame": "tip"}
    yield (
        "with_payload",
        Call(psp3.with_payload, carried, reads=lambda made: made.mass_matrix(POSES["five_bar"])),
    )


def of_kinematics() -> Iterator[tuple[str, Call]]:
    """Yield frames, tasks, singularities and workspaces."""
    five_bar, machine = robot("five_bar"), robot("psp3")
    point = {"position": [0.1, 0.2, 0.3], "velocity": [1.0, 2.0, 3.0], "acceleration": [0.0] * 3}
    yield "point_motion", Call(frames.point_motion, point)
    moved = {name: value for name, value in state("five_bar").items() if name != "forces"}
    moved |= {"robot": five_bar, "positions": POSES["five_bar"], "frame": "tip"}
    yield "frame_motion", Call(frames.frame_motion, moved)
    task = {"robot": five_bar, "frame": "tip", "task": ("x", "z")}
    yield "square_task", Call(square_task, task)
    analysis = psp3.SingularityAnalysis(*task.values())
    q = five_bar.configuration(POSES["five_bar"])
    optional = {"length": ("None",)}
    yield "SingularityAnalysis", Call(psp3.SingularityAnalysis, {**task, "length": 0.2}, optional)
    classify = {"configuration": q, "tolerance": 1e-6}
    yield "SingularityAnalysis.classify", Call(analysis.classify, classify)
    yield "SingularityAnalysis.measures", Call(analysis.measures, {"configurations": q})
    yield "SingularityAnalysis.positions", Call(analysis.positions, {"configurations": q})
    more = {**task, "over": "task", "length": 0.2, "singular_below": 0.01}
    yield "Workspace", Call(psp3.Workspace, more, optional)
    space = psp3.Workspace(**more)
    x, z = space.reference["x"], space.reference["z"]
    grid = {"x": [x - 0.01, x + 0.01], "z": [z, z + 0.01]}
    known = dict.fromkeys(("held", "start"), ("empty",))
    # Numbers are NaN where nothing can be reached, and limits may be infinite.
    status = {"reads": lambda poses: poses.status}
    yield "Workspace.map", Call(space.map, {"grid": grid, "held": None}, known, **status)
    poses = space.map(grid)
    yield (
        "Workspace.boundary",
        Call(space.boundary, {"poses": poses, "at_least": Status.USABLE}, {"poses": ()}),
    )
    way = {"direction": {"x": 1.0}, "farthest": 0.05, "start": None}
    yield (
        "Workspace.distance",
        Call(
            space.distance,
            way,
            known,
        ),
    )
    heights = POSES["psp3"]
    angles = {"tilt": np.array([0.1, 0.2]), "azimuth": np.array([0.3, 0.4])}
    tilted = {"height": 0.0, **angles, "screw_radius": 0.2}
    anything = ("tiny", "tiny entries", "empty", "column", *SHAPES)
    yield (
        "heights_of_tilt",
        Call(geometry.heights_of_tilt, tilted, dict.fromkeys(tilted, anything)),
    )
    # Lengths that overflow are no numbers, which is what the caller looks at.
    lengths = {"heights": heights, "screw_radius": 0.2}
    yield "arm_lengths", Call(geometry.arm_lengths, lengths, {"screw_radius": ("huge",)})
    yield (
        "geometry.tip_reach",
        Call(geometry.tip_reach, {"azimuth": 0.3, "screw_radius": 0.2, "tool_length": 0.1}),
    )
    rotation = machine.forward_kinematics(heights).rotation
    yield "tilt_and_azimuth", Call(workspace.tilt_and_azimuth, {"rotation": rotation})
    over = {"robot": machine, **angles}
    # One angle goes with several, and a column makes a map.
    grids = dict.fromkeys(("tilt", "share", "azimuth"), ("one entry too few", "column"))
    yield "map_over_tilt", Call(workspace.map_over_tilt, over, grids)
    share = {"robot": machine, "share": [0.2, 0.4], "azimuth": [0.3, 0.4]}
    yield "map_over_reach", Call(workspace.map_over_reach, share, grids)
    at = {"robot": machine, "heights": np.stack([heights, heights + 0.01])}
    yield "map_at_heights", Call(workspace.map_at_heights, at)
    free = {"azimuth": SHAPES}
    yield "largest_tilt", Call(workspace.largest_tilt, {"azimuth": [0.3, 0.4]}, free)
    both = {"robot": machine, "azimuth": [0.3, 0.4]}
    yield "fold_tilt", Call(workspace.fold_tilt, both, free)
    yield "reach_boundary", Call(workspace.reach_boundary, both, free)


SHAPES = ("one entry too many", "one entry too few", "column")
"""Those of arrays of any shape."""


def of_dynamics() -> Iterator[tuple[str, Call]]:
    """Yield derivatives, linear systems and the other implementations of the dynamics."""
    five_bar = robot("five_bar")
    moved = {"positions": POSES["five_bar"], **state("five_bar")}
    forced = {name: moved[name] for name in ("positions", "speeds", "forces")}
    moved = {name: moved[name] for name in ("positions", "speeds", "accelerations")}
    for name, function, motion in (
        ("inverse_dynamics_derivatives", psp3.inverse_dynamics_derivatives, moved),
        ("forward_dynamics_derivatives", psp3.forward_dynamics_derivatives, forced),
    ):
        yield name, Call(function, {"robot": five_bar, **motion})
    optional = {"speeds": ("None",), "accelerations": ("None",)}
    yield "linearize", Call(psp3.linearize, {"robot": five_bar, **moved}, optional)
    system = psp3.linearize(five_bar, POSES["five_bar"])
    yield "discretize", Call(discretize, {"system": system, "period": 0.002})
    for name in ("psp3", "five_bar"):
        yield from of_implementations(name)


def of_implementations(name: str) -> Iterator[tuple[str, Call]]:
    """Yield methods of the implementations of a robot's equation of motion."""
    q, v = robot(name).configuration(POSES[name]), None
    v = robot(name).velocity(POSES[name], state(name)["speeds"])
    good = {"positions": POSES[name], "q": q, "v": v, **state(name)}
    for other in ("noc", "pinocchio"):
        model = robot(name).dynamics(other)
        if other == "noc" and name == "psp3":
            yield (
                "NaturalOrthogonalComplement",
                Call(psp3.NaturalOrthogonalComplement, {"robot": robot(name)}),
            )
        for method in dir(model):
            function = getattr(model, method, None)
            if method.startswith(("_", "from_")) or not callable(function):
                continue
            names = parameters_of(function)
            if names and set(names) <= set(good):
                taken = TAKEN.get(method, {})
                whose = "NaturalOrthogonalComplement" if other == "noc" else "ProjectedDynamics"
                whose += "" if name == "psp3" else f" of {name}"
                yield (
                    f"{whose}.{method}",
                    Call(function, {part: good[part] for part in names}, taken),
                )


def of_trajectories(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield paths, and what is asked of them at given times."""
    machine, five_bar = robot("psp3"), robot("five_bar")
    own = {"robot": machine}
    shape = {"radius": 0.01, "period": 2.0}
    start, end = [0.0, 0.0, 0.1], [0.01, 0.0, 0.1]
    line = {"start": start, "end": end, "duration": 1.0, "robot": machine, "space": "tip"}
    knots = {"times": [0.0, 0.5, 1.0], "points": [start, end, start]}
    good: dict[Any, dict[str, Any]] = {
        paths.Helix: {**shape, "rise": 0.01, "height": 0.1, **own},
        paths.Circle: {**shape, "height": 0.1, **own},
        paths.Hold: {"point": start, **own, "space": "tip"},
        paths.Line: line,
        paths.PointToPoint: line,
        paths.Waypoints: {**knots, **own, "space": "tip"},
        paths.Sway: {"amplitude": 0.1, "period": 2.0, **own},
        paths.FromCSV: {"path": folder / "path.csv", **own},
    }
    default = ("None",)
    for kind, arguments in good.items():
        optional = dict.fromkeys(("robot", "space", "height", "point", "amplitude"), default)
        yield kind.__name__, Call(kind, arguments, optional, lambda made: made(0.3))
        made = kind(**arguments)
        asked = {"t": [0.1, 0.2]}
        free = {"t": SHAPES, "clearance": default}
        yield f"{kind.__name__} at", Call(made.__call__, asked, free)
        yield (
            f"{kind.__name__}.check",
            Call(made.check, {**asked, "clearance": None}, free),
        )
    yield "Sway.joints", Call(paths.Sway(robot=machine).joints, {"t": [0.1, 0.2]}, {"t": SHAPES})
    yield (
        "Trajectory",
        Call(
            paths.Trajectory,
            {"robot": five_bar, "space": "joints"},
            {"robot": default, "space": default},
        ),
    )
    yield "Trajectory.check", Call(paths.Hold(robot=five_bar).check, {"t": 0.1, "clearance": None})
    motion = paths.Hold(robot=five_bar)(np.array([0.1, 0.2]))
    yield (
        "check_stroke",
        Call(
            paths.check_stroke,
            {"robot": five_bar, "t": np.array([0.1, 0.2]), "motion": motion},
            {"t": SHAPES},
        ),
    )
    yield "finite_times", Call(paths.finite_times, {"t": [0.1, 0.2]}, {"t": SHAPES})
    yield (
        "measured_motion",
        Call(paths.measured_motion, {"path": folder / "measured.csv", "robot": machine}),
    )
    yield "tip_of", Call(paths.tip_of, {"robot": machine, "positions": POSES["psp3"]})
    series = {"period": 2.0, "center": [0.0, 0.0], "sines": [[0.1, 0.2]], "cosines": [[0.1, 0.1]]}
    yield "FourierSeries", Call(FourierSeries, {**series, "robot": five_bar})


def of_simulation(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield what simulates, what it drives with, and what reads what came of it."""
    five_bar, machine = robot("five_bar"), robot("psp3")
    friction = {"coulomb_friction": 1.0, "viscous_friction": 2.0, "motor_inertia": 1e-4}
    drive = psp3.Drive(**friction, lead=0.01)
    yield "Drive", Call(psp3.Drive, {**friction, "lead": 0.01})
    force = {"force": [10.0, 20.0, 30.0]}
    yield "Drive.motor_torque", Call(drive.motor_torque, force, {"force": SHAPES})
    torque = {"motor_torque": [0.1, 0.2, 0.3]}
    yield "Drive.force", Call(drive.force, torque, {"motor_torque": SHAPES})
    yield "drive_table", Call(drives.drive_table, {"drive": drive, "joints": 3})
    yield (
        "Encoder",
        Call(
            simulation.Encoder,
            {"resolution": np.array([0.1, 0.2]), "period": 0.1},
            {"resolution": SHAPES},
        ),
    )
    seen = {"positions": np.array([0.1, 0.2]), "speeds": np.array([0.3, 0.4])}
    # Whoever sees a motion diverge must see it.
    diverged = (*SHAPES, "NaN entry", "infinite entry")
    free = {"positions": diverged, "speeds": diverged}

    def read(**given: Any) -> Any:
        return simulation.Encoder(np.array([0.1, 0.2]), 0.1).read(**given)

    yield "Encoder.read", Call(read, seen, free)
    run = {
        "robot": five_bar,
        "controller": psp3.PD(10.0, 1.0),
        "trajectory": paths.Hold(robot=five_bar),
        "duration": 0.02,
        "period": 0.002,
        "initial_positions": five_bar.reference,
        "initial_speeds": np.zeros(2),
        "torque_limit": [5.0, 6.0],
        "encoder_resolution": [0.0, 1e-3],
        "delay": 1,
        "plant": None,
        "clearance": None,
        "progress": None,
    }
    optional = dict.fromkeys(("initial_positions", "initial_speeds", "torque_limit"), ("None",))
    # One that asks for no force is one, too.
    yield "simulate", Call(psp3.simulate, run, optional, lambda result: result.positions)
    result = psp3.simulate(**run)
    yield "Result.save", Call(result.save, {"path": folder / "run.npz"}, {"path": ANY_TEXT})
    result.save(folder / "saved.npz")
    yield (
        "load_result",
        Call(
            psp3.load_result, {"path": folder / "saved.npz", "largest": 2**20}, {"path": ANY_TEXT}
        ),
    )
    engine = {"robot": five_bar, "steps": 2, "drive": psp3.Drive(0.1, 0.1)}
    engine |= {"limits": ([-3.0, -3.0], [3.0, 3.0]), "torque_limit": [5.0, 6.0]}
    yield (
        "MuJoCo",
        Call(psp3.MuJoCo, engine, {"limits": ("None",), "torque_limit": ("None",)}),
    )
    plant = psp3.MuJoCo(five_bar)
    begun = {"positions": POSES["five_bar"], "speeds": np.array([0.1, 0.2])}
    yield "MuJoCo.start", Call(plant.start, begun)

    def advanced(**given: Any) -> Any:
        plant.start(**begun)
        return plant.advance(**given)

    yield (
        "MuJoCo.advance",
        Call(advanced, {"forces": np.array([0.1, 0.2]), "duration": 0.002}),
    )
    path = np.stack([POSES["psp3"], POSES["psp3"] + 0.01])
    watched = {"robot": machine, "positions": path, "time": [0.0, 1.0], "clearance": 0.001}
    model = collision_model(machine)
    default = dict.fromkeys(("time", "model"), ("None",))
    for name, function in (
        ("check", collisions.check),
        ("check_clearance", collisions.check_clearance),
    ):
        yield name, Call(function, {**watched, "model": model}, default)


def of_identification() -> Iterator[tuple[str, Call]]:
    """Yield unknowns, motions that excite them, and estimates."""
    five_bar = robot("five_bar")
    unknowns = all_parameters(five_bar)
    base = base_parameters(unknowns)
    moved = {"positions": POSES["five_bar"], **state("five_bar")}
    del moved["forces"]
    yield "regressor", Call(regressor, {"robot": five_bar, **moved})
    yield "all_parameters", Call(all_parameters, {"robot": five_bar})
    yield "standard_parameters", Call(standard_parameters, {"robot": five_bar})
    yield "parameter_names", Call(parameter_names, {"robot": five_bar})
    yield (
        "equal_bodies",
        Call(equal_bodies, {"robot": five_bar, "groups": ()}, {"groups": ("empty",)}),
    )
    yield "Unknowns.forces_of", Call(unknowns.forces_of, moved)
    yield "Unknowns.expand", Call(unknowns.expand, {"values": unknowns.believed})
    yield "Unknowns.without", Call(unknowns.without, {"names": ()}, {"names": ("empty",)})
    yield "base_parameters", Call(base_parameters, {"unknowns": unknowns, "rng": None})
    yield "BaseParameters.values", Call(base.values, {"unknowns": unknowns.believed})
    yield "BaseParameters.forces_of", Call(base.forces_of, moved)
    yield "BaseParameters.nearest", Call(base.nearest, {"values": base.believed})
    yield "bodies", Call(bodies, {"robot": five_bar, "parameters": standard_parameters(five_bar)})
    excited = {
        "base": base,
        "largest_speed": [1.0, 1.0],
        "largest_acceleration": [10.0, 10.0],
        "lower": five_bar.reference - 0.1,
        "upper": five_bar.reference + 0.1,
        "period": 2.0,
        "harmonics": 1,
        "force_noise": [1.0, 2.0],
        "draws": 1,
        "steps": 1,
        "rng": None,
    }
    limits = {"lower": ("None",), "upper": ("None",)}
    yield "exciting_motion", Call(psp3.exciting_motion, excited, limits)
    t = np.arange(12) / 6.0
    motion = psp3.exciting_motion(**{**excited, "harmonics": 2})
    positions, speeds, accelerations = motion.joints(t)
    measured = {
        "base": base,
        "t": t,
        "positions": positions,
        "forces": five_bar.inverse_dynamics(positions, speeds, accelerations),
        "period": 2.0,
        "harmonics": 2,
        "held": 0.0,
    }
    yield "identify", Call(psp3.identify, measured)


def of_bounds() -> Iterator[tuple[str, Call]]:
    """Yield bounds of errors and of torques."""
    gains = {"kp": 100.0, "kv": 20.0}
    yield "ErrorDynamics", Call(bounds.ErrorDynamics, {**gains, "period": 0.01})
    scores = np.linspace(0.1, 1.0, 12)
    yield (
        "conformal_bound",
        Call(
            bounds.conformal_bound,
            {"scores": scores, "share": 0.5},
            {"scores": (*SHAPES, "infinite entry")},  # of a run that failed
        ),
    )
    yield "runs_needed", Call(bounds.runs_needed, {"share": 0.5})
    sizes = np.linspace(1.0, 2.0, 12)
    runs = [constant(np.array([size, 2.0 * size])) for size in sizes]
    yield "TrackingTube", Call(psp3.TrackingTube, {"runs": runs, **gains, "share": 0.5})
    tube = psp3.TrackingTube(runs, **gains, share=0.5)
    yield "TrackingTube.around", Call(tube.around, {"result": runs[0]})
    yield "TrackingTube.holds", Call(tube.holds, {"result": runs[0]})
    yield "TrackingTube.with_gains", Call(tube.with_gains, gains)
    small = [constant(np.array([size, size])) for size in 0.01 * sizes]
    narrow = psp3.TrackingTube(small, **gains, share=0.5)
    yield (
        "TrackingTube.tip_width",
        Call(narrow.tip_width, {"robot": robot("five_bar"), "positions": POSES["five_bar"]}),
    )
    yield (
        "residual_accelerations",
        Call(bounds.residual_accelerations, {"result": runs[0], **gains}),
    )
    torques = np.linspace(0.0, 1.0, 24).reshape(12, 2)
    ends = np.stack([torques - 0.3, torques + 0.3], axis=-1)
    calibrated = {"torques": torques, "intervals": ends, "share": 0.5, "scale": "interval"}
    yield "ConformalIntervals", Call(psp3.ConformalIntervals, calibrated)
    intervals = psp3.ConformalIntervals(**calibrated)
    yield "ConformalIntervals.around", Call(intervals.around, {"intervals": ends})
    yield "ConformalIntervals.holds", Call(intervals.holds, {"torques": torques, "intervals": ends})


def of_trees() -> Iterator[tuple[str, Call]]:
    """Yield flattened trees and their symbols."""
    five_bar, machine = robot("five_bar"), robot("psp3")
    tree = {"model": five_bar.model, "constraint_models": list(five_bar.constraint_models)}
    tree |= {"independent_v": five_bar.coordinates_v, "locked_v": (), "springs": None}
    yield (
        "flattened",
        Call(
            closure.flattened,
            tree,
            {
                "locked_v": ("empty",),
                "constraint_models": ("empty",),
                "independent_v": ("empty", "one entry too few"),
            },
        ),
    )
    flat = closure.flattened(five_bar.model, five_bar.constraint_models, closure.NO_MOTORS)
    yield (
        "assembled",
        Call(closure.assembled, {"model": five_bar.model, "flat": flat, "q0": five_bar.q0}),
    )
    yield "residual", Call(closure.residual, {"flat": flat, "q": five_bar.q0})
    yield "SymbolicPSP3", Call(symbolic.SymbolicPSP3, {"robot": machine})
    yield "SymbolicRobot", Call(symbolic.SymbolicRobot, {"robot": five_bar})
    learned = psp3.FuzzyComputedTorque(robot=machine, n_terms=2)
    learned.fit(paths.Helix(0.01, robot=machine), duration=2.0, samples=50)
    yield "fuzzy_torque", Call(symbolic.fuzzy_torque, {"controller": learned})
    made = symbolic.SymbolicRobot(five_bar)
    yield "SymbolicRobot.derivatives", Call(made.derivatives, {"name": "gravity"})
    yield "SymbolicRobot.frame", Call(made.frame, {"name": "tip"})


ARM = """<sdf version="1.9"><model name="arm">
  <link name="base"/>
  <joint name="weld" type="fixed"><parent>world</parent><child>base</child></joint>
  <link name="arm"><inertial><mass>1.0</mass><pose>0.1 0 0 0 0 0</pose>
    <inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>
  <joint name="hinge" type="revolute"><parent>base</parent><child>arm</child>
    <axis><xyz>0 1 0</xyz></axis></joint>
</model></sdf>
"""


def write_files(folder: Path) -> None:
    """Write the files that the table names."""
    (folder / "arm.sdf").write_text(ARM)
    steps = range(4)
    lines = [f"{0.1 * k},{0.004 * k},0,0.1" for k in steps]
    (folder / "path.csv").write_text("t,x,y,z\n" + "\n".join(lines))
    lines = [f"{0.1 * k},{0.01 * k * k},0,0.02,{k},2,3" for k in range(14)]
    head = "t,a1,a2,a3,force1,force2,force3"
    (folder / "measured.csv").write_text("\n".join([head, *lines]))


def rows(folder: Path) -> dict[str, Call]:
    """Return the table: what is public, with good arguments; files are written to a folder."""
    write_files(folder)
    return {
        **dict(methods_of_a_robot("psp3")),
        **dict(methods_of_a_robot("five_bar")),
        **dict(of_loading(folder)),
        **dict(of_kinematics()),
        **dict(of_dynamics()),
        **dict(of_trajectories(folder)),
        **dict(of_simulation(folder)),
        **dict(of_identification()),
        **dict(of_bounds()),
        **dict(of_trees()),
    }

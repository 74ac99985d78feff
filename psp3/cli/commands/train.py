"""The command that trains a controller."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy2.support.deferred_compilation import deferred_compilation
from psp3.cli.joint_tables import joint_units
from psp3.cli.option_groups import MotionOptions, single_options
from psp3.cli.options import TrajectoryText, controller_output, file_path, only_allowed
from psp3.cli.output import new_table, say, show
from psp3.cli.robot_options import RobotOptions
from psp3.cli.shared import gains_of_computed_torque, trajectory_from_options

if TYPE_CHECKING:
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque


@dataclass(frozen=True, kw_only=True)
class RuleOptions:
    """The rules to learn, and the noise on their record."""

    kind: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Kind of the rules: it2 (interval type-2), t1 (type-1) or gt2 (general type-2).",
        ),
    ] = "it2"
    learner: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=(
                "How rules are learned: strongest (default for the 3-PSP), strict, average, ridge "
                "or least-squares (default for other robots)."
            ),
        ),
    ] = None
    terms: Annotated[
        int | None,
        typer.Option(
            metavar="COUNT",
            help="Terms of every input, on a grid; default 2 for the 3-PSP, otherwise none.",
        ),
    ] = None
    coriolis: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help=(
                "Source of C: rules of its own, or mass for the derivative of M (not for the "
                "3-PSP)."
            ),
        ),
    ] = "rules"
    snr: Annotated[
        float,
        typer.Option(
            metavar="DB",
            help="Signal-to-noise ratio of the recorded M, C and G (dB); inf adds no noise.",
        ),
    ] = math.inf
    mean_variation: Annotated[
        float | None,
        typer.Option(
            metavar="SHARE",
            help="Mean variation as a share of each input's range; by default it follows --snr.",
        ),
    ] = None
    defuzzify: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="What gt2 defuzzifies: first M, C and G, or last the torque, as in the thesis.",
        ),
    ] = "first"
    seed: Annotated[
        int, typer.Option(min=0, metavar="NUMBER", help="Seed of the noise that --snr adds.")
    ] = 0


@single_options
@deferred_compilation()
def train(
    *,
    file: Annotated[
        Path,
        typer.Argument(
            parser=controller_output,
            metavar="FILE",
            help="File to write (*.json).",
            show_default=False,
        ),
    ],
    robot: RobotOptions,
    rules: RuleOptions,
    kp: Annotated[
        float | None,
        typer.Option(
            metavar="GAIN",
            help="Proportional gain (1/s²); default 10, for robots other than the 3-PSP that of a "
            "bandwidth of 20 rad/s.",
        ),
    ] = None,
    kv: Annotated[
        float | None,
        typer.Option(
            metavar="GAIN",
            help="Derivative gain (1/s); default 1, for robots other than the "
            "3-PSP critical damping.",
        ),
    ] = None,
    trajectory: TrajectoryText = None,
    motion: MotionOptions,
    measured: Annotated[
        Path | None,
        typer.Option(
            "--record",
            parser=file_path,
            metavar="FILE",
            help=(
                "Learn from measured forces instead of M, C and G. The CSV file has a column t, "
                "and for each motor a column with its name and one with force_ before its name "
                "(or a1,… and force1,…, as simulate --csv writes them)."
            ),
            show_default=False,
        ),
    ] = None,
) -> None:
    """Train a fuzzy computed-torque controller and write it to a file.

    Exact computed torque tracks a motion, and the rules learn M, C and G along it. By default the
    motion is the helix, or sway for robots other than the 3-PSP. With --record the rules learn from
    measured motion and motor forces of the real robot.
    """
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque

    which = robot.load()
    if measured is not None:
        refused = vars(motion) | {"trajectory": trajectory, "learner": rules.learner}
        refused |= {"snr": rules.snr if math.isfinite(rules.snr) else None}
        only_allowed("--record", refused, ())
    gains = gains_of_computed_torque(which, kp, kv)
    controller = FuzzyComputedTorque(
        rules.kind,
        which,
        **gains,
        n_terms=rules.terms,
        learner=rules.learner,
        coriolis=rules.coriolis,
        snr_db=rules.snr,
        mean_variation=rules.mean_variation,
        defuzzify=rules.defuzzify,
    )
    if measured is None:
        source, errors = _learned_by_simulation(controller, trajectory, motion, rules.seed)
    else:
        source, errors = _learned_from_record(controller, measured)
    controller.save(file)
    numbers = " + ".join(str(len(system.rules)) for system in controller.systems_)
    title = f"{rules.kind}, learned on {source}"
    table = new_table(
        title if which.has_inverse_of_tip else f"{which.title}, {title}",
        "trained range",
        "least",
        "greatest",
        "unit",
        note=f"{numbers} rules, mean variation {controller.mean_variation:.3g}",
    )
    names, joints = controller.inputs.names, joint_units(which, which.actuated)
    units = (*joints, *(f"{unit}/s" for unit in joints))
    of_inputs = [units[place] for place in controller.inputs.plus]
    for name, low, high, unit in zip(names, *controller.ranges_, of_inputs, strict=True):
        table.add_row(name, f"{low:z.4f}", f"{high:z.4f}", unit)
    show(table, errors)
    say(file)


def _learned_by_simulation(
    controller: FuzzyComputedTorque, trajectory: str | None, motion: MotionOptions, seed: int
) -> tuple[str, Any]:
    """Learn M, C and G along the exact controller's motion; return its name and a table."""
    import numpy as np

    from psp3.fuzzy_control.records import record, unpack

    which = controller.robot
    desired, seconds, name_of_motion = trajectory_from_options(which, trajectory, motion)
    recorded = record(which, desired, seconds, kp=controller.kp, kv=controller.kv)
    samples = min(controller.samples, len(recorded.t))
    controller.learn(recorded, samples, np.random.default_rng(seed))
    errors = new_table("Estimates on the way", "", "RMS error, relative")
    estimates = controller.estimate(recorded.positions, recorded.speeds)
    for name, exact, estimate in zip("MCG", unpack(recorded.outputs), estimates, strict=True):
        errors.add_row(name, f"{np.sqrt(((estimate - exact) ** 2).mean() / (exact**2).mean()):.2%}")
    return name_of_motion, errors


def _learned_from_record(controller: FuzzyComputedTorque, path: Path) -> tuple[str, Any]:
    """Learn from measured forces; return the file's name and a table of errors."""
    import numpy as np

    from psp3.trajectories.recorded import measured_motion

    _, a, v, w, forces = measured_motion(path, controller.robot)
    controller.learn_from_motion(a, v, w, forces)
    M, C, G = controller.estimate(a, v)
    said = np.einsum("nij,nj->ni", M, w) + np.einsum("nij,nj->ni", C, v) + G
    missed = np.sqrt(((said - forces) ** 2).mean(axis=0) / (forces**2).mean(axis=0))
    errors = new_table("Forces on the way", "motor", "RMS error, relative")
    for name, share in zip(controller.robot.actuated, missed, strict=True):
        errors.add_row(name, f"{share:.2%}")
    return path.name, errors

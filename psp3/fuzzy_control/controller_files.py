"""Files of trained controllers: JSON, with the identity of their robot."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy2.files.json_files import from_json, to_json
from fuzzy2.learning.partition import KINDS
from fuzzy2.support.bounded_files import not_read
from fuzzy2.support.json_text import parse_json
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System
from psp3.checks import Array, checked_not_negative, checked_path, checked_robot
from psp3.description.parts import ROBOTS
from psp3.errors import InvalidControllerFile
from psp3.fuzzy_control.numbers import output_names, pack
from psp3.loading import load as load_robot
from psp3.three_psp.parameters import Parameters
from psp3.three_psp.robot import PSP3

FORMAT = "psp3-fuzzy-computed-torque-1"
"""Format mark of controller files of the 3-PSP; a file with another mark is refused."""

FORMAT_OF_ANY = "psp3-fuzzy-computed-torque-2"
"""Format mark for other robots, which have several rule bases."""

KEYS = frozenset(
    {
        *("format", "kind", "kp", "kv", "outside", "defuzzify", "learner", "n_terms"),
        *("mean_variation", "term_width", "inputs", "outputs", "snr_db", "ranges", "robot"),
        *("rules", "coriolis", "system", "systems"),
    }
)
"""Keys of either format. Any other key is refused, because it may be a misspelled one that would be
ignored."""

SAME_DYNAMICS = 1e-6
"""Greatest relative difference of M and G at the reference pose between a robot and the one in the
file."""

_SYSTEMS = dict(zip(KINDS, (Type1System, IntervalType2System, GeneralType2System), strict=True))


def save(controller: Any, path: str | Path) -> Path:
    """Write a trained controller as JSON, and return the path."""
    robot = controller.robot
    is_ours = isinstance(robot, PSP3)
    content = {
        "format": FORMAT if is_ours else FORMAT_OF_ANY,
        "kind": controller.kind,
        "kp": controller.kp,
        "kv": controller.kv,
        "outside": controller.outside,
        "defuzzify": controller.order,
        "learner": controller.learner,
        "n_terms": controller.n_terms,
        "mean_variation": controller.mean_variation,
        "term_width": controller.term_width,
        "inputs": controller.inputs.names,
        "outputs": output_names(controller.joints),
        "snr_db": controller.snr_db if math.isfinite(controller.snr_db) else "inf",
        "ranges": controller.ranges_.tolist(),
        "robot": robot.parameters.as_dict() if is_ours else identity(robot),
    }
    if controller.rules is not None or not is_ours:
        content["rules"] = controller.rules
    if is_ours:
        content["system"] = to_json(controller.systems_[0])
    else:
        content["coriolis"] = controller.coriolis
        content["systems"] = [to_json(system) for system in controller.systems_]
    write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", path)
    return Path(path)


def identity(robot: Any) -> dict[str, Any]:
    """Return what identifies a robot: its name, its joints, and M and G at its reference pose."""
    reference = np.asarray(robot.reference, dtype=float)
    M, C, G = robot.equation_of_motion(reference, np.zeros_like(reference))
    return {
        "name": robot.title,
        "joints": list(robot.coordinates),
        "reference": reference.tolist(),
        "numbers_at_reference": pack(M, C, G).tolist(),
    }


def load(kind_of_controller: type[Any], path: str | Path, robot: Any) -> Any:
    """Read a controller, see :meth:`psp3.FuzzyComputedTorque.load`."""
    path = checked_path("path", path)
    if robot is not None:
        checked_robot(robot)
    try:
        return _controller_from(kind_of_controller, parse_json(read_text(path)), robot, path)
    except InvalidControllerFile:
        raise
    except OSError as error:
        raise InvalidControllerFile(path, not_read(error)) from error
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise InvalidControllerFile(path, f"is not a whole controller file ({error})") from error
    except KeyError as error:
        raise InvalidControllerFile(path, f"lacks {error.args[0]!r}") from error


def _controller_from(
    kind_of_controller: type[Any], content: Any, robot: Any, path: str | Path
) -> Any:
    known = (FORMAT, FORMAT_OF_ANY)
    if not isinstance(content, dict) or content.get("format") not in known:
        found = content.get("format") if isinstance(content, dict) else type(content).__name__
        raise InvalidControllerFile(
            path, f"has format {found!r}, this version reads {' and '.join(map(repr, known))}"
        )
    if unknown := sorted(content.keys() - KEYS):
        raise InvalidControllerFile(path, f"has {', '.join(unknown)}, which no controller has")
    is_ours = content["format"] == FORMAT
    robot = (_three_psp if is_ours else _other_robot)(content["robot"], robot, path)
    systems = [
        from_json(system) for system in ([content["system"]] if is_ours else content["systems"])
    ]
    kind, snr = content["kind"], content["snr_db"]
    options: dict[str, Any] = {}
    for system in systems:
        if not isinstance(system, FuzzySystem) or type(system) is not _SYSTEMS.get(kind):
            raise InvalidControllerFile(
                path, f"has kind {kind!r} and holds {type(system).__name__}"
            )
        if isinstance(system, GeneralType2System):
            options = {"levels": system.levels, "reduction": system.reduction}
    controller = kind_of_controller(
        kind,
        robot,
        kp=content["kp"],
        kv=content["kv"],
        n_terms=content["n_terms"],
        rules=content.get("rules") if is_ours else content["rules"],
        learner=content["learner"],
        coriolis="rules" if is_ours else content["coriolis"],
        snr_db=math.inf if snr == "inf" else snr,
        mean_variation=checked_not_negative("mean_variation", content["mean_variation"]),
        term_width=content["term_width"],
        outside=content["outside"],
        # Files of version 1 without this key come from controllers that had only one order.
        defuzzify=content.get("defuzzify", "first"),
        **options,
    )
    # Null would mean that the controller chooses, but a saved file always holds the choice.
    for option in ("learner", "n_terms"):
        if getattr(controller, option) != content[option]:
            raise InvalidControllerFile(path, f"has {content[option]!r} as {option}")
    for what, names in (
        ("inputs", controller.inputs.names),
        ("outputs", output_names(controller.joints)),
    ):
        if tuple(content[what]) != tuple(names):
            raise InvalidControllerFile(
                path,
                f"has the {what} {', '.join(content[what])}, this version needs {', '.join(names)}",
            )
    ranges = np.asarray(content["ranges"], dtype=float)
    _check_systems(controller, systems, path)
    _check_ranges(ranges, len(controller.inputs.names), path)
    controller._take(systems, ranges)
    return controller


def _three_psp(said: Any, robot: Any, path: str | Path) -> Any:
    """Return the 3-PSP of a file, or the given one if it is the same."""
    parameters = Parameters(**{name: said[name] for name in Parameters().as_dict() | said})
    if robot is None:
        return load_robot("psp3", parameters=parameters)
    if not isinstance(robot, PSP3):
        raise InvalidControllerFile(
            path, f"was trained for the 3-PSP robot, but yours is {robot.title}"
        )
    if robot.parameters != parameters:
        given = robot.parameters.as_dict()
        other = [
            f"{name} {value} (yours {given[name]})"
            for name, value in parameters.as_dict().items()
            if given[name] != value
        ]
        raise InvalidControllerFile(
            path,
            f"was trained for a robot with {', '.join(other)}; load it without a robot, or train "
            "again",
        )
    return robot


def _other_robot(said: Any, robot: Any, path: str | Path) -> Any:
    """Return the robot that a file names, or the given one if it is the same."""
    name = said["name"]
    if robot is None:
        if name not in ROBOTS:
            raise InvalidControllerFile(
                path, f"was trained for {name!r}, which does not come with the package: give robot="
            )
        robot = load_robot(name)
    if robot.title != name or list(robot.coordinates) != said["joints"]:
        raise InvalidControllerFile(
            path,
            f"was trained for {name} with the joints {', '.join(said['joints'])}, but yours is "
            f"{robot.title} with {', '.join(robot.coordinates)}",
        )
    own = identity(robot)
    for what, where in (
        ("reference", "stands elsewhere in its reference pose"),
        ("numbers_at_reference", "has another mass or weight in its reference pose"),
    ):
        found, expected = np.asarray(own[what]), np.asarray(said[what], dtype=float)
        allowed = SAME_DYNAMICS * np.abs(found).max(initial=1e-300)
        if found.shape != expected.shape or not (np.abs(found - expected) <= allowed).all():
            raise InvalidControllerFile(
                path, f"was trained for another {name}: yours {where}; train again"
            )
    return robot


def _check_systems(controller: Any, systems: list[Any], path: str | Path) -> None:
    names, of_numbers = controller.inputs.names, output_names(controller.joints)
    if len(systems) != len(controller.places):
        raise InvalidControllerFile(
            path, f"holds {len(systems)} fuzzy systems in place of {len(controller.places)}"
        )
    for system, place in zip(systems, controller.places, strict=True):
        inputs = tuple(names[column] for column in place.columns)
        outputs = tuple(of_numbers[j] for j in place.outputs)
        if (system.input_names, system.output_names) != (inputs, outputs):
            raise InvalidControllerFile(
                path, "holds a fuzzy system of other inputs or outputs than the file says"
            )
        if np.shape(system.consequents) != (len(system.rules), len(outputs)):
            raise InvalidControllerFile(
                path, "has consequents that are not a number for each rule and output"
            )
        terms = [len(of_input) for of_input in system.inputs]
        wanted = controller.terms_of(place)
        if any(count != wanted for count in terms):
            raise InvalidControllerFile(
                path,
                f"has inputs of {terms} terms, and n_terms {controller.n_terms!r} or rules "
                f"{controller.rules!r} make {wanted}",
            )
        if system.table is None:
            raise InvalidControllerFile(
                path, "holds a fuzzy system that the compiled loop cannot evaluate"
            )


def _check_ranges(ranges: Array, inputs: int, path: str | Path) -> None:
    if (
        ranges.shape != (2, inputs)
        or not np.isfinite(ranges).all()
        or not (ranges[0] < ranges[1]).all()
    ):
        raise InvalidControllerFile(
            path, f"has ranges that are not {inputs} smallest and {inputs} largest inputs"
        )

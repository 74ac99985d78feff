"""What README.md says in numbers: templates, and comparisons in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

LEVELS = ("20", "15", "10")

TEMPLATES = (
    *(
        f"| {level} dB | {{printed/{level}/ratio:.2f}} | "
        + "{at/ratio/value:.2f} ({at/ratio/low:.2f} to {at/ratio/high:.2f}) | "
        "{at/spread_of_ratios/0:.2f} to {at/spread_of_ratios/1:.2f} |".replace(
            "at/", f"type_2_against_type_1/{level}/"
        )
        for level in LEVELS
    ),
    "the license of the code is {license}",
    "Badge: {version} is the version of this source code",
    "Badge: Python {python} or newer is needed to run it",
    "You need Linux, Python {python} or newer, make and pip.",
    (
        "`make view` takes {first use/view} s of one core and downloads a GiB, and `make "
        "reproduce` takes another {first use/reproduce} s, most of it to compile once"
    ),
    (
        "For the robots of the thesis the mass matrix, the velocity forces and gravity agree with "
        "those of MuJoCo, projected on the motions that the loops allow, to {bars/mujoco} of the "
        "largest entry in {bars/mujoco states} random states."
    ),
    (
        "Type-2 is better under {derived/better under} of {derived/definitions} definitions of "
        '"noise of S dB". Under the other four it is worse in {derived/worse cells} of '
        "{derived/other cells} cases."
    ),
    (
        "the error of type-1 falls to {derived/averaged/least:%.0f} to "
        "{derived/averaged/most:%.0f} % of type-2's."
    ),
    "ours are {derived/least times:.0f} to {derived/most times:.0f} times as large.",
    (
        "A step of computed torque takes {µs/One control step/CTC, closed form} µs in closed "
        "form. The thesis measured {printed/step/CTC:ms.0f} ms."
    ),
    (
        "Inverse dynamics takes {along a path/five_bar} µs a call for a five-bar linkage and "
        "{along a path/gough_stewart} µs for a Gough–Stewart platform, from Python."
    ),
    "That is {along a path/of MuJoCo} times MuJoCo's `mj_forward`",
    (
        "A fuzzy system with {timed system/rules} rules and {timed system/outputs} outputs takes "
        "{µs/Type-2 inference/fuzzy2, type-1} µs (type-1), {µs/Type-2 inference/fuzzy2, interval "
        "type-2} µs (interval type-2) or {µs/Type-2 inference/fuzzy2, general type-2, 5 "
        "α-planes} µs (general type-2 with five α-planes):"
    ),
    "Bars of the error of {board/entries} controllers on three robots",
    "ranks your way to learn a robot's dynamics among {board/entries} others,",
    (
        "has {board/learner/times} times the error of the best controller that knows the model "
        "(95 % interval {board/learner/low} to {board/learner/high}):"
    ),
)


def comparisons(sources: Mapping[str, Any]) -> list[tuple[str, bool]]:
    """Return what is said in words, and whether the numbers say so."""
    table = sources["type_2_against_type_1"]
    board = sources["board"]
    return [
        (
            "Under the definition that we use, which favors type-2, the error of type-2 is "
            "smaller:",
            all(table[level]["ratio"]["high"] < 1.0 for level in LEVELS),
        ),
        (
            "PD's error is matched by a fit",
            abs(sources["derived"]["PD"]) < sources["verdict"]["reproduced"],
        ),
        (
            "**The printed errors under noise are not reproduced**",
            sources["derived"]["least times"] > sources["verdict"]["same order"],
        ),
        (
            "The best learner, a fuzzy system that adapts while it controls",
            board["learner"]["entry"] == "adaptive",
        ),
    ]

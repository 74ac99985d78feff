"""What is run on an emulated Cortex-M: one of each kind of system, a controller, a robot."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

import fuzzy2
import psp3

RULES = list(itertools.product(range(3), repeat=2))
CONSEQUENTS = np.random.default_rng(0).normal(size=(len(RULES), 1))
MIDDLES = (-1.0, 0.0, 1.0)


class Thing(NamedTuple):
    """What is exported: how it is made, which of its functions counts, and what it is.

    ``flash`` [bytes] and ``instructions`` are the most that the function may need on a Cortex-M7
    in double precision, where there is a bound.
    """

    make: Callable[[], Any]
    function: str
    about: str
    flash: int | None = None
    instructions: int | None = None


def _type1() -> Any:
    return fuzzy2.Type1System([_crisp()] * 2, RULES, CONSEQUENTS)


def _interval() -> Any:
    terms = [fuzzy2.GaussianUncertainMean((m - 0.1, m + 0.1), 0.5) for m in MIDDLES]
    return fuzzy2.IntervalType2System([terms] * 2, RULES, CONSEQUENTS)


def _planes() -> Any:
    return fuzzy2.GeneralType2System([_general()] * 2, RULES, CONSEQUENTS, levels=5)


def _corollary() -> Any:
    return fuzzy2.GeneralType2System([_general()] * 2, RULES, CONSEQUENTS, reduction="gaussian")


def _crisp() -> list[Any]:
    return [fuzzy2.Gaussian(m, 0.5) for m in MIDDLES]


def _general() -> list[Any]:
    return [fuzzy2.GaussianType2Set(principal=one, sigma=0.05) for one in _crisp()]


def _controller(kind: str, **options: Any) -> Callable[[], Any]:
    def trained() -> Any:
        helix = psp3.trajectories.Helix(radius=0.020, period=2.0, rise=0.010)
        robot = psp3.load("psp3")
        given = {"learner": "average", "mean_variation": 0.35} | options
        return psp3.FuzzyComputedTorque(kind, robot, **given).fit(helix)

    return trained


THINGS = {
    "type1": Thing(_type1, "evaluate", "type-1, 2 inputs with 3 terms, 9 rules"),
    "interval": Thing(_interval, "evaluate", "interval type-2, the same"),
    "corollary": Thing(_corollary, "evaluate", "general type-2 by the corollary, the same"),
    "planes": Thing(_planes, "evaluate", "general type-2, 5 α-planes, the same"),
    "controller": Thing(
        _controller("it2"),
        "step",
        "computed torque of the 3-PSP, learned, interval type-2",
        flash=25_000,
        instructions=12_000,
    ),
    "controller_by_corollary": Thing(
        _controller("gt2", reduction="gaussian"),
        "step",
        "the same, general type-2 by the corollary",
        flash=25_000,
        instructions=12_000,
    ),
    "controller_of_two_planes": Thing(
        _controller("gt2", levels=2),
        "step",
        "the same, general type-2, 2 α-planes",
        flash=25_000,
        instructions=16_000,
    ),
    "controller_of_planes": Thing(
        _controller("gt2"),
        "step",
        "the same, general type-2, 5 α-planes",
        flash=25_000,
        instructions=38_000,
    ),
    "delta": Thing(
        lambda: psp3.load("delta"),
        "inverse_dynamics",
        "inverse dynamics of the Delta at the last pose",
        instructions=60_000,
    ),
}

"""What an FMU is made of: C code, and the variables that its functions read and write."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import CCode, CFunction

Causality = Literal["parameter", "input", "output"]

_NOT_IN_XML = re.compile(r"[^ -~\u00a0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that no XML has, and those that a name of a variable must not have: ends of lines."""


def name_in_c(name: str) -> str:
    """Return what the code of a model is called: never as a word of C, or what else is there."""
    return f"code_{name}"


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU.

    Parameters
    ----------
    name : str
        Its name.
    about : str
        What it is.
    unit : str
        Its unit as FMI writes it, ``"N.m"``; empty for none.
    causality : {"parameter", "input", "output"}
        A parameter is set before the simulation begins.
    start : float
        What it is until it is set; of an output nothing.
    """

    name: str
    about: str
    unit: str
    causality: Causality
    start: float = 0.0


@dataclass(frozen=True)
class Model:
    """A plant or a controller that goes on by one period in each step.

    All functions of ``code`` that return something return 1 where all is well.

    Parameters
    ----------
    name : str
        The identifier of the model.
    code : CCode
        Its functions in C.
    title : str
        What it is, a sentence.
    variables : tuple of Variable
        Its variables; a value reference is a place among them.
    places : mapping of str to int
        For each array that the functions read or write the place of its first variable.
    begin : CFunction or None
        Puts the state where it begins; None where there is no state.
    step : CFunction
        Goes on by one period; ``t`` is the time at which that begins.
    feeds_through : bool
        Whether outputs belong to the inputs at the beginning of a step, as of a controller, and not
        to the end of it, as of a plant.
    period : float
        The period [s].
    messages : mapping of int to str
        What a function means by returning another number than 1.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If two variables would have one name, or there are characters that XML cannot hold.
    """

    name: str
    code: CCode
    title: str
    variables: tuple[Variable, ...]
    places: Mapping[str, int]
    begin: CFunction | None
    step: CFunction
    feeds_through: bool
    period: float
    messages: Mapping[int, str]

    def __post_init__(self) -> None:
        names = [variable.name for variable in self.variables]
        for text in (self.title, *names):
            if _NOT_IN_XML.search(text):
                why = f"no FMU can hold all characters of {text!r}"
                raise NotExportable(self.name, why, "the robot and its joints printable names")
        name, count = Counter(names).most_common(1)[0]
        if count > 1:
            why = f"{count} of its variables would be called {name}"
            raise NotExportable(self.name, why, "the robot's joints other names")

    def of(self, causality: Causality) -> list[int]:
        """Return the value references of the variables of a causality."""
        return [i for i, one in enumerate(self.variables) if one.causality == causality]


def in_one_row(
    groups: Mapping[str, Sequence[Variable]],
) -> tuple[tuple[Variable, ...], dict[str, int]]:
    """Return the variables of arrays one after the other, and for each array where it begins."""
    row: list[Variable] = []
    places = {}
    for array, group in groups.items():
        places[array] = len(row)
        row += group
    return tuple(row), places

"""The content of an FMU: C code, and the variables that its functions read and write."""

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
"""Characters that XML does not allow, and line ends, which variable names must not have."""


def name_in_c(name: str) -> str:
    """Return the prefix of a model's code; it never equals a C keyword or another name there."""
    return f"code_{name}"


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU.

    Parameters
    ----------
    name : str
        Its name.
    about : str
        Description of the variable.
    unit : str
        Its unit as FMI writes it, ``"N.m"``; empty for none.
    causality : {"parameter", "input", "output"}
        A parameter is set before the simulation begins.
    start : float
        Initial value until it is set; not used for an output.
    """

    name: str
    about: str
    unit: str
    causality: Causality
    start: float = 0.0


@dataclass(frozen=True)
class Model:
    """A plant or a controller that advances by one period in each step.

    All functions of ``code`` that return something return 1 on success.

    Parameters
    ----------
    name : str
        The identifier of the model.
    code : CCode
        Its functions in C.
    title : str
        Description of the model in a sentence.
    variables : tuple of Variable
        Its variables; a value reference is an index into them.
    places : mapping of str to int
        For each array that the functions read or write, the index of its first variable.
    begin : CFunction or None
        Function that sets the initial state; None if there is no state.
    step : CFunction
        Function that advances by one period; ``t`` is the time at its beginning.
    feeds_through : bool
        Whether outputs belong to the inputs at the beginning of a step, as for a controller, or to
        its end, as for a plant.
    period : float
        The period [s].
    messages : mapping of int to str
        Meanings of the return codes other than 1.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If two variables would have the same name, or XML cannot hold a character.
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
    """Return the variables of all arrays in a row, and the index at which each array begins."""
    row: list[Variable] = []
    places = {}
    for array, group in groups.items():
        places[array] = len(row)
        row += group
    return tuple(row), places

"""Writer of a description as the text of a ``.fis`` file."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any, NoReturn

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import (
    Description,
    LinearFunction,
    Variable,
    check_crisp,
    check_names,
)
from fuzzy2.files.fis_lines import quoted
from fuzzy2.files.fis_names import (
    AGGREGATIONS,
    DEFUZZIFIERS,
    MATLAB_NORMS,
    OPEN_TOOLBOX_REDUCERS,
    OPEN_TOOLBOX_SUFFIX,
    REDUCERS,
    SAMPLE_POINTS,
    T_CONORMS,
    T_NORMS,
)
from fuzzy2.files.fis_rules import OCTAVE, rule_line
from fuzzy2.files.fis_shapes import corners_of, named_shape
from fuzzy2.files.operator_words import known_as
from fuzzy2.operations.set_operations import complement
from fuzzy2.sets.derived import Complement, Truncated
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.lagged import Lagged
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.sets.smooth_shapes import PiShaped
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.systems.operators import DIRECT_METHODS, MAXIMA, UNIONS

_SEPARATE = ("center_of_sets", "weighted_sum")
"""Averages and sums over the rules, even if some have the same consequent."""

_SEPARATE_OF = {"united_average": "center_of_sets", "united_sum": "weighted_sum"}
"""Averages and sums over different consequents, with their counterparts over the rules."""


class FisWriter:
    """Writer of one description, line by line."""

    def __init__(self, description: Description, name: str, where: str) -> None:
        self.description, self.where = description, where
        self.open_toolbox = where == OPEN_TOOLBOX_SUFFIX
        check_names(description, where)
        self.name = name if name.isprintable() else "system"

    def _refuse(self, what: str, reason: str) -> NoReturn:
        raise NotExpressible(what, self.where, reason)

    def _check_integration(self) -> None:
        """Refuse integrations that differ from that of the program that reads the file."""
        described = self.description
        reduction = described.reduced_by
        if not described.mamdani or reduction not in UNIONS:
            return
        # Trapezoids use the same points as the sum, and maxima only depend on the points.
        known = ("sum", "trapezoidal") if reduction in MAXIMA else ("sum",)
        if self.where == OCTAVE and reduction not in MAXIMA:
            known = ("trapezoidal",)
        if described.integration not in known or described.resolution != SAMPLE_POINTS:
            points = "" if described.integration == "exact" else f" over {described.resolution}"
            self._refuse(
                f"integration={described.integration!r}{points}",
                f"the program that reads the file uses {SAMPLE_POINTS} points; change it with "
                f'replace(integration="{known[0]}", resolution={SAMPLE_POINTS})',
            )

    def _check_defaults(self) -> None:
        for output in self.description.outputs:
            if output.default is not None:
                self._refuse(
                    f"the default {output.default:g} of the output {output.name!r}",
                    "it cannot hold the output where no rule fires; take "
                    "replace(default_outputs=None)",
                )

    def text(self) -> str:
        """Return the text of the file."""
        described = self.description
        if self.open_toolbox and described.mamdani:
            self._refuse(
                "a system whose consequents are sets",
                "that toolbox has Sugeno systems only; write .fis",
            )
        if self.open_toolbox and not described.type2:
            self._refuse("a type-1 system", "that toolbox has type-2 systems only; write .fis")
        lines = ["[System]", f"Name={quoted(self.name)}", *self._system(), ""]
        inputs, outputs = (
            [_without_complements(variable) for variable in of]
            for of in (described.inputs, described.outputs)
        )
        for i, (variable, _) in enumerate(inputs):
            lines += [f"[Input{i + 1}]", *self._variable(variable, True), ""]
        for i, (variable, _) in enumerate(outputs):
            lines += [f"[Output{i + 1}]", *self._variable(variable, described.mamdani), ""]
        lines.append("[Rules]")
        asked, said = ([numbers for _, numbers in of] for of in (inputs, outputs))
        lines += [rule_line(rule, asked, said, self.where) for rule in described.rules]
        self._check_integration()
        self._check_defaults()
        return "\n".join(lines) + "\n"

    def _system(self) -> list[str]:
        described = self.description
        version = "3.0" if described.type2 and not self.open_toolbox else "2.0"
        kind, methods = self._methods()
        lines = [
            f"Type='{kind}'",
            f"Version={version}",
            f"NumInputs={len(described.inputs)}",
            f"NumOutputs={len(described.outputs)}",
            f"NumRules={len(described.rules)}",
        ]
        keys = ("AndMethod", "OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod")
        lines += [f"{key}='{method}'" for key, method in zip(keys, methods, strict=True)]
        return [*lines, *self._reducer()]

    def _methods(self) -> tuple[str, tuple[str, ...]]:
        """Return the kind of system and the names of its operators."""
        described, dialect = self.description, "octave" if self.where == OCTAVE else "matlab"
        reduction, kind = described.reduced_by, "mamdani" if described.mamdani else "sugeno"
        either = self._norm(described.disjunction, T_CONORMS, "t-conorm")
        both = self._norm(described.t_norm, T_NORMS, "t-norm")
        implied = self._norm(described.implied_by, T_NORMS, "implication")
        united = self._norm(described.aggregation, AGGREGATIONS, "t-conorm")
        if reduction == "tsukamoto":
            self._refuse("Tsukamoto's reduction", "its outputs are of Mamdani or Sugeno; use JSON")
        if kind == "sugeno":
            implied, united = "prod", "sum" if reduction in _SEPARATE else united
            if reduction not in _SEPARATE and dialect == "matlab":
                self._refuse(
                    f"the type reduction {reduction!r}", "it is Octave's; take dialect='octave'"
                )
            reduction = _SEPARATE_OF.get(reduction, reduction)
        word = known_as(reduction, DEFUZZIFIERS[kind, dialect], "type reduction", self.where)
        return kind, (both, either, implied, united, word)

    def _norm(self, name: str, known: dict[str, str], what: str) -> str:
        if self.where != OCTAVE:
            known = {theirs: ours for theirs, ours in known.items() if theirs in MATLAB_NORMS}
        elif name == "probabilistic":
            # Octave only knows its own name.
            return "algebraic_sum"
        elif name == "nilpotent":
            self._refuse(f"the {what} {name!r}", "it has none of the name")
        return known_as(name, known, what, self.where)

    def _reducer(self) -> list[str]:
        described = self.description
        if not described.type2:
            return []
        if self.open_toolbox:
            if described.method == "begian_melek_mendel":
                lower, upper = (repr(share) for share in described.shares)
                return [f"TypeRedMethod='BMM({lower},{upper})'"]
            known, key = OPEN_TOOLBOX_REDUCERS, "TypeRedMethod"
        else:
            known, key = REDUCERS, "TypeReductionMethod"
        if described.method in (*DIRECT_METHODS, *known.values()):
            return [f"{key}='{known_as(described.method, known, 'method', self.where)}'"]
        # An exact method that the program does not have is replaced with another exact one.
        return [f"{key}='{known_as('eiasc', known, 'method', self.where)}'"]

    def _variable(self, variable: Variable, of_sets: bool) -> list[str]:
        lines = [
            f"Name={quoted(variable.name)}",
            f"Range={_vector(variable.range)}",
            f"NumMFs={len(variable.terms)}",
        ]
        for i, (name, term) in enumerate(variable.terms.items()):
            if of_sets:
                lines += self._term(f"MF{i + 1}", name, term)
            elif isinstance(term, LinearFunction):
                lines.append(f"MF{i + 1}={quoted(name)}:'linear',{_vector(self._linear(term))}")
            elif self.open_toolbox:
                lines.append(f"MF{i + 1}={quoted(name)}:'constant',{_vector(term)}")
            elif term.left == term.right:
                lines.append(f"MF{i + 1}={quoted(name)}:'constant',{_vector(term[:1])}")
            else:
                self._refuse(
                    f"the interval {list(term)} as a consequent",
                    "its constants are crisp; write .t2fis",
                )
        return lines

    def _linear(self, term: LinearFunction) -> tuple[float, ...]:
        """Return slopes and constant, for both ends if they are intervals."""
        middle = (*term.slopes, term.constant)
        if not term.spreads or not self.open_toolbox:
            check_crisp(term, self.where)
            return middle
        ranges = [variable.range for variable in self.description.inputs]
        if any(low < 0.0 < high and term.spreads[i + 1] for i, (low, high) in enumerate(ranges)):
            reason = "its ends cross at 0; let the input keep to one side, or the slope be a number"
            self._refuse("the interval of a slope of an input on both sides of 0", reason)
        spreads = [
            spread if low >= 0.0 else -spread
            for spread, (low, _) in zip(term.spreads[1:], ranges, strict=True)
        ]
        half = (*spreads, term.spreads[0])
        return (
            *(one - own for one, own in zip(middle, half, strict=True)),
            *(one + own for one, own in zip(middle, half, strict=True)),
        )

    def _term(self, key: str, name: str, term: Any) -> list[str]:
        lower, upper = (
            (term.lower, term.upper) if isinstance(term, IntervalType2Set) else (term, term)
        )
        if self.open_toolbox:
            both = [(side, *self._shape(one)) for side, one in (("U", upper), ("L", lower))]
            return [
                f"{key}{side}={quoted(name)}:'{kind}',{_vector((*values, height))}"
                for side, kind, values, height in both
            ]
        kind, values, height = self._shape(upper)
        if height != 1.0:
            self._refuse(f"{upper!r}", "its membership functions reach 1")
        if not self.description.type2:
            return [f"{key}={quoted(name)}:'{kind}',{_vector(values)}"]
        scale, lags = self._scale_and_lags(term, lower, upper)
        return [
            f"{key}={quoted(name)}:'{kind}',{_vector(values)},{_vector([scale])},{_vector(lags)}"
        ]

    def _scale_and_lags(
        self, term: Any, lower: Type1Set, upper: Type1Set
    ) -> tuple[float, tuple[float, float]]:
        if lower == upper:
            return 1.0, (0.0, 0.0)
        if isinstance(lower, Lagged) and lower.whole == upper:
            return lower.scale, lower.lags
        if (
            isinstance(lower, Gaussian | PiShaped)
            and dataclasses.replace(lower, height=1.0) == upper
        ):
            return lower.height, (0.0, 0.0)
        below, above = corners_of(lower), corners_of(upper)
        if below is None or above is None or below[1:3] != above[1:3]:
            self._refuse(
                f"{term!r}",
                "the lower membership function is not the upper one, scaled and lagged; write "
                ".t2fis or JSON",
            )
        return lower.height, (
            _lag(above[0], below[0], above[1]),
            _lag(above[3], below[3], above[2]),
        )

    def _shape(self, one: Type1Set) -> tuple[str, tuple[float, ...], float]:
        if isinstance(one, Lagged) and not any(one.lags):
            kind, values, height = self._shape(one.whole)
            return kind, values, height * one.scale
        if isinstance(one, Truncated) and self.open_toolbox:
            # It was cut off because it is above the upper function beyond the range.
            return self._shape(one.whole)
        return named_shape(one) or self._refuse(
            f"{one!r}", "it has no membership function of that shape"
        )


def _without_complements(variable: Variable) -> tuple[Variable, list[int]]:
    """Return a variable without its complements, and the number of each term in the file.

    Numbers start at 1 and are negative for complements.
    """
    terms = {name: term for name, term in variable.terms.items() if not _is_complement(term)}
    numbers = []
    for name, term in variable.terms.items():
        sign, one = (-1, complement(term)) if _is_complement(term) else (1, term)
        if name not in terms and one not in terms.values():
            own = name.removeprefix("not ") or name
            while own in variable.terms or own in terms:
                own = f"not {own}"
            terms[own] = one
        place = list(terms).index(name) if sign > 0 else list(terms.values()).index(one)
        numbers.append(sign * (place + 1))
    return Variable(variable.name, variable.range, terms), numbers


def _is_complement(term: Any) -> bool:
    if isinstance(term, IntervalType2Set):
        return isinstance(term.lower, Complement) and isinstance(term.upper, Complement)
    return isinstance(term, Complement)


def _lag(foot: float, lower_foot: float, shoulder: float) -> float:
    """Return the grade of the upper membership function at the foot of the lower one."""
    return (
        0.0 if foot == lower_foot else min(max((lower_foot - foot) / (shoulder - foot), 0.0), 1.0)
    )


def _vector(values: Iterable[float]) -> str:
    # Enough digits to read back the same float.
    return (
        "["
        + " ".join(repr(float(value)).removesuffix(".0").replace("inf", "Inf") for value in values)
        + "]"
    )

"""A description, written as the text of a ``.fis`` file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import Any, NoReturn

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import Description, LinearFunction, Variable, check_names
from fuzzy2.files.fis_names import (
    AGGREGATIONS,
    OPEN_TOOLBOX_REDUCERS,
    OPEN_TOOLBOX_SUFFIX,
    REDUCERS,
    T_NORMS,
    corners_of,
)
from fuzzy2.operations.set_operations import complement
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.shapes import Gaussian, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.sets.uncertain_mean import NearestMeanGaussian


class FisWriter:
    """One description, written line by line."""

    def __init__(self, description: Description, name: str, where: str) -> None:
        self.description, self.where = description, where
        self.open_toolbox = where == OPEN_TOOLBOX_SUFFIX
        check_names(description, where)
        self.name = name if name.isprintable() else "system"

    def _refuse(self, what: str, reason: str) -> NoReturn:
        raise NotExpressible(what, self.where, reason)

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
        lines = ["[System]", f"Name={_quote(self.name)}", *self._system(), ""]
        inputs, outputs = (
            [_without_complements(variable) for variable in of]
            for of in (described.inputs, described.outputs)
        )
        for i, (variable, _) in enumerate(inputs):
            lines += [f"[Input{i + 1}]", *self._variable(variable, True), ""]
        for i, (variable, _) in enumerate(outputs):
            lines += [f"[Output{i + 1}]", *self._variable(variable, described.mamdani), ""]
        lines.append("[Rules]")
        for asked, said in described.rules:
            if max(asked) < 0:
                self._refuse(
                    "a rule that asks for nothing", "it cannot be told from one that never fires"
                )
            sides = (
                " ".join(
                    str(numbers[term] if term >= 0 else 0)
                    for term, (_, numbers) in zip(terms, variables, strict=True)
                )
                for terms, variables in ((asked, inputs), (said, outputs))
            )
            lines.append(f"{', '.join(sides)} (1) : 1")
        return "\n".join(lines) + "\n"

    def _system(self) -> list[str]:
        described = self.description
        version = "3.0" if described.type2 and not self.open_toolbox else "2.0"
        t_norm = _known_as(described.t_norm, T_NORMS) or self._refuse(
            f"the t-norm {described.t_norm!r}", "it has min and prod only"
        )
        if described.mamdani:
            aggregation = _known_as(described.aggregation, AGGREGATIONS)
            if aggregation is None:
                self._refuse(
                    f"the t-conorm {described.aggregation!r}", "it has max, probor and sum only"
                )
            kind, methods = "mamdani", ("max", t_norm, aggregation, "centroid")
        else:
            kind, methods = "sugeno", ("probor", "prod", "sum", "wtaver")
        lines = [
            f"Type='{kind}'",
            f"Version={version}",
            f"NumInputs={len(described.inputs)}",
            f"NumOutputs={len(described.outputs)}",
        ]
        lines += [f"NumRules={len(described.rules)}", f"AndMethod='{t_norm}'"]
        lines += [
            f"{key}='{method}'"
            for key, method in zip(
                ("OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod"), methods, strict=True
            )
        ]
        if described.type2:
            # A method that MATLAB has not is as exact as the one that it is exchanged for.
            known, key = (
                (OPEN_TOOLBOX_REDUCERS, "TypeRedMethod")
                if self.open_toolbox
                else (REDUCERS, "TypeReductionMethod")
            )
            lines.append(
                f"{key}='{_known_as(described.method, known) or _known_as('eiasc', known)}'"
            )
        return lines

    def _variable(self, variable: Variable, of_sets: bool) -> list[str]:
        low, high = variable.range
        if not low < high:
            # A range of no width is not read; constants may all be one.
            margin = max(1.0, 0.5 * abs(low))
            low, high = low - margin, high + margin
        lines = [
            f"Name={_quote(variable.name)}",
            f"Range={_vector((low, high))}",
            f"NumMFs={len(variable.terms)}",
        ]
        for i, (name, term) in enumerate(variable.terms.items()):
            if of_sets:
                lines += self._term(f"MF{i + 1}", name, term)
            elif isinstance(term, LinearFunction):
                lines.append(
                    f"MF{i + 1}={_quote(name)}:'linear',{_vector((*term.slopes, term.constant))}"
                )
            elif self.open_toolbox:
                lines.append(f"MF{i + 1}={_quote(name)}:'constant',{_vector(term)}")
            elif term.left == term.right:
                lines.append(f"MF{i + 1}={_quote(name)}:'constant',{_vector(term[:1])}")
            else:
                self._refuse(
                    f"the interval {list(term)} as a consequent",
                    "its constants are crisp; write .t2fis",
                )
        return lines

    def _term(self, key: str, name: str, term: Any) -> list[str]:
        lower, upper = (
            (term.lower, term.upper) if isinstance(term, IntervalType2Set) else (term, term)
        )
        if self.open_toolbox:
            both = [(side, *self._shape(one)) for side, one in (("U", upper), ("L", lower))]
            return [
                f"{key}{side}={_quote(name)}:'{kind}',{_vector((*values, height))}"
                for side, kind, values, height in both
            ]
        kind, values, height = self._shape(upper)
        if height != 1.0:
            self._refuse(f"{upper!r}", "its membership functions reach 1")
        if not self.description.type2:
            return [f"{key}={_quote(name)}:'{kind}',{_vector(values)}"]
        scale, lags = self._scale_and_lags(term, lower, upper)
        return [
            f"{key}={_quote(name)}:'{kind}',{_vector(values)},{_vector([scale])},{_vector(lags)}"
        ]

    def _scale_and_lags(
        self, term: Any, lower: Type1Set, upper: Type1Set
    ) -> tuple[float, tuple[float, float]]:
        if lower == upper:
            return 1.0, (0.0, 0.0)
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
        if isinstance(one, Trapezoidal) and math.isinf(one.a) and math.isfinite(one.d):
            return "linzmf", (one.c, one.d), one.height
        if isinstance(one, Trapezoidal) and math.isinf(one.d) and math.isfinite(one.a):
            return "linsmf", (one.a, one.b), one.height
        corners = corners_of(one)
        if corners is not None and all(map(math.isfinite, corners)):
            return (
                ("trimf", (corners[0], *corners[2:]), one.height)
                if isinstance(one, Triangular)
                else ("trapmf", corners, one.height)
            )
        if isinstance(one, Gaussian):
            return "gaussmf", (one.sigma, one.mean), one.height
        if isinstance(one, NearestMeanGaussian):
            return "gauss2mf", (one.sigma, one.mean[0], one.sigma, one.mean[1]), 1.0
        if isinstance(one, PiShaped) and (math.isfinite(one.a) or math.isfinite(one.d)):
            corners = one.a, one.b, one.c, one.d
            kind = "zmf" if math.isinf(one.a) else "smf" if math.isinf(one.d) else "pimf"
            return kind, tuple(filter(math.isfinite, corners)), one.height
        if isinstance(one, TwoSidedGaussian):
            return "gauss2mf", (one.sigma[0], one.mean[0], one.sigma[1], one.mean[1]), 1.0
        if isinstance(one, SigmoidDifference | SigmoidProduct):
            (c1, c2), (s1, s2) = one.center, one.slope
            return (
                "dsigmf" if isinstance(one, SigmoidDifference) else "psigmf",
                (s1, c1, s2, c2),
                1.0,
            )
        if isinstance(one, Bell):
            return "gbellmf", (one.width, one.slope, one.center), 1.0
        if isinstance(one, Sigmoid):
            return "sigmf", (one.slope, one.center), 1.0
        raise NotExpressible(f"{one!r}", self.where, "it has no membership function of that shape")


def _without_complements(variable: Variable) -> tuple[Variable, list[int]]:
    """Return a variable without its complements, and the number of each term.

    Numbers count from 1 and are negative for a complement.
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


def _known_as(name: str, known: dict[str, str]) -> str | None:
    return next((theirs for theirs, ours in known.items() if ours == name), None)


def _quote(name: str) -> str:
    return "'" + name.replace("'", "''") + "'"


def _vector(values: Iterable[float]) -> str:
    # The digits that give back the same float.
    return (
        "["
        + " ".join(repr(float(value)).removesuffix(".0").replace("inf", "Inf") for value in values)
        + "]"
    )

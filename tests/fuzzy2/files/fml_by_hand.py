"""An evaluator of FML documents that shares nothing with the package but NumPy.

It takes what IEEE Std 1855 says word by word: an element is a grade, a rule a firing, an output an
average. Inputs are rows; sets of outputs are united on a grid.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any
from xml.etree import ElementTree

import numpy as np

Array = np.ndarray[Any, Any]
Grade = Callable[[Array], Array]

T_NORMS: dict[str, Callable[[Array, Array], Array]] = {
    "MIN": np.minimum,
    "PROD": np.multiply,
    "BDIF": lambda a, b: np.maximum(0.0, a + b - 1.0),
    "BSUM": lambda a, b: np.maximum(0.0, a + b - 1.0),
    "DRP": lambda a, b: np.where(a == 1.0, b, np.where(b == 1.0, a, 0.0)),
    "EPROD": lambda a, b: a * b / (2.0 - (a + b - a * b)),
    "NILMIN": lambda a, b: np.where(a + b > 1.0, np.minimum(a, b), 0.0),
}
S_NORMS: dict[str, Callable[[Array, Array], Array]] = {
    "MAX": np.maximum,
    "PROBOR": lambda a, b: a + b - a * b,
    "BSUM": lambda a, b: np.minimum(1.0, a + b),
    "DRS": lambda a, b: np.where(a == 0.0, b, np.where(b == 0.0, a, 1.0)),
    "ESUM": lambda a, b: (a + b) / (1.0 + a * b),
    "NILMAX": lambda a, b: np.where(a + b < 1.0, np.maximum(a, b), 1.0),
}
MODIFIERS: dict[str, Callable[[Array], Array]] = {
    "": lambda g: g,
    "not": lambda g: 1.0 - g,
    "very": lambda g: g**2,
    "extremely": lambda g: g**3,
    "somewhat": np.sqrt,
    "more_or_less": np.cbrt,
    "plus": lambda g: g**1.25,
}


def _name(element: ElementTree.Element) -> str:
    return element.tag.split("}")[-1]


def _of(element: ElementTree.Element, *names: str) -> list[ElementTree.Element]:
    return [child for child in element if _name(child) in names]


def _text(element: ElementTree.Element, name: str) -> str:
    return (_of(element, name)[0].text or "").strip()


def _ramp(x: Array, low: float, high: float) -> Array:
    """Return 0 left of the first point, 1 right of the second one, a line between them."""
    if low == high:
        return np.where(x >= low, 1.0, 0.0)
    return np.clip((x - low) / (high - low), 0.0, 1.0)


def _s(x: Array, a: float, b: float) -> Array:
    """Return two parabolas from 0 at a to 1 at b."""
    if a >= b:
        return np.where(x >= a, 1.0, 0.0)
    t = np.clip((x - a) / (b - a), 0.0, 1.0)
    return np.where(t <= 0.5, 2.0 * t**2, 1.0 - 2.0 * (1.0 - t) ** 2)


def _bell(x: Array, mean: float, sigma: float) -> Array:
    return np.exp(-0.5 * ((x - mean) / sigma) ** 2)


def _trapezoid(x: Array, a: float, b: float, c: float, d: float) -> Array:
    falling = np.where(x <= c, 1.0, 0.0) if c == d else np.clip((d - x) / (d - c), 0.0, 1.0)
    return np.minimum(_ramp(x, a, b), falling)


SHAPES: dict[str, Callable[..., Array]] = {
    "triangularShape": lambda x, a, b, c: _trapezoid(x, a, b, b, c),
    "trapezoidShape": _trapezoid,
    "rectangularShape": lambda x, a, b: np.where((a <= x) & (x <= b), 1.0, 0.0),
    "singletonShape": lambda x, a: np.where(x == a, 1.0, 0.0),
    "gaussianShape": _bell,
    "rightGaussianShape": lambda x, m, s: np.where(x >= m, 1.0, _bell(x, m, s)),
    "leftGaussianShape": lambda x, m, s: np.where(x <= m, 1.0, _bell(x, m, s)),
    "rightLinearShape": _ramp,
    "leftLinearShape": lambda x, a, b: 1.0 - _ramp(x, a, b),
    "sShape": _s,
    "zShape": lambda x, a, b: 1.0 - _s(x, a, b),
    "piShape": lambda x, a, b: _s(np.where(x <= b, x, 2.0 * b - x), a, b),
}


def _lagrange(x: Array, at: Array, grades: Array) -> Array:
    total = np.zeros_like(x)
    for k, one in enumerate(at):
        factor = np.full_like(x, grades[k])
        for other in np.delete(at, k):
            factor = factor * (x - other) / (one - other)
        total = total + factor
    return np.clip(total, 0.0, 1.0)


def _through_points(shape: ElementTree.Element) -> Grade:
    pairs = sorted((float(p.attrib["x"]), float(p.attrib["y"])) for p in _of(shape, "point"))
    at, grades = np.array(pairs).T
    if shape.attrib.get("interpolationMethod", "linear") == "lagrange":
        return lambda x: _lagrange(x, at, grades)
    return lambda x: np.interp(x, at, grades)


def _of_parameters(kind: str, numbers: list[float], x: Array) -> Array:
    return SHAPES[kind](x, *numbers)


def _grade(term: ElementTree.Element, terms: dict[str, Grade]) -> Grade:
    """Return the membership function of a term, which may be made of others."""
    shape = next(iter(term))
    kind = _name(shape)
    if kind == "circularDefinition":
        whole = _logical(next(iter(shape)), terms)
    elif kind.startswith("pointSet"):
        whole = _through_points(shape)
    else:
        numbers = [float(shape.attrib[f"param{i + 1}"]) for i in range(len(shape.attrib))]
        whole = partial(_of_parameters, kind, numbers)
    if term.attrib.get("complement", "false").lower() == "true":
        return lambda x: 1.0 - whole(x)
    return whole


def _logical(element: ElementTree.Element, terms: dict[str, Grade]) -> Grade:
    if _name(element) == "termName":
        return lambda x: terms[(element.text or "").strip()](x)
    first, second = (_logical(child, terms) for child in element)
    norm = _norm_of(element)
    return lambda x: norm(first(x), second(x))


def _norm_of(element: ElementTree.Element) -> Callable[[Array, Array], Array]:
    """Return what an element <and> or <or> of parts means."""
    if _name(element) == "and":
        return T_NORMS[element.attrib.get("t-norm", "MIN")]
    return S_NORMS[element.attrib.get("t-conorm", "MAX")]


class ByHand:
    """One document, evaluated as it is written.

    ``points`` is how many points of an output's domain the center of gravity takes.
    """

    def __init__(self, text: str, points: int = 20001) -> None:
        root = ElementTree.fromstring(text.encode("utf-8"))
        self._points = points
        base = _of(root, "knowledgeBase")[0]
        self._rule_base = next(child for child in root if _name(child).endswith("RuleBase"))
        variables = {
            one.attrib["name"]: one for one in base if _name(one) != "aggregatedFuzzyVariable"
        }
        self._aggregated = {
            one.attrib["name"]: {term.attrib["name"]: next(iter(term)) for term in one}
            for one in base
            if _name(one) == "aggregatedFuzzyVariable"
        }
        self._inputs = {name: one for name, one in variables.items() if _is_input(one)}
        self._outputs = {name: one for name, one in variables.items() if name not in self._inputs}
        self._terms = {name: _terms(one) for name, one in variables.items()}

    def inputs(self, count: int, seed: int = 0) -> Array:
        """Return inputs (count, p) within the domains; of clouds within their data."""
        low, high = np.transpose([_domain(one) for one in self._inputs.values()])
        return np.random.default_rng(seed).uniform(low, high, (count, len(low)))

    def ranges(self) -> Array:
        """Return the widths (m,) by which answers are judged, 1 for numbers."""
        return np.array([np.ptp(_domain(one)) for one in self._outputs.values()])

    def __call__(self, X: Array) -> Array:
        """Return the outputs (n, m) at inputs (n, p)."""
        given = dict(zip(self._inputs, np.transpose(X), strict=True))
        fired: dict[str, list[tuple[str, Array]]] = {name: [] for name in self._outputs}
        for rule, firing in self._firings(given):
            consequent = _of(rule, "consequent", "tskConsequent")[0]
            for branch in consequent:
                own = firing if _name(branch).lower().endswith("then") else 1.0 - firing
                for clause in branch:
                    fired[_text(clause, "variable")].append((_word(clause), own))
        return np.stack(
            [self._output(name, one, fired[name], given) for name, one in self._outputs.items()],
            axis=-1,
        )

    def _firings(self, given: dict[str, Array]) -> list[tuple[ElementTree.Element, Array]]:
        weights = [float(rule.attrib.get("weight", "1")) for rule in self._rule_base]
        if _name(self._rule_base) == "anYaRuleBase":
            names = [
                _text(_of(rule, "anYaAntecedent")[0], "dataCloudName") for rule in self._rule_base
            ]
            dense = [_density(self._terms[name]["data"], given[name]) for name in names]
            firings = [one / np.sum(dense, axis=0) for one in dense]
        else:
            firings = [self._antecedent(rule, given) for rule in self._rule_base]
        return [
            (rule, weight * firing)
            for rule, weight, firing in zip(self._rule_base, weights, firings, strict=True)
        ]

    def _antecedent(self, rule: ElementTree.Element, given: dict[str, Array]) -> Array:
        parts = [self._clause(clause, given) for clause in _of(rule, "antecedent")[0]]
        word = rule.attrib.get("connector", "and").lower()
        known = T_NORMS if word == "and" else S_NORMS
        base = self._rule_base.attrib.get(f"{word}Method", "MIN" if word == "and" else "MAX")
        norm, whole = known[rule.attrib.get(f"{word}Method", base).upper()], parts[0]
        for part in parts[1:]:
            whole = norm(whole, part)
        return whole

    def _clause(self, clause: ElementTree.Element, given: dict[str, Array]) -> Array:
        name, modifier = _text(clause, "variable"), clause.attrib.get("modifier", "").lower()
        if name in self._aggregated:
            grade = self._of_others(self._aggregated[name][_text(clause, "term")], given)
        else:
            grade = self._terms[name][_text(clause, "term")](given[name])
        return MODIFIERS[modifier](grade)

    def _of_others(self, element: ElementTree.Element, given: dict[str, Array]) -> Array:
        if _name(element) == "clause":
            return self._clause(element, given)
        first, second = (self._of_others(part, given) for part in element)
        return _norm_of(element)(first, second)

    def _output(
        self,
        name: str,
        variable: ElementTree.Element,
        fired: list[tuple[str, Array]],
        given: dict[str, Array],
    ) -> Array:
        terms, count = self._terms[name], len(next(iter(given.values())))
        if _name(variable) == "tskVariable":
            at = np.stack([np.ones(count), *given.values()], axis=-1)
            said = [
                (firing, at[:, : len(terms[word])] @ np.array(terms[word]))
                for word, firing in fired
            ]
            answer = _average(said, count)
        elif _name(variable) == "tsukamotoVariable":
            left, right = _domain(variable)
            ends = left - 9.0 * (right - left), right + 9.0 * (right - left)
            said = [(firing, _point_of(terms[word], ends, firing)) for word, firing in fired]
            answer = _average(said, count)
        else:
            answer = self._defuzzified(variable, terms, fired, count)
        default = variable.attrib.get("defaultValue", "0")
        return np.where(np.isnan(answer), float(default), answer)

    def _defuzzified(
        self,
        variable: ElementTree.Element,
        terms: dict[str, Any],
        fired: list[tuple[str, Array]],
        count: int,
    ) -> Array:
        left, right = _domain(variable)
        points = [float(one.attrib["param1"]) for one in variable.iter() if _is_point(one)]
        grid = np.array(sorted(points)) if points else np.linspace(left, right, self._points)
        implied = T_NORMS[self._rule_base.attrib.get("activationMethod", "MIN").upper()]
        joined = S_NORMS[variable.attrib.get("accumulation", "MAX").upper()]
        shapes = {word: terms[word](grid) for word, _ in fired}
        answers = np.empty(count)
        for k in range(count):
            united = np.zeros_like(grid)
            for word, firing in fired:
                united = joined(united, implied(firing[k], shapes[word]))
            answers[k] = _crisp(grid, united, variable.attrib.get("defuzzifier", "COG").upper())
        return answers


def _is_input(variable: ElementTree.Element) -> bool:
    if _name(variable) == "anYaDataCloud":
        return True
    kind = variable.attrib.get("type", "input").lower()
    return _name(variable) == "fuzzyVariable" and kind == "input"


def _is_point(element: ElementTree.Element) -> bool:
    return _name(element) == "singletonShape"


def _domain(variable: ElementTree.Element) -> tuple[float, float]:
    if _name(variable) == "anYaDataCloud":
        data = [float(one.text or "") for one in variable]
        return min(data), max(data)
    if _name(variable) == "tskVariable":
        return 0.0, 1.0
    return float(variable.attrib["domainleft"]), float(variable.attrib["domainright"])


def _terms(variable: ElementTree.Element) -> dict[str, Any]:
    if _name(variable) == "anYaDataCloud":
        return {"data": np.array([float(one.text or "") for one in variable])}
    terms: dict[str, Any] = {}
    for term in variable:
        terms[term.attrib["name"]] = (
            [float(one.text or "") for one in term]
            if _name(variable) == "tskVariable"
            else _grade(term, terms)
        )
    return terms


def _word(clause: ElementTree.Element) -> str:
    assert "modifier" not in clause.attrib
    return _text(clause, "term")


def _density(cloud: Array, x: Array) -> Array:
    return len(cloud) / (len(cloud) + np.abs(x[:, np.newaxis] - cloud).sum(axis=1))


def _average(said: list[tuple[Array, Array]], count: int) -> Array:
    """Return the weighted average, NaN where nothing fires."""
    above, below = np.zeros(count), np.zeros(count)
    for firing, value in said:
        above, below = above + firing * value, below + firing
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(below > 0.0, above / below, np.nan)


def _point_of(grade: Grade, ends: tuple[float, float], wanted: Array) -> Array:
    """Return the points between ends at which a monotonic set has wanted grades, by bisection."""
    low, high = np.full_like(wanted, ends[0]), np.full_like(wanted, ends[1])
    rising = grade(high) > grade(low)
    for _ in range(100):
        middle = 0.5 * (low + high)
        beyond = (grade(middle) >= wanted) == rising
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return 0.5 * (low + high)


def _crisp(grid: Array, grades: Array, method: str) -> float:
    """Return the number that a set on a grid stands for, NaN if it is empty."""
    if not grades.any():
        return float("nan")
    if method == "COG":
        return float(grid @ grades / grades.sum())
    if method == "COA":
        area = np.cumsum(grades)
        return float(np.interp(0.5 * area[-1], area, grid))
    top = grid[grades >= grades.max() * (1.0 - 1e-12)]
    return float({"LM": top[0], "RM": top[-1], "MOM": 0.5 * (top[0] + top[-1])}[method])

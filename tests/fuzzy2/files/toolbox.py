"""The Fuzzy Logic Toolbox in a hundred lines, written from its documentation.

It evaluates the text of a ``.fis`` or ``.t2fis`` file a rule and a point at a time, and shares
nothing with the package.
"""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np


def sections(text: str) -> dict[str, list[str]]:
    """Return the lines of a file by section, without comments."""
    found: dict[str, list[str]] = {}
    for line in text.splitlines():
        line = line.strip()
        if re.fullmatch(r"\[(System|Rules|(Input|Output)\d+)\]", line):
            current = found.setdefault(line[1:-1], [])
        elif line and line[0] not in "%#":
            current.append(line)
    return found


def entries(lines: list[str]) -> dict[str, str]:
    return {key.strip(): value.strip() for key, value in (line.split("=", 1) for line in lines)}


def vector(text: str) -> list[float]:
    words = text.replace(",", " ").strip("[] ").split()
    return [float(word.replace("pi", "3.141592653589793")) for word in words if "/" not in word] + [
        float(word.split("/")[0].replace("pi", "3.141592653589793")) / float(word.split("/")[1])
        for word in words
        if "/" in word
    ]


def ramp(x: float, low: float, high: float) -> float:
    """Return 0 up to one point, 1 from another one."""
    if low == high:
        return 1.0 if x >= low else 0.0
    return min(max((x - low) / (high - low), 0.0), 1.0)


def s_curve(x: float, a: float, b: float) -> float:
    if a >= b:
        return 1.0 if x >= (a + b) / 2 else 0.0
    if x <= a:
        return 0.0
    if x >= b:
        return 1.0
    if x <= (a + b) / 2:
        return float(2 * ((x - a) / (b - a)) ** 2)
    return float(1 - 2 * ((x - b) / (b - a)) ** 2)


def logistic(x: float, a: float, c: float) -> float:
    return 1.0 / (1.0 + math.exp(min(-a * (x - c), 700.0)))


def bell(x: float, sigma: float, c: float) -> float:
    return 0.0 if sigma == 0.0 else math.exp(-((x - c) ** 2) / (2 * sigma**2))


def grade(kind: str, p: list[float], x: float) -> float:  # noqa: C901 (one branch a shape)
    if kind == "trimf":
        a, b, c = p[:3]
        left = 1.0 if x == b else ramp(x, a, b) if x < b else 1.0
        return left if x <= b else 1.0 - ramp(x, b, c)
    if kind == "trapmf":
        a, b, c, d = p[:4]
        left = 1.0 if x >= b else ramp(x, a, b)
        return min(left, 1.0 if x <= c else 1.0 - ramp(x, c, d))
    if kind == "gaussmf":
        return bell(x, *p[:2])
    if kind == "gauss2mf":
        s1, c1, s2, c2 = p[:4]
        return (bell(x, s1, c1) if x < c1 else 1.0) * (bell(x, s2, c2) if x > c2 else 1.0)
    if kind == "gbellmf":
        a, b, c = p[:3]
        return float(1.0 / (1.0 + abs((x - c) / a) ** (2 * b)))
    if kind == "sigmf":
        return logistic(x, *p[:2])
    if kind == "dsigmf":
        return min(max(logistic(x, *p[:2]) - logistic(x, *p[2:4]), 0.0), 1.0)
    if kind == "psigmf":
        return logistic(x, *p[:2]) * logistic(x, *p[2:4])
    if kind == "smf":
        return s_curve(x, *p[:2])
    if kind == "zmf":
        return 1.0 - s_curve(x, *p[:2])
    if kind == "pimf":
        return s_curve(x, *p[:2]) * (1.0 - s_curve(x, *p[2:4]))
    if kind == "rampmf":
        return ramp(x, *p) if p[0] <= p[1] else 1.0 - ramp(x, p[1], p[0])
    if kind == "linsmf":
        return ramp(x, *p[:2])
    if kind == "linzmf":
        return 1.0 - ramp(x, *p[:2])
    raise NotImplementedError(kind)


T_NORMS = {"min": lambda *of: min(of), "prod": lambda *of: math.prod(of)}
T_CONORMS = {
    "max": lambda *of: max(of),
    "probor": lambda *of: 1.0 - math.prod(1.0 - one for one in of),
    "sum": lambda *of: sum(of),
}
MF = re.compile(r"'([^']*)'\s*:\s*'([^']*)'\s*,\s*\[([^\]]*)\]")


class Toolbox:
    """A file, ready to be evaluated."""

    def __init__(self, text: str) -> None:
        found = sections(text)
        self.system = {key: one.strip("'") for key, one in entries(found["System"]).items()}
        self.inputs, self.outputs = (
            [entries(found[f"{kind}{i + 1}"]) for i in range(int(self.system[f"Num{kind}s"]))]
            for kind in ("Input", "Output")
        )
        self.rules = []
        for line in found["Rules"]:
            asked, said, weight, join = re.fullmatch(
                r"([^,]*),([^(]*)\(([^)]*)\)\s*:\s*(\d)", line
            ).groups()
            self.rules.append(
                (
                    [round(float(word)) for word in asked.split()],
                    [round(float(word)) for word in said.split()],
                    float(weight),
                    int(join),
                )
            )

    def of_term(self, variable: dict[str, str], number: int, x: float, side: str = "") -> float:
        """Return the grade of a term, by its number in the file."""
        if f"MF{abs(number)}U" in variable:
            _, kind, text = MF.match(variable[f"MF{abs(number)}{side or 'U'}"]).groups()
            *parameters, height = vector(text)
            value = height * grade(kind, parameters, x)
        else:
            _, kind, text = MF.match(variable[f"MF{abs(number)}"]).groups()
            value = grade(kind, vector(text), x)
        return 1.0 - value if number < 0 else value

    def fired(self, rule: Any, x: list[float], side: str = "") -> float:
        """Return how far a rule fires."""
        asked, _, weight, join = rule
        grades = [
            self.of_term(variable, number, at, side)
            for variable, number, at in zip(self.inputs, asked, x, strict=True)
            if number
        ]
        if join == 2:
            return weight * T_CONORMS[self.system["OrMethod"]](*grades)
        return weight * T_NORMS[self.system["AndMethod"]](*grades)

    def said(self, output: dict[str, str], number: int, x: list[float]) -> tuple[float, float]:
        """Return the interval that a rule says."""
        _, kind, text = MF.match(output[f"MF{number}"]).groups()
        values = vector(text)
        if kind == "constant":
            return values[0], values[1] if len(values) == 2 else values[0]
        value = sum(a * b for a, b in zip(values, x, strict=False)) + values[len(x)]
        return value, value

    def __call__(self, x: list[float]) -> list[float]:
        """Return the outputs."""
        return [self.output(j, list(x)) for j in range(len(self.outputs))]

    def output(self, j: int, x: list[float]) -> float:
        """Return one output."""
        rules = [rule for rule in self.rules if rule[1][j]]
        if self.system["Type"] == "sugeno":
            low = np.array([self.fired(rule, x, "L") for rule in rules])
            high = np.array([self.fired(rule, x, "U") for rule in rules])
            values = np.array([self.said(self.outputs[j], rule[1][j], x) for rule in rules])
            return self.averaged(values, low, high)
        output = self.outputs[j]
        points = np.linspace(*vector(output["Range"]), 101)
        implied = {"min": np.minimum, "prod": np.multiply}[self.system["ImpMethod"]]
        united = np.zeros(101)
        for rule in rules:
            shape = np.array([self.of_term(output, rule[1][j], at) for at in points])
            clipped = implied(self.fired(rule, x), shape)
            if self.system["AggMethod"] == "max":
                united = np.maximum(united, clipped)
            elif self.system["AggMethod"] == "probor":
                united = united + clipped - united * clipped
            else:
                united = united + clipped
        return self.defuzzified(points, united)

    def averaged(self, values: Any, low: Any, high: Any) -> float:
        """Return the average of what the rules say, by the method of the file."""
        if not high.any():
            return math.nan
        if self.system["DefuzzMethod"] == "wtsum":
            return float((high * values[:, 0]).sum())
        method = self.system.get("TypeRedMethod", "KM")
        middle = values.mean(axis=1)
        if method == "NT":
            return float((middle * (low + high)).sum() / (low + high).sum())
        if method.startswith("BMM"):
            a, b = map(float, method[4:-1].split(","))
            below = (middle * low).sum() / low.sum() if low.any() else math.nan
            return float(a * below + b * (middle * high).sum() / high.sum())
        ends = []
        for side, least in ((0, True), (1, False)):
            order = np.argsort(values[:, side], kind="stable")
            y, f, g = values[order, side], low[order], high[order]
            found = []
            for k in range(len(y) + 1):
                head, tail = (g, f) if least else (f, g)
                weights = np.concatenate([head[:k], tail[k:]])
                if weights.any():
                    found.append((y * weights).sum() / weights.sum())
            ends.append(min(found) if least else max(found))
        return float(sum(ends) / 2)

    def defuzzified(self, points: Any, united: Any) -> float:
        """Return the output of a united set, given at points."""
        method, best = self.system["DefuzzMethod"], united.max()
        if best == 0.0:
            return math.nan
        highest = points[united >= best * (1 - 1e-12)]
        if method == "centroid":
            return float((points * united).sum() / united.sum())
        if method == "mom":
            return float(highest.mean())
        if method in ("som", "lom"):
            order = np.argsort(abs(highest), kind="stable")
            return float(highest[order[0 if method == "som" else -1]])
        total = np.cumsum(united)
        return float(points[np.flatnonzero(total >= total[-1] / 2)[0]])

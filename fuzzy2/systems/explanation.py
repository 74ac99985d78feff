"""Explanations of a system's output: its deciding rules in words, in order of their shares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array
from fuzzy2.support.markup import Markup, element, joined
from fuzzy2.support.shown import Shown, table
from fuzzy2.systems.explainable import Explainable
from fuzzy2.systems.pictures import bars
from fuzzy2.systems.shares import shares_of
from fuzzy2.systems.words import rules_in_words

MOST = 10
"""Greatest number of rules that are listed for each output."""
LEAST = 5e-4
"""Share below which a rule is not listed; it would read 0.0 %."""


@dataclass(frozen=True, repr=False)
class Explanation(Shown):
    """Explanation of a system's output; ``str`` gives the text, :meth:`view` the picture.

    Parameters
    ----------
    system : FuzzySystem
        The system.
    x : (p,) ndarray
        The input.
    outputs : (m,) ndarray
        The crisp outputs; NaN where no rule fires.
    reduced : (m, 2) ndarray
        The type-reduced intervals, see :meth:`FuzzySystem.type_reduced`.
    firing : (R, 2) ndarray
        The firing intervals of the rules.
    shares : (R, m) ndarray
        Share of each rule in each output, see :mod:`fuzzy2.systems.shares`. The shares of an output
        add up to 1, or are all 0 if no rule fires for it.
    rules : tuple of R str
        The rules in words.
    """

    system: Explainable
    x: Array
    outputs: Array
    reduced: Array
    firing: Array
    shares: Array
    rules: tuple[str, ...]

    @property
    def pictured(self) -> Explanation:
        """The explanation that is drawn."""
        return self

    def ranking(self, output: int = 0) -> NDArray[np.intp]:
        """Return the numbers of the contributing rules, in descending order of their shares.

        Parameters
        ----------
        output : int
            Number of the output.
        """
        shares = self.shares[:, output]
        order = np.argsort(-shares, kind="stable")
        contributing: NDArray[np.intp] = order[shares[order] > 0.0]
        return contributing

    def text(self, most: int = MOST) -> str:
        """Return the outputs and the rules that decided each of them, as text.

        Parameters
        ----------
        most : int
            Rules that are listed for each output.
        """
        names = self.system.input_names
        at = ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, self.x, strict=True))
        return "\n".join(
            line
            for j in range(len(self.outputs))
            for line in (f"{self._headline(j)} at {at}", *self._lines(j, most))
        )

    def _headline(self, j: int) -> str:
        text = f"{self.system.output_names[j]} = {self.outputs[j]:.6g}"
        left, right = self.reduced[j]
        if left == right or np.isnan(left):
            return text
        if getattr(self.system, "reduction", None) == "gaussian":
            return f"{text}, standard deviation {right:.6g},"
        return f"{text}, in [{left:.6g}, {right:.6g}],"

    def _listed(self, j: int, most: int) -> NDArray[np.intp]:
        order = self.ranking(j)[:most]
        listed: NDArray[np.intp] = order[self.shares[order, j] >= LEAST]
        return listed

    def _lines(self, j: int, most: int) -> list[str]:
        order = self._listed(j, most)
        if not len(order):
            default = "" if np.isnan(self.outputs[j]) else "; the default output"
            return [f"  no rule fires{default}"]
        lines = [
            f"  {100.0 * self.shares[r, j]:5.1f} %  rule {r + 1} (fires {self._fires(int(r))}): "
            f"{self.rules[r]}"
            for r in order
        ]
        rest = len(self.ranking(j)) - len(order)
        if rest:
            share = 100.0 * (1.0 - self.shares[order, j].sum())
            lines.append(f"  {share:5.1f} %  {rest} other rule{'s' if rest > 1 else ''}")
        return lines

    def _fires(self, r: int) -> str:
        low, high = self.firing[r]
        return f"{high:.4g}" if low == high else f"{low:.4g} to {high:.4g}"

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<Explanation of {self._headline(0).rstrip(',')}, {len(self.ranking())} rules>"

    def _repr_html_(self) -> Markup:
        parts: list[Markup] = []
        for j in range(len(self.outputs)):
            order = self._listed(j, MOST)
            shares = [float(self.shares[r, j]) for r in order]
            rows = [
                [f"{100.0 * share:.1f} %", bar, f"rule {r + 1}", self.rules[r]]
                for r, share, bar in zip(order, shares, bars(shares), strict=True)
            ]
            parts += [element("p", element("b", self._headline(j))), table(rows)]
        return joined(parts)


def explained(system: Explainable, x: ArrayLike) -> Explanation:
    """Return the explanation of a system's output at one input; see :meth:`FuzzySystem.explain`."""
    firing = system.firing(x)
    if firing.ndim != 2:
        raise InvalidValue("x", firing.shape[:-2], "one input: a row of numbers, or one by name")
    row = system.one_row(x)
    outputs = np.asarray(system(row)[0])
    shares = np.zeros((len(firing), system.n_outputs))
    for weight, plane in system.explained_by:
        logarithms, far = plane.log_firing(row)
        shares += weight * shares_of(plane, row, logarithms[0], bool(far[0]))
    return Explanation(
        system,
        row[0],
        outputs,
        system.type_reduced(row)[0],
        firing,
        shares,
        tuple(rules_in_words(system)),
    )

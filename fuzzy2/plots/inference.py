"""The inference as a picture with one row for each rule, which MATLAB calls the rule viewer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fuzzy2.plots.names import literal
from fuzzy2.plots.panels import Panels, check_output, cycle_colors, given_panels, muted, new_panels
from fuzzy2.plots.sets import domain_of, points_of
from fuzzy2.support.checks import Array, of_kind
from fuzzy2.systems.antecedents import leaves, trees_of
from fuzzy2.systems.explanation import Explanation
from fuzzy2.systems.operators import SUM
from fuzzy2.systems.shares import points_of_rules

MOST = 12
"""Greatest number of rules that are drawn; those that contribute most are chosen."""


def figure_of_inference(
    explanation: Explanation, output: int = 0, axes: Sequence[Axes] | Axes | None = None
) -> Panels:
    """Draw how rules lead from an input to an output, with one row for each rule.

    The left panels show the terms of the antecedent, with the input as a line and the area below
    its grades filled. The right panel shows the consequent, clipped or scaled by the firing
    interval: a set, or a point or an interval whose height is the firing. The last row shows the
    union of all consequents, the type-reduced interval as a band, and the crisp output as a line.
    For a general type-2 system the lowest α-plane is drawn, with the crisp output of all planes;
    under the Gaussian corollary the band is one standard deviation wide on both sides. At most
    twelve rules are drawn, those that contribute most, but the union includes all rules.

    Parameters
    ----------
    explanation : Explanation
        The result of ``system.explain(x)``.
    output : int
        Number of the output.
    axes : sequence of Axes, optional
        Axes to draw into: one row for each rule that is drawn and a last row for the result, with
        one column for each input and a last column for the output. By default, those of a new
        figure.

    Returns
    -------
    tuple of Axes
        The axes, row by row.

    Raises
    ------
    InvalidValue
        If there is no such output, or if the number of axes is wrong.
    """
    of_kind("explanation", explanation, Explanation, "what explain() of a system returns")
    explanation = explanation.pictured
    system = explanation.system
    check_output(output, system.n_outputs)
    rules = sorted(explanation.ranking(output)[:MOST].tolist()) or list(
        range(min(MOST, len(explanation.rules)))
    )
    shown = _Shown(explanation, output)
    rows, columns = len(rules) + 1, len(system.input_names) + 1
    panels = given_panels(axes, rows * columns) or new_panels(
        2.1 * columns, 0.95 * rows + 0.5, rows, columns
    )
    grid = np.array(panels, dtype=object).reshape(rows, columns)
    for row, r in zip(grid, rules, strict=False):
        for i, panel in enumerate(row[:-1]):
            shown.draw_terms(panel, r, i)
        shown.draw_said(row[-1], r)
        row[0].set_ylabel(f"rule {r + 1}", rotation=0.0, ha="right", va="center")
    for i, panel in enumerate(grid[-1, :-1]):
        _hide(panel)
        value = f"{system.input_names[i]} = {explanation.x[i]:.5g}"
        panel.text(0.5, 0.5, literal(value), ha="center", va="center", transform=panel.transAxes)
    shown.draw_result(grid[-1, -1])
    for panel in grid[:-1].flat:
        panel.tick_params(labelbottom=False)
    return panels


class _Shown:
    """The part of an explanation that is drawn: the plane that represents the system."""

    def __init__(self, explanation: Explanation, output: int) -> None:
        self.explanation, self.output = explanation, output
        system = explanation.system
        # The lowest α-plane comes first; other systems represent themselves.
        self.plane = system.explained_by[0][1]
        rules = self.plane.rules
        self.trees = rules if isinstance(rules, tuple) else trees_of(rules)
        self.firing = self.plane.firing(explanation.x)
        self.colors = cycle_colors()
        self.domains = [domain_of(terms) if terms else (0.0, 1.0) for terms in self.plane.inputs]
        self.sets = self.plane.consequent_sets
        # Sets are drawn as sets even if type reduction replaces them with their centroids.
        self.range = self._range()

    def _range(self) -> tuple[float, float]:
        ranges = self.plane.output_ranges
        if ranges is not None:
            return ranges[self.output]
        if self.sets is not None:
            return domain_of([row[self.output] for row in self.sets if row[self.output]])
        points = self._points()
        shown = [*points[self._speaks()].ravel(), *self.explanation.reduced[self.output]]
        found = np.array([value for value in shown if np.isfinite(value)])
        margin = 0.06 * float(np.ptp(found)) or 1.0
        return float(found.min()) - margin, float(found.max()) + margin

    def _points(self) -> Array:
        rows = self.plane.one_row(self.explanation.x)
        return points_of_rules(self.plane, rows, self.output)

    def _speaks(self) -> Any:
        silent = self.plane.silent
        return np.ones(len(self.firing), bool) if silent is None else ~silent[:, self.output]

    def draw_terms(self, panel: Axes, r: int, i: int) -> None:
        """Draw the terms of an input in a rule's antecedent, and the input."""
        asked = [leaf for leaf in leaves(self.trees[r]) if leaf.variable == i]
        terms = [leaf.term for leaf in asked if leaf.term is not None]
        if not terms:
            _hide(panel)
            return
        x, domain = float(self.explanation.x[i]), self.domains[i]
        domain = min(domain[0], x), max(domain[1], x)
        for k, term in enumerate(dict.fromkeys(terms)):
            item, color = self.plane.inputs[i][int(term)], self.colors[k % len(self.colors)]
            points = points_of(domain, item)
            lower, upper = item.lower(points), item.upper(points)
            self._outline(panel, points, lower, upper, color)
            grade = float(item.lower(x)), float(item.upper(x))
            for level in grade:
                panel.fill_between(
                    points, np.minimum(upper, level), color=color, alpha=0.25, linewidth=0.0
                )
        panel.axvline(x, color=self.colors[1], linewidth=1.0)
        names = (self.explanation.system.term_names[i][int(term)] for term in dict.fromkeys(terms))
        panel.set_title(
            literal(f"{self.explanation.system.input_names[i]}: {', '.join(names)}"), loc="center"
        )
        panel.set(xlim=domain, ylim=(0.0, 1.05), yticks=())
        panel.title.set_fontsize("x-small")

    def draw_said(self, panel: Axes, r: int) -> None:
        """Draw the consequent of a rule, clipped or scaled by its firing."""
        if not self._speaks()[r]:
            _hide(panel)
            return
        self._draw_rule(panel, r, outlined=True)
        share = self.explanation.shares[r, self.output]
        panel.set_title(f"{100.0 * share:.1f} %", fontsize="x-small", loc="center")
        panel.set(xlim=self.range, ylim=(0.0, 1.05), yticks=())

    def _draw_rule(self, panel: Axes, r: int, outlined: bool) -> None:
        color = self.colors[0]
        if self.sets is None:
            left, right = self._points()[r]
            low, high = self.firing[r]
            if left != right:
                panel.fill_between([left, right], high, color=color, alpha=0.25, linewidth=0.0)
            panel.vlines([left, right], 0.0, high, color=color)
            panel.vlines([left, right], 0.0, low, color=color, linewidth=2.5)
            return
        item = self.sets[r][self.output]
        points = points_of(self.range, item)
        if outlined:
            self._outline(panel, points, item.lower(points), item.upper(points), muted())
        lower, upper = self._clipped(r, points)
        panel.fill_between(points, lower, color=color, alpha=0.3, linewidth=0.0)
        panel.fill_between(points, upper, color=color, alpha=0.3, linewidth=0.0)
        if item.upper.support[0] == item.upper.support[1]:
            at = item.upper.support[0]
            panel.vlines([at], 0.0, float(self._clipped(r, np.array([at]))[1][0]), color=color)

    def _clipped(self, r: int, points: Array) -> Array:
        assert self.sets is not None
        item = self.sets[r][self.output]
        grades = np.stack([item.lower(points), item.upper(points)])
        return np.asarray(self.plane.implication(self.firing[r][:, np.newaxis], grades))

    def union(self, points: Array) -> Array:
        """Return lower and upper grades (2, n) of the union of all consequents."""
        rules = np.flatnonzero(self._speaks())
        clipped = np.stack([self._clipped(int(r), points) for r in rules])
        kind = self.plane.type_reduction
        if kind == "center_of_sums" or self.plane.t_conorm is SUM:
            return np.asarray(clipped.sum(axis=0))
        return np.asarray(self.plane.t_conorm.reduce(clipped, axis=0))

    def draw_result(self, panel: Axes) -> None:
        """Draw the union, the type-reduced interval and the crisp output."""
        if self.sets is None:
            for r in np.flatnonzero(self._speaks()):
                self._draw_rule(panel, int(r), outlined=False)
            top = 1.05
        else:
            items = [row[self.output] for row in self.sets if row[self.output] is not None]
            points = np.unique(np.concatenate([points_of(self.range, item) for item in items]))
            lower, upper = self.union(points)
            self._outline(panel, points, lower, upper, self.colors[0])
            panel.fill_between(
                points, upper, color=self.colors[0], alpha=0.3, linewidth=0.0, label="union"
            )
            top = 1.05 * max(1.0, float(np.max(upper)))
        crisp = float(self.explanation.outputs[self.output])
        left, right = self.explanation.reduced[self.output]
        if getattr(self.explanation.system, "reduction", None) == "gaussian":
            left, right = left - right, left + right
        if np.isfinite(crisp):
            if left < right:
                panel.axvspan(left, right, color=self.colors[1], alpha=0.25, label="reduced")
            panel.axvline(crisp, color=self.colors[1], label="output")
        name = self.explanation.system.output_names[self.output]
        said = "no rule fires" if np.isnan(crisp) else f"{crisp:.5g}"
        panel.set_xlabel(literal(f"{name} = {said}"))
        panel.set(xlim=self.range, ylim=(0.0, top), yticks=())

    @staticmethod
    def _outline(panel: Axes, points: Array, lower: Array, upper: Array, color: str) -> None:
        panel.plot(points, upper, color=color, linewidth=1.0)
        if not np.array_equal(lower, upper):
            panel.plot(points, lower, color=color, linewidth=0.8, linestyle=(0, (5, 2)))


def _hide(panel: Axes) -> None:
    """Leave a panel empty except for its label, which describes its row."""
    panel.set(xticks=(), yticks=())
    for spine in panel.spines.values():
        spine.set_visible(False)
    panel.patch.set_visible(False)

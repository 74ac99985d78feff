"""One function that draws anything: a set, a system, a learner, an explanation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fuzzy2.errors import InvalidValue
from fuzzy2.plots.inference import figure_of_inference
from fuzzy2.plots.names import literal
from fuzzy2.plots.panels import Panels, given_panels, new_panels
from fuzzy2.plots.sets import figure_of_sets
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.explanation import Explanation
from fuzzy2.systems.system import FuzzySystem


def view(thing: Any, axes: Sequence[Axes] | Axes | None = None) -> Panels:
    """Draw a set, a system or a learner, as ``thing.view()`` does.

    Parameters
    ----------
    thing : set, mapping from names to sets, FuzzySystem, AnYaSystem, learner or Explanation
        A set is drawn as its membership function. A system is drawn as the terms of its inputs and
        of those outputs whose consequents are sets, with one panel for each variable. An AnYa
        system is drawn as the data and densities of its clouds, and a learner as its system. An
        explanation (``system.explain(x)``) is drawn as the inference, see
        :func:`fuzzy2.plots.figure_of_inference`.
    axes : Axes or sequence of them, optional
        Axes to draw into; by default, those of a new figure.

    Returns
    -------
    tuple of Axes
        The axes; ``axes[0].figure`` is the figure to save or to show.

    Raises
    ------
    InvalidValue
        If the thing cannot be drawn or is a learner that is not fitted, or if the number of axes is
        wrong.
    """
    if isinstance(thing, Explanation):
        return figure_of_inference(thing, axes=axes)
    if isinstance(thing, FuzzySystem):
        return _terms(thing, axes)
    if isinstance(thing, AnYaSystem):
        return _clouds(thing, axes)
    if isinstance(thing, Type1Set | IntervalType2Set | GeneralType2Set | dict):
        return figure_of_sets(thing, axes)
    system = getattr(thing, "system_", None)
    if isinstance(system, FuzzySystem):
        return _terms(system, axes)
    raise InvalidValue(
        "thing", thing, "a fuzzy set, a system, an explanation, or a learner after fit"
    )


def _terms(system: FuzzySystem, axes: Sequence[Axes] | Axes | None) -> Panels:
    named = [
        (name, dict(zip(words, terms, strict=True)))
        for name, words, terms in zip(
            system.input_names, system.term_names, system.inputs, strict=True
        )
        if terms
    ]
    if system.consequent_sets is not None:
        for j, name in enumerate(system.output_names):
            named.append((name, _said(system, j)))
    panels = given_panels(axes, len(named)) or new_panels(6.0, 2.2 * len(named), len(named))
    for panel, (name, sets) in zip(panels, named, strict=True):
        figure_of_sets(sets, panel)
        panel.set_xlabel(literal(name))
    return panels


def _clouds(system: AnYaSystem, axes: Sequence[Axes] | Axes | None) -> Panels:
    count = len(system.clouds)
    panels = given_panels(axes, count) or new_panels(6.0, 2.2 * count, count)
    for panel, name, cloud in zip(panels, system.input_names, system.clouds, strict=True):
        # Distances are drawn on a scale of 1, whatever the range of the data.
        points = np.linspace(cloud.min() - 1.0, cloud.max() + 1.0, 401)
        densities = 1.0 / (1.0 + np.abs(points[:, np.newaxis] - cloud).mean(axis=1))
        panel.plot(points, densities)
        panel.plot(cloud, np.zeros(cloud.size), "|", clip_on=False)
        panel.set_ylim(0.0, 1.0)
        panel.set_xlabel(literal(name))
    return panels


def _said(system: FuzzySystem, j: int) -> dict[str, Any]:
    """Return the different consequent sets of an output, by names of terms or rules."""
    assert system.consequent_sets is not None
    found: dict[str, Any] = {}
    for r, row in enumerate(system.consequent_sets):
        if row[j] is not None and row[j] not in found.values():
            name = system.consequent_names[r][j] if system.consequent_names else f"rule {r + 1}"
            found[name] = row[j]
    return found

"""Figures of sets, operations, type reduction and systems.

Figures of the thesis are named after their numbers there.

Every function draws into the given axes, or into those of a new figure, and returns them;
``axes[0].figure`` is the figure to save. Nothing here uses ``matplotlib.pyplot``. The appearance
follows the current settings of matplotlib::

    with fuzzy2.plots.style.style():
        figure_of_sets({"low": low, "high": high})[0].figure.savefig("sets.svg")

Secondary grades are drawn as darkness, or as brightness in the dark theme: the stronger the color,
the higher the grade.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from fuzzy2.plots.chapter_1 import figure_1 as figure_1
    from fuzzy2.plots.chapter_1 import figure_2 as figure_2
    from fuzzy2.plots.chapter_1 import figure_3 as figure_3
    from fuzzy2.plots.chapter_1 import figure_4 as figure_4
    from fuzzy2.plots.chapter_1 import figure_5 as figure_5
    from fuzzy2.plots.inference import figure_of_inference as figure_of_inference
    from fuzzy2.plots.operations import figure_of_join_and_meet as figure_of_join_and_meet
    from fuzzy2.plots.operations import figure_of_operations as figure_of_operations
    from fuzzy2.plots.sets import ACROSS as ACROSS
    from fuzzy2.plots.sets import POINTS as POINTS
    from fuzzy2.plots.sets import VISIBLE as VISIBLE
    from fuzzy2.plots.sets import figure_from_above as figure_from_above
    from fuzzy2.plots.sets import figure_in_space as figure_in_space
    from fuzzy2.plots.sets import figure_of_secondaries as figure_of_secondaries
    from fuzzy2.plots.sets import figure_of_sets as figure_of_sets
    from fuzzy2.plots.systems import figure_of_response as figure_of_response
    from fuzzy2.plots.systems import figure_of_rule_surface as figure_of_rule_surface
    from fuzzy2.plots.type_reduced import REACH as REACH
    from fuzzy2.plots.type_reduced import figure_of_type_reduced as figure_of_type_reduced
    from fuzzy2.plots.viewing import view as view

__all__, __getattr__, __dir__ = lazy_names(__name__)

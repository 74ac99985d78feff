r"""Names of the operators of a system: aggregation, type reduction and defuzzification.

Type reductions compute an answer from the firing of the rules:

============================  ==================================================================
name                          answer
============================  ==================================================================
"center_of_sets"              average of the consequents, by their centroids if they are sets
"height"                      average of the consequents' highest points
"modified_height"             the same, weights divided by squared spreads
"centroid"                    centroid of the united sets
"center_of_sums"              centroid of their sum
"bisector"                    point that halves the area of the united sets
"smallest_of_maxima"          first point of their greatest grade
"middle_of_maxima"            middle between the first and the last
"mean_of_maxima"              mean of all such points
"largest_of_maxima"           last point of their greatest grade
"smallest_absolute_maximum"   of these points the one nearest to 0, MATLAB's smallest of maxima
"largest_absolute_maximum"    the one farthest from 0, MATLAB's largest of maxima
"weighted_sum"                sum of the consequents, weighted with the firing, without dividing
"united_average"              average of the different consequents; the firing of rules with
                              the same consequent is united by the t-conorm first
"united_sum"                  sum of the different consequents, with the same firing
"tsukamoto"                   average of the points where monotonic consequents have the grade of
                              the firing
============================  ==================================================================

MATLAB's names ``"wtaver"``, ``"wtsum"``, ``"mom"``, ``"som"`` and ``"lom"`` are accepted with
MATLAB's meaning, and so is ``"weighted_average"`` for ``"center_of_sets"``.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from fuzzy2.errors import UnknownName
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS, BinaryFunction, TConorm, t_conorm
from fuzzy2.reduction.interval import METHODS as EXACT_METHODS

POINTS = ("center_of_sets", "weighted_sum", "united_average", "united_sum")
"""Type reductions that accept numbers, intervals and functions, too."""

HEIGHTS = ("height", "modified_height")
"""Type reductions that average highest points."""

AVERAGES = (*POINTS, *HEIGHTS, "tsukamoto")
"""Type reductions that average over the rules."""

MAXIMA = (
    "smallest_of_maxima",
    "middle_of_maxima",
    "mean_of_maxima",
    "largest_of_maxima",
    "smallest_absolute_maximum",
    "largest_absolute_maximum",
)
"""Type reductions that return a point of greatest grade."""

UNIONS = ("centroid", "center_of_sums", "bisector", *MAXIMA)
"""Type reductions that first unite the sets of the rules."""

TYPE_REDUCTIONS = (*AVERAGES, *UNIONS)
"""Names of the type reductions."""

CRISP_ONLY = ("bisector", *MAXIMA, "tsukamoto")
"""Type reductions that are only defined for type-1 systems."""

DIRECT_METHODS = ("nie_tan", "wu_mendel", "begian_melek_mendel")
"""Approximate methods that compute the crisp output without the type-reduced interval."""

METHODS = (*EXACT_METHODS, *DIRECT_METHODS)
"""Names of the methods of type reduction of a system."""

INTEGRATIONS = ("exact", "sum", "trapezoidal", "midpoint", "left")
"""How the centroid of united sets is computed: by integration, or as a sum over points from end to
end, over trapezoids between them, over the middles of equal pieces, or over their left ends."""

ALIASES = MappingProxyType(
    {
        "weighted_average": "center_of_sets",
        "wtaver": "center_of_sets",
        "wtsum": "weighted_sum",
        "mom": "mean_of_maxima",
        "som": "smallest_absolute_maximum",
        "lom": "largest_absolute_maximum",
    }
)
"""Other names of type reductions."""

SUM = TConorm("sum", np.add, T_NORMS["lukasiewicz"])
"""Aggregation that adds up the sets of the rules, even above 1. It is not a t-conorm."""

AGGREGATIONS = MappingProxyType({**T_CONORMS, SUM.name: SUM})
"""Ways to unite the sets of the rules, by name."""


def aggregation(name: str | TConorm | BinaryFunction) -> TConorm:
    """Return the aggregation of the rules' sets: a t-conorm, or the sum."""
    if isinstance(name, str) and name == SUM.name:
        return SUM
    return t_conorm(name)


def type_reduction(name: str) -> str:
    """Return the canonical name of a type reduction.

    Raises
    ------
    UnknownName
        If there is none.
    """
    known = ALIASES.get(name, name) if isinstance(name, str) else None
    if known not in TYPE_REDUCTIONS:
        raise UnknownName("type reduction", name, TYPE_REDUCTIONS)
    return known

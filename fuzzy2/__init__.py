"""Type-1, interval and general type-2 fuzzy logic: sets, operations, measures, numbers, type reduction, systems, learning, files, plots.

Names are imported when they are first used, so ``import fuzzy2`` costs little more than ``import numpy``.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fuzzy2.adaptation import AdaptiveConsequents
    from fuzzy2.approximate_reduction import approximate_centroid, approximate_generalized_centroid
    from fuzzy2.clustering import Clusters, fuzzy_c_means
    from fuzzy2.defuzzification import defuzzify
    from fuzzy2.errors import ApproximationWarning, Fuzzy2Error
    from fuzzy2.extension import extend
    from fuzzy2.fine_tuning import FineTuning, fine_tune
    from fuzzy2.fuzzifiers import NonSingletonFuzzifier, SingletonFuzzifier
    from fuzzy2.general_reduction import (
        alpha_plane_centroid,
        alpha_plane_reduction,
        exhaustive_centroid,
        exhaustive_generalized_centroid,
    )
    from fuzzy2.general_type2 import FunctionalType2Set, GaussianType2Set, GeneralType2Set, SampledType2Set, ZSlices
    from fuzzy2.interval_type2 import GaussianUncertainMean, GaussianUncertainSigma, IntervalType2Set
    from fuzzy2.join_meet import join, meet, negation
    from fuzzy2.json_files import from_json, load, save, to_json
    from fuzzy2.learning import WangMendel, gaussian_partition
    from fuzzy2.measures import cardinality, fuzziness, jaccard, rank
    from fuzzy2.noise import add_noise, mean_variation_from_snr, snr_from_mean_variation
    from fuzzy2.numbers import FuzzyNumber, GaussianNumber, IntervalNumber, gaussian_meet, gaussian_meet_error
    from fuzzy2.relations import cartesian_product, compose
    from fuzzy2.rules import Rule, format_rules, parse_rules
    from fuzzy2.set_operations import complement, intersection, union
    from fuzzy2.systems import FuzzySystem, GeneralType2System, IntervalType2System, Linear, Type1System
    from fuzzy2.t_norms import t_conorm, t_norm
    from fuzzy2.type1 import (
        Bell,
        Complement,
        FunctionalSet,
        Gaussian,
        Interval,
        PiShaped,
        SampledSet,
        Sigmoid,
        SigmoidDifference,
        SigmoidProduct,
        Singleton,
        Trapezoidal,
        Triangular,
        TwoSidedGaussian,
        Type1Set,
    )
    from fuzzy2.type_reduction import begian_melek_mendel, centroid, generalized_centroid, nie_tan, wu_mendel_bounds

_NAMES = {
    "approximate_reduction": ("approximate_centroid", "approximate_generalized_centroid"),
    "defuzzification": ("defuzzify",),
    "errors": ("ApproximationWarning", "Fuzzy2Error"),
    "extension": ("extend",),
    "fine_tuning": ("FineTuning", "fine_tune"),
    "fuzzifiers": ("NonSingletonFuzzifier", "SingletonFuzzifier"),
    "general_reduction": (
        "alpha_plane_centroid",
        "alpha_plane_reduction",
        "exhaustive_centroid",
        "exhaustive_generalized_centroid",
    ),
    "general_type2": ("FunctionalType2Set", "GaussianType2Set", "GeneralType2Set", "SampledType2Set", "ZSlices"),
    "interval_type2": ("GaussianUncertainMean", "GaussianUncertainSigma", "IntervalType2Set"),
    "join_meet": ("join", "meet", "negation"),
    "json_files": ("from_json", "load", "save", "to_json"),
    "learning": ("WangMendel", "gaussian_partition"),
    "adaptation": ("AdaptiveConsequents",),
    "clustering": ("Clusters", "fuzzy_c_means"),
    "measures": ("cardinality", "fuzziness", "jaccard", "rank"),
    "noise": ("add_noise", "mean_variation_from_snr", "snr_from_mean_variation"),
    "numbers": ("FuzzyNumber", "GaussianNumber", "IntervalNumber", "gaussian_meet", "gaussian_meet_error"),
    "relations": ("cartesian_product", "compose"),
    "rules": ("Rule", "format_rules", "parse_rules"),
    "set_operations": ("complement", "intersection", "union"),
    "systems": ("FuzzySystem", "GeneralType2System", "IntervalType2System", "Linear", "Type1System"),
    "t_norms": ("t_conorm", "t_norm"),
    "type1": (
        "Bell",
        "Complement",
        "FunctionalSet",
        "Gaussian",
        "Interval",
        "PiShaped",
        "SampledSet",
        "Sigmoid",
        "SigmoidDifference",
        "SigmoidProduct",
        "Singleton",
        "Trapezoidal",
        "Triangular",
        "TwoSidedGaussian",
        "Type1Set",
    ),
    "type_reduction": ("begian_melek_mendel", "centroid", "generalized_centroid", "nie_tan", "wu_mendel_bounds"),
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names}

__all__ = [
    "AdaptiveConsequents",
    "ApproximationWarning",
    "Bell",
    "Clusters",
    "Complement",
    "FineTuning",
    "FunctionalSet",
    "FunctionalType2Set",
    "Fuzzy2Error",
    "FuzzyNumber",
    "FuzzySystem",
    "Gaussian",
    "GaussianNumber",
    "GaussianType2Set",
    "GaussianUncertainMean",
    "GaussianUncertainSigma",
    "GeneralType2Set",
    "GeneralType2System",
    "Interval",
    "IntervalNumber",
    "IntervalType2Set",
    "IntervalType2System",
    "Linear",
    "NonSingletonFuzzifier",
    "PiShaped",
    "Rule",
    "SampledSet",
    "SampledType2Set",
    "Sigmoid",
    "SigmoidDifference",
    "SigmoidProduct",
    "Singleton",
    "SingletonFuzzifier",
    "Trapezoidal",
    "Triangular",
    "TwoSidedGaussian",
    "Type1Set",
    "Type1System",
    "WangMendel",
    "ZSlices",
    "add_noise",
    "alpha_plane_centroid",
    "alpha_plane_reduction",
    "approximate_centroid",
    "approximate_generalized_centroid",
    "begian_melek_mendel",
    "cardinality",
    "cartesian_product",
    "centroid",
    "complement",
    "compose",
    "defuzzify",
    "exhaustive_centroid",
    "exhaustive_generalized_centroid",
    "extend",
    "fine_tune",
    "format_rules",
    "from_json",
    "fuzziness",
    "fuzzy_c_means",
    "gaussian_meet",
    "gaussian_meet_error",
    "gaussian_partition",
    "generalized_centroid",
    "intersection",
    "jaccard",
    "join",
    "load",
    "mean_variation_from_snr",
    "meet",
    "negation",
    "nie_tan",
    "parse_rules",
    "rank",
    "save",
    "snr_from_mean_variation",
    "t_conorm",
    "t_norm",
    "to_json",
    "union",
    "wu_mendel_bounds",
]


def __getattr__(name: str) -> Any:
    # ``t_norm`` the function lives in ``t_norms`` the module, and so on: no name here is that of a module.
    if name in _HOMES:
        return getattr(importlib.import_module(f"fuzzy2.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'fuzzy2' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)

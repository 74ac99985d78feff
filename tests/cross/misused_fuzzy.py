"""Good arguments of everything that fuzzy2 offers; see tests.misuse."""

from __future__ import annotations

import copy
import functools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import fuzzy2
from fuzzy2 import learning, plots
from fuzzy2.errors import MalformedFile
from tests.misuse import Call, methods_of, parameters_of

ANYTHING = ("*",)
ANY_TEXT = ("text",)
POINTS = (
    "infinite",
    "infinite entry",
    "empty",
    "one entry too many",
    "one entry too few",
    "column",
)
"""What a function of single numbers takes as well: numbers of any shape, and the infinite ones."""
NOT_A_NUMBER = ("NaN", "NaN entry")
INFINITE = ("infinite", "infinite entry")
VANISHED = ("huge entries",)
"""So far out no rule fires, and the answer is NaN, as documented."""
SHAPES = ("one entry too many", "one entry too few", "column", "empty")
ROWS = ("column",)

OUTER = fuzzy2.Gaussian(0.5, 1.5)
INNER = fuzzy2.Trapezoidal(-1.0, 0.0, 1.0, 2.0, 0.5)
LOW, HIGH = fuzzy2.Gaussian(-1.0, 1.0), fuzzy2.Gaussian(1.0, 1.0)
UNCERTAIN = fuzzy2.GaussianUncertainMean((-0.5, 0.5), 1.0)
SAMPLED = fuzzy2.SampledSet([0.0, 0.5, 1.0], [0.2, 1.0, 0.4])
OTHER_SAMPLED = fuzzy2.SampledSet([0.1, 0.6, 0.9], [0.3, 1.0, 0.1])
BELOW, ABOVE = fuzzy2.SampledSet([0.2, 0.4], [1.0, 0.5]), fuzzy2.SampledSet([0.3, 0.9], [0.4, 1.0])


def bump(x: Any) -> Any:
    return np.maximum(0.0, 1.0 - np.abs(x))


def slice_at(x: float) -> Any:
    return fuzzy2.Triangular(0.0, 0.5 * float(np.exp(-(x * x))), 1.0)


SETS: dict[str, Any] = {
    "Bell": fuzzy2.Bell(0.0, 1.0, 2.0),
    "Complement": fuzzy2.Complement(fuzzy2.Sigmoid(0.0, 2.0)),
    "FunctionalSet": fuzzy2.FunctionalSet(bump, -1.0, 1.0, slope=bump),
    "FunctionalType2Set": fuzzy2.FunctionalType2Set(slice_at, -2.0, 2.0),
    "Gaussian": LOW,
    "GaussianType2Set": fuzzy2.GaussianType2Set(LOW, 0.1, (-3.0, 3.0)),
    "GaussianUncertainMean": UNCERTAIN,
    "GaussianUncertainSigma": fuzzy2.GaussianUncertainSigma(0.0, (0.5, 1.0)),
    "Interval": fuzzy2.Interval(-1.0, 1.0),
    "IntervalType2Set": fuzzy2.IntervalType2Set(
        fuzzy2.Gaussian(0.0, 0.5), fuzzy2.Gaussian(0.0, 1.0)
    ),
    "NamedShape": fuzzy2.NamedShape("cosine", (0.0, 2.0)),
    "PiShaped": fuzzy2.PiShaped(-1.0, 0.0, 1.0, 2.0),
    "SampledSet": fuzzy2.SampledSet([-1.0, 0.5, 2.0], [0.2, 1.0, 0.4]),
    "SampledType2Set": fuzzy2.SampledType2Set([0.0, 1.0], [BELOW, ABOVE]),
    "Sigmoid": fuzzy2.Sigmoid(0.0, 2.0),
    "SigmoidDifference": fuzzy2.SigmoidDifference((-1.0, 1.0), (2.0, 2.0)),
    "SigmoidProduct": fuzzy2.SigmoidProduct((-1.0, 1.0), (2.0, -3.0)),
    "Singleton": fuzzy2.Singleton(0.5),
    "Trapezoidal": fuzzy2.Trapezoidal(-1.0, 0.0, 1.0, 2.0),
    "Triangular": fuzzy2.Triangular(-1.0, 0.0, 1.0),
    "TwoSidedGaussian": fuzzy2.TwoSidedGaussian((-0.5, 0.5), (1.0, 2.0)),
    "ZSlices": fuzzy2.FunctionalType2Set(slice_at, -2.0, 2.0).zslices([0.5, 1.0]),
}

INPUTS = np.array([[0.1, -0.4], [0.7, 0.2], [-0.5, 0.9]])
RULES = [[0, 0], [0, 1], [1, 0], [1, 1]]
TERMS = [[LOW, HIGH], [LOW, HIGH]]
CLOUD_TERM = fuzzy2.Trapezoidal(0.0, 1.0, np.inf, np.inf)


@functools.cache
def general_system() -> Any:
    general = fuzzy2.GaussianType2Set(LOW, 0.1), fuzzy2.GaussianType2Set(HIGH, 0.1)
    return fuzzy2.GeneralType2System([list(general)] * 2, RULES, [[0.0], [1.0], [2.0], [4.0]])


@functools.cache
def systems() -> dict[str, Any]:
    blurred = fuzzy2.GaussianUncertainMean((0.5, 1.5), 1.0)
    ranges = [[-1.0, 1.0], [-1.0, 1.0]]
    type1 = fuzzy2.Type1System(TERMS, RULES, [[0.0], [1.0], [2.0], [4.0]], input_ranges=ranges)
    interval = fuzzy2.IntervalType2System(
        [[UNCERTAIN, blurred]] * 2, RULES, [[0.0], [1.0], [2.0], [4.0]]
    )
    firing = fuzzy2.Type1System([[CLOUD_TERM]] * 2, [[0, -1], [-1, 0]], [[1.0], [3.0]])
    clouds = fuzzy2.AnYaSystem([[0.0, 1.0], [2.0, 3.0]], [0, 1], firing)
    return {
        "Type1System": type1,
        "IntervalType2System": interval,
        "GeneralType2System": general_system(),
        "AnYaSystem": clouds,
        "ParallelSystem": fuzzy2.ParallelSystem([type1, type1.replace(output_names=["y2"])]),
    }


def samples() -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    X = np.random.default_rng(1).uniform(-1.0, 1.0, (30, 2))
    return X, X[:, 0] + X[:, 1] ** 2


@functools.cache
def learners() -> dict[str, Any]:
    X, y = samples()
    return {
        "ANFIS": fuzzy2.ANFIS(most_epochs=2).fit(X, y),
        "WangMendel": fuzzy2.WangMendel().fit(X, y),
        "FuzzyClassifier": fuzzy2.FuzzyClassifier(most_epochs=2, rng=np.random.default_rng(1)).fit(
            X, y > 0.5
        ),
    }


OF_SETS: dict[str, Any] = {
    "alpha": 0.6,
    "alphas": [0.5, 1.0],
    "axes": None,
    "choice": 0.3,
    "origin": 0.5,
    "power": 1,
    "secondary.x": 0.25,
    "u": [0.2, 0.4, 0.8],
    "upper_first": True,
    "x": [-0.5, 0.25, 1.5],
}
OF_SETS_TAKE: dict[str, Any] = {
    "alpha_cut.alpha": (*SHAPES, "tiny"),
    "alphas": SHAPES,
    "derivative.x": (*POINTS, *NOT_A_NUMBER),
    "footprint.x": (*POINTS, *NOT_A_NUMBER),
    "membership.x": (*POINTS, *NOT_A_NUMBER),
    "sample.x": SHAPES,
    "sample.u": SHAPES,
    "spread.x": (*POINTS, *NOT_A_NUMBER),
    "secondary_grade.u": ("infinite", "infinite entry", "column", *NOT_A_NUMBER),
    "secondary_grade.x": ("infinite", "infinite entry", "column", *NOT_A_NUMBER),
}
OF_SYSTEMS: dict[str, Any] = {
    "X": INPUTS,
    "axes": None,
    "count": 3,
    "domain": [[-1.0, 1.0], [-1.0, 1.0]],
    "points": 3,
    "rng": None,
    "threshold": 0.1,
    "x": INPUTS[0],
}
OF_LEARNERS: dict[str, Any] = {
    "X": INPUTS,
    "axes": None,
    "deep": True,
    "fit.X": samples()[0],
    "fit.y": samples()[1],
    "sample_weight": None,
    "x": INPUTS[0],
    "y": np.array([0.1, 0.7, -0.5]),
}
NOT_FOR_USERS = ("kernel_row", "log_firing", "one_row", "quadrature_points", "at", "said")
"""What only the packages ask one another; what they give it is checked before."""
REFUSE = ("Complement.moments", "NamedShape.derivative", "Sigmoid.moments")
"""Whatever the arguments are: shoulders have no area, and some shapes by name no derivative."""


def methods(
    kind: str, thing: Any, values: dict[str, Any], takes: dict[str, Any]
) -> Iterator[tuple[str, Call]]:
    """Yield the public methods of a thing, whose arguments are known by their names."""
    for name, _ in methods_of(type(thing)):
        function = getattr(thing, name)
        names = parameters_of(function)
        if name == "embedded_outputs":
            function = listing(function)
        if names and name not in NOT_FOR_USERS and f"{kind}.{name}" not in REFUSE:
            yield (
                f"{kind}.{name}",
                Call(
                    function,
                    {one: values.get(f"{name}.{one}", values.get(one)) for one in names},
                    {one: takes.get(f"{name}.{one}", takes.get(one, ())) for one in names},
                ),
            )


def listing(function: Any) -> Any:
    """Return a function that goes through all that a generator yields."""
    return lambda **given: list(function(**given))


def of_sets() -> Iterator[tuple[str, Call]]:
    """Yield how sets are made and what they answer."""
    for name, one in SETS.items():
        yield from methods(name, one, OF_SETS, OF_SETS_TAKE)
        names = parameters_of(type(one))
        takes: dict[str, Any] = {
            "domain": ("infinite entry",),
            "sigma": ("infinite entry",),
            "slope": ("None",),
        }
        if name in ("FunctionalSet", "FunctionalType2Set"):
            takes |= dict.fromkeys(("left", "right"), ("infinite",)) | {"knots": ("empty",)}
        yield (
            name,
            Call(
                type(one),
                {field: getattr(one, field) for field in names if hasattr(one, field)},
                takes,
            ),
        )


OF_CONSTRUCTORS_TAKE = {
    **dict.fromkeys(
        (
            "type_reduction",
            "implication",
            "weights",
            "silent",
            "input_names",
            "term_names",
            "consequent_names",
            "input_ranges",
            "output_ranges",
        ),
        ("None",),
    ),
    "rules": ("int64",),
    "hedges": ("empty", "mapping"),
    "default_outputs": ("None", "None entry", "NaN entry"),
    "output_names": ("None", "mapping"),
}


def of_systems() -> Iterator[tuple[str, Call]]:
    """Yield how systems are made and what they answer."""
    for name, one in systems().items():
        yield from methods(
            name, one, OF_SYSTEMS, {"X": ("column", *VANISHED), "x": VANISHED, "domain": ("None",)}
        )
        yield (
            f"{name}.__call__",
            Call(lambda X, system=one: system(X), {"X": INPUTS}, {"X": ("column", *VANISHED)}),
        )
    cases: dict[str, Any] = {
        "inputs": TERMS,
        "rules": RULES,
        "consequents": [[0.0], [1.0], [2.0], [4.0]],
        "t_norm": "product",
        "type_reduction": "center_of_sets",
        "method": "eiasc",
        "t_conorm": "max",
        "disjunction": "max",
        "implication": "min",
        "weights": [1.0, 0.5, 1.0, 0.8],
        "silent": [[False], [False], [False], [False]],
        "default_outputs": [0.5],
        "shares": (0.5, 0.5),
        "hedges": None,
        "integration": "exact",
        "fuzzifier": None,
        "input_names": ["a", "b"],
        "output_names": ["c"],
        "term_names": [["low", "high"]] * 2,
        "consequent_names": [["one"], ["two"], ["three"], ["four"]],
        "input_ranges": [[-1.0, 1.0]] * 2,
        "output_ranges": [[-1.0, 5.0]],
        "resolution": 51,
        "output_terms": None,
    }

    def called(kind: Any) -> Any:
        return lambda **given: kind(**given)([[0.3, -0.2]])

    for name, one in systems().items():
        if name.endswith("System") and name[:2] in ("Ty", "In", "Ge"):
            yield (
                name,
                Call(
                    called(type(one)),
                    {
                        **cases,
                        "inputs": one.inputs,
                        **(
                            {"reduction": "alpha_planes", "levels": 3, "grade_t_norm": "min"}
                            if name[0] == "G"
                            else {}
                        ),
                    },
                    OF_CONSTRUCTORS_TAKE,
                ),
            )
    clouds = systems()["AnYaSystem"]
    yield (
        "AnYaSystem",
        Call(
            fuzzy2.AnYaSystem,
            {
                "clouds": [[0.0, 1.0], [2.0, 3.0]],
                "asked": [0, 1],
                "consequents": clouds.consequents,
                "input_names": ["a", "b"],
            },
            {
                "clouds": ("ragged", "one entry too many", "one entry too few"),
                "input_names": ("None",),
            },
        ),
    )
    yield "ParallelSystem", Call(fuzzy2.ParallelSystem, {"systems": [systems()["Type1System"]]})
    yield (
        "Linear",
        Call(
            fuzzy2.Linear,
            {
                "coefficients": np.array([[[1.0, 2.0]], [[0.5, -1.0]]]),
                "spreads": np.array([[[0.1, 0.2]], [[0.0, 0.1]]]),
            },
            {"spreads": ("None",)},
        ),
    )
    yield (
        "Rule",
        Call(
            fuzzy2.Rule,
            {
                "antecedents": {"a": "low"},
                "consequents": {"c": "high"},
                "weight": 0.5,
                "otherwise": {"c": "low"},
            },
            {"otherwise": ("empty",)},
        ),
    )
    words = {"a": ["low", "high"]}, {"c": ["weak", "strong"]}
    yield (
        "parse_rules",
        Call(
            fuzzy2.parse_rules,
            {"rules": "IF a is low THEN c is weak", "inputs": words[0], "outputs": words[1]},
        ),
    )
    yield (
        "format_rules",
        Call(
            fuzzy2.format_rules,
            {
                "antecedents": [[0], [1]],
                "consequents": [[1], [0]],
                "inputs": words[0],
                "outputs": words[1],
            },
        ),
    )
    for name, fuzzifier in (
        ("SingletonFuzzifier", fuzzy2.SingletonFuzzifier()),
        ("NonSingletonFuzzifier", fuzzy2.NonSingletonFuzzifier(fuzzy2.Gaussian(0.0, 0.2))),
    ):
        given = {"term": LOW, "x": [-0.5, 0.25], "t_norm": "product"}
        yield f"{name}.firing", Call(fuzzifier.firing, given, {"x": (*SHAPES, *NOT_A_NUMBER)})
        general = {
            **given,
            "term": SETS["GaussianType2Set"],
            "alphas": [0.5, 1.0],
            "grade_t_norm": "min",
        }
        yield (
            f"{name}.firing_planes",
            Call(
                fuzzifier.firing_planes, general, {"x": (*SHAPES, *NOT_A_NUMBER), "alphas": SHAPES}
            ),
        )
    yield "NonSingletonFuzzifier", Call(fuzzy2.NonSingletonFuzzifier, {"shape": LOW})


def prediction(kind: Any, X_: Any, y_: Any, /, **given: Any) -> Any:
    """Return what a learner with options predicts."""
    return kind(**given).fit(X_, y_).predict(INPUTS)


def fitting(learner: Any, /, **given: Any) -> Any:
    """Return what a learner predicts that is taught."""
    return copy.deepcopy(learner).fit(**given).predict(INPUTS)


def of_learning() -> Iterator[tuple[str, Call]]:
    """Yield what learns, and what it has learned."""
    kinds = {
        "ANFIS": fuzzy2.ANFIS,
        "WangMendel": fuzzy2.WangMendel,
        "FuzzyClassifier": fuzzy2.FuzzyClassifier,
    }
    few = {"most_epochs": 2}
    X, y = samples()
    for name, one in learners().items():
        made = kinds[name]().get_params()
        if name != "WangMendel":
            made |= few
        if name == "FuzzyClassifier":
            y = y > 0.5

        fitted = functools.partial(prediction, kinds[name], X, y)
        yield (
            name,
            Call(
                fitted,
                made,
                {"rng": ("None",), "ridge": ("None", "column"), "output_terms": ("None",)},
            ),
        )
        for called, call in methods(
            name,
            one,
            {
                **OF_LEARNERS,
                **(
                    {"y": np.array([True, False, True]), "fit.y": y}
                    if name == "FuzzyClassifier"
                    else {}
                ),
            },
            {
                "X": ("column", *VANISHED),
                "x": VANISHED,
                "fit.y": ("column",),
                "score.y": ("column",),
                "deep": ANYTHING,
                "sample_weight": ("huge", "tiny", "true"),
            },
        ):
            if called.endswith(".fit"):
                call = call._replace(function=functools.partial(fitting, kinds[name](**made)))
            yield called, call
    X, y = samples()
    system = systems()["Type1System"]
    yield (
        "AdaptiveConsequents",
        Call(
            fuzzy2.AdaptiveConsequents,
            {"system": system, "forgetting": 0.99, "trust": 1.0, "bounds": ([-1.0], [5.0])},
            {"bounds": ("None", "column", "infinite entry")},
        ),
    )

    def update(**given: Any) -> Any:
        return fuzzy2.AdaptiveConsequents(system).update(**given)

    yield (
        "AdaptiveConsequents.update",
        Call(update, {"X": INPUTS, "y": np.array([[0.1], [0.5], [0.2]])}, {"X": VANISHED}),
    )
    yield (
        "fine_tune",
        Call(
            fuzzy2.fine_tune,
            {
                "system": system,
                "X": X,
                "y": y,
                "rng": np.random.default_rng(1),
                "learning_rate": 0.01,
                "most_epochs": 2,
                "patience": 1,
                "validation_share": 0.2,
            },
            {"y": ("column",)},
            reads=lambda found: None,
        ),
    )
    yield (
        "add_noise",
        Call(
            lambda signal, snr_db, rng=None: fuzzy2.add_noise(
                signal, snr_db, rng if rng is not None else np.random.default_rng(1)
            ),
            {"signal": [0.1, 0.5, -0.3], "snr_db": 10.0, "rng": None},
            {"signal": SHAPES, "snr_db": ("infinite",)},
        ),
    )
    yield (
        "mean_variation_from_snr",
        Call(fuzzy2.mean_variation_from_snr, {"snr_db": [10.0, 20.0]}, {"snr_db": POINTS}),
    )
    yield (
        "snr_from_mean_variation",
        Call(
            fuzzy2.snr_from_mean_variation,
            {"mean_variation": [0.1, 0.2]},
            {"mean_variation": SHAPES},
        ),
    )
    yield (
        "gaussian_partition",
        Call(
            fuzzy2.gaussian_partition,
            {"least": -1.0, "greatest": 1.0, "n_terms": 3, "kind": "it2", "mean_variation": 0.1},
        ),
    )
    yield "automf", Call(fuzzy2.automf, {"least": -1.0, "greatest": 1.0, "terms": 3})
    yield (
        "lagged",
        Call(
            fuzzy2.lagged,
            {"series": [1.0, 2.0, 3.0, 5.0, 8.0], "lags": [0, 2], "horizon": 1},
            {"series": ("column", "one entry too many", "one entry too few")},
        ),
    )
    yield "term_names", Call(learning.term_names, {"n_terms": 3})
    yield (
        "fuzzy_c_means",
        Call(
            fuzzy2.fuzzy_c_means,
            {
                "X": X,
                "n_clusters": 2,
                "fuzzifier": 2.0,
                "rng": None,
                "starts": 2,
                "sample_weight": None,
            },
        ),
    )
    yield (
        "subtractive_clustering",
        Call(
            fuzzy2.subtractive_clustering,
            {"X": X, "radius": 0.5, "squash": 1.5, "sample_weight": None},
            {"X": ("one entry too many", "one entry too few")},
        ),
    )
    clusters = fuzzy2.fuzzy_c_means(X, 2)
    yield "Clusters.membership", Call(clusters.membership, {"X": INPUTS})
    yield (
        "cluster_partition",
        Call(
            learning.cluster_partition,
            {"clusters": clusters, "widths": [0.5, 0.5], "kind": "it2", "mean_variation": 0.1},
        ),
    )


def of_numbers() -> Iterator[tuple[str, Call]]:
    """Yield fuzzy numbers, and reductions with them."""
    interval, bell = (
        fuzzy2.IntervalNumber([1.0, 2.0], [0.1, 0.2]),
        fuzzy2.GaussianNumber([1.0, 2.0], [0.1, 0.2]),
    )
    number = fuzzy2.FuzzyNumber([0.0, 1.0, 1.5], [4.0, 2.0, 1.6], [0.0, 0.5, 1.0])
    yield (
        "IntervalNumber",
        Call(
            fuzzy2.IntervalNumber,
            {"center": [1.0, 2.0], "spread": [0.1, 0.2]},
            {"center": (*POINTS, *NOT_A_NUMBER), "spread": (*POINTS, *NOT_A_NUMBER)},
        ),
    )
    yield (
        "IntervalNumber.from_ends",
        Call(
            fuzzy2.IntervalNumber.from_ends,
            {"ends": [[1.0, 2.0], [3.0, 4.0]]},
            {"ends": (*NOT_A_NUMBER, *INFINITE)},
        ),
    )
    yield (
        "GaussianNumber",
        Call(
            fuzzy2.GaussianNumber,
            {"mean": [1.0, 2.0], "sigma": [0.1, 0.2], "t_norm": "product"},
            {"mean": (*POINTS, *NOT_A_NUMBER), "sigma": (*POINTS, *NOT_A_NUMBER)},
        ),
    )
    yield (
        "FuzzyNumber",
        Call(
            fuzzy2.FuzzyNumber,
            {"left": [0.0, 1.0, 1.5], "right": [4.0, 2.0, 1.6], "levels": [0.0, 0.5, 1.0]},
            {"left": ("column",), "right": ("column",), "levels": ("None",)},
        ),
    )
    yield "FuzzyNumber.at_levels", Call(number.at_levels, {"levels": [0.0, 0.6, 1.0]}, {})
    yield (
        "FuzzyNumber.of",
        Call(
            fuzzy2.FuzzyNumber.of,
            {"value": 1.0, "levels": [0.0, 0.5, 1.0]},
            {"value": SHAPES, "levels": ("None",)},
        ),
    )
    for one in (interval, bell, number):
        name = type(one).__name__
        yield f"{name}.interval", Call(one.interval, {"alpha": 0.6})
        yield (
            f"{name}.membership",
            Call(one.membership, {"x": [0.5, 1.5]}, {"x": (*POINTS, *NOT_A_NUMBER)}),
        )
        if hasattr(one, "sum"):
            yield f"{name}.sum", Call(one.sum, {"axis": 0})
    yield (
        "gaussian_meet",
        Call(
            fuzzy2.gaussian_meet,
            {"means": [0.5, 0.6], "sigmas": [0.1, 0.05]},
            {"means": (*SHAPES, *NOT_A_NUMBER), "sigmas": (*SHAPES, *NOT_A_NUMBER)},
        ),
    )
    yield (
        "gaussian_meet_error",
        Call(
            fuzzy2.gaussian_meet_error,
            {"means": [0.5, 0.6], "sigmas": [0.1, 0.05], "points": 51},
            {"means": SHAPES, "sigmas": SHAPES},
        ),
    )
    yield (
        "approximate_centroid",
        Call(
            fuzzy2.approximate_centroid,
            {"x": [1.0, 2.0], "memberships": fuzzy2.IntervalNumber([0.5, 0.6], [0.01, 0.02])},
        ),
    )
    yield (
        "approximate_generalized_centroid",
        Call(
            fuzzy2.approximate_generalized_centroid,
            {
                "Z": [1.0, 2.0],
                "W": fuzzy2.GaussianNumber([0.5, 0.6], [0.01, 0.02]),
                "t_norm": "product",
            },
            {"t_norm": ("None",)},
        ),
    )


def of_reduction() -> Iterator[tuple[str, Call]]:
    """Yield type reduction and defuzzification."""
    z, w = np.array([1.0, 2.0, 3.0]), np.array([[0.1, 0.5], [0.2, 0.6], [0.1, 0.9]])
    both = {"z": z, "w": w}
    yield "generalized_centroid", Call(fuzzy2.generalized_centroid, {**both, "method": "eiasc"})
    yield (
        "centroid",
        Call(
            fuzzy2.centroid,
            {"x": z, "lower": w[:, 0], "upper": w[:, 1], "method": "eiasc"},
            {"lower": ("column",), "upper": ("column",)},
        ),
    )
    yield "nie_tan", Call(fuzzy2.nie_tan, both)
    yield "wu_mendel_bounds", Call(fuzzy2.wu_mendel_bounds, both)
    yield "begian_melek_mendel", Call(fuzzy2.begian_melek_mendel, {**both, "m": 0.5, "n": 0.5})
    yield (
        "alpha_plane_reduction",
        Call(
            fuzzy2.alpha_plane_reduction,
            {"alphas": [0.5, 1.0], "z": z, "w": np.stack([w, w]), "method": "eiasc"},
        ),
    )
    general = SETS["GaussianType2Set"]
    yield (
        "alpha_plane_centroid",
        Call(
            fuzzy2.alpha_plane_centroid,
            {"fuzzy_set": general, "x": [-1.0, 0.0, 1.0], "alphas": [0.5, 1.0], "method": "eiasc"},
            {"x": (*SHAPES, *VANISHED), "alphas": SHAPES},
        ),
    )
    small = fuzzy2.SampledType2Set([0.0, 1.0], [BELOW, ABOVE])
    yield (
        "exhaustive_centroid",
        Call(fuzzy2.exhaustive_centroid, {"fuzzy_set": small, "t_norm": "min", "limit": 1000}),
    )
    yield (
        "exhaustive_generalized_centroid",
        Call(
            fuzzy2.exhaustive_generalized_centroid,
            {"Z": [1.0, 2.0], "W": [BELOW, ABOVE], "t_norm": "min", "samples": None, "limit": 1000},
            {"samples": ("None",)},
        ),
    )
    yield "defuzzify", Call(fuzzy2.defuzzify, {"fuzzy_set": LOW, "method": "centroid"})


def of_operations() -> Iterator[tuple[str, Call]]:
    """Yield t-norms, operations on sets, relations and measures."""

    def of_two(function: Any) -> Any:
        return lambda first, second, **given: function(first, second, **given)

    two = {"first": LOW, "second": HIGH}
    secondary = {"first": SAMPLED, "second": OTHER_SAMPLED}
    x = [0.0, 0.4]

    def seen(fuzzy_set: Any) -> Any:
        return fuzzy_set(x)

    norm = {"t_norm": "min", "grade_t_norm": "min"}
    free = {"grade_t_norm": ("None",)}
    yield "union", Call(of_two(fuzzy2.union), {**two, **norm, "t_conorm": "max"}, free, reads=seen)
    yield "intersection", Call(of_two(fuzzy2.intersection), {**two, **norm}, free, reads=seen)
    yield "complement", Call(fuzzy2.complement, {"fuzzy_set": LOW}, reads=seen)
    yield (
        "join",
        Call(of_two(fuzzy2.join), {**secondary, **norm, "t_conorm": "max", "method": "auto"}, free),
    )
    yield "meet", Call(of_two(fuzzy2.meet), {**secondary, **norm, "method": "auto"}, free)
    yield "negation", Call(fuzzy2.negation, {"fuzzy_set": SAMPLED})
    yield (
        "extend",
        Call(
            lambda f, first, second, t_norm: fuzzy2.extend(f, first, second, t_norm=t_norm),
            {"f": np.add, "first": BELOW, "second": ABOVE, "t_norm": "min"},
        ),
    )
    yield "t_norm", Call(lambda name: fuzzy2.t_norm(name)(0.3, 0.6), {"name": "min"})
    yield "t_conorm", Call(lambda name: fuzzy2.t_conorm(name)(0.3, 0.6), {"name": "max"})
    relation = np.array([[0.1, 0.9], [0.4, 0.6]])
    yield (
        "compose",
        Call(
            fuzzy2.compose,
            {"R": relation, "S": relation, "t_norm": "min", "grade_t_norm": None},
            {"S": SHAPES},
            reads=np.asarray,
        ),
    )
    yield (
        "cartesian_product",
        Call(
            of_two(fuzzy2.cartesian_product),
            {"first": [0.1, 0.4], "second": [0.3, 0.9], "t_norm": "min", "grade_t_norm": None},
            {"first": SHAPES, "second": SHAPES},
            reads=np.asarray,
        ),
    )
    yield "cardinality", Call(fuzzy2.cardinality, {"fuzzy_set": UNCERTAIN})
    yield "fuzziness", Call(fuzzy2.fuzziness, {"fuzzy_set": UNCERTAIN})
    yield "jaccard", Call(fuzzy2.jaccard, {"first": UNCERTAIN, "second": UNCERTAIN})
    yield "rank", Call(fuzzy2.rank, {"sets": [UNCERTAIN, UNCERTAIN]})


def of_files(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield what reads and writes."""
    system = systems()["Type1System"]
    path = folder / "system.json"

    def read(path: Any) -> Any:
        """Read a system; that there is no such file is said by Python's own error."""
        if isinstance(path, str) and not Path(path).exists():
            raise MalformedFile(path, "everywhere", "there is no such file")
        return fuzzy2.load(path)(INPUTS)

    fuzzy2.save(system, path)
    yield "load", Call(read, {"path": path})
    yield "save", Call(fuzzy2.save, {"thing": system, "path": path}, {"path": ANY_TEXT})
    yield "to_json", Call(fuzzy2.to_json, {"thing": system})
    yield (
        "from_json",
        Call(
            lambda document: fuzzy2.from_json(document)(INPUTS),
            {"document": fuzzy2.to_json(system)},
        ),
    )
    yield (
        "export_c",
        Call(
            fuzzy2.export_c,
            {"system": system, "path": folder / "c", "precision": "double", "name": "system"},
            {"path": ANY_TEXT},
            reads=lambda found: None,
        ),
    )


OF_NO_MATTER = ("NaN entry", "infinite entry")
"""What is held of an input that varies."""


def of_figures() -> Iterator[tuple[str, Call]]:
    """Yield figures; what they draw is no number."""
    general, system = SETS["GaussianType2Set"], systems()["Type1System"]
    explanation = system.explain(INPUTS[0])
    reduced = fuzzy2.alpha_plane_centroid(general, [-1.0, 0.0, 1.0], [0.5, 1.0])
    arguments: dict[str, dict[str, Any]] = {
        **{f"figure_{number}": {} for number in range(1, 6)},
        "figure_from_above": {"fuzzy_set": general},
        "figure_in_space": {"fuzzy_set": general},
        "figure_of_inference": {"explanation": explanation, "output": 0},
        "figure_of_join_and_meet": {
            "F": fuzzy2.Triangular(0.1, 0.4, 0.8),
            "G": fuzzy2.Triangular(0.2, 0.6, 0.9),
            "t_norm": "min",
            "grade_t_norm": "min",
        },
        "figure_of_operations": {"first": LOW, "second": HIGH, "t_norm": "min"},
        "figure_of_response": {
            "system": system,
            "varied": 0,
            "output": 0,
            "held": [0.0, 0.5],
            "domain": (-1.0, 1.0),
        },
        "figure_of_rule_surface": {
            "system": system,
            "varied": (0, 1),
            "output": 0,
            "held": [0.0, 0.5],
            "domains": ((-1.0, 1.0), (-1.0, 1.0)),
        },
        "figure_of_secondaries": {"fuzzy_set": general, "x": [0.5, 1.0]},
        "figure_of_sets": {"sets": {"low": LOW}},
        "figure_of_type_reduced": {"reduced": {"it": reduced}},
        "view": {"thing": LOW},
    }
    for name, given in arguments.items():
        yield (
            name,
            Call(
                getattr(plots, name),
                {**given, "axes": None},
                {
                    "held": ("None", *(OF_NO_MATTER if "surface" in name else ())),
                    "domain": ("None",),
                    "grade_t_norm": ("None",),
                    "x": ("one entry too many", "one entry too few"),
                },
                reads=lambda panels: None,
            ),
        )


def rows(folder: Path) -> dict[str, Call]:
    """Return the table: what is public, with good arguments."""
    return dict(
        (
            *of_sets(),
            *of_systems(),
            *of_learning(),
            *of_numbers(),
            *of_reduction(),
            *of_operations(),
            *of_files(folder),
            *of_figures(),
        )
    )

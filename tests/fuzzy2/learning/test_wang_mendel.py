"""Table look-up learning.

Against a second implementation written with plain loops, and against scikit-learn's own checks.
"""

from __future__ import annotations

import itertools
import math
import pickle
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fuzzy2.errors import (
    FeatureNamesWarning,
    Fuzzy2Error,
    InvalidValue,
    NotFitted,
    NotNumbers,
    UnknownName,
    WrongFeatures,
)
from fuzzy2.learning import KINDS, WangMendel
from fuzzy2.learning.clustering import fuzzy_c_means
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System
from tests.fuzzy2.learning.plain_loops import (
    clouds,
    corners_and_more,
    loops_fire,
    loops_grade,
    loops_partition,
    loops_strict,
    loops_strongest,
)

# A second implementation: loops, sums in the order of the text, and no function of the module.


def loops_type1_output(
    x: np.ndarray, rules: dict[tuple[int, ...], np.ndarray], terms: list[list[tuple[float, float]]]
) -> np.ndarray:
    weights = {cell: loops_fire(x, cell, terms) for cell in rules}
    return sum(weights[cell] * rules[cell] for cell in rules) / sum(weights.values())


@pytest.mark.parametrize("learner", ["strongest", "strict"])
def test_type_1_prediction_is_that_of_plain_loops(learner: str) -> None:
    """Both average at most 9 numbers of order 1: 1e-12 is 1000 times their rounding."""
    X, Y = corners_and_more()
    model = WangMendel(n_terms=3, kind="t1", learner=learner, completion="none").fit(X, Y)
    rules = (
        loops_strongest(X, Y, [3, 3], False)
        if learner == "strongest"
        else loops_strict(X, Y, [3, 3], None)
    )
    terms = [loops_partition(X[:, i], 3) for i in range(2)]
    points = np.random.default_rng(5).uniform(-2.0, 4.0, (30, 2))
    expected = [loops_type1_output(x, rules, terms) for x in points]
    np.testing.assert_allclose(model.predict(points), expected, rtol=0.0, atol=1e-12)


def test_samples_at_the_centers_of_cells_are_reproduced_as_far_as_the_neighbors_let_them() -> None:
    r"""At a corner the other cells fire with 1/16 and 1/256, by hand.

    :math:`\exp(-d^2/2\sigma^2) = 2^{-4}`. 1e-12 is rounding.
    """
    X, Y = (
        np.array([[0.0, 0.0], [0.0, 2.0], [5.0, 0.0], [5.0, 2.0]]),
        np.array([1.0, -4.0, 9.0, 2.0]),
    )
    model = WangMendel(kind="t1").fit(X, Y)
    np.testing.assert_array_equal(model.system_.consequents[:, 0], Y)
    weights = np.array([1.0, 1.0 / 16.0, 1.0 / 16.0, 1.0 / 256.0])
    assert model.predict(X[:1])[0] == pytest.approx(weights @ Y / weights.sum(), abs=1e-12)
    # A single rule per axis that nothing else comes near: with 40 cells between, the neighbors'
    # share is 16**-(39**2).
    far = WangMendel(kind="t1", n_terms=40, learner="strict", completion="none").fit(
        [[0.0], [1.0]], [3.0, 7.0]
    )
    np.testing.assert_array_equal(far.predict([[0.0], [1.0]]), [3.0, 7.0])


@pytest.mark.parametrize("learner", ["strongest", "strict", "average", "ridge"])
@pytest.mark.parametrize("output_terms", [None, 4])
@pytest.mark.parametrize("t_norm", ["product", "min"])
def test_without_mean_variation_all_kinds_are_the_type_1_system(
    learner: str, output_terms: int | None, t_norm: str
) -> None:
    """1e-12 relative to the outputs' size is what is asked for."""
    X, Y = corners_and_more()
    options: dict[str, Any] = {
        "n_terms": 3,
        "mean_variation": 0.0,
        "learner": learner,
        "output_terms": output_terms,
        "t_norm": t_norm,
    }
    points = np.random.default_rng(1).uniform(-3.0, 5.0, (50, 2))
    first, *others = (WangMendel(kind=kind, **options).fit(X, Y) for kind in ("t1", "it2", "gt2"))
    expected = first.predict(points)
    for other in others:
        np.testing.assert_allclose(
            other.predict(points), expected, rtol=0.0, atol=1e-12 * np.abs(Y).max()
        )
        interval = other.predict_interval(points)
        np.testing.assert_allclose(
            interval[..., 0], interval[..., 1], rtol=0.0, atol=1e-12 * np.abs(Y).max()
        )


def test_kinds_differ_in_their_uncertainty_only() -> None:
    X, Y = corners_and_more()
    systems = [
        WangMendel(n_terms=3, kind=kind, mean_variation=0.3).fit(X, Y).system_ for kind in KINDS
    ]
    assert [type(system) for system in systems] == [
        Type1System,
        IntervalType2System,
        GeneralType2System,
    ]
    for system in systems[1:]:
        np.testing.assert_array_equal(system.rules, systems[0].rules)
        np.testing.assert_array_equal(system.consequents, systems[0].consequents)


# Clusters as the first step


@pytest.mark.parametrize("learner", ["strongest", "average", "ridge"])
def test_rules_of_clusters_are_those_of_plain_loops(learner: str) -> None:
    """The terms are the clusters' centers and spreads in shares of the ranges, put back into units.

    1e-10 for the condition of ridge.
    """
    X, Y = clouds()
    model = WangMendel(4, "t1", learner=learner, partition="clusters").fit(X, Y)
    least, widths = X.min(axis=0), np.ptp(X, axis=0)
    clusters = fuzzy_c_means((X - least) / widths, 4)
    np.testing.assert_array_equal(model.clusters_.memberships, clusters.memberships)
    centers, sigmas = least + widths * clusters.centers, widths * clusters.spreads
    firing = np.array(
        [
            [
                math.prod(loops_grade(x[i], (centers[k, i], sigmas[k, i])) for i in range(2))
                for k in range(4)
            ]
            for x in X
        ]
    )
    average = np.array([(firing[:, [k]] * Y).sum(axis=0) / firing[:, k].sum() for k in range(4)])
    if learner == "strongest":
        expected = np.array([Y[firing[:, k].argmax()] for k in range(4)])
    elif learner == "average":
        expected = average
    else:
        shares = firing / firing.sum(axis=1, keepdims=True)
        rows = np.concatenate([shares / 10.0, math.sqrt(1e-3) * np.eye(4)])
        expected = np.linalg.lstsq(
            rows, np.concatenate([Y / 10.0, math.sqrt(1e-3) * average]), rcond=None
        )[0]
    np.testing.assert_allclose(model.system_.consequents, expected, rtol=1e-10, atol=1e-10)
    for i, terms in enumerate(model.system_.inputs):
        means = [term.mean for term in terms]
        assert means == sorted(means)
        for k, asked in enumerate(model.system_.rules[:, i]):
            assert terms[asked].mean == pytest.approx(centers[k, i], rel=1e-12)
            assert terms[asked].sigma == pytest.approx(sigmas[k, i], rel=1e-12)
    points = np.array([[0.5, 1500.0], [2.5, 1200.0]])
    weights = [
        [
            math.prod(loops_grade(x[i], (centers[k, i], sigmas[k, i])) for i in range(2))
            for k in range(4)
        ]
        for x in points
    ]
    outputs = [np.array(w) @ expected / sum(w) for w in weights]
    np.testing.assert_allclose(model.predict(points), outputs, rtol=1e-9, atol=1e-9)


def test_kinds_of_clustered_systems_differ_in_their_uncertainty_only() -> None:
    """Means reach as far as in a partition of the range, to both sides.

    Without that all are the type-1 system, up to rounding.
    """
    X, Y = clouds()
    models = {kind: WangMendel(4, kind, 0.2, partition="clusters").fit(X, Y) for kind in KINDS}
    systems = {kind: model.system_ for kind, model in models.items()}
    for system in systems.values():
        np.testing.assert_array_equal(system.rules, systems["t1"].rules)
        np.testing.assert_array_equal(system.consequents, systems["t1"].consequents)
    for i, width in enumerate(np.ptp(X, axis=0)):
        for first, second, third in zip(*(systems[kind].inputs[i] for kind in KINDS), strict=True):
            assert second.sigma == first.sigma
            assert second.mean == pytest.approx(
                (first.mean - 0.2 * width, first.mean + 0.2 * width), rel=1e-12
            )
            assert third.principal == first
            assert third.sigma == pytest.approx(
                0.2 * width * math.exp(-0.5) / math.sqrt(3.0) / first.sigma, rel=1e-12
            )
    expected = models["t1"].predict(X)
    for kind in ("it2", "gt2"):
        np.testing.assert_allclose(
            WangMendel(4, kind, 0.0, partition="clusters").fit(X, Y).predict(X),
            expected,
            atol=1e-12,
        )


def test_clusters_need_as_many_rules_for_many_inputs_as_for_few() -> None:
    """Ten inputs that all follow one hidden variable: the grid would have 3**10 rules.

    R² is 0.98 with 6; 0.9 leaves room for seeds.
    """
    rng = np.random.default_rng(0)
    hidden = rng.uniform(-1.0, 1.0, 300)
    X = np.stack([np.sin(k + hidden) for k in range(10)], axis=1) + 0.01 * rng.normal(
        size=(300, 10)
    )
    model = WangMendel(6, "it2", 0.02, "average", partition="clusters").fit(X[:200], hidden[:200])
    assert len(model.system_.rules) == 6
    assert model.score(X[200:], hidden[200:]) > 0.9
    assert not hasattr(model.set_params(partition="grid", n_terms=1).fit(X, hidden), "clusters_")


def test_starts_of_clusters_are_the_caller_s() -> None:
    X, Y = corners_and_more()
    options: dict[str, Any] = {"n_terms": 9, "partition": "clusters"}
    np.testing.assert_array_equal(
        WangMendel(**options).fit(X, Y).predict(X), WangMendel(**options).fit(X, Y).predict(X)
    )
    rng = np.random.default_rng(0)
    model = WangMendel(**options, rng=rng)
    np.testing.assert_array_equal(
        model.fit(X, Y).predict(X), WangMendel(**options).fit(X, Y).predict(X)
    )
    assert rng.bit_generator.state != np.random.default_rng(0).bit_generator.state


# Output terms and completion


@pytest.mark.parametrize("kind", KINDS)
def test_output_terms_enter_by_their_centroids(kind: str) -> None:
    X, Y = corners_and_more(outputs=2)
    model = WangMendel(kind=kind, output_terms=5, mean_variation=0.05).fit(X, Y)
    values = Y[model.rule_samples_[:, 0]]
    for r, j in itertools.product(range(4), range(2)):
        terms = model.output_terms_[j]
        grades = [loops_grade(values[r, j], term) for term in loops_partition(Y[:, j], 5)]
        assert model.output_rules_[r, j] == int(np.argmax(grades))
        chosen = terms[model.output_rules_[r, j]]
        assert not isinstance(chosen, GaussianType2Set)
        # The mean and the middle of the means are the same up to rounding; quadrature is good to
        # 1e-12 of the range.
        np.testing.assert_allclose(
            model.system_.consequents[r, j], np.broadcast_to(chosen.centroid(), 2), atol=1e-11
        )
    width = np.ptp(model.system_.consequents, axis=-1)
    assert (width == 0.0).all() if kind == "t1" else (width > 0.0).all()


# scikit-learn's conventions

NOT_APPLICABLE = {
    "check_sample_weight_equivalence_on_dense_data": (
        "has 30 inputs, for which no grid can be filled; weights are repetitions is tested below"
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"kind": "t1", "learner": "strict"},
        {"kind": "gt2", "output_terms": 5},
        {"partition": "clusters", "learner": "average"},
    ],
    ids=str,
)
@pytest.mark.filterwarnings("ignore:Estimator WangMendel does not inherit:UserWarning")
@pytest.mark.filterwarnings("ignore::fuzzy2.errors.CompletedRules")
def test_scikit_learn_finds_nothing_to_complain_about(options: dict[str, Any]) -> None:
    checks = pytest.importorskip("sklearn.utils.estimator_checks")
    results = checks.check_estimator(
        WangMendel(**options), expected_failed_checks=NOT_APPLICABLE, on_fail=None, on_skip=None
    )
    failed = {
        result["check_name"]: result["exception"]
        for result in results
        if result["status"] == "failed"
    }
    assert not failed
    assert sum(result["status"] == "passed" for result in results) >= 55


@pytest.mark.filterwarnings("ignore::fuzzy2.errors.CompletedRules")
@pytest.mark.parametrize(
    "options",
    [{"learner": name} for name in ("strongest", "strict", "average", "ridge")]
    + [{"partition": "clusters", "n_terms": 4, "learner": "average"}],
    ids=str,
)
def test_weights_are_repetitions(options: dict[str, Any]) -> None:
    """1e-9 for the clusters, which stop where memberships change by less."""
    X, Y = corners_and_more()
    weights = np.random.default_rng(2).integers(0, 4, len(X))
    weighted = WangMendel(**options).fit(X, Y, sample_weight=weights)
    many_X, many_Y = np.repeat(X, weights, axis=0), np.repeat(Y, weights, axis=0)
    repeated = WangMendel(**options).fit(many_X, many_Y)
    scale = np.abs(Y).max()
    np.testing.assert_allclose(
        weighted.predict(X), repeated.predict(X), rtol=0.0, atol=1e-9 * scale
    )
    assert weighted.score(X, Y, weights) == pytest.approx(weighted.score(many_X, many_Y), rel=1e-9)
    for bad in (np.zeros(len(X)), -np.ones(len(X)), np.ones(3)):
        with pytest.raises(InvalidValue, match="sample_weight"):
            WangMendel(**options).fit(X, Y, sample_weight=bad)


def test_scikit_learn_can_search_and_clone() -> None:
    selection = pytest.importorskip("sklearn.model_selection")
    base = pytest.importorskip("sklearn.base")
    X, Y = corners_and_more(count=120)
    model = base.clone(WangMendel(n_terms=3, learner="average"))
    assert model.get_params()["n_terms"] == 3
    search = selection.GridSearchCV(
        model, {"learner": ["average", "ridge"], "mean_variation": [0.0, 0.1]}, cv=3
    ).fit(X, Y)
    assert set(search.best_params_) == {"learner", "mean_variation"}


def test_score_is_that_of_scikit_learn() -> None:
    metrics = pytest.importorskip("sklearn.metrics")
    X, Y = corners_and_more()
    model = WangMendel(learner="ridge").fit(X, Y)
    assert model.score(X, Y) == pytest.approx(metrics.r2_score(Y, model.predict(X)), rel=1e-12)
    constant = np.concatenate([Y, np.ones((len(Y), 1))], axis=1)
    model.fit(X, constant)
    assert model.score(X, constant) == pytest.approx(
        metrics.r2_score(constant, model.predict(X)), rel=1e-12
    )


@pytest.mark.slow
def test_nothing_is_imported_from_scikit_learn() -> None:
    """In its own process: learning, predicting and asking too early do not load scikit-learn."""
    script = (
        "import sys; from fuzzy2.learning import WangMendel\n"
        "try: WangMendel().predict([[1.0]])\n"
        "except AttributeError as error: assert 'call fit' in str(error)\n"
        "print(WangMendel(kind='t1').fit([[0.0], [1.0]], [0.0, 1.0]).predict([[0.5]])[0], "
        "'sklearn' in sys.modules)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert result.stdout.split() == ["0.5", "False"]


def test_asking_too_early_is_also_scikit_learns_error_where_that_is_loaded() -> None:
    exceptions = pytest.importorskip("sklearn.exceptions")
    with pytest.raises(exceptions.NotFittedError) as caught:
        WangMendel().predict([[1.0]])
    assert isinstance(caught.value, NotFitted)
    assert isinstance(pickle.loads(pickle.dumps(caught.value)), NotFitted)


def test_asking_too_early_without_scikit_learn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "sklearn.exceptions", raising=False)
    with pytest.raises(NotFitted, match="call fit first") as caught:
        WangMendel().score([[1.0]], [1.0])
    assert type(caught.value) is NotFitted


def test_parameters_by_name() -> None:
    model = WangMendel()
    assert model.set_params(n_terms=4, kind="t1") is model
    assert model.get_params()["n_terms"] == 4
    assert repr(model) == "WangMendel(kind='t1', n_terms=4)"
    assert repr(WangMendel()) == "WangMendel()"
    with pytest.raises(UnknownName, match="mean_variation"):
        model.set_params(terms=3, learner="ridge")
    assert model.learner == "strongest"


def test_outputs_keep_their_dimensions() -> None:
    X, Y = corners_and_more(outputs=2)
    many, one, column = (WangMendel().fit(X, y) for y in (Y, Y[:, 0], Y[:, :1]))
    n = len(X)
    assert (many.predict(X).shape, one.predict(X).shape, column.predict(X).shape) == (
        (n, 2),
        (n,),
        (n, 1),
    )
    assert (many.predict_interval(X).shape, one.predict_interval(X).shape) == ((n, 2, 2), (n, 2))
    # Many outputs over one rule base are as many models; the compiled loop treats them alike, to
    # the last digit.
    np.testing.assert_allclose(many.predict(X)[:, 0], one.predict(X), rtol=0.0, atol=1e-14)
    assert one.score(X, Y[:, 0]) == pytest.approx(column.score(X, Y[:, :1]), rel=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_intervals_hold_the_prediction(kind: str) -> None:
    X, Y = corners_and_more()
    model = WangMendel(kind=kind).fit(X, Y)
    left, right = np.moveaxis(model.predict_interval(X), -1, 0)
    middle = model.predict(X)
    assert (left <= middle + 1e-12).all()
    assert (middle <= right + 1e-12).all()


@pytest.mark.filterwarnings("ignore::fuzzy2.errors.ApproximationWarning")
def test_gaussian_reduction_gives_two_standard_deviations() -> None:
    X, Y = corners_and_more()
    model = WangMendel(kind="gt2", reduction="gaussian").fit(X, Y)
    mean, sigma = np.moveaxis(model.system_.type_reduced(X), -1, 0)
    np.testing.assert_allclose(
        model.predict_interval(X),
        np.stack([mean - 2.0 * sigma, mean + 2.0 * sigma], axis=-1),
        rtol=1e-12,
    )
    # By the corollary the crisp output is that of type 1, whatever the uncertainty; 1e-12 is
    # rounding.
    np.testing.assert_allclose(
        model.predict(X), WangMendel(kind="t1").fit(X, Y).predict(X), rtol=0.0, atol=1e-12
    )


class Table:
    """What a data frame shows of itself here."""

    def __init__(self, values: np.ndarray, columns: list[Any]) -> None:
        self.values, self.columns = values, columns

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.values, dtype=dtype)


def test_names_of_columns_name_the_system_and_are_checked() -> None:
    X, Y = corners_and_more(outputs=2)
    model = WangMendel().fit(Table(X, ["speed", "height"]), Table(Y, ["force", "torque"]))
    assert model.system_.input_names == ("speed", "height")
    assert model.system_.output_names == ("force", "torque")
    assert list(model.feature_names_in_) == ["speed", "height"]
    np.testing.assert_array_equal(model.predict(Table(X, ["speed", "height"])), model.system_(X))
    with pytest.raises(WrongFeatures, match="same order"):
        model.predict(Table(X, ["height", "speed"]))
    with pytest.raises(
        WrongFeatures, match=r"(?s)unseen at fit time:\n- width.*now missing:\n- height"
    ):
        model.predict(Table(X, ["speed", "width"]))
    with pytest.warns(FeatureNamesWarning, match="was fitted with feature names"):
        model.predict(X)
    assert not hasattr(model.fit(Table(X, [0, 1]), Y), "feature_names_in_")
    with pytest.warns(FeatureNamesWarning, match="fitted without") as caught:
        model.predict(Table(X, ["speed", "height"]))
    again = pickle.loads(pickle.dumps(caught[0].message))
    assert str(again) == str(caught[0].message)


def test_pickled_models_predict_the_same() -> None:
    X, Y = corners_and_more()
    for kind in KINDS:
        model = WangMendel(kind=kind).fit(X, Y)
        np.testing.assert_array_equal(
            pickle.loads(pickle.dumps(model)).predict(X), model.predict(X)
        )


def test_learning_again_forgets_what_was_learned_before() -> None:
    X, Y = corners_and_more()
    model = WangMendel(output_terms=3).fit(X, Y)
    model.set_params(output_terms=None, learner="average").fit(X, Y)
    assert not hasattr(model, "output_terms_")
    assert not hasattr(model, "rule_samples_")


# What is refused


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"kind": "it3"}, UnknownName, "t1, it2, gt2"),
        ({"learner": "weakest"}, UnknownName, "strongest"),
        ({"completion": "some"}, UnknownName, "nearest"),
        ({"t_norm": "lukasiewicz"}, UnknownName, "product"),
        ({"kind": "gt2", "reduction": "some"}, UnknownName, "alpha_planes"),
        ({"n_terms": 0}, InvalidValue, "n_terms"),
        ({"n_terms": 2.0}, InvalidValue, "n_terms"),
        ({"n_terms": [2, 2, 2]}, InvalidValue, "each of the 2 inputs"),
        ({"n_terms": 2000}, InvalidValue, "4,000,000"),
        ({"n_terms": 100, "learner": "ridge"}, InvalidValue, "10,000"),
        ({"mean_variation": -0.1}, InvalidValue, "mean_variation"),
        ({"mean_variation": math.nan}, InvalidValue, "mean_variation"),
        ({"ridge": 0.0}, InvalidValue, "ridge"),
        ({"output_terms": 1}, InvalidValue, "output_terms"),
    ],
)
def test_parameters_that_cannot_be_meant_are_refused_by_fit(
    options: dict[str, Any], error: type[Fuzzy2Error], words: str
) -> None:
    X, Y = corners_and_more()
    with pytest.raises(error, match=words):
        WangMendel(**options).fit(X, Y)


def test_large_grids_can_be_left_empty() -> None:
    X, Y = corners_and_more(count=10)
    model = WangMendel(n_terms=2000, learner="strict", completion="none").fit(X, Y)
    assert len(model.system_.rules) == len(X)


def changed(array: np.ndarray, index: Any, value: float) -> np.ndarray:
    copy = array.copy()
    copy[index] = value
    return copy


@pytest.mark.parametrize(
    ("spoil", "error", "words"),
    [
        (lambda X, Y: (changed(X, (3, 1), math.nan), Y), InvalidValue, r"X\[3, 1\].*NaN"),
        (lambda X, Y: (X, changed(Y, (4, 0), math.inf)), InvalidValue, r"y\[4, 0\]"),
        (lambda X, Y: (changed(X, (slice(None), 1), 7.0), Y), InvalidValue, "input x2"),
        (lambda X, Y: (X[:1], Y[:1]), InvalidValue, "at least 2 samples"),
        (lambda X, Y: (X[:0], Y[:0]), InvalidValue, "0 sample"),
        (lambda X, Y: (X[:, :0], Y), InvalidValue, "0 feature"),
        (lambda X, Y: (X[:, 0], Y), InvalidValue, "Reshape your data"),
        (lambda X, Y: (X, Y[:-1]), InvalidValue, "one for each sample"),
        (lambda X, Y: (X, None), InvalidValue, "y"),
        (lambda X, Y: (X + 1j, Y), InvalidValue, "Complex"),
        (lambda X, Y: (np.array([["a", "b"]] * len(X)), Y), InvalidValue, "numbers"),
        (lambda X, Y: (np.array([[{}, 1.0]] * len(X)), Y), NotNumbers, "argument must be"),
    ],
)
def test_samples_that_cannot_be_learned_from_are_refused(
    spoil: Callable[[np.ndarray, np.ndarray], tuple[Any, Any]], error: type[Fuzzy2Error], words: str
) -> None:
    with pytest.raises(error, match=words):
        WangMendel().fit(*spoil(*corners_and_more()))


def test_sparse_matrices_are_refused() -> None:
    sparse = pytest.importorskip("scipy.sparse")
    X, Y = corners_and_more()
    with pytest.raises(NotNumbers, match="toarray"):
        WangMendel().fit(sparse.csr_array(X), Y)


def test_an_output_without_a_range_has_no_terms_but_can_be_learned() -> None:
    X, Y = corners_and_more()
    Y[:, 1] = 5.0
    with pytest.raises(InvalidValue, match="output y2"):
        WangMendel(output_terms=3).fit(X, Y)
    # A weighted average of one number is that number, up to rounding.
    np.testing.assert_allclose(WangMendel().fit(X, Y).predict(X)[:, 1], 5.0, rtol=1e-14)


def test_inputs_unlike_those_learned_from_are_refused() -> None:
    X, Y = corners_and_more()
    model = WangMendel().fit(X, Y)
    with pytest.raises(WrongFeatures, match="X has 1 features, but WangMendel is expecting 2"):
        model.predict(X[:, :1])
    with pytest.raises(InvalidValue, match="NaN"):
        model.predict(changed(X, (0, 0), math.nan))
    with pytest.raises(InvalidValue, match="3 outputs"):
        model.score(X, Y[:, :2])


@pytest.mark.parametrize("t_norm", ["product", "min"])
def test_far_from_all_samples_the_nearest_rule_predicts(t_norm: str) -> None:
    """Forty standard deviations off a Gaussian is exp(-800), which is zero as a float."""
    X, Y = corners_and_more()
    model = WangMendel(t_norm=t_norm).fit(X, Y)
    far = X.max(axis=0) + 1e4 * np.ptp(X, axis=0)
    assert not model.system_.firing(far).any()
    corner = int(model.system_.rules.sum(axis=1).argmax())  # the greatest terms of both inputs
    expected = model.system_.consequent_intervals[corner].mean(axis=-1)
    np.testing.assert_allclose(model.predict([far])[0], expected, rtol=1e-12)
    beyond = np.full((1, 2), 1e200)  # the square of the distance is no float
    assert np.isnan(model.predict(beyond)).all()
    assert np.isnan(model.predict_interval(beyond)).all()
    assert math.isnan(model.score(np.concatenate([X, beyond]), np.concatenate([Y, Y[:1]])))

"""Partitions of inputs and outputs into terms: even ones, and those of clusters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from fuzzy2.errors import (
    Fuzzy2Error,
    InvalidValue,
    UnknownName,
)
from fuzzy2.learning import KINDS, WangMendel, cluster_partition, gaussian_partition, term_names
from fuzzy2.learning.clustering import fuzzy_c_means
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.sets.shapes import Gaussian
from tests.fuzzy2.learning.plain_loops import (
    clouds,
    corners_and_more,
)


@pytest.mark.parametrize("kind", KINDS)
def test_partition_is_what_its_equations_say(kind: str) -> None:
    low, high, count, variation = -3.0, 7.0, 5, 0.3
    terms = gaussian_partition(low, high, count, kind, variation)
    principal = [term.principal if kind == "gt2" else term for term in terms]
    middles = np.array([np.mean(term.mean) for term in principal])
    np.testing.assert_allclose(middles, [-3.0, -0.5, 2.0, 4.5, 7.0], atol=1e-15)
    crossings = 0.5 * (middles[1:] + middles[:-1])
    for left, right, at in zip(principal, principal[1:], crossings, strict=False):
        # The definition: neighbors cross at 1/2.
        assert Gaussian(np.mean(left.mean), left.sigma)(at) == pytest.approx(0.5, rel=1e-14)
        assert Gaussian(np.mean(right.mean), right.sigma)(at) == pytest.approx(0.5, rel=1e-14)
    for term in terms:
        if isinstance(term, GaussianUncertainMean):
            assert term.mean[1] - term.mean[0] == pytest.approx(2.0 * 0.3 * 10.0, rel=1e-14)


def test_secondary_grades_are_what_a_mean_spread_over_the_interval_does() -> None:
    """By experiment: membership one sigma from the mean.

    For means spread evenly over a small interval; second order in that.
    """
    variation = 0.002
    term = gaussian_partition(0.0, 1.0, 2, "gt2", variation)[1]
    assert isinstance(term, GaussianType2Set)
    assert isinstance(term.principal, Gaussian)
    sigma = term.principal.sigma
    means = 1.0 + np.linspace(-variation, variation, 200_001)
    memberships = np.exp(-((1.0 + sigma - means) ** 2) / (2.0 * sigma**2))
    assert term.sigma == pytest.approx(memberships.std(), rel=1e-4)


def test_one_term_covers_its_range_from_one_half_to_one_half() -> None:
    (term,) = gaussian_partition(2.0, 6.0, 1, "t1")
    np.testing.assert_allclose(term([2.0, 4.0, 6.0]), [0.5, 1.0, 0.5], rtol=1e-14)


def test_names_of_terms() -> None:
    assert term_names(2) == ("Low", "High")
    assert term_names(3) == ("Low", "Mid", "High")
    assert len(set(term_names(7))) == 7


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"partition": "trees"}, UnknownName, "grid, clusters"),
        ({"partition": "clusters", "learner": "strict"}, InvalidValue, "every rule is a cluster's"),
        ({"partition": "clusters", "n_terms": [2, 2]}, InvalidValue, "n_terms"),
        ({"partition": "clusters", "n_terms": 65}, InvalidValue, "at most 64"),
        (
            {"partition": "clusters", "n_terms": 64},
            InvalidValue,
            "has none along input 1: take fewer clusters",
        ),
        ({"partition": "clusters", "fuzzifier": 1.0}, InvalidValue, "fuzzifier"),
        ({"partition": "clusters", "rng": 0}, InvalidValue, "rng"),
        ({"partition": "clusters", "n_terms": 20_000, "learner": "ridge"}, InvalidValue, "20,000"),
    ],
)
def test_what_makes_no_clusters_is_refused(
    options: dict[str, Any], error: type[Fuzzy2Error], words: str
) -> None:
    X, Y = corners_and_more()
    with pytest.raises(error, match=words):
        WangMendel(**options).fit(X, Y)


@pytest.mark.parametrize(
    "arguments", [([1.0],), ([1.0, 0.0],), ([1.0, math.inf],), ([1.0, 1.0], "it2", -0.1)]
)
def test_cluster_partitions_of_nothing_are_refused(arguments: tuple[Any, ...]) -> None:
    with pytest.raises(InvalidValue):
        cluster_partition(fuzzy_c_means(clouds()[0], 3), *arguments)
    with pytest.raises(UnknownName, match="t1, it2, gt2"):
        cluster_partition(fuzzy_c_means(clouds()[0], 3), [1.0, 1.0], "it3")


@pytest.mark.parametrize(
    "arguments",
    [(1.0, 1.0), (2.0, 1.0), (0.0, math.nan), (0.0, 1.0, 0), (0.0, 1.0, 2, "it2", -0.1)],
)
def test_partitions_of_nothing_are_refused(arguments: tuple[Any, ...]) -> None:
    with pytest.raises(InvalidValue):
        gaussian_partition(*arguments)


def test_unknown_kind_of_partition_lists_the_known_ones() -> None:
    with pytest.raises(UnknownName, match="t1, it2, gt2"):
        gaussian_partition(0.0, 1.0, 2, "it3")

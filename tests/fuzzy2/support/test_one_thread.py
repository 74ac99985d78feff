"""Linear algebra on one thread: within, and no longer."""

from __future__ import annotations

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from fuzzy2 import ANFIS
from fuzzy2.support.one_thread import one_thread


def threads() -> set[int]:
    assert np.linalg.svd(np.eye(2))
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def test_there_is_one_thread_within_and_what_was_before_after() -> None:
    with threadpool_limits(2, user_api="blas"):
        assert threads() == {2}
        with one_thread():
            assert threads() == {1}
        assert threads() == {2}


@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_rules_do_not_depend_on_the_number_of_threads(kind: str) -> None:
    rng = np.random.default_rng(1)
    X = rng.uniform(-1.0, 1.0, (300, 3))
    y = np.sin(X.sum(axis=1)) + X[:, 0] ** 2
    said = []
    for number in (1, 2):
        with threadpool_limits(number, user_api="blas"):
            said.append(ANFIS(2, kind, most_epochs=5).fit(X, y).system_(X))
    np.testing.assert_array_equal(*said)

"""Time series as samples."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.time_series import lagged


def test_rows_are_those_of_a_plain_loop() -> None:
    series = np.random.default_rng(0).normal(size=40)
    X, y = lagged(series, [18, 12, 6, 0], horizon=6)
    times = range(18, 34)
    np.testing.assert_array_equal(
        X, [[series[t - 18], series[t - 12], series[t - 6], series[t]] for t in times]
    )
    np.testing.assert_array_equal(y, [series[t + 6] for t in times])


def test_columns_of_a_series_stay_together() -> None:
    series = np.arange(12.0).reshape(6, 2)
    X, y = lagged(series, [1, 0])
    np.testing.assert_array_equal(X[0], [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_array_equal(y[0], [4.0, 5.0])
    assert (X.shape, y.shape) == ((4, 4), (4, 2))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"series": [0.0, np.nan, 1.0]}, "series"),
        ({"series": [0.0, 1.0]}, "longer than 2"),
        ({"lags": []}, "at least one"),
        ({"lags": [1, 1]}, "different"),
        ({"lags": [-1]}, "lags"),
        ({"horizon": 0}, "horizon"),
    ],
)
def test_what_cannot_be_meant_is_refused(changes: dict[str, Any], words: str) -> None:
    arguments: dict[str, Any] = {"series": [0.0, 1.0, 2.0], "lags": [1], "horizon": 1}
    with pytest.raises(InvalidValue, match=words):
        lagged(**(arguments | changes))

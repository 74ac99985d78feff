"""What is written as JSON can be read back by anyone: no NaN, no arrays."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np

from fuzzy2.support.plain_data import plain


def test_everything_becomes_what_json_can_hold() -> None:
    content = {
        "array": np.array([[1.0, np.nan], [-np.inf, 2.5]]),
        "number": np.float64(0.1),
        "count": np.int64(3),
        "flag": np.bool_(True),
        "pair": (1, math.inf),
        "deep": {"list": [np.arange(2), None, "text"]},
        "path": Path("a") / "b",
        "none": math.nan,
    }
    expected = {
        "array": [[1.0, None], [None, 2.5]],
        "number": 0.1,
        "count": 3,
        "flag": True,
        "pair": [1, None],
        "deep": {"list": [[0, 1], None, "text"]},
        "path": "a/b",
        "none": None,
    }
    assert plain(content) == expected
    assert json.loads(json.dumps(plain(content), allow_nan=False)) == expected

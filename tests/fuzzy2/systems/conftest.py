"""What tests of systems share."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def consequents() -> Array:
    return np.random.default_rng(0).normal(size=(8, 4))


@pytest.fixture(scope="module")
def X() -> Array:
    return np.random.default_rng(1).uniform(-2.0, 2.0, size=(40, 3))

"""What tests of figures share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from fuzzy2.plots.style import style

Array = NDArray[np.float64]


@pytest.fixture
def styled() -> Iterator[None]:
    """Draw in the style of the figures."""
    with style():
        yield


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Array]:
    """Coordinates (3, ...) of every surface and net that is drawn in space, in order.

    Matplotlib does not give them back.
    """
    seen: list[Array] = []
    for name in ("plot_surface", "plot_wireframe"):
        draw = getattr(Axes3D, name)

        def record(
            panel: Axes3D, *coordinates: Array, draw: Callable[..., Any] = draw, **options: Any
        ) -> Any:
            seen.append(np.stack(coordinates))
            return draw(panel, *coordinates, **options)

        monkeypatch.setattr(Axes3D, name, record)
    return seen

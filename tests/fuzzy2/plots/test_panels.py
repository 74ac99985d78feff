"""Axes and text of every figure.

Axes are those that were given, and no text lies outside or on other text.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy2 import plots
from fuzzy2.errors import InvalidValue
from fuzzy2.numbers import GaussianNumber
from fuzzy2.plots.style import style
from fuzzy2.sets.shapes import Triangular
from fuzzy2.sets.type1 import Singleton
from tests.fuzzy2.plots.subjects import FUZZY, SYSTEM, TRIANGLES
from tests.legible import check_texts, labels_of

pytestmark = pytest.mark.usefixtures("styled")


FIGURES: dict[str, tuple[Callable[..., tuple[Axes, ...]], int]] = {
    "figure_1": (plots.figure_1, 2),
    "figure_2": (plots.figure_2, 1),
    "figure_3": (plots.figure_3, 2),
    "figure_4": (plots.figure_4, 3),
    "figure_5": (plots.figure_5, 3),
    "sets": (
        lambda axes=None: plots.figure_of_sets(
            {"low": Triangular(0.0, 1.0, 2.0), "fuzzy": FUZZY, "now": Singleton(3.0)}, axes
        ),
        1,
    ),
    "secondaries": (lambda axes=None: plots.figure_of_secondaries(FUZZY, [4.0, 5.0], axes), 1),
    "reduced": (
        lambda axes=None: plots.figure_of_type_reduced(
            {"one": [1.0, 2.0], "two": GaussianNumber(3.0, 0.5)}, axes
        ),
        1,
    ),
    "response": (lambda axes=None: plots.figure_of_response(SYSTEM, axes=axes), 1),
}


IN_SPACE: dict[str, Callable[..., tuple[Axes, ...]]] = {
    "set": lambda axes=None: plots.figure_in_space(TRIANGLES, axes),
    "surface": lambda axes=None: plots.figure_of_rule_surface(SYSTEM, axes=axes),
}


@pytest.mark.parametrize("name", list(FIGURES))
def test_figures_draw_into_the_axes_they_are_given(name: str) -> None:
    draw, count = FIGURES[name]
    figure = Figure(figsize=(6.0, 3.0 * count), layout="constrained")
    axes = figure.subplots(count, 1, squeeze=False).ravel()
    assert list(draw(axes)) == list(axes)
    # A color bar brings axes of its own.
    assert len(figure.axes) == count + (name == "figure_2")
    with pytest.raises(InvalidValue, match=f"axes must be {count} axes"):
        draw([*axes, axes[0]])


@pytest.mark.parametrize("name", list(IN_SPACE))
def test_figures_in_space_need_three_dimensional_axes(name: str) -> None:
    figure = Figure()
    space = figure.add_subplot(projection="3d")
    assert IN_SPACE[name](space) == (space,)
    with pytest.raises(InvalidValue, match="three-dimensional"):
        IN_SPACE[name](figure.add_subplot())


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FIGURES, *IN_SPACE])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_is_inside_the_figure_and_does_not_lie_on_other_text(name: str, theme: str) -> None:
    """Bounding boxes from matplotlib's own renderer; one pixel is the rounding of the boxes."""
    with style(theme):
        panel = (FIGURES[name][0] if name in FIGURES else IN_SPACE[name])()[0]
        figure: Any = panel.figure
        texts = []
        for axes in figure.axes:
            texts += [*axes.texts, *labels_of(axes)]
        assert check_texts(figure, texts) >= 2
        # Light text on dark ground, or the other way round: most of the picture is ground.
        ground = np.median(np.asarray(figure.canvas.buffer_rgba())[..., :3])
        assert ground > 240 if theme == "light" else ground < 60


def test_drawing_leaves_pyplot_alone() -> None:
    """In a fresh process, because another test may have imported pyplot."""
    program = (
        "import sys; from fuzzy2.plots import figure_2; figure_2(); sys.exit('matplotlib.pyplot' "
        "in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0

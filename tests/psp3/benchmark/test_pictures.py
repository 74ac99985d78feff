"""Pictures of a board: every number is drawn, and no name is taken for a formula."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

from psp3.benchmark.pictures import LONGEST, as_svg, figure_of_cells, figure_of_times
from psp3.errors import InvalidValue
from tests.psp3.benchmark.made import board_of

ERRORS = {
    "ctc": np.full((2, 3, 2), 1e-4),
    "$\\frac{1$ & <b> and a long tail": 1e-3 * np.random.default_rng(0).lognormal(size=(2, 3, 2)),
}


def test_every_cell_is_drawn_with_its_interval_in_millimeters() -> None:
    board = board_of(ERRORS)
    (panel,) = figure_of_cells(board)
    assert len(panel.containers) == len(board.cells)
    for container, cell in zip(panel.containers, board.cells, strict=True):
        line, _, (bars,) = container.lines  # type: ignore[attr-defined]
        estimates = [score.cells[cell].error for score in board.ranked]
        np.testing.assert_allclose(line.get_xdata(), [1e3 * one.value for one in estimates])
        ends = np.array(bars.get_segments())[:, :, 0]
        np.testing.assert_allclose(ends[1], [1e3 * estimates[1].low, 1e3 * estimates[1].high])
    # A dollar that begins no formula has a backslash in front, which is not drawn.
    names = [label.get_text().replace(r"\$", "$") for label in panel.get_yticklabels()]
    assert [name[:10] for name in names] == [name[:10] for name in ERRORS]
    assert max(map(len, names)) == LONGEST


def test_every_entry_is_a_point_of_time_and_error() -> None:
    board = board_of(ERRORS)
    (panel,) = figure_of_times(board)
    points = [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in panel.lines]
    expected = [(1e6 * score.step_time, 1e3 * score.error.value) for score in board.ranked]
    np.testing.assert_allclose(points, expected)


@pytest.mark.parametrize("draw", [figure_of_cells, figure_of_times])
def test_names_that_look_like_formulas_and_tags_make_a_picture_all_the_same(draw) -> None:  # type: ignore[no-untyped-def]
    """Well-formed, without a script, and the same at every call."""
    board = board_of(ERRORS)
    svg = as_svg(draw(board))
    tags = {element.tag.rpartition("}")[2] for element in ElementTree.fromstring(svg).iter()}
    assert "script" not in tags
    assert "b" not in tags
    assert svg == as_svg(draw(board))


@pytest.mark.parametrize("draw", [figure_of_cells, figure_of_times])
def test_axes_are_used_or_refused(draw) -> None:  # type: ignore[no-untyped-def]
    axes = Figure().subplots(1, 2)
    assert draw(board_of(ERRORS), axes[:1]) == (axes[0],)
    with pytest.raises(InvalidValue, match="1 axes"):
        draw(board_of(ERRORS), axes)

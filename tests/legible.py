"""Whether the text of a figure can be read: by boxes from matplotlib's own renderer."""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text


def labels_of(axes: Axes) -> list[Text]:
    """Return labels, title and legend of axes, flat or in space; they may be empty."""
    legend = axes.get_legend()
    axis = [axes.xaxis, axes.yaxis, *([axes.zaxis] if hasattr(axes, "zaxis") else [])]
    title: Text = axes._left_title  # type: ignore[attr-defined]
    return [*(one.label for one in axis), title, *(legend.get_texts() if legend else [])]


def check_texts(figure: Figure, texts: Iterable[Text]) -> int:
    """Check that texts are inside the figure and apart; return how many have words.

    One pixel is the rounding of the boxes.
    """
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer, whole = canvas.get_renderer(), figure.bbox
    boxes = [
        (text.get_text(), text.get_window_extent(renderer))
        for text in texts
        if text.get_text() not in ("", "+")
    ]
    for n, (text, box) in enumerate(boxes):
        assert box.x0 > whole.x0 - 1, text
        assert box.x1 < whole.x1 + 1, text
        assert box.y0 > whole.y0 - 1, text
        assert box.y1 < whole.y1 + 1, text
        for other, other_box in boxes[:n]:
            apart = (
                box.x0 > other_box.x1 - 1
                or other_box.x0 > box.x1 - 1
                or box.y0 > other_box.y1 - 1
                or other_box.y0 > box.y1 - 1
            )
            assert apart, f"{text} lies on {other}"
    return len(boxes)

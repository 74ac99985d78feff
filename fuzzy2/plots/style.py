"""How the figures of both packages look.

Colors can be told apart by color-blind readers, grids are thin, and there is a light and a dark
theme.

Matplotlib is imported when a style is first entered, not before.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

# Okabe and Ito's colors ("Color Universal Design", 2008) without the yellow, which is hardly
# visible on white. The order keeps neighbors distinguishable for every kind of color vision, and
# puts the colors with the least contrast to the background last.
BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
)

CYCLES = MappingProxyType(
    {
        "light": (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY),
        "dark": (SKY, ORANGE, GREEN, PURPLE, VERMILLION, "#F0E442"),
    }
)
# Background, text, muted text and secondary lines, grid.
GROUNDS = MappingProxyType(
    {
        "light": ("#FFFFFF", "#1A1A1A", "#6B6B6B", "#DDDDDD"),
        "dark": ("#14171C", "#ECECEC", "#A0A4AB", "#333942"),
    }
)


def parameters(theme: str = "light") -> dict[str, Any]:
    """Return matplotlib's settings for a theme.

    Parameters
    ----------
    theme : {"light", "dark"}
        Dark text on white, or light text on near-black.

    Returns
    -------
    dict
        Settings for ``matplotlib.rc_context``.

    Raises
    ------
    ValueError
        If there is no such theme.
    """
    if theme not in CYCLES:
        raise ValueError(f"unknown theme {theme!r}; known are {', '.join(CYCLES)}")
    from cycler import cycler

    background, text, muted, grid = GROUNDS[theme]
    return {
        "axes.axisbelow": True,
        "axes.edgecolor": muted,
        "axes.facecolor": background,
        "axes.formatter.useoffset": False,
        "axes.grid": True,
        "axes.labelcolor": text,
        "axes.labelsize": 10.0,
        "axes.linewidth": 0.8,
        "axes.prop_cycle": cycler(color=CYCLES[theme]),
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.titlecolor": text,
        "axes.titlelocation": "left",
        "axes.titlesize": 11.0,
        "axes.titleweight": "bold",
        "figure.constrained_layout.use": True,
        "figure.dpi": 100.0,
        "figure.edgecolor": background,
        "figure.facecolor": background,
        "figure.titlesize": 12.0,
        "figure.titleweight": "bold",
        # DejaVu Sans comes with matplotlib, so a figure has the same line breaks on every machine.
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans"],
        "font.size": 10.0,
        "grid.color": grid,
        "grid.linewidth": 0.5,
        "legend.edgecolor": grid,
        "legend.facecolor": background,
        "legend.fontsize": 9.0,
        "legend.framealpha": 0.9,
        "legend.labelcolor": text,
        "lines.linewidth": 1.6,
        "patch.edgecolor": text,
        "savefig.dpi": 150.0,
        "savefig.edgecolor": background,
        "savefig.facecolor": background,
        # Letters drawn as outlines look the same in every browser. The salt makes the identifiers
        # in the file reproducible.
        "svg.fonttype": "path",
        "svg.hashsalt": "psp3",
        "text.color": text,
        "xtick.color": muted,
        "xtick.labelcolor": text,
        "xtick.labelsize": 9.0,
        "ytick.color": muted,
        "ytick.labelcolor": text,
        "ytick.labelsize": 9.0,
    }


@contextmanager
def style(theme: str = "light") -> Iterator[None]:
    """Draw and save figures in the style of both packages.

    Parameters
    ----------
    theme : {"light", "dark"}
        Dark text on white, or light text on near-black.

    Yields
    ------
    None
        Figures created or saved in the ``with`` block have the style. The previous settings of
        matplotlib are restored afterwards.

    Raises
    ------
    ValueError
        If there is no such theme.
    """
    # matplotlib's type of this argument lists every key
    settings: Any = parameters(theme)
    from matplotlib import rc_context

    with rc_context(settings):
        yield

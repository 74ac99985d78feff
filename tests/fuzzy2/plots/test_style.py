"""The style of the figures.

Contrast by the WCAG formula, color vision by Machado's matrices, settings restored.
"""

from __future__ import annotations

import subprocess
import sys
from itertools import combinations, pairwise

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from fuzzy2.plots.style import CYCLES, GROUNDS, parameters, style

# Machado, Oliveira and Fernandes, "A Physiologically-based Model for Simulation of Color Vision
# Deficiency", IEEE TVCG 15(6), 2009, table of severity 1.0; they act on linear RGB.
VISION = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}


def linear(color: str) -> NDArray[np.float64]:
    rgb = np.array(to_rgb(color))
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def luminance(color: str) -> float:
    return float(np.array([0.2126, 0.7152, 0.0722]) @ linear(color))


def contrast(first: str, second: str) -> float:
    dark, light = sorted((luminance(first), luminance(second)))
    return (light + 0.05) / (dark + 0.05)


def lab(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """CIELAB of linear sRGB under D65."""
    matrix = np.array(
        [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
    )
    ratios = matrix @ np.clip(rgb, 0.0, 1.0) / (matrix @ np.ones(3))
    f = np.where(ratios > (6 / 29) ** 3, np.cbrt(ratios), ratios / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("theme", list(CYCLES))
@pytest.mark.parametrize("vision", list(VISION))
def test_neighboring_colors_are_told_apart_by_every_kind_of_vision(theme: str, vision: str) -> None:
    """CIE76 distance: 2.3 is just noticeable, 10 at a glance.

    The first four colors against each other, the rest against neighbors.
    """
    colors = {color: lab(VISION[vision] @ linear(color)) for color in CYCLES[theme]}
    pairs = set(combinations(CYCLES[theme][:4], 2)) | set(pairwise(CYCLES[theme]))
    for first, second in pairs:
        assert np.linalg.norm(colors[first] - colors[second]) > 10.0, (first, second)


@pytest.mark.parametrize("theme", list(CYCLES))
def test_text_and_lines_stand_out_from_the_background(theme: str) -> None:
    """WCAG 2.2: 4.5 for text, 3 for graphics.

    The first three colors of the cycle keep the latter, and the rest come near (2).
    """
    background, text, muted, grid = GROUNDS[theme]
    assert contrast(text, background) > 7.0
    assert contrast(muted, background) > 4.5
    assert contrast(grid, background) < 2.0  # a grid stays behind the data
    assert min(contrast(color, background) for color in CYCLES[theme][:3]) > 3.0
    assert min(contrast(color, background) for color in CYCLES[theme]) > 2.0


def test_style_is_in_force_within_and_gone_after() -> None:
    before = dict(mpl.rcParams)
    with style("dark"):
        assert mpl.rcParams["axes.facecolor"] == GROUNDS["dark"][0]
        assert mpl.rcParams["axes.prop_cycle"].by_key()["color"] == list(CYCLES["dark"])
        with style():
            assert mpl.rcParams["axes.facecolor"] == GROUNDS["light"][0]
        assert mpl.rcParams["axes.facecolor"] == GROUNDS["dark"][0]
    assert dict(mpl.rcParams) == before


def test_style_is_gone_after_an_error() -> None:
    before = dict(mpl.rcParams)
    with pytest.raises(RuntimeError, match="while drawing"), style():
        raise RuntimeError("while drawing")
    assert dict(mpl.rcParams) == before


def test_refuses_an_unknown_theme() -> None:
    with pytest.raises(ValueError, match=r"unknown theme 'sepia'; known are light, dark"):
        parameters("sepia")
    with pytest.raises(ValueError, match="unknown theme"), style("sepia"):
        pass


def test_importing_the_style_does_not_import_matplotlib() -> None:
    program = "import sys; import fuzzy2.plots.style; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0

"""Small pictures of sets: what is drawn is the membership."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import fuzzy2
from fuzzy2.support.shown import HEIGHT, WIDTH

SVG = "{http://www.w3.org/2000/svg}"


def drawn(thing: object) -> ElementTree.Element:
    return ElementTree.fromstring(thing._repr_html_())  # type: ignore[attr-defined]


def test_the_curve_is_the_membership() -> None:
    """A triangle on [1, 5] with a margin of 4 % of 4; to a tenth of a pixel, as it is printed."""
    triangle = fuzzy2.Triangular(1.0, 2.0, 5.0)
    (line,) = drawn(triangle).iter(f"{SVG}polyline")
    corners = np.array([pair.split(",") for pair in line.attrib["points"].split()], dtype=float)
    x = 0.84 + (corners[:, 0] - 2.0) / (WIDTH - 4.0) * 4.32
    grades = (HEIGHT - 2.0 - corners[:, 1]) / (HEIGHT - 4.0)
    # A tenth of a pixel across is 0.0025 of x, by the slope of 1.
    np.testing.assert_allclose(grades, triangle(x), atol=0.005)
    assert grades.max() == 1.0


@pytest.mark.parametrize(
    ("fuzzy_set", "lines", "areas"),
    [
        (fuzzy2.Singleton(3.0), 1, 0),
        (fuzzy2.Sigmoid(0.0, 2.0), 1, 0),
        (fuzzy2.SampledSet([0.0, 1.0, 4.0], [0.0, 1.0, 0.2]), 1, 0),
        (fuzzy2.Interval(-1e300, 1e300), 1, 0),
        (fuzzy2.GaussianUncertainMean((0.0, 1.0), 0.5), 2, 1),
        (fuzzy2.GaussianType2Set(fuzzy2.Gaussian(0.0, 1.0), 0.1), 2, 1),
    ],
)
def test_sets_of_all_types_have_a_picture(fuzzy_set: object, lines: int, areas: int) -> None:
    shown = drawn(fuzzy_set)
    assert len(list(shown.iter(f"{SVG}polyline"))) == lines
    assert len(list(shown.iter(f"{SVG}polygon"))) == areas
    assert "".join(shown.find("figcaption").itertext()) == repr(fuzzy_set)  # type: ignore[union-attr]

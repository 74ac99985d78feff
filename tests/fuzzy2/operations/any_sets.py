"""Sets on the unit interval as hypothesis makes them up."""

from __future__ import annotations

from hypothesis import assume
from hypothesis import strategies as st

from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet, Type1Set


@st.composite
def discrete_sets(draw: st.DrawFn, smallest_grade: int = 0) -> SampledSet:
    """Points on a grid of 1/20 and grades of sixteenths, any shape."""
    points = draw(st.lists(st.integers(0, 20), min_size=1, max_size=7, unique=True))
    grades = draw(
        st.lists(st.integers(smallest_grade, 16), min_size=len(points), max_size=len(points))
    )
    assume(any(grades))
    return SampledSet([k / 20.0 for k in points], [k / 16.0 for k in grades])


@st.composite
def convex_functions(draw: st.DrawFn, normal: bool = True) -> Type1Set:
    """Draw sets over a continuous domain whose peaks and corners lie on the grid THETA."""
    corners = sorted(draw(st.lists(st.integers(0, 20), min_size=4, max_size=4)))
    a, b, c, d = (k / 20.0 for k in corners)
    height = 1.0 if normal else draw(st.integers(1, 16)) / 16.0
    kind = draw(st.sampled_from(("gaussian", "triangle", "trapezoid", "bell", "interval", "cut")))
    if kind == "gaussian":
        return Gaussian(b, 0.03 + 0.3 * d, height)
    if kind == "triangle":
        return Triangular(a, b, c, height)
    if kind == "trapezoid":
        return Trapezoidal(a, b, c, d, height)
    if kind == "bell":
        return Bell(b, 0.05 + a, 2.0)
    if kind == "cut":
        return Truncated(Gaussian(c, 0.2), a, d)
    return Interval(a, d)

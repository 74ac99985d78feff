"""Named partitions: triangles called poor, average and good, and the like."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.shapes import Triangular
from fuzzy2.support.checks import listed, real, whole_number

NAMES = {
    3: ("poor", "average", "good"),
    5: ("poor", "mediocre", "average", "decent", "good"),
    7: ("dismal", "poor", "mediocre", "average", "decent", "good", "excellent"),
}
"""Names by the number of terms, as in scikit-fuzzy's ``automf``."""


def automf(least: float, greatest: float, terms: int | Sequence[str] = 3) -> dict[str, Triangular]:
    r"""Return named triangles that partition a range evenly; their grades add up to 1.

    Term k of K has its peak at :math:`a + k (b - a) / (K - 1)` and its feet at the peaks of its
    neighbors. The outer feet of the first and the last term lie one spacing outside the range.

    Parameters
    ----------
    least, greatest : float
        Ends a < b of the range.
    terms : int or sequence of str
        3 gives the names *poor, average, good*; 5 adds *mediocre* and *decent*, and 7 also *dismal*
        and *excellent*. Any other number gives *term1, term2, ...*. A list gives the names
        themselves, at least two.

    Returns
    -------
    dict from str to Triangular
        The terms in ascending order, in the form that a system accepts for an input.

    Raises
    ------
    InvalidValue
        If the range has no width, if there are fewer than two terms, or if a name is repeated.

    Examples
    --------
    >>> list(fuzzy2.automf(0.0, 10.0))
    ['poor', 'average', 'good']
    """
    low, high = real("least", least), real("greatest", greatest)
    if not low < high:
        raise InvalidValue("greatest", greatest, f"above least, {low!r}")
    names = _names(terms)
    step = high / (len(names) - 1) - low / (len(names) - 1)
    peaks = np.linspace(low, high, len(names)).tolist()
    feet = [low - step, *peaks, high + step]
    return {
        name: Triangular(left, peak, right)
        for name, left, peak, right in zip(names, feet[:-2], peaks, feet[2:], strict=True)
    }


def _names(terms: int | Sequence[str]) -> tuple[str, ...]:
    if isinstance(terms, int | np.integer):
        count = whole_number("terms", terms, 2)
        return NAMES.get(count) or tuple(f"term{k + 1}" for k in range(count))
    names = listed("terms", terms, "a number, or at least two different names")
    if (
        len(names) < 2
        or not all(isinstance(name, str) for name in names)
        or len(set(names)) < len(names)
    ):
        raise InvalidValue("terms", terms, "a number, or at least two different names")
    return names

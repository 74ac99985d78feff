r"""Hedges, which are words that make a term stricter or looser, as in ``x is very Low``.

=====================  ==================================================
word                   grade for a grade :math:`\mu`
=====================  ==================================================
very                   :math:`\mu^2`
extremely              :math:`\mu^3`
somewhat               :math:`\sqrt\mu`
more or less           :math:`\sqrt\mu`
slightly               :math:`\sqrt[3]\mu`
=====================  ==================================================

These are Zadeh's powers, as in MATLAB's documentation. Other programs give these words other
meanings. A system accepts user-defined hedges, ``hedges={"very": Hedge("very", power=1.5)}``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.type1 import set_fields
from fuzzy2.support.checks import Array, of_kind, positive

_TRIAL_GRADES = np.linspace(0.0, 1.0, 129)


def intensify(grades: Array) -> Array:
    r"""Return :math:`2\mu^2` up to 1/2 and :math:`1 - 2(1 - \mu)^2` above (Zadeh)."""
    return np.where(grades <= 0.5, 2.0 * grades**2, 1.0 - 2.0 * (1.0 - grades) ** 2)


def relax(grades: Array) -> Array:
    r"""Return the inverse of :func:`intensify`, which is :math:`\sqrt{\mu/2}` up to 1/2."""
    low, high = np.sqrt(0.5 * grades), 1.0 - np.sqrt(0.5 * (1.0 - grades))
    return np.where(grades <= 0.5, low, high)


@dataclass(frozen=True)
class Scaled:
    """Hedge function that multiplies grades by a factor in [0, 1], the weight of a part."""

    factor: float

    def __call__(self, grades: Array) -> Array:
        """Return the grades times the factor."""
        return self.factor * grades


NAMED_FUNCTIONS = MappingProxyType({"intensify": intensify, "relax": relax})
"""Functions of hedges that have a name in files."""


@dataclass(frozen=True)
class Hedge:
    """Function that a word applies to the grade of a term.

    Parameters
    ----------
    name : str
        The word, or words.
    power : float, optional
        Exponent of the grade, above 0.
    function : callable, optional
        Monotonic function that maps grades (...,) in [0, 1] to grades (...,), instead of a power.
        Compiled loops, exported code and files support :func:`intensify`, :func:`relax` and
        :class:`Scaled`. Systems with other functions are evaluated in NumPy, which is slower.

    Raises
    ------
    InvalidValue
        If neither or both are given, if the power is not above 0, or if the function leaves [0, 1]
        or is not monotonic.
    """

    name: str
    power: float | None = None
    function: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.strip():
            raise InvalidValue("name", self.name, "the word of a hedge")
        set_fields(self, name=" ".join(self.name.split()))
        if (self.power is None) == (self.function is None):
            raise InvalidValue("power and function", (self.power, self.function), "one of both")
        if self.power is not None:
            set_fields(self, power=positive("power", self.power))
        if self.function is not None:
            self._try_function(self.function)

    @staticmethod
    def _try_function(function: Callable[[Array], Array]) -> None:
        grades = np.asarray(function(_TRIAL_GRADES), dtype=float)
        if grades.shape != _TRIAL_GRADES.shape or not ((grades >= 0.0) & (grades <= 1.0)).all():
            raise InvalidValue("function", function, "from arrays of grades to grades in [0, 1]")
        steps = np.diff(grades)
        if (steps < 0.0).any() and (steps > 0.0).any():
            raise InvalidValue("function", function, "rising all the way, or falling all the way")

    def __call__(self, grades: Array) -> Array:
        """Return the hedged grades of grades (...,)."""
        if self.function is not None:
            return np.asarray(self.function(grades), dtype=float)
        assert self.power is not None
        return np.asarray(grades**self.power)

    def of_logarithms(self, logarithms: Array) -> Array:
        """Return the logarithms of the hedged grades, given the logarithms (...,) of grades.

        For a user-defined function the grades are floats, so a grade that underflows is 0.
        """
        if self.power is not None:
            return np.asarray(self.power * logarithms)
        with np.errstate(divide="ignore"):
            found = np.log(self(np.exp(logarithms)))
        low = logarithms < np.log(0.5)
        if self.function is intensify:
            found = np.where(low, np.log(2.0) + 2.0 * logarithms, found)
        elif self.function is relax:
            found = np.where(low, 0.5 * (logarithms - np.log(2.0)), found)
        elif isinstance(self.function, Scaled) and self.function.factor > 0.0:
            found = np.log(self.function.factor) + logarithms
        return np.asarray(found)


HEDGES = MappingProxyType(
    {
        hedge.name: hedge
        for hedge in (
            Hedge("very", 2.0),
            Hedge("extremely", 3.0),
            Hedge("somewhat", 0.5),
            Hedge("more or less", 0.5),
            Hedge("slightly", 1.0 / 3.0),
        )
    }
)
"""Hedges that every system accepts."""

ANY = "any"
"""Word for any value: ``x is any`` always holds."""


def known_hedges(
    given: Mapping[str, Hedge | Callable[[Array], Array]] | None,
) -> dict[str, Hedge]:
    """Return a system's own hedges and the common ones, by their words in lower case.

    Raises
    ------
    InvalidValue
        If a value is neither a hedge nor a function, or a name is a keyword.
    """
    known = dict(HEDGES)
    if given is not None:
        of_kind("hedges", given, Mapping, "a mapping from words to hedges")
    for name, hedge in (given or {}).items():
        word = " ".join(str(name).split()).lower()
        if word in ("", "not", ANY, "is", "if", "then", "and", "or", "else", "with"):
            raise InvalidValue("hedges", name, "words that are not keywords")
        if not isinstance(hedge, Hedge) and not callable(hedge):
            raise InvalidValue(f"hedge {name!r}", hedge, "a Hedge, or a function of grades")
        known[word] = hedge if isinstance(hedge, Hedge) else Hedge(word, function=hedge)
    return known

"""Fuzzy numbers: interval and Gaussian ones, and ones held as α-cuts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from fuzzy2.numbers.affine import GaussianNumber as GaussianNumber
    from fuzzy2.numbers.affine import IntervalNumber as IntervalNumber
    from fuzzy2.numbers.fuzzy_number import FuzzyNumber as FuzzyNumber
    from fuzzy2.numbers.meets import gaussian_meet as gaussian_meet
    from fuzzy2.numbers.meets import gaussian_meet_error as gaussian_meet_error

__all__, __getattr__, __dir__ = lazy_names(__name__)

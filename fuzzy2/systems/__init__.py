"""Fuzzy systems of the three types: rules, fuzzifiers, inference and gradients."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from fuzzy2.systems.consequents import Linear as Linear
    from fuzzy2.systems.general_type2 import GeneralType2System as GeneralType2System
    from fuzzy2.systems.report import Report as Report
    from fuzzy2.systems.system import FuzzySystem as FuzzySystem
    from fuzzy2.systems.system import IntervalType2System as IntervalType2System
    from fuzzy2.systems.system import Type1System as Type1System
    from fuzzy2.systems.terms import AnySet as AnySet

__all__, __getattr__, __dir__ = lazy_names(__name__)

"""Dynamic parameters from measured motions and forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.identification.least_squares import CONFIDENCE as CONFIDENCE
    from psp3.identification.least_squares import Identified as Identified
    from psp3.identification.least_squares import identify as identify

__all__, __getattr__, __dir__ = lazy_names(__name__)

"""Loops: a first closed pose, mobility, rank, and the limits of passive joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.closure.assembly import ASSEMBLED as ASSEMBLED
    from psp3.closure.assembly import assembled as assembled
    from psp3.closure.assembly import residual as residual
    from psp3.multibody.flatten import CLOSURE_TOLERANCE as CLOSURE_TOLERANCE
    from psp3.multibody.flatten import NO_MOTORS as NO_MOTORS
    from psp3.multibody.flatten import flattened as flattened

__all__, __getattr__, __dir__ = lazy_names(__name__)

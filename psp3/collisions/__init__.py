"""Collisions between links: shapes, checked pairs, and distances along a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.collisions.motion import Contact as Contact
    from psp3.collisions.motion import Report as Report
    from psp3.collisions.motion import check as check
    from psp3.collisions.motion import check_clearance as check_clearance

__all__, __getattr__, __dir__ = lazy_names(__name__)

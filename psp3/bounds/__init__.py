"""Bounds with a given probability, for tracking errors and for torques."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.bounds.conformal import conformal_bound as conformal_bound
    from psp3.bounds.error_dynamics import ErrorDynamics as ErrorDynamics
    from psp3.bounds.torque_intervals import ConformalIntervals as ConformalIntervals
    from psp3.bounds.tracking_tube import TrackingTube as TrackingTube
    from psp3.bounds.tracking_tube import residual_accelerations as residual_accelerations
    from psp3.bounds.tracking_tube import runs_needed as runs_needed

__all__, __getattr__, __dir__ = lazy_names(__name__)

"""Desired motions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.trajectories.motion import Motion as Motion
    from psp3.trajectories.motion import check_stroke as check_stroke
    from psp3.trajectories.motion import finite_times as finite_times
    from psp3.trajectories.motion import tip_of as tip_of
    from psp3.trajectories.paths import Circle as Circle
    from psp3.trajectories.paths import Helix as Helix
    from psp3.trajectories.paths import Hold as Hold
    from psp3.trajectories.paths import Line as Line
    from psp3.trajectories.paths import PointToPoint as PointToPoint
    from psp3.trajectories.recorded import FromCSV as FromCSV
    from psp3.trajectories.recorded import MeasuredMotion as MeasuredMotion
    from psp3.trajectories.recorded import Waypoints as Waypoints
    from psp3.trajectories.recorded import measured_motion as measured_motion
    from psp3.trajectories.sway import Sway as Sway
    from psp3.trajectories.trajectory import SPACES as SPACES
    from psp3.trajectories.trajectory import Trajectory as Trajectory

__all__, __getattr__, __dir__ = lazy_names(__name__)

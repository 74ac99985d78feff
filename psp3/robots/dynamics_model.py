"""The path by which :mod:`psp3.dynamics.dynamics_model` was public first, and still is."""

from __future__ import annotations

from psp3.dynamics.dynamics_model import DynamicsModel as DynamicsModel
from psp3.dynamics.dynamics_model import equation_of_motion_of as equation_of_motion_of

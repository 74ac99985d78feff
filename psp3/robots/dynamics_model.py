"""An alias of :mod:`psp3.dynamics.dynamics_model`, kept because it was its first public path."""

from __future__ import annotations

from psp3.dynamics.dynamics_model import DynamicsModel as DynamicsModel
from psp3.dynamics.dynamics_model import equation_of_motion_of as equation_of_motion_of

"""Dynamics and learned controllers as functions of CasADi symbols, from the kernels' source code.

Use them for your own optimal control; ``docs/how_to/optimal_control.md`` shows how. They need the
extra ``symbolic``: ``pip install 'psp3[symbolic]'``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.symbolic.closed_form import SymbolicPSP3 as SymbolicPSP3
    from psp3.symbolic.controller import fuzzy_torque as fuzzy_torque
    from psp3.symbolic.robot import SymbolicRobot as SymbolicRobot

__all__, __getattr__, __dir__ = lazy_names(__name__)

"""Plants, the closed loop of controller and plant, results and their metrics."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.simulation.encoder import Encoder as Encoder
    from psp3.simulation.result import Result as Result
    from psp3.simulation.result import load_result as load_result
    from psp3.simulation.tracking import simulate as simulate

__all__, __getattr__, __dir__ = lazy_names(__name__)

"""A public benchmark of learned computed torque for parallel robots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.benchmark.baselines import BASELINES as BASELINES
    from psp3.benchmark.benchmark import Benchmark as Benchmark
    from psp3.benchmark.board import Board as Board
    from psp3.benchmark.entries import Entry as Entry
    from psp3.benchmark.entries import load_entry as load_entry
    from psp3.benchmark.page import write_numbers as write_numbers
    from psp3.benchmark.page import write_page as write_page

__all__, __getattr__, __dir__ = lazy_names(__name__)

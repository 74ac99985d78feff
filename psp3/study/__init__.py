"""Many runs of controllers on robots: grids, files, statistics and comparisons."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.study.grids import Grid as Grid
    from psp3.study.grids import grid as grid
    from psp3.study.study import Progress as Progress
    from psp3.study.study import Study as Study
    from psp3.study.table import Table as Table

__all__, __getattr__, __dir__ = lazy_names(__name__)

"""Fuzzy systems learned from data."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from fuzzy2.learning.consequents import COMPLETIONS as COMPLETIONS
    from fuzzy2.learning.partition import KINDS as KINDS
    from fuzzy2.learning.partition import cluster_partition as cluster_partition
    from fuzzy2.learning.partition import gaussian_partition as gaussian_partition
    from fuzzy2.learning.partition import term_names as term_names
    from fuzzy2.learning.wang_mendel import LEARNERS as LEARNERS
    from fuzzy2.learning.wang_mendel import PARTITIONS as PARTITIONS
    from fuzzy2.learning.wang_mendel import WangMendel as WangMendel

__all__, __getattr__, __dir__ = lazy_names(__name__)

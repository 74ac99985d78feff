"""A few hundred mutants of every reader, in a process with bounds; many more: ``make fuzz``.

No foreign error, none that says nothing, no hang, nothing passed over, no more than a GiB.
"""

from __future__ import annotations

import os

import pytest

from tests.hostile.campaign import tried
from tests.hostile.fuzzy_readers import fuzzy_readers
from tests.hostile.robot_readers import robot_readers

COUNT = int(os.environ.get("MUTANTS", "40"))
"""Mutants of each reader."""

OF_FEW_WORDS = ("result", "stl", "study")
"""Readers of files in which nearly every change is a damage."""


@pytest.mark.parametrize(
    "names",
    [[one.name for one in fuzzy_readers()], [one.name for one in robot_readers()]],
    ids=["fuzzy2", "psp3"],
)
def test_changed_files_are_read_right_or_refused(names: list[str]) -> None:
    report = tried({name: range(COUNT) for name in names})
    assert report.faults == []
    for name, tally in report.tallies.items():
        assert tally.tried == COUNT
        # Neither is everything refused, nor is everything read.
        assert tally.results["refused"] >= COUNT // 10, name
        if name not in OF_FEW_WORDS:
            assert tally.results["read"] + tally.results["told"] >= COUNT // 10, name

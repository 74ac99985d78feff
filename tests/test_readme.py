"""The table of results in the README is what the main job finds.

Its code and links are tested in ``test_docs.py``.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def test_results_table_is_that_of_the_main_job(tmp_path: Path) -> None:
    """The README's table, to its four decimals."""
    from psp3.thesis.replication import reproduce

    numbers = reproduce(tmp_path, quick=True).numbers["table_6_3"]
    for name in ("PD", "CTC"):
        (row,) = re.findall(rf"\| {name} \| ([\d.]+) \| ([\d.]+) \|", TEXT)
        assert float(row[0]) == numbers[name]["printed_sum_of_squared_errors"]
        assert float(row[1]) == pytest.approx(numbers[name]["sum_of_squared_errors"], abs=5e-5)

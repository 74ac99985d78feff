"""What the README says is what happens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def test_example_runs_and_prints_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    exec(compile(code, "README.md", "exec"), {})
    printed = float(capsys.readouterr().out)
    (promised,) = re.findall(r"# (0\.\d+) m, from starting at rest", code)
    assert round(printed, 4) == float(promised)


def test_links_lead_to_files() -> None:
    links = [link for link in re.findall(r"\]\(([^)]+)\)", TEXT) if not link.startswith("http")]
    assert links
    for link in links:
        assert (ROOT / link).exists(), link


def test_results_table_is_that_of_the_main_job(tmp_path: Path) -> None:
    """The README's table, to its four decimals."""
    from psp3.reproduce import reproduce

    numbers = reproduce(tmp_path, quick=True).numbers["table_6_3"]
    for name in ("PD", "CTC"):
        (row,) = re.findall(rf"\| {name} \| ([\d.]+) \| ([\d.]+) \|", TEXT)
        assert float(row[0]) == numbers[name]["printed_sum_of_squared_errors"]
        assert float(row[1]) == pytest.approx(numbers[name]["sum_of_squared_errors"], abs=5e-5)

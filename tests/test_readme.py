"""What the README says is what happens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


EXAMPLES = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)


@pytest.mark.parametrize("code", EXAMPLES, ids=["robot", "fuzzy"])
def test_examples_print_what_they_say(code: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Numbers in the comment behind ``print`` are those printed, to the digits given."""
    exec(compile(code, "README.md", "exec"), {})
    numbers = re.compile(r"-?\d+\.\d+")
    (comment,) = re.findall(r"print\(.*\)  # (.*)", code)
    printed = [float(number) for number in numbers.findall(capsys.readouterr().out)]
    promised = numbers.findall(comment)
    assert [f"{value:.{len(text.split('.')[1])}f}" for value, text in zip(printed, promised, strict=True)] == promised


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

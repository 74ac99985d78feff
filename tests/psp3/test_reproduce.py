"""The main job as a user runs it: what it writes, and that the numbers in it are those of the simulations."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3 import published
from psp3.reproduce import Reproduction, reproduce


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> tuple[Reproduction, Path, list[tuple[str, int, int]]]:
    out, seen = tmp_path_factory.mktemp("reproduce") / "deep" / "folder", []
    return reproduce(out, progress=lambda *step: seen.append(step)), out, seen


def test_everything_promised_is_written(outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    found, out, _ = outcome
    names = {"report.html", "results.json", "animation.html", "pd.npz", "ctc.npz", "figures/figure_52.svg", "figures/figure_53.svg"}
    assert {str(file.relative_to(out)) for file in found.files} == names
    assert {str(file.relative_to(out)) for file in out.rglob("*") if file.is_file()} == names


def test_classical_rows_lie_where_the_thesis_has_them(outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    """PD within 5 % of the printed 4.6339, as the project promises; CTC within a factor of two, because its start is unknown."""
    rows = json.loads((outcome[1] / "results.json").read_text())["table_6_3"]
    assert rows["PD"]["sum_of_squared_errors"] == pytest.approx(4.6339, rel=0.05)
    assert 0.5 < rows["CTC"]["sum_of_squared_errors"] / 0.0241 < 2.0
    for name in ("PD", "CTC"):
        run = psp3.load_result(outcome[1] / f"{name.lower()}.npz")
        error = (run.desired.heights - run.heights)[::25]
        assert rows[name]["sum_of_squared_errors"] == pytest.approx((error**2).sum(), rel=1e-12)


def test_table_5_1_within_its_bars(outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    """Bars of the project: |ΔM| 0.0071 kg, |ΔG| 0.02 N. C is never compared."""
    table = json.loads((outcome[1] / "results.json").read_text())["table_5_1"]
    assert np.abs(np.array(table["M"]) - published.TABLE_5_1_MASS).max() <= 0.0071
    assert np.abs(np.array(table["G"]) - published.TABLE_5_1_GRAVITY).max() <= 0.02
    text = " ".join(cell for row in outcome[0].tables[1].rows for cell in row)
    assert text.count("not reproducible") == 3


def test_table_5_2_names_the_configurations_that_contradict_it(outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    verdicts = {row[0]: row[-1] for row in outcome[0].tables[2].rows}
    assert verdicts["Δq13"] == verdicts["Δq23"] == "contradicts configurations 2 and 3"
    assert {verdicts[name] for name in ("Δq12", "Δq̇12", "Δq̇13", "Δq̇23")} == {"reproduced"}


def test_three_implementations_agree_in_the_report(outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    """1e-9 relative is the bar between the implementations."""
    gaps = outcome[0].numbers["cross_check"]
    assert max(gap for one in gaps.values() for gap in one.values()) < 1e-9


def test_report_stands_alone(outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    text = (outcome[1] / "report.html").read_text(encoding="utf-8")
    links = re.findall(r"(?:src|href)=['\"]([^'\"]+)['\"]", text)
    assert {link for link in links if not link.startswith("data:")} == {"animation.html"}
    assert len(re.findall("<img alt='Figure 5[23]", text)) == 2
    for table in outcome[0].tables:
        assert table.title.split(":")[0] in text
    assert "4.6339" in text.split("<h2>")[0], "the answer must stand at the top"


def test_progress_ends_at_the_end(outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    steps = outcome[2]
    assert [done for _, done, _ in steps] == list(range(steps[-1][2] + 1))


def test_quick_leaves_out_the_animation_only(tmp_path: Path, outcome: tuple[Reproduction, Path, list[tuple[str, int, int]]]) -> None:
    quick = reproduce(tmp_path, quick=True)
    assert not (tmp_path / "animation.html").exists()
    assert "animation.html" not in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert quick.numbers["table_6_3"] == outcome[0].numbers["table_6_3"]


def test_a_place_that_cannot_be_written_to_is_refused_first(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    seen: list[object] = []
    with pytest.raises(OSError, match="file"):
        reproduce(tmp_path / "file" / "out", progress=lambda *step: seen.append(step))
    assert seen == []

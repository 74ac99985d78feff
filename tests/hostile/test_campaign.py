"""A campaign notices what no reader may do, and goes on behind it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.hostile.campaign import tried
from tests.hostile.mutant import LOST, NONE, OTHER, SAME, Mutant
from tests.hostile.reader import Reader


def test_hanging_dying_and_greedy_readers() -> None:
    report = tried(
        {"hanging": range(3), "dying": range(3), "greedy": range(1)}, "tests.hostile.bad_worker"
    )
    assert report.tallies["hanging"].results == {"read": 2, "died": 1}
    assert report.tallies["dying"].results == {"read": 2, "died": 1}
    hung, died, ate = report.faults
    assert "hanging 1" in hung
    assert "(it took too long)" in hung
    assert "dying 1" in died
    assert "(code -6)" in died
    assert "greedy 0 (): MemoryError" in ate


def _first_number(path: Path) -> str:
    return path.read_text().split()[0].replace("_", "")


@pytest.mark.parametrize(
    ("content", "claim", "fault"),
    [
        (b"1 2", SAME, ""),
        (b"2 2", SAME, "what has no meaning changed what was read"),
        (b"1 3", OTHER, "another number was passed over"),
        (b"3 2", OTHER, ""),
        (b"1_0", NONE, "read, though it is none"),
        (b"1 2 extra", LOST, "lost without a word"),
        (b"", "", "IndexError: list index out of range"),
        (b"\xff", "", ""),
        (b"9", "", "nine"),
    ],
)
def test_what_a_mutant_must_come_to(content: bytes, claim: str, fault: str, tmp_path: Path) -> None:
    seed = b"1 2"
    reader = Reader(
        "first", ".txt", UnicodeDecodeError, (seed,),
        lambda one, rng: Mutant(0, "", content, claim), _first_number,
        second=lambda content, value: "nine" if value == "9" else "",
    )  # fmt: skip
    assert reader.trial(0, tmp_path / "file").fault == fault


def test_mutants_are_the_same_for_the_same_number(tmp_path: Path) -> None:
    from tests.hostile.worker import all_readers

    for name in ("fis", "json", "fml", "csv", "result", "stl"):
        reader = all_readers()[name]
        assert isinstance(reader, Reader)
        one, other = (
            [reader.change(reader.seeds[0], np.random.default_rng(k)) for k in range(20)]
            for _ in range(2)
        )
        assert one == other
        assert len({mutant.content for mutant in one}) > 10

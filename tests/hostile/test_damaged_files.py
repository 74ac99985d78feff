"""Some damages of each kind of file; many are ``python -m tests.hostile.damaged_files 10000``."""

from __future__ import annotations

import pytest

from tests.hostile.damaged_files import KINDS, campaign


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_is_what_was_written_or_is_refused(kind: str) -> None:
    counts = campaign(kind, 300, seed=1)
    answers = {answer for _, answer in counts}
    assert answers <= {"equal", "refused"} | ({"fewer"} if kind == "outcomes" else set())
    assert {"equal", "refused"} <= answers, "some bits mean nothing, and others do"

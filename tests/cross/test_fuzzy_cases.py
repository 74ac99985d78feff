"""Files as people have them, with answers that were worked out apart from this package.

They stand beside the tests of files, each made after one that somebody published, which the
``source`` of each in ``cases.json`` names.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2

FOLDER = Path(__file__).resolve().parents[1] / "fuzzy2" / "files" / "cases"
CASES = json.loads((FOLDER / "cases.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", CASES, ids=[case["file"] for case in CASES])
def test_a_file_gives_the_right_answer(case: dict[str, Any]) -> None:
    """To 1e-6 and half of the last digit that is given: six of .fis files, five of FML."""
    digits = 6 if case["file"].endswith(".fis") else 5
    found = fuzzy2.load(FOLDER / case["file"])(case["inputs"])
    np.testing.assert_allclose(found, case["outputs"], rtol=0.0, atol=1e-6 + 0.5 * 10.0**-digits)


def test_each_file_is_a_case() -> None:
    assert sorted(case["file"] for case in CASES) == sorted(
        path.name for path in FOLDER.iterdir() if path.suffix != ".json"
    )

"""Machine code on disk: what one process keeps is never taken for what another one kept."""

from __future__ import annotations

import itertools
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba.core.caching import IndexDataCacheFile

from fuzzy2.support.code_files import CodeFiles
from fuzzy2.support.compiled import compiled


def files(folder: Path, stamp: int = 1) -> Any:
    plain = IndexDataCacheFile(str(folder), "kernels.function-7.py311", (stamp, 5))
    return CodeFiles.instead_of(plain, __name__)


STEPS = ("_save_data", "_save_index")


@pytest.mark.parametrize("place", range(len(STEPS) + 1))
def test_two_processes_at_the_same_time(place: int, tmp_path: Path) -> None:
    """The other one keeps its code before or after each write of the first one."""
    first, other = files(tmp_path), files(tmp_path)
    # What both see before either has written.
    other._load_index = dict
    done = itertools.count()

    def between(write: Any) -> Any:
        def written(*arguments: Any) -> None:
            if next(done) == place:
                other.save(("float64",), "code for numbers")
            write(*arguments)

        return written

    for step in STEPS:
        setattr(first, step, between(getattr(first, step)))
    first.save(("int64",), "code for whole numbers")
    if place == len(STEPS):
        other.save(("float64",), "code for numbers")
    after = files(tmp_path)
    found = [after.load(("int64",)), after.load(("float64",))]
    assert found[0] in ("code for whole numbers", None)
    assert found[1] in ("code for numbers", None)
    assert found != [None, None]


def test_code_comes_back_and_is_replaced(tmp_path: Path) -> None:
    kept = files(tmp_path)
    kept.save(("int64",), "one")
    kept.save(("float64",), "two")
    kept.save(("int64",), "three")
    assert [kept.load((name,)) for name in ("int64", "float64", "bool")] == ["three", "two", None]
    assert len(list(tmp_path.glob("*.nbc"))) == 2


def test_another_source_has_other_files(tmp_path: Path) -> None:
    """A process that still runs the old source does not write over the code of the new one."""
    old, new = files(tmp_path, stamp=1), files(tmp_path, stamp=2)
    new.save(("int64",), "new")
    old._save_index = lambda _: None
    old.save(("int64",), "old")
    assert new.load(("int64",)) == "new"
    assert files(tmp_path, stamp=1).load(("int64",)) is None


def test_compiled_functions_have_such_files() -> None:
    function: Any = compiled(lambda x: x + 1)
    assert isinstance(function._cache._cache_file, CodeFiles)


CALLED = """
from fuzzy2.support.compiled import compiled

@compiled
def inner(x):
    return x + {added}
"""

CALLING = """
from called_kernels.inner import inner
from fuzzy2.support.compiled import compiled

@compiled
def outer(x):
    return 2.0 * inner(x)
"""


def test_code_is_forgotten_when_a_function_that_it_calls_has_changed(tmp_path: Path) -> None:
    """In a file that has not changed itself, as after ``git pull``."""
    package = tmp_path / "called_kernels"
    package.mkdir()
    (package / "__init__.py").write_text("", encoding="utf-8")
    (package / "outer.py").write_text(CALLING, encoding="utf-8")
    ask = "from called_kernels.outer import outer; print(outer(1.0), *outer.stats.cache_hits)"
    answers = []
    for added in (1.0, 1.0, 5.0):
        (package / "inner.py").write_text(CALLED.format(added=added), encoding="utf-8")
        command = [sys.executable, "-c", ask]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        answers.append(done.stdout.split())
    assert [answer[0] for answer in answers] == ["4.0", "4.0", "12.0"]
    # The second time it came from the disk: that is what must not happen the third time.
    assert [len(answer) - 1 for answer in answers] == [0, 1, 0]

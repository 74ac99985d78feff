"""Machine code on disk: what one process keeps is never taken for what another one kept."""

from __future__ import annotations

import contextlib
import itertools
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba.core.caching import IndexDataCacheFile

from fuzzy2.errors import CodeNotKept
from fuzzy2.support import code_files
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


def test_code_of_other_sources_goes_when_new_code_comes(tmp_path: Path) -> None:
    old, new = files(tmp_path, stamp=1), files(tmp_path, stamp=2)
    for kind in ("float64", "int64"):
        old.save((kind,), "old")
    assert len(list(tmp_path.glob("*.nbc"))) == 2
    new.save(("float64",), "new")
    new.save(("int64",), "newer")
    assert len(list(tmp_path.glob("*.nbc"))) == 2
    assert [new.load((kind,)) for kind in ("float64", "int64")] == ["new", "newer"]
    # Whoever still runs the old sources compiles anew, and is not misled.
    assert files(tmp_path, stamp=1).load(("float64",)) is None


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
    assert x > 0.0
    return 2.0 * inner(x)
"""


def kept(folder: Path) -> Any:
    own = files(folder)
    own.save(("int64",), "the code")
    assert not list(folder.glob("*.tmp.*"))
    return own


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_each_damage_of_a_file_is_noticed(ending: str, tmp_path: Path) -> None:
    """Every bit of a file that is flipped, and every length that it is cut to, one by one."""
    own = kept(tmp_path)
    (path,) = tmp_path.glob(f"*.{ending}")
    whole = path.read_bytes()
    damaged = [whole[:length] for length in range(len(whole))]
    for bit in range(8 * len(whole)):
        flipped = bytearray(whole)
        flipped[bit // 8] ^= 1 << bit % 8
        damaged.append(bytes(flipped))
    damaged += [whole + b"\0", b"\0" * len(whole)]
    for content in damaged:
        path.write_bytes(content)
        with pytest.warns(CodeNotKept, match="damaged"):
            assert own.load(("int64",)) is None
    with pytest.warns(CodeNotKept) if ending == "nbi" else contextlib.nullcontext():
        own.save(("int64",), "the code")
    assert own.load(("int64",)) == "the code"


def test_a_file_of_another_name_is_damaged(tmp_path: Path) -> None:
    own = kept(tmp_path)
    own.save(("float64",), "other code")
    one, other = tmp_path.glob("*.nbc")
    one.write_bytes(other.read_bytes())
    with pytest.warns(CodeNotKept, match="damaged"):
        found = {own.load((name,)) for name in ("int64", "float64")}
    assert found in ({None, "the code"}, {None, "other code"})


def test_code_of_another_version_is_not_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of numba, of what makes its machine code, or of Python."""
    own = kept(tmp_path)
    with monkeypatch.context() as other_version:
        other_version.setattr(code_files, "VERSIONS", "another")
        assert files(tmp_path).load(("int64",)) is None
        kept(tmp_path)
    assert own.load(("int64",)) == files(tmp_path).load(("int64",)) == "the code"
    assert len(list(tmp_path.glob("*.nbc"))) == 2


def test_a_file_that_cannot_be_read_is_as_none(tmp_path: Path) -> None:
    """A directory in its place cannot be read by anybody, root included."""
    own = kept(tmp_path)
    (path,) = tmp_path.glob("*.nbc")
    path.unlink()
    assert own.load(("int64",)) is None
    path.mkdir()
    with pytest.warns(CodeNotKept, match="cannot be read"):
        assert own.load(("int64",)) is None


COMPUTED = """
import sys, warnings
from pathlib import Path
from called_kernels.outer import outer
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    {before}
    found = outer(1.0)
print(found, len(outer.stats.cache_hits), *{{type(one.message).__name__ for one in told}})
"""


def computed(folder: Path, before: str = "pass", *options: str) -> list[str]:
    """Return what a new process computes, how often from the disk, and of what it warned."""
    package = folder / "called_kernels"
    if not package.exists():
        package.mkdir()
        (package / "__init__.py").write_text("", encoding="utf-8")
        (package / "outer.py").write_text(CALLING, encoding="utf-8")
        (package / "inner.py").write_text(CALLED.format(added=1.0), encoding="utf-8")
    command = [sys.executable, *options, "-c", COMPUTED.format(before=before)]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "code")}
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=True, env=environment
    )
    return done.stdout.split()


# Numba marks what it compiles by the number of times that it found it on the disk.
FRESH, FROM_DISK = "0", "1"


def test_python_without_assertions_finds_the_same_code(tmp_path: Path) -> None:
    """Of a function with one, whose bytecode is another then."""
    assert computed(tmp_path) == ["4.0", FRESH]
    assert computed(tmp_path, "pass", "-OO") == ["4.0", FROM_DISK]


def test_damaged_files_of_a_real_function_are_compiled_anew(tmp_path: Path) -> None:
    assert computed(tmp_path) == ["4.0", FRESH]
    assert computed(tmp_path) == ["4.0", FROM_DISK]
    for ending in ("nbi", "nbc"):
        (path,) = tmp_path.rglob(f"outer*.{ending}")
        # In the middle of the machine code, where nothing but the checksum would notice it.
        damaged = bytearray(path.read_bytes())
        damaged[len(damaged) // 2] ^= 1
        path.write_bytes(damaged)
        assert computed(tmp_path) == ["4.0", FRESH, "CodeNotKept"]
        assert computed(tmp_path) == ["4.0", FROM_DISK]


def test_a_disk_without_room_or_a_lost_folder_costs_time_only(tmp_path: Path) -> None:
    full = """
    import resource, signal
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
    """.replace("\n    ", "; ").strip("; \n")
    assert computed(tmp_path, full) == ["4.0", FRESH, "CodeNotKept"]
    assert not list(tmp_path.rglob("*.tmp.*"))
    lost = "import shutil; shutil.rmtree(outer._cache.cache_path); "
    lost += "Path(outer._cache.cache_path).write_text('no folder')"
    assert computed(tmp_path, lost) == ["4.0", FRESH, "CodeNotKept"]
    next(path for path in (tmp_path / "code").iterdir() if path.is_file()).unlink()
    assert computed(tmp_path) == ["4.0", FRESH]
    assert computed(tmp_path) == ["4.0", FROM_DISK]

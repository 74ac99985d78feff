"""Where machine code is kept: nowhere where others could put something that would be run."""

from __future__ import annotations

import logging
import os
import tempfile
from pathlib import Path

import pytest

from fuzzy2.support import code_folder as module
from fuzzy2.support.code_folder import code_folder, forget_code, is_private, name_for


@pytest.fixture
def caches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder for the caches of a user who has chosen nothing else."""
    home, temporary = tmp_path / "home", tmp_path / "temporary"
    for folder, mode in ((home, 0o755), (temporary, 0o1777)):
        folder.mkdir()
        folder.chmod(mode)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    module._first_that_serves.cache_clear()
    return home / ".cache"


def private_one(tmp_path: Path) -> Path:
    return tmp_path / "temporary" / f"psp3-{os.getuid()}"


def test_code_is_kept_in_the_cache_of_the_user(
    caches: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert code_folder() == caches / "psp3"
    assert (caches / "psp3").stat().st_mode & 0o777 == 0o700
    assert not caplog.records


@pytest.mark.parametrize(("wanted", "is_taken"), [("{}/elsewhere", True), ("elsewhere", False)])
def test_the_standard_variable_names_another_cache(
    wanted: str,
    is_taken: bool,
    caches: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", wanted.format(tmp_path))
    assert code_folder() == (tmp_path / "elsewhere" / "psp3" if is_taken else caches / "psp3")


def test_who_names_a_folder_for_numba_gets_it(
    caches: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "chosen"))
    assert code_folder() == tmp_path / "chosen"
    # One that cannot be there is as none.
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    assert code_folder() == caches / "psp3"


def bar(caches: Path) -> None:
    caches.touch()


def open_to_all(caches: Path) -> None:
    (caches / "psp3").mkdir(parents=True)
    (caches / "psp3").chmod(0o777)


def open_above(caches: Path) -> None:
    caches.mkdir()
    caches.chmod(0o777)


def lead_elsewhere(caches: Path) -> None:
    (caches / "others").mkdir(parents=True)
    (caches / "psp3").symlink_to(caches / "others")


FAULTS = [bar, open_to_all, open_above, lead_elsewhere]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_folder_that_others_could_write_to_is_not_taken(
    fault: object, caches: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """But a private one below the temporary directory, which is said once."""
    assert callable(fault)
    fault(caches)
    with caplog.at_level(logging.WARNING):
        assert code_folder() == code_folder() == private_one(tmp_path)
    (record,) = caplog.records
    assert str(private_one(tmp_path)) in record.getMessage()
    assert private_one(tmp_path).stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("fault", ["link", "open"])
def test_who_had_the_private_name_first_gets_nothing_run(
    fault: str, caches: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    bar(caches)
    if fault == "link":
        (tmp_path / "theirs").mkdir()
        private_one(tmp_path).symlink_to(tmp_path / "theirs")
    else:
        private_one(tmp_path).mkdir()
        private_one(tmp_path).chmod(0o777)
    with caplog.at_level(logging.WARNING):
        assert code_folder() is None
    (record,) = caplog.records
    assert "NUMBA_CACHE_DIR" in record.getMessage()


def test_a_folder_of_somebody_else_is_not_private(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "own"
    own.mkdir(mode=0o700)
    assert is_private(own)
    monkeypatch.setattr(os, "getuid", lambda: own.stat().st_uid + 1)
    assert not is_private(own)


def test_what_is_not_there_is_not_private(tmp_path: Path) -> None:
    assert not is_private(tmp_path / "nothing")


def test_code_of_a_package_is_forgotten_and_no_other(caches: Path, tmp_path: Path) -> None:
    for package in ("one", "one/inner", "other"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "module.py").touch()
        folder = caches / "psp3" / name_for(tmp_path / package)
        folder.mkdir(parents=True)
        for name in ("index.nbi", "code.nbc"):
            (folder / name).touch()
    forget_code(tmp_path / "one")
    left = {path.parent.name for path in (caches / "psp3").rglob("*.nb?")}
    assert left == {name_for(tmp_path / "other")}

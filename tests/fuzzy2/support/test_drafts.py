"""Drafts that nobody holds are removed, and those that somebody writes are not."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from typing import IO, Any

import pytest

from fuzzy2.support import drafts
from fuzzy2.support.drafts import clear_drafts, is_draft, new_draft


def opened(path: str) -> IO[Any]:
    return open(path, "x", encoding="utf-8")


def test_a_draft_is_there_as_long_as_it_is_open(tmp_path: Path) -> None:
    path, file = new_draft(str(tmp_path), opened)
    assert is_draft(path)
    clear_drafts(str(tmp_path))
    assert os.path.exists(path)
    file.close()
    clear_drafts(str(tmp_path))
    assert not os.path.exists(path)


@pytest.mark.parametrize("name", [".fuzzy2-0.part", f"fuzzy2-{'0' * 16}.part", "text.part"])
def test_other_names_are_none_of_drafts(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    clear_drafts(str(tmp_path))
    assert (tmp_path / name).read_text() == "mine"


def test_neither_links_nor_folders_of_such_a_name_are_followed(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine")
    (tmp_path / f".fuzzy2-{'0' * 16}.part").symlink_to("mine")
    (tmp_path / f".fuzzy2-{'1' * 16}.part").mkdir()
    clear_drafts(str(tmp_path))
    assert (tmp_path / "mine").read_text() == "mine"
    assert len(os.listdir(tmp_path)) == 3


def test_a_folder_that_is_not_there_is_no_error(tmp_path: Path) -> None:
    clear_drafts(str(tmp_path / "nowhere"))


@pytest.mark.parametrize("removed", [True, False])
def test_a_draft_that_is_cleared_before_it_is_locked_is_made_anew(
    tmp_path: Path, removed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the moment after the first one is made another process locks it, and removes it or not."""
    taken: list[int] = []

    def opened_and_found(path: str) -> IO[Any]:
        file = opened(path)
        if not taken:
            taken.append(os.open(path, os.O_RDWR))
            fcntl.flock(taken[0], fcntl.LOCK_EX)
            if removed:
                os.unlink(path)
                os.close(taken[0])
        return file

    path, file = new_draft(str(tmp_path), opened_and_found)
    assert os.listdir(tmp_path) == [os.path.basename(path)]
    file.close()


def test_without_locks_nothing_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(descriptor: int, operation: int) -> None:
        raise OSError("no locks")

    monkeypatch.setattr(drafts.fcntl, "flock", none)
    path, file = new_draft(str(tmp_path), opened)
    file.close()
    clear_drafts(str(tmp_path))
    assert os.path.exists(path)

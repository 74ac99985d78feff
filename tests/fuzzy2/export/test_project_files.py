"""A folder holds one export, and no work of a user is lost."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from pathlib import Path

import pytest

import fuzzy2
from fuzzy2.errors import FileInTheWay
from fuzzy2.export.project import export_project
from fuzzy2.export.project_files import LIST, replace_files
from tests.project_folder import make, needs_c

SYSTEM = fuzzy2.Type1System(
    [[fuzzy2.Gaussian(m, 1.0) for m in (-1.0, 1.0)]],
    [[0], [1]],
    [[1.0], [2.0]],
    input_ranges=[(-2.0, 2.0)],
)


def contents(folder: Path) -> dict[str, str]:
    """Return all files of a folder."""
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def test_a_second_export_is_as_if_it_were_the_first(tmp_path: Path) -> None:
    export_project(SYSTEM, tmp_path / "both", name="one")
    export_project(SYSTEM, tmp_path / "both", name="other", precision="single")
    export_project(SYSTEM, tmp_path / "second", name="other", precision="single")
    assert contents(tmp_path / "both") == contents(tmp_path / "second")
    assert "one.c" not in contents(tmp_path / "both")


@needs_c
def test_what_was_made_does_not_matter(tmp_path: Path) -> None:
    """Programs of the first export are made anew, since their sources are newer."""
    export_project(SYSTEM, tmp_path, name="one")
    assert "passed" in make(tmp_path, "test")
    export_project(SYSTEM, tmp_path, name="other")
    assert "passed" in make(tmp_path, "test")


def test_the_list_says_what_was_written(tmp_path: Path) -> None:
    paths = replace_files({"a.c": "int a;\n", "b.h": "µ\n"}, tmp_path / "there")
    assert (
        {path.name for path in paths} == set(contents(tmp_path / "there")) == {"a.c", "b.h", LIST}
    )
    for line in (tmp_path / "there" / LIST).read_text(encoding="utf-8").splitlines():
        digest, name = line.split("  ")
        content = (tmp_path / "there" / name).read_bytes()
        assert hashlib.sha256(content).hexdigest() == digest
    if shutil.which("sha256sum"):
        subprocess.run(
            ["sha256sum", "--check", "--quiet", LIST], cwd=tmp_path / "there", check=True
        )


def test_files_of_a_user_are_not_written_over(tmp_path: Path) -> None:
    """Neither those that were there first, nor those of an export that were changed."""
    (tmp_path / "main.c").write_text("int main(void) { return 0; }\n")
    before = contents(tmp_path)
    with pytest.raises(FileInTheWay, match=r"main\.c exists.*move or delete it"):
        export_project(SYSTEM, tmp_path, name="one")
    assert contents(tmp_path) == before
    (tmp_path / "main.c").unlink()
    export_project(SYSTEM, tmp_path, name="one")
    with (tmp_path / "Makefile").open("a") as file:
        file.write("# mine\n")
    before = contents(tmp_path)
    with pytest.raises(FileInTheWay, match="Makefile"):
        export_project(SYSTEM, tmp_path, name="other")
    assert contents(tmp_path) == before


def test_what_a_user_changed_or_added_stays(tmp_path: Path) -> None:
    """Also where the next export has no file of the name, or the list was spoilt."""
    replace_files({"a.c": "a", "b.c": "b", "c.c": "c"}, tmp_path)
    (tmp_path / "a.c").write_text("changed")
    (tmp_path / "b.c").unlink()
    (tmp_path / "mine.c").write_text("mine")
    replace_files({"d.c": "d"}, tmp_path)
    assert set(contents(tmp_path)) == {"a.c", "mine.c", "d.c", LIST}
    (tmp_path / LIST).write_text("../escape\nnothing\n")
    replace_files({"d.c": "d", "e.c": "e"}, tmp_path)
    assert set(contents(tmp_path)) == {"a.c", "mine.c", "d.c", "e.c", LIST}


def test_the_list_leads_out_of_no_folder(tmp_path: Path) -> None:
    outside, folder = tmp_path / "outside.c", tmp_path / "folder"
    outside.write_text("mine")
    replace_files({"a.c": "a"}, folder)
    digest = hashlib.sha256(b"mine").hexdigest()
    (folder / LIST).write_text(f"{digest}  ../outside.c\n")
    replace_files({"b.c": "b"}, folder)
    assert outside.read_text() == "mine"

"""Names in exported C: a compiler finds nothing of them but comments and strings."""

from __future__ import annotations

import dataclasses
import re
import subprocess
from pathlib import Path

import pytest

import fuzzy2
import psp3
from fuzzy2.errors import NotExportable
from fuzzy2.export.c_text import comment
from fuzzy2.export.project import export_project
from psp3.drives.drive import Drive
from psp3.export.fmu_glue import _text, glue
from psp3.export.fmu_plant import plant_model
from psp3.export.robot_text import LONGEST, prefix_of

NAMES = (
    "*/ int evil; /*",
    "*\\\n/ int evil; /*",
    "*\\ \n/ int evil; /*",
    "*\\\r\n/ int evil; /*",
    "*??/\n/ int evil; /*",
    "*??/ \n/ int evil; /*",
    "**//int evil;",
    "/*/ int evil; /*/",
    '"; int evil; "',
    '\\"; int evil; "',
    '??/"; int evil; "',
    "\x1b\x00\x07\n%s%n",
    "\\",
    "\u202e",
)


def preprocessed(text: str, folder: Path) -> str:
    """Return C without comments and strings, trigraphs and joined lines as C99 has them."""
    file = folder / "tried.c"
    file.write_bytes(text.encode())
    command = ["gcc", "-std=c99", "-pedantic-errors", "-fsyntax-only", str(file)]
    subprocess.run(command, check=True, capture_output=True)
    command = ["gcc", "-std=c99", "-E", "-P", str(file)]
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return re.sub(r'"(\\.|[^"\\\n])*"', '""', out)


@pytest.mark.parametrize("name", NAMES, ids=repr)
def test_a_name_ends_no_comment_and_no_string(name: str, tmp_path: Path) -> None:
    text = f"/* {comment(name)} */\n/*\n * {comment(name)}\n */\nchar *const a = {_text(name)};\n"
    assert preprocessed(text, tmp_path).split() == ["char", "*const", "a", "=", '"";']


def test_titles_of_robots_are_comments_of_their_code(tmp_path: Path) -> None:
    model = plant_model(psp3.load("five_bar"), "five_bar", 0.002, 1, Drive(), None)
    shown = 0
    for name in NAMES:
        try:
            named = dataclasses.replace(model, title=name)
        except NotExportable:  # XML has no word for some characters
            continue
        header, shown = glue(named, "guid"), shown + 1
        begin = header.partition("#ifndef")[0]
        assert preprocessed(begin + "int a;", tmp_path).split() == ["int", "a;"]
    assert shown > len(NAMES) // 2


def test_names_of_a_system_are_cells_of_its_readme(tmp_path: Path) -> None:
    name = "<script>a</script>|b"
    terms = [fuzzy2.Gaussian(0.0, 1.0), fuzzy2.Gaussian(1.0, 1.0)]
    system = fuzzy2.Type1System(
        [terms], [[0], [1]], [[1.0], [2.0]], input_names=[name], output_names=[name]
    )
    export_project(system, tmp_path)
    text = (tmp_path / "README.md").read_text("utf-8")
    assert "<script" not in text
    assert "&lt;script>a&lt;/script>\\|b" in text


@pytest.mark.parametrize("name", [*NAMES, "../../etc/passwd", "a" * 5000, "-x", "CON"], ids=ascii)
def test_files_are_not_called_what_a_name_says(name: str) -> None:
    assert re.fullmatch(rf"[A-Za-z]\w{{,{LONGEST - 1}}}", prefix_of(name), re.ASCII)

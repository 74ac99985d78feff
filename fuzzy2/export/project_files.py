"""Files of an exported folder: those of an earlier export are replaced, those of the user are kept.

Beside the files stands a list of them with their hashes, as ``sha256sum`` writes it. What is in it,
with the same hash, is what was exported and nobody's work.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path

from fuzzy2.errors import FileInTheWay
from fuzzy2.support.text_files import made_folder, read_text, write_text

LIST = "files.sha256"
"""The list; ``sha256sum -c files.sha256`` tells which files are not as they were exported."""


def replace_files(texts: Mapping[str, str], folder: Path) -> list[Path]:
    """Write files and a list of them, remove those of an export before, and return their paths.

    Files of an export before that are not written again are removed, unless they were changed.

    Parameters
    ----------
    texts : mapping of str to str
        What is to be in each file, by its name.
    folder : Path
        Where; it is made if it is not there.

    Raises
    ------
    FileInTheWay
        If one of the files is there and is not as an export before left it. Nothing is written.
    """
    former = _former(folder)
    for name, text in texts.items():
        path = folder / name
        if path.exists() and name not in former and not _is(path, _hash(text.encode())):
            raise FileInTheWay(str(path))
    made_folder(folder)
    for name, text in texts.items():
        write_text(text, folder / name)
    for name in former - set(texts):
        (folder / name).unlink()
    lines = [f"{_hash(text.encode())}  {name}\n" for name, text in texts.items()]
    write_text("".join(lines), folder / LIST)
    return [folder / name for name in (*texts, LIST)]


def _former(folder: Path) -> set[str]:
    """Return the names of files that are as an export before left them."""
    if not (folder / LIST).is_file():
        return set()
    listed = re.findall(r"^([0-9a-f]{64})  ([\w.]+)$", read_text(folder / LIST), flags=re.M)
    return {name for digest, name in listed if _is(folder / name, digest)}


def _is(path: Path, digest: str) -> bool:
    """Tell whether a file has a hash."""
    return path.is_file() and _hash(path.read_bytes()) == digest


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()

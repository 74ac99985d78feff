"""Files of an exported folder: an earlier export is replaced, and the user's files are kept.

The folder contains a list of the files with their hashes, in the format of ``sha256sum``. A file in
the list with the same hash was exported and has not been edited.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path

from fuzzy2.errors import FileInTheWay
from fuzzy2.support.text_files import made_folder, read_text, write_text

LIST = "files.sha256"
"""Name of the list; ``sha256sum -c files.sha256`` reports edited files."""


def replace_files(texts: Mapping[str, str], folder: Path) -> list[Path]:
    """Write files and a list of them, remove files of an earlier export, and return the paths.

    Files of an earlier export that are not written again are removed unless they were edited.

    Parameters
    ----------
    texts : mapping of str to str
        Content of each file, by name.
    folder : Path
        The folder, which is created if necessary.

    Raises
    ------
    FileInTheWay
        If one of the files exists and was not left there unchanged by an export. Nothing is written
        then.
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
    """Return the names of files that an earlier export left and nobody has edited."""
    if not (folder / LIST).is_file():
        return set()
    listed = re.findall(r"^([0-9a-f]{64})  ([\w.]+)$", read_text(folder / LIST), flags=re.M)
    return {name for digest, name in listed if _is(folder / name, digest)}


def _is(path: Path, digest: str) -> bool:
    """Return whether a file has a given hash."""
    return path.is_file() and _hash(path.read_bytes()) == digest


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()

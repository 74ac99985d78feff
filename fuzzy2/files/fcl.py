"""Systems as files of the Fuzzy Control Language (``.fcl``), IEC 61131-7."""

from __future__ import annotations

import os

from fuzzy2.files.engine import AnySystem
from fuzzy2.files.fcl_reader import FclReader
from fuzzy2.support.text_files import read_text


def parse_fcl(text: str, source: str = "text", block: str | None = None, dialect: str = "iec") -> AnySystem:
    return FclReader(text, source, block, dialect).system()


def read_fcl(path: str | os.PathLike[str], block: str | None = None, dialect: str = "iec") -> AnySystem:
    return parse_fcl(read_text(path), str(path), block, dialect)

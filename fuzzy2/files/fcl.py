"""Systems as files of the Fuzzy Control Language (``.fcl``), IEC 61131-7.

A file consists of function blocks. In addition to the points and singletons of the standard, the
shapes of jFuzzyLogic and fuzzylite are read. Names are case-insensitive. Methods integrate exactly,
as in the standard; with ``dialect="jfuzzylogic"`` they sum up 1000 points as that program does.
Formulas (``FUNCTION``) may use the inputs, and the outputs that precede them.

The standard leaves some points open. A block that only defines AND has the dual OR, and without any
definition AND is ``MIN`` and ``ACT`` is ``MIN``. ``COGS`` accumulates equal singletons before it
averages them if an accumulation is given, and adds them up otherwise. If a term or a name is
defined twice, the last definition is used. An output in a condition stands for the preceding rules
that conclude it. ``DEFAULT := NC`` (no change) gives NaN, because a system has no memory. AND binds
tighter than OR. An output without ``RANGE`` has the range of its terms, where Gaussians extend to 4
standard deviations.

Terms whose numbers are variables, ``SINGLETONS``, and ``log`` in a formula are refused with a
message. The latter is the natural logarithm in fuzzylite and the decimal one in jFuzzyLogic.
"""

from __future__ import annotations

import os
from pathlib import Path

from fuzzy2.files.engine import AnySystem
from fuzzy2.files.engine_writer import engine_of
from fuzzy2.files.fcl_reader import FclReader
from fuzzy2.files.fcl_writer import FclWriter
from fuzzy2.support.text_files import read_text, write_text


def parse_fcl(
    text: str, source: str = "text", block: str | None = None, dialect: str = "iec"
) -> AnySystem:
    """Return the system that the text of a ``.fcl`` file describes; see :func:`read_fcl`.

    Parameters
    ----------
    text : str
        The text.
    source : str
        Name of the text in error messages.
    block : str, optional
        Name of the function block; required if there are several.
    dialect : {"iec", "jfuzzylogic"}
        Whether methods integrate exactly, or sum up points as jFuzzyLogic does.

    Returns
    -------
    Type1System or ParallelSystem
        The system.

    Raises
    ------
    MalformedFile
        If the text is not such a file; ``place`` is the line.
    NotExpressible
        If this package cannot represent the system; the message names the line.
    UnknownName
        If there is no such block.
    InvalidValue
        If there are several blocks and ``block`` is not given; the message lists them.
    """
    return FclReader(text, source, block, dialect).system()


def read_fcl(
    path: str | os.PathLike[str], block: str | None = None, dialect: str = "iec"
) -> AnySystem:
    """Return the system of a function block of a ``.fcl`` file.

    Parameters
    ----------
    path : str or path-like
        The file.
    block : str, optional
        Name of the function block; required if there are several.
    dialect : {"iec", "jfuzzylogic"}
        Whether methods integrate exactly, or sum up points as jFuzzyLogic does.

    Returns
    -------
    Type1System or ParallelSystem
        The system; a ParallelSystem if outputs have different operators.

    Raises
    ------
    MalformedFile
        If it is not such a file; ``place`` is the line.
    NotExpressible
        If this package cannot represent the system; the message names the line.
    UnknownName
        If there is no such block.
    InvalidValue
        If there are several blocks and ``block`` is not given; the message lists them.
    OSError
        If the file cannot be read.
    """
    return parse_fcl(read_text(path), str(path), block, dialect)


def format_fcl(system: AnySystem, name: str = "system") -> str:
    """Return a system as the text of a ``.fcl`` file; see :func:`write_fcl`.

    Parameters
    ----------
    system : Type1System or ParallelSystem
        The system.
    name : str
        Name of the function block.

    Returns
    -------
    str
        The text.

    Raises
    ------
    NotExpressible
        If the format cannot express the system.
    """
    return FclWriter(engine_of(system, name, ".fcl"), ".fcl").text()


def write_fcl(system: AnySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to a ``.fcl`` file.

    Parameters
    ----------
    system : Type1System or ParallelSystem
        The system. If it integrates, it must do so exactly, ``integration="exact"``.
    path : str or path-like
        The file; an existing file is replaced.

    Raises
    ------
    NotExpressible
        If the format cannot express the system.
    FileNotWritten
        If the file cannot be written; an existing file is kept.
    """
    write_text(format_fcl(system, Path(path).stem), path)

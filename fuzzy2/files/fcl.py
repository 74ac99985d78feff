"""Systems as files of the Fuzzy Control Language (``.fcl``), IEC 61131-7.

Its function blocks, with the shapes of jFuzzyLogic and fuzzylite beside its points and singletons;
upper and lower case are the same. Methods integrate exactly, as the standard has it; with
``dialect="jfuzzylogic"`` they sum up 1000 points as that program does. Formulas (``FUNCTION``) are
of the inputs, and of outputs before theirs.

Where the standard leaves something open: a block that says only what AND means has the dual OR (AND
``MIN`` and ``ACT : MIN`` if it says nothing); ``COGS`` accumulates equal singletons before it
averages them if an accumulation is given, and adds them up if none is; a term or a name given twice
is the last one; an output in a condition stands for the rules that spoke of it before;
``DEFAULT := NC`` (no change) gives NaN, for a system does not remember; AND binds tighter than OR.
An output without ``RANGE`` has that of its terms, Gaussians up to 4 standard deviations.

Refused by name are terms whose numbers are variables, ``SINGLETONS``, and ``log`` in a formula,
which is natural in fuzzylite and decimal in jFuzzyLogic.
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
        What error messages call it.
    block : str, optional
        Name of the function block; needed where there are several.
    dialect : {"iec", "jfuzzylogic"}
        Whether methods integrate, or sum up as jFuzzyLogic does.

    Returns
    -------
    Type1System or ParallelSystem
        The system.

    Raises
    ------
    MalformedFile
        If the text is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    UnknownName
        If there is no such block.
    InvalidValue
        If there are several blocks and none is named; it names them.
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
        Name of the function block; needed where there are several.
    dialect : {"iec", "jfuzzylogic"}
        Whether methods integrate, or sum up as jFuzzyLogic does.

    Returns
    -------
    Type1System or ParallelSystem
        The latter if outputs differ in their operators.

    Raises
    ------
    MalformedFile
        If it is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    UnknownName
        If there is no such block.
    InvalidValue
        If there are several blocks and none is named; it names them.
    OSError
        If it cannot be read.
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
        If the format has no way to write the system.
    """
    return FclWriter(engine_of(system, name, ".fcl"), ".fcl").text()


def write_fcl(system: AnySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to a ``.fcl`` file.

    Parameters
    ----------
    system : Type1System or ParallelSystem
        The system. Those that integrate must do so exactly, ``integration="exact"``.
    path : str or path-like
        The file; one that exists is replaced whole.

    Raises
    ------
    NotExpressible
        If the format has no way to write the system.
    FileNotWritten
        If the file cannot be written; what was there before remains.
    """
    write_text(format_fcl(system, Path(path).stem), path)

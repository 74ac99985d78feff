"""Systems as files of fuzzylite (``.fll``).

Reader and writer follow fuzzylite 8: its terms, hedges and norms, the midpoint rule of its
integrals (``integration="midpoint"``, with 1000 points if a file gives no number), weighted
averages and sums, and Tsukamoto's terms, whose points may lie outside the range. Outputs with
different operators become a :class:`fuzzy2.ParallelSystem`. An output in a condition stands for the
preceding rules that conclude it. A *Function* is a formula of the inputs and of preceding outputs,
or, as a membership function, a formula of x.

Three features of fuzzylite are easily overlooked. A hedge in a conclusion also applies to the
following conclusions of the rule. If several terms have the same name, the last one is used. With
an aggregation, weighted averages first aggregate the rules that conclude the same term (version 6
adds them up, as both versions do with ``aggregation: none``). With ``lock-previous``, an output
without a firing rule is NaN, which means that there is no new value: a system has no memory, but
its caller may keep the last value.

The following are refused with a message: ``lock-previous`` with a default, activations other than
*General*, disabled variables, ``lock-range`` where it has an effect, formulas of variables other
than x as membership functions, and different operators in the rules of one output.
"""

from __future__ import annotations

import os
from pathlib import Path

from fuzzy2.files.engine import AnySystem
from fuzzy2.files.engine_writer import engine_of
from fuzzy2.files.fll_reader import FllReader
from fuzzy2.files.fll_writer import FllWriter
from fuzzy2.support.text_files import read_text, write_text


def parse_fll(text: str, source: str = "text") -> AnySystem:
    """Return the system that the text of a ``.fll`` file describes; see :func:`read_fll`.

    Parameters
    ----------
    text : str
        The text.
    source : str
        Name of the text in error messages.

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
    """
    return FllReader(text, source).system()


def read_fll(path: str | os.PathLike[str]) -> AnySystem:
    """Return the system of a ``.fll`` file of fuzzylite.

    Parameters
    ----------
    path : str or path-like
        The file.

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
    OSError
        If the file cannot be read.
    """
    return parse_fll(read_text(path), str(path))


def format_fll(system: AnySystem, name: str = "system") -> str:
    """Return a system as the text of a ``.fll`` file; see :func:`write_fll`.

    Parameters
    ----------
    system : Type1System or ParallelSystem
        The system.
    name : str
        Its name in the file.

    Returns
    -------
    str
        The text.

    Raises
    ------
    NotExpressible
        If the format cannot express the system.
    """
    return FllWriter(engine_of(system, name, ".fll"), ".fll").text()


def write_fll(system: AnySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to a ``.fll`` file of fuzzylite.

    Parameters
    ----------
    system : Type1System or ParallelSystem
        The system. If it integrates, it must do so as fuzzylite does, ``integration="midpoint"``.
    path : str or path-like
        The file; an existing file is replaced.

    Raises
    ------
    NotExpressible
        If the format cannot express the system.
    FileNotWritten
        If the file cannot be written; an existing file is kept.
    """
    write_text(format_fll(system, Path(path).stem), path)

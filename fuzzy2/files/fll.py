"""Systems as files of fuzzylite (``.fll``).

What is read and written is what fuzzylite 8 does: its terms, its hedges and norms, the midpoint
rule of its integrals (``integration="midpoint"``, 1000 points if a file gives no number), weighted
averages and sums, Tsukamoto's terms anywhere, within the range or not. Outputs with operators of
their own become a :class:`fuzzy2.ParallelSystem`. An output in a condition stands for the rules
that spoke of it before. A *Function* is a formula of the inputs and of outputs before it, or as a
membership function of x.

Three things that fuzzylite does are easily overlooked: a hedge in a conclusion goes on to the
conclusions after it in the same rule; of terms with one name the last one counts; and under an
aggregation, weighted averages first aggregate the rules that conclude the same term (version 6 adds
them up, as both do with ``aggregation: none``). With ``lock-previous`` an output without a firing
rule is NaN, which says that there is nothing new: a system does not remember, its caller may.

Refused by name are ``lock-previous`` beside a default, activations other than *General*, disabled
variables, ``lock-range`` where it would change something, membership functions by formula of other
variables than x, and different operators in rules of one output.
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
        What error messages call it.

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
        The latter if outputs differ in their operators.

    Raises
    ------
    MalformedFile
        If it is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    OSError
        If it cannot be read.
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
        If the format has no way to write the system.
    """
    return FllWriter(engine_of(system, name, ".fll"), ".fll").text()


def write_fll(system: AnySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to a ``.fll`` file of fuzzylite.

    Parameters
    ----------
    system : Type1System or ParallelSystem
        The system. Those that integrate must do so as fuzzylite does, ``integration="midpoint"``.
    path : str or path-like
        The file; one that exists is replaced whole.

    Raises
    ------
    NotExpressible
        If the format has no way to write the system.
    FileNotWritten
        If the file cannot be written; what was there before remains.
    """
    write_text(format_fll(system, Path(path).stem), path)

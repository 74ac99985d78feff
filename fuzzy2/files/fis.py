"""Systems as files of MATLAB's Fuzzy Logic Toolbox (``.fis``), type-1 and interval type-2.

Three layouts are known by what is in them:

* type-1 (version 2): ``MF1='poor':'gaussmf',[1.5 0]``;
* type-2 of the Fuzzy Logic Toolbox (version 3): ``MF1='low':'trimf',[0 1 2],[0.8],[0.1 0.1]``, the
  upper membership function with the scale of the lower one and its lags on both sides, the grades
  of the upper one at which the lower one begins;
* type-2 of the open IT2-FLS toolbox by Taskin and Kumbasar (``.t2fis``):
  ``MF1U='low':'trimf',[0 1 2 1]`` and ``MF1L=...``, any two membership functions, with a height
  after their parameters.

Rules have weights, *or*, negations, and may be silent about outputs; and, or, implication and
aggregation are independent. A negated output has its complement as a term beside it, called *not*
with its name, and is written as such a negation. The lower membership function of version 3 is
``scale * max(0, (upper - lag) / (1 - lag))``, which is how this package reads MATLAB's
documentation for every shape.

The dialects differ in what they mean. MATLAB's toolbox adds up 101 points for the centroid, and so
does a system that is read. Octave's takes trapezoids between them; it unites Sugeno rules that say
the same number under the aggregation before it averages; its smallest and largest of maxima go by
value, MATLAB's by distance from 0; it has more t-norms, and hedges. fuzzylite's integrals take the
middles of 100 pieces in version 6, of 200 in version 5 and of 1000 in version 7, and a file those
of the version that wrote it; it has more terms, formulas among them, outputs of Tsukamoto and
hybrid systems, whose outputs differ in their operators (:class:`fuzzy2.ParallelSystem`); numbers
add up there, as in its version 6, which wrote most files. A file that says that it is of Octave's
toolkit or of fuzzylite, or has what only they know, is read in their meaning. Where no rule fires a
system answers NaN, as Octave does; MATLAB answers with the middle of the range.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, TypeAlias

from fuzzy2.files.description import description_of
from fuzzy2.files.engine_writer import engine_of
from fuzzy2.files.fis_engine import FUZZYLITE, FisEngineReader, is_of_fuzzylite
from fuzzy2.files.fis_engine_writer import FisEngineWriter
from fuzzy2.files.fis_names import DIALECTS, OPEN_TOOLBOX_SUFFIX, is_of_octave
from fuzzy2.files.fis_reader import FisReader
from fuzzy2.files.fis_rules import OCTAVE
from fuzzy2.files.fis_writer import FisWriter
from fuzzy2.support.checks import known_name
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.system import FuzzySystem

AnySystem: TypeAlias = FuzzySystem | ParallelSystem


def parse_fis(text: str, source: str = "text", dialect: str | None = None) -> AnySystem:
    """Return the system that the text of a ``.fis`` file describes; see :func:`read_fis`.

    Parameters
    ----------
    text : str
        The text.
    source : str
        What error messages call it.
    dialect : {"matlab", "octave", "fuzzylite"}, optional
        Whose meaning it has. By default fuzzylite's or Octave's if the file says that it is of
        theirs, or has what only they know; else MATLAB's.

    Returns
    -------
    Type1System, IntervalType2System or ParallelSystem
        The system.

    Raises
    ------
    MalformedFile
        If the text is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    """
    own = "fuzzylite" if is_of_fuzzylite(text) else "octave" if is_of_octave(text) else "matlab"
    chosen = own if dialect is None else known_name("dialect", dialect, DIALECTS)
    if chosen == "fuzzylite":
        return FisEngineReader(text, source).system()
    return FisReader(text, source, chosen).system()


def read_fis(path: str | os.PathLike[str], dialect: str | None = None) -> AnySystem:
    """Return the system of a MATLAB ``.fis`` file, or of a ``.t2fis`` file of the IT2-FLS toolbox.

    Parameters
    ----------
    path : str or path-like
        The file.
    dialect : {"matlab", "octave", "fuzzylite"}, optional
        Whose meaning it has. By default fuzzylite's or Octave's if the file says that it is of
        theirs, or has what only they know; else MATLAB's.

    Returns
    -------
    Type1System, IntervalType2System or ParallelSystem
        Mamdani systems with the reducer ``"centroid"`` (``"center_of_sums"`` if the file sums), on
        101 points but for fuzzylite's; Sugeno systems with ``"center_of_sets"``.

    Raises
    ------
    MalformedFile
        If it is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    OSError
        If it cannot be read.
    """
    return parse_fis(read_text(path), str(path), dialect)


def format_fis(
    system: AnySystem,
    name: str = "system",
    open_toolbox: bool = False,
    dialect: str = "matlab",
) -> str:
    """Return a system as the text of a ``.fis`` file; see :func:`write_fis`.

    Parameters
    ----------
    system : Type1System, IntervalType2System or ParallelSystem
        The system; the last one for fuzzylite.
    name : str
        Its name in the file.
    open_toolbox : bool
        Whether type-2 sets are written for the IT2-FLS toolbox (``.t2fis``).
    dialect : {"matlab", "octave", "fuzzylite"}
        For which program it is otherwise; see the module.

    Returns
    -------
    str
        The text.

    Raises
    ------
    NotExpressible
        If the format has no way to write the system.
    """
    octave = known_name("dialect", dialect, DIALECTS) == "octave"
    whatever: Any = system
    if dialect == "fuzzylite" and not open_toolbox:
        return FisEngineWriter(engine_of(whatever, name, FUZZYLITE), FUZZYLITE).text()
    where = OPEN_TOOLBOX_SUFFIX if open_toolbox else OCTAVE if octave else ".fis"
    return FisWriter(description_of(whatever, where), name, where).text()


def write_fis(system: AnySystem, path: str | os.PathLike[str], dialect: str = "matlab") -> None:
    """Write a system to a MATLAB ``.fis`` file, or to a ``.t2fis`` file.

    The latter is the IT2-FLS toolbox's, and taken if the name ends so.

    MATLAB's own type-2 files hold only lower membership functions that are the upper one, scaled
    and, if it is a triangle or a trapezoid, with feet further in. The other ones hold any pair, but
    only Sugeno systems.

    Parameters
    ----------
    system : Type1System, IntervalType2System or ParallelSystem
        The system; the last one for fuzzylite.
    path : str or path-like
        The file; one that exists is replaced whole.
    dialect : {"matlab", "octave", "fuzzylite"}
        For which program a ``.fis`` file is.

    Raises
    ------
    NotExpressible
        If the format has no way to write the system.
    FileNotWritten
        If the file cannot be written; what was there before remains.
    """
    target = Path(path)
    open_toolbox = target.suffix.lower() == OPEN_TOOLBOX_SUFFIX
    write_text(format_fis(system, target.stem, open_toolbox, dialect), path)

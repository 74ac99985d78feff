"""Systems as files of MATLAB's Fuzzy Logic Toolbox (``.fis``), type-1 and interval type-2.

Three layouts are recognized by their content:

* type-1 (version 2): ``MF1='poor':'gaussmf',[1.5 0]``;
* type-2 of the Fuzzy Logic Toolbox (version 3): ``MF1='low':'trimf',[0 1 2],[0.8],[0.1 0.1]``, the
  upper membership function, the scale of the lower one, and its lags on both sides, which are the
  grades of the upper function at which the lower one begins;
* type-2 of the open IT2-FLS toolbox by Taskin and Kumbasar (``.t2fis``):
  ``MF1U='low':'trimf',[0 1 2 1]`` and ``MF1L=...``, which are any two membership functions, each
  with its height after its parameters.

Rules have weights, *or* and negations, and need not have a consequent for every output. The
operators of and, or, implication and aggregation are independent. A negated output term is read as
an additional term, its complement, named *not* and the term's name; it is written as a negation
again. The lower membership function of version 3 is ``scale * max(0, (upper - lag) / (1 - lag))``,
which is this package's interpretation of MATLAB's documentation for every shape.

The same file has different meanings in the dialects. MATLAB's toolbox adds up 101 points for the
centroid, and so does a system that is read. Octave's toolkit takes trapezoids between these points,
and it unites Sugeno rules with the same number by the aggregation before it averages. Its smallest
and largest of maxima are chosen by value, MATLAB's by distance from 0. It has more t-norms, and
hedges. fuzzylite's integrals take the middles of 200 pieces in version 5, of 100 in version 6 and
of 1000 in version 7; a file is read with those of the version that wrote it. fuzzylite has more
terms, including formulas, outputs of Tsukamoto systems, and hybrid systems, whose outputs have
different operators (:class:`fuzzy2.ParallelSystem`). Rules with equal numbers are added up, as in
version 6, which wrote most files. A file that names Octave's toolkit or fuzzylite, or uses features
that only they have, is read in that dialect. Where no rule fires, a system returns NaN, as Octave
does; MATLAB returns the middle of the range.
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
        Name of the text in error messages.
    dialect : {"matlab", "octave", "fuzzylite"}, optional
        Dialect of the file. By default it is fuzzylite's or Octave's if the file names the program
        or uses features that only the program has, and MATLAB's otherwise.

    Returns
    -------
    Type1System, IntervalType2System or ParallelSystem
        The system.

    Raises
    ------
    MalformedFile
        If the text is not such a file; ``place`` is the line.
    NotExpressible
        If this package cannot represent the system; the message names the line.
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
        Dialect of the file. By default it is fuzzylite's or Octave's if the file names the program
        or uses features that only the program has, and MATLAB's otherwise.

    Returns
    -------
    Type1System, IntervalType2System or ParallelSystem
        Mamdani systems with the reducer ``"centroid"`` (``"center_of_sums"`` if the file sums), on
        101 points except for fuzzylite's; Sugeno systems with ``"center_of_sets"``.

    Raises
    ------
    MalformedFile
        If it is not such a file; ``place`` is the line.
    NotExpressible
        If this package cannot represent the system; the message names the line.
    OSError
        If the file cannot be read.
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
        The system; a ParallelSystem can only be written for fuzzylite.
    name : str
        Its name in the file.
    open_toolbox : bool
        Whether type-2 sets are written for the IT2-FLS toolbox (``.t2fis``).
    dialect : {"matlab", "octave", "fuzzylite"}
        Program for which other files are written; see the module.

    Returns
    -------
    str
        The text.

    Raises
    ------
    NotExpressible
        If the format cannot express the system.
    """
    octave = known_name("dialect", dialect, DIALECTS) == "octave"
    whatever: Any = system
    if dialect == "fuzzylite" and not open_toolbox:
        return FisEngineWriter(engine_of(whatever, name, FUZZYLITE), FUZZYLITE).text()
    where = OPEN_TOOLBOX_SUFFIX if open_toolbox else OCTAVE if octave else ".fis"
    return FisWriter(description_of(whatever, where), name, where).text()


def write_fis(system: AnySystem, path: str | os.PathLike[str], dialect: str = "matlab") -> None:
    """Write a system to a MATLAB ``.fis`` file, or to a ``.t2fis`` file.

    ``.t2fis`` is the format of the IT2-FLS toolbox, which the suffix of the name selects.

    In MATLAB's own type-2 files, the lower membership function must be the scaled upper one, whose
    feet may be further inside if it is a triangle or a trapezoid. ``.t2fis`` files can hold any
    pair, but only Sugeno systems.

    Parameters
    ----------
    system : Type1System, IntervalType2System or ParallelSystem
        The system; a ParallelSystem can only be written for fuzzylite.
    path : str or path-like
        The file; an existing file is replaced.
    dialect : {"matlab", "octave", "fuzzylite"}
        Program for which a ``.fis`` file is written.

    Raises
    ------
    NotExpressible
        If the format cannot express the system.
    FileNotWritten
        If the file cannot be written; an existing file is kept.
    """
    target = Path(path)
    open_toolbox = target.suffix.lower() == OPEN_TOOLBOX_SUFFIX
    write_text(format_fis(system, target.stem, open_toolbox, dialect), path)

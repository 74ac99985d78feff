"""Systems in the Fuzzy Markup Language of IEEE Std 1855-2016 (FML).

Type-1 systems of Mamdani, and of Takagi, Sugeno and Kang.

The shapes that have a class here are read and written: triangles, trapezoids, shoulders (right and
left linear), Gaussians, rectangles, singletons, linearly interpolated points, Gaussian shoulders,
and S-, Z- and pi-shaped sets. The standard gives a pi shape two parameters and does not say which;
here, as in its reference implementation JFML, they are the left foot and the top, and the right
side mirrors the left one. Complements of all these are kept, and what the modifier ``not`` makes of
a term becomes a term of its own.

One t-norm serves for *and* and for the activation. A rule with *or* becomes one rule for each
alternative, where that is the same: under the maximum. Weights, other modifiers, *else*, other
defuzzifiers than the center of gravity, and the rule bases of Tsukamoto and AnYa are refused with
their line.

Where no rule fires a system answers NaN; so ``defaultValue`` is written ``NaN``, and that of a file
is not used. Terms of outputs that no rule mentions are not kept. A document type declaration is
refused: it could make a small file expand without end, or read other files.

The schema of the standard names the t-norms of Lukasiewicz and the drastic one ``BSUM`` and
``DRS``, like their t-conorms, its text ``BDIF`` and ``DRP``: written are the names of the schema,
read are both.
"""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

from fuzzy2.files.description import description_of
from fuzzy2.files.fml_reader import FmlReader
from fuzzy2.files.fml_writer import document_of
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.system import FuzzySystem


def parse_fml(text: str, source: str = "text") -> FuzzySystem:
    """Return the system that an FML document describes; see :func:`read_fml`.

    Parameters
    ----------
    text : str
        The document.
    source : str
        What error messages call it.

    Returns
    -------
    Type1System
        The system.

    Raises
    ------
    MalformedFile
        If the text is no such document; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    """
    return FmlReader(source).system(text)


def read_fml(path: str | os.PathLike[str]) -> FuzzySystem:
    """Return the system of an FML file.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Type1System
        A Mamdani system with the reducer ``"centroid"``, or a Takagi-Sugeno-Kang system with
        ``"center_of_sets"``.

    Raises
    ------
    MalformedFile
        If it is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    OSError
        If it cannot be read.
    """
    return parse_fml(read_text(path), str(path))


def format_fml(system: FuzzySystem, name: str = "system") -> str:
    """Return a system as an FML document; see :func:`write_fml`.

    Parameters
    ----------
    system : Type1System
        The system.
    name : str
        Its name in the document.

    Returns
    -------
    str
        The document.

    Raises
    ------
    NotExpressible
        If FML has no way to write the system.
    """
    root = document_of(description_of(system, "FML"), name if name.isprintable() else "system")
    ElementTree.indent(root)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        + ElementTree.tostring(root, encoding="unicode")
        + "\n"
    )


def write_fml(system: FuzzySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to an FML file.

    Parameters
    ----------
    system : Type1System
        The system.
    path : str or path-like
        The file; one that exists is replaced whole.

    Raises
    ------
    NotExpressible
        If FML has no way to write the system.
    OSError
        If the file cannot be written; what was there before remains.
    """
    write_text(format_fml(system, Path(path).stem), path)

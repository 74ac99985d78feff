"""Systems in the Fuzzy Markup Language of IEEE Std 1855-2016 (FML).

Type-1 systems of Mamdani, of Takagi, Sugeno and Kang, and of Tsukamoto; and AnYa rule bases, whose
rules ask for clouds of data and say sets (:class:`fuzzy2.AnYaSystem`).

The shapes that have a class here are read and written: triangles, trapezoids, shoulders (right and
left linear), Gaussians, rectangles, singletons, linearly interpolated points, Gaussian shoulders,
and S-, Z- and pi-shaped sets. The standard gives a pi shape two parameters and does not say which;
here, as in its reference implementation JFML, they are the left foot and the top, and the right
side mirrors the left one. Complements of all these are kept. Points of Lagrange's polynomial are
read, cut off at 0 and 1, and terms made of others (circular definitions, aggregated variables).

Rules have weights, *and* or *or*, modifiers, an *else*, and may be silent about outputs. Where
JFML departs from the standard the standard is followed: JFML's ``plus``, ``somewhat``,
``more_or_less`` and ``seldom`` divide whole numbers. Refused with their line are the modifiers
``above``, ``below``, ``norm`` and ``slightly``, custom shapes and operators, cubic and spline
interpolation, several rule bases, operators that differ among outputs or rules, and of AnYa
functions of the inputs as consequents, and outputs of several kinds.

Words are read in any case. ``defaultValue`` is the output where no rule fires, and NaN, which is
written, stands for none. The center of gravity, an integral in the standard, is summed up over
20 001 points, and integrated exactly if there are singletons; a processing instruction, which other
programs pass over, says it of systems of this package. A document type declaration is refused: it
could make a small file expand without end, or read other files.

The schema of the standard names the t-norms of Lukasiewicz and the drastic one ``BSUM`` and
``DRS``, like their t-conorms, its text ``BDIF`` and ``DRP``: written are the names of the schema,
read are both.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeAlias
from xml.etree import ElementTree

from fuzzy2.files.description import description_of
from fuzzy2.files.fml_names import OWN_INSTRUCTION
from fuzzy2.files.fml_reader import FmlReader
from fuzzy2.files.fml_writer import document_of
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.system import FuzzySystem

AnySystem: TypeAlias = FuzzySystem | AnYaSystem
"""What an FML document describes."""


def parse_fml(text: str, source: str = "text") -> AnySystem:
    """Return the system that an FML document describes; see :func:`read_fml`.

    Parameters
    ----------
    text : str
        The document.
    source : str
        What error messages call it.

    Returns
    -------
    Type1System or AnYaSystem
        The system.

    Raises
    ------
    MalformedFile
        If the text is no such document; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    """
    return FmlReader(source).system(text)


def read_fml(path: str | os.PathLike[str]) -> AnySystem:
    """Return the system of an FML file.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Type1System or AnYaSystem
        A Mamdani system with the reducer ``"centroid"``, or a Takagi-Sugeno-Kang system with
        ``"center_of_sets"``; of clouds of data an :class:`fuzzy2.AnYaSystem`.

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


def format_fml(system: AnySystem, name: str = "system") -> str:
    """Return a system as an FML document; see :func:`write_fml`.

    Parameters
    ----------
    system : Type1System or AnYaSystem
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
    clouds = system if isinstance(system, AnYaSystem) else None
    described = system.consequents if isinstance(system, AnYaSystem) else system
    description = description_of(described, "FML")
    root = document_of(description, name if name.isprintable() else "system", clouds)
    ElementTree.indent(root)
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    if description.mamdani:
        integration, points = description.integration, description.resolution
        lines.append(f'<?{OWN_INSTRUCTION} integration="{integration}" resolution="{points}"?>')
    return "\n".join([*lines, ElementTree.tostring(root, encoding="unicode"), ""])


def write_fml(system: AnySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to an FML file.

    Parameters
    ----------
    system : Type1System or AnYaSystem
        The system.
    path : str or path-like
        The file; one that exists is replaced whole.

    Raises
    ------
    NotExpressible
        If FML has no way to write the system.
    FileNotWritten
        If the file cannot be written; what was there before remains.
    """
    write_text(format_fml(system, Path(path).stem), path)

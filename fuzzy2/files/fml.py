"""Systems in the Fuzzy Markup Language of IEEE Std 1855-2016 (FML).

The format holds type-1 systems of Mamdani, of Takagi, Sugeno and Kang, and of Tsukamoto, and AnYa
rule bases, whose antecedents are data clouds and whose consequents are sets
(:class:`fuzzy2.AnYaSystem`).

Shapes for which this package has a class are read and written: triangles, trapezoids, shoulders
(right and left linear), Gaussians, rectangles, singletons, linearly interpolated points, Gaussian
shoulders, and S-, Z- and pi-shaped sets. The standard gives a pi shape two parameters but does not
define them. Here, as in its reference implementation JFML, they are the left foot and the top, and
the right side mirrors the left one. Complements of all these are preserved. Interpolation by
Lagrange's polynomial, limited to [0, 1], and terms made of others (circular definitions, aggregated
variables) are only read.

Rules have weights, *and* or *or*, modifiers and an *else*, and need not have a consequent for every
output. Where JFML departs from the standard, the standard is followed: JFML's ``plus``,
``somewhat``, ``more_or_less`` and ``seldom`` divide integers. The following are refused with their
line: the modifiers ``above``, ``below``, ``norm`` and ``slightly``, custom shapes and operators,
cubic and spline interpolation, several rule bases, different operators for outputs or rules, and in
AnYa rule bases functions of the inputs as consequents and outputs of several kinds.

Keywords are case-insensitive. ``defaultValue`` is the output where no rule fires; NaN, which is
written if there is no default, stands for none. The center of gravity, an integral in the standard,
is summed up over 20 001 points, and integrated exactly if there are singletons. Files of this
package store the integration in a processing instruction, which other programs ignore. A document
type declaration is refused, because it could make a small file expand without end, or read other
files.

The schema of the standard calls the Łukasiewicz and the drastic t-norm ``BSUM`` and ``DRS``, like
their t-conorms, but its text calls them ``BDIF`` and ``DRP``. Both names are read, and those of the
schema are written.
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
        Name of the text in error messages.

    Returns
    -------
    Type1System or AnYaSystem
        The system.

    Raises
    ------
    MalformedFile
        If the text is not such a document; ``place`` is the line.
    NotExpressible
        If this package cannot represent the system; the message names the line.
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
        ``"center_of_sets"``; for data clouds, an :class:`fuzzy2.AnYaSystem`.

    Raises
    ------
    MalformedFile
        If it is not such a file; ``place`` is the line.
    NotExpressible
        If this package cannot represent the system; the message names the line.
    OSError
        If the file cannot be read.
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
        If FML cannot express the system.
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
        The file; an existing file is replaced.

    Raises
    ------
    NotExpressible
        If FML cannot express the system.
    FileNotWritten
        If the file cannot be written; an existing file is kept.
    """
    write_text(format_fml(system, Path(path).stem), path)

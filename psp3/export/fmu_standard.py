"""A version of FMI: the parts of FMUs that differ between versions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from psp3.export.fmu_model import Model


@dataclass(frozen=True)
class Standard:
    """A version of FMI.

    Parameters
    ----------
    version : str
        Its number.
    face : str
        The file with its functions in C.
    platform : str
        Name of the folder of binaries for Linux on x86-64.
    description : callable
        Returns modelDescription.xml of a model, given the model, the identifier of the code, and
        the files to compile.
    about_sources : callable
        Returns files about the sources, by name, given the model and the files to compile.
    """

    version: str
    face: str
    platform: str
    description: Callable[[Model, str, Sequence[str]], str]
    about_sources: Callable[[Model, Sequence[str]], dict[str, str]]

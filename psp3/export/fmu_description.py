"""Common parts of modelDescription.xml in all versions of FMI."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fuzzy2.errors import printable
from psp3.export.fmu_model import Model, Variable
from psp3.version import __version__

BASE_UNITS = {
    "s": {"s": 1},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
}
"""Units by their exponents of SI base units."""


def root_of(model: Model, version: str, token: dict[str, str]) -> Element:
    """Return the outermost element.

    Parameters
    ----------
    model : Model
        The plant or controller.
    version : str
        Version of FMI.
    token : dict of str to str
        The attribute that binds the description to the code.
    """
    about = {"fmiVersion": version, "modelName": model.name, **token}
    return Element(
        "fmiModelDescription",
        about,
        description=printable(model.title),
        generationTool=f"psp3 {__version__}",
        variableNamingConvention="flat",
    )


def add_units(root: Element, units: Iterable[str]) -> None:
    """Add the definitions of units in SI base units."""
    used = sorted(set(units) - {""})
    definitions = SubElement(root, "UnitDefinitions") if used else root
    for name in used:
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(unit, "BaseUnit", {base: str(n) for base, n in BASE_UNITS[name].items()})


def add_settings(root: Element, model: Model) -> None:
    """Add the log category, and the default experiment."""
    categories = SubElement(root, "LogCategories")
    SubElement(
        categories, "Category", name="logStatusError", description="Why something went wrong"
    )
    SubElement(root, "DefaultExperiment", startTime="0.0", stepSize=repr(model.period))


def kind_of(variable: Variable) -> dict[str, str]:
    """Return the attributes for a variable's causality and the source of its first value."""
    of_each = {
        "parameter": {"variability": "fixed", "initial": "exact"},
        "input": {},
        "output": {"initial": "calculated"},
    }
    about = {"description": variable.about, "causality": variable.causality}
    return about | of_each[variable.causality]


def number_of(variable: Variable) -> dict[str, str]:
    """Return the attributes with the first value of a variable, and its unit."""
    number = {"start": repr(variable.start)} if variable.causality != "output" else {}
    return number | ({"unit": variable.unit} if variable.unit else {})


def known_of(model: Model) -> tuple[list[int], list[int]]:
    """Return the variables that each output depends on, in a step and at initialization."""
    inputs = model.of("input") if model.feeds_through else []
    return inputs, inputs or model.of("parameter")


def as_file(root: Element) -> str:
    """Return an element as the text of a file, indented."""
    indent(root)
    head = '<?xml version="1.0" encoding="UTF-8"?>\n'
    return head + tostring(root, encoding="unicode") + "\n"

"""FMI 2.0: its modelDescription.xml, and the layout of an FMU."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from psp3.export.fmu_description import (
    add_settings,
    add_units,
    as_file,
    kind_of,
    known_of,
    number_of,
    root_of,
)
from psp3.export.fmu_model import Model
from psp3.export.fmu_standard import Standard


def description(model: Model, guid: str, sources: Sequence[str]) -> str:
    """Return modelDescription.xml.

    Parameters
    ----------
    model : Model
        The plant or controller.
    guid : str
        The identifier that binds it to the code.
    sources : sequence of str
        Files to compile.
    """
    root = root_of(model, "2.0", {"guid": guid})
    co_simulation = SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        canHandleVariableCommunicationStepSize="false",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    files = SubElement(co_simulation, "SourceFiles")
    for name in sources:
        SubElement(files, "File", name=name)
    add_units(root, (variable.unit for variable in model.variables))
    add_settings(root, model)
    variables = SubElement(root, "ModelVariables")
    for place, variable in enumerate(model.variables):
        names = {"name": variable.name, "valueReference": str(place)}
        element = SubElement(variables, "ScalarVariable", names | kind_of(variable))
        SubElement(element, "Real", number_of(variable))
    _add_structure(root, model)
    return as_file(root)


def _add_structure(root: Element, model: Model) -> None:
    """Add the dependencies of outputs, by the indices of variables, which begin with one."""
    structure = SubElement(root, "ModelStructure")
    for name, known in zip(("Outputs", "InitialUnknowns"), known_of(model), strict=True):
        group = SubElement(structure, name)
        for place in model.of("output"):
            numbers = " ".join(str(one + 1) for one in known)
            SubElement(group, "Unknown", index=str(place + 1), dependencies=numbers)


FMI2 = Standard("2.0", "fmi2.c", "linux64", description, lambda model, sources: {})

"""FMI 3.0: its modelDescription.xml and buildDescription.xml, and the layout of an FMU."""

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


def description(model: Model, token: str, sources: Sequence[str]) -> str:
    """Return modelDescription.xml.

    Parameters
    ----------
    model : Model
        The plant or controller.
    token : str
        The identifier that binds it to the code.
    sources : sequence of str
        Files to compile; buildDescription.xml lists them.
    """
    root = root_of(model, "3.0", {"instantiationToken": token})
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        canHandleVariableCommunicationStepSize="false",
        fixedInternalStepSize=repr(model.period),
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
    )
    add_units(root, ("s", *(variable.unit for variable in model.variables)))
    add_settings(root, model)
    variables = SubElement(root, "ModelVariables")
    for place, variable in enumerate(model.variables):
        names = {"name": variable.name, "valueReference": str(place)}
        SubElement(variables, "Float64", names | kind_of(variable) | number_of(variable))
    SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(len(model.variables)),
        description="time",
        causality="independent",
        variability="continuous",
        unit="s",
    )
    _add_structure(root, model)
    return as_file(root)


def _add_structure(root: Element, model: Model) -> None:
    """Add the dependencies of outputs, by value references."""
    structure = SubElement(root, "ModelStructure")
    for name, known in zip(("Output", "InitialUnknown"), known_of(model), strict=True):
        for place in model.of("output"):
            numbers = " ".join(map(str, known))
            SubElement(structure, name, valueReference=str(place), dependencies=numbers)


def build_description(model: Model, sources: Sequence[str]) -> dict[str, str]:
    """Return buildDescription.xml under its file name."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=model.name)
    files = SubElement(build, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    return {"buildDescription.xml": as_file(root)}


FMI3 = Standard("3.0", "fmi3.c", "x86_64-linux", description, build_description)

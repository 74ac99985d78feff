"""The file modelDescription.xml of an FMU, as FMI 2.0 has it."""

from __future__ import annotations

from xml.etree import ElementTree

from fuzzy2.errors import printable
from psp3.export.fmu_model import Model, Variable
from psp3.version import __version__

BASE_UNITS = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
}
"""Units in those of the SI, by their exponents."""


def description(model: Model, guid: str, sources: list[str]) -> str:
    """Return modelDescription.xml.

    Parameters
    ----------
    model : Model
        The plant or controller.
    guid : str
        What binds it to the code.
    sources : list of str
        Files to compile.
    """
    root = ElementTree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model.name,
        guid=guid,
        description=printable(model.title),
        generationTool=f"psp3 {__version__}",
        variableNamingConvention="flat",
    )
    _add_co_simulation(root, model, sources)
    _add_units(root, model)
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(
        categories, "Category", name="logStatusError", description="Why something went wrong"
    )
    ElementTree.SubElement(root, "DefaultExperiment", startTime="0.0", stepSize=repr(model.period))
    variables = ElementTree.SubElement(root, "ModelVariables")
    for place, variable in enumerate(model.variables):
        _add_variable(variables, variable, place)
    _add_structure(root, model)
    ElementTree.indent(root)
    head = '<?xml version="1.0" encoding="UTF-8"?>\n'
    return head + ElementTree.tostring(root, encoding="unicode") + "\n"


def _add_co_simulation(root: ElementTree.Element, model: Model, sources: list[str]) -> None:
    co_simulation = ElementTree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        canHandleVariableCommunicationStepSize="false",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    files = ElementTree.SubElement(co_simulation, "SourceFiles")
    for name in sources:
        ElementTree.SubElement(files, "File", name=name)


def _add_units(root: ElementTree.Element, model: Model) -> None:
    used = sorted({variable.unit for variable in model.variables} - {""})
    definitions = ElementTree.SubElement(root, "UnitDefinitions")
    for name in used:
        unit = ElementTree.SubElement(definitions, "Unit", name=name)
        exponents = {base: str(power) for base, power in BASE_UNITS[name].items()}
        ElementTree.SubElement(unit, "BaseUnit", exponents)


def _add_variable(parent: ElementTree.Element, variable: Variable, place: int) -> None:
    of_parameter = {"variability": "fixed", "initial": "exact"}
    element = ElementTree.SubElement(
        parent,
        "ScalarVariable",
        {
            "name": variable.name,
            "valueReference": str(place),
            "description": variable.about,
            "causality": variable.causality,
            **(of_parameter if variable.causality == "parameter" else {}),
            **({"initial": "calculated"} if variable.causality == "output" else {}),
        },
    )
    number = {"start": repr(variable.start)} if variable.causality != "output" else {}
    unit = {"unit": variable.unit} if variable.unit else {}
    ElementTree.SubElement(element, "Real", {**number, **unit})


def _add_structure(root: ElementTree.Element, model: Model) -> None:
    """Say which variables outputs depend on: by their numbers, which begin with one."""
    structure = ElementTree.SubElement(root, "ModelStructure")
    inputs = model.of("input") if model.feeds_through else []
    for name, known in (("Outputs", inputs), ("InitialUnknowns", inputs or model.of("parameter"))):
        group = ElementTree.SubElement(structure, name)
        for place in model.of("output"):
            numbers = " ".join(str(one + 1) for one in known)
            ElementTree.SubElement(group, "Unknown", index=str(place + 1), dependencies=numbers)

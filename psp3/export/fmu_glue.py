"""The header model.h of an FMU, which describes the model to the C functions."""

from __future__ import annotations

from collections.abc import Iterable

from fuzzy2.export.c_code import CFunction
from fuzzy2.export.c_text import comment
from psp3.export.fmu_model import Model


def glue(model: Model, guid: str) -> str:
    """Return model.h, between the kernels in C and the functions of FMI.

    Parameters
    ----------
    model : Model
        The plant or controller.
    guid : str
        The identifier that binds it to its modelDescription.xml.
    """
    state = f"{model.code.name}_state" if _has_state(model) else "struct { char none; }"
    return "\n".join(
        [
            f"/* {comment(model.title)}: values, and what begins the model and moves it on. */",
            "#ifndef MODEL_H",
            "#define MODEL_H",
            "",
            f'#include "{model.code.name}.h"',
            "",
            f"#define MODEL_GUID {_text(guid)}",
            f"#define MODEL_PERIOD {model.period!r} /* s */",
            f"#define MODEL_VALUES {len(model.variables)}",
            f"#define MODEL_LONGEST {_longest(model)} /* bytes of a text of the model */",
            "",
            f"typedef {state} model_state;",
            "",
            _table("double", "start", (repr(one.start) for one in model.variables)),
            _table("char", "causality", (f"'{one.causality[0]}'" for one in model.variables)),
            _table("char *const", "names", (_text(one.name) for one in model.variables)),
            "",
            _function("begin", model, [_call(model, model.begin)]),
            _function("show", model, _shown(model)),
            _function("step", model, [_call(model, model.step)]),
            _messages(model),
            "#endif",
            "",
        ]
    )


def _has_state(model: Model) -> bool:
    return any(function.has_state for function in model.code.functions)


def _text(text: str) -> str:
    """Return a text as a C string literal; special characters are escaped as bytes of UTF-8."""
    plain = (
        chr(b) if 32 <= b < 127 and chr(b) not in '"?\\' else f"\\{b:03o}" for b in text.encode()
    )
    return f'"{"".join(plain)}"'


def _longest(model: Model) -> int:
    texts = [*model.messages.values(), *(variable.name for variable in model.variables)]
    return max(len(text.encode()) for text in texts)


def _table(kind: str, name: str, entries: Iterable[str]) -> str:
    rows = "".join(f"    {entry},\n" for entry in entries)
    return f"static const {kind} model_{name}[MODEL_VALUES] = {{\n{rows}}};"


def _call(model: Model, function: CFunction | None, state: str = "state") -> str:
    """Return a statement that calls a function and returns 1 on success."""
    if function is None:
        return "return 1;"
    given = [state] if function.has_state else []
    for argument in function.visible:
        if argument.name == "t":
            given.append("time")
        elif argument.role == "in" and argument.size is None:
            given.append(f"values[{model.places[argument.name]}]")
        else:
            given.append(f"values + {model.places[argument.name]}")
    call = f"{function.name}({', '.join(given)})"
    return f"return {call};" if function.result else f"{call};\n    return 1;"


def _shown(model: Model) -> list[str]:
    """Return the body of the function that writes the outputs before the first step."""
    if not model.feeds_through:
        # A plant writes its outputs when it begins.
        return ["return 1;"]
    # The next step is computed on a copy, so the model's memory does not change.
    if not model.step.has_state:
        return [_call(model, model.step)]
    return ["model_state copy = *state;", _call(model, model.step, "&copy")]


def _function(name: str, model: Model, lines: list[str]) -> str:
    unused = [
        f"(void){argument};"
        for argument in ("state", "values", "time")
        if not any(argument in line for line in lines)
    ]
    time = "" if name == "begin" else ", double time"
    if not time:
        unused = [line for line in unused if "time" not in line]
    declared = [line for line in lines if line.startswith("model_state")]
    body = [*declared, *unused, *(line for line in lines if line not in declared)]
    text = "\n".join(f"    {line}" for line in body)
    return f"static int model_{name}(model_state *state, double *values{time})\n{{\n{text}\n}}\n"


def _messages(model: Model) -> str:
    cases = "".join(
        f"    case {code}:\n        return {_text(said)};\n"
        for code, said in sorted(model.messages.items())
    )
    return (
        "static const char *model_message(int code)\n{\n    switch (code) {\n"
        f'{cases}    default:\n        return "the model failed";\n    }}\n}}\n'
    )

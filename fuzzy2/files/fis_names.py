"""Meaning of the names of operators and methods in ``.fis`` files."""

from __future__ import annotations

import re
from typing import Any

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import SUM

DIALECTS = ("matlab", "octave", "fuzzylite")
"""Programs that interpret ``.fis`` files differently."""

SAMPLE_POINTS = 101
"""Number of points of an output's range that MATLAB uses for the centroid by default."""

OPEN_TOOLBOX_SUFFIX = ".t2fis"

T_NORMS = {
    "min": "min",
    "prod": "product",
    "algebraic_product": "product",
    "bounded_difference": "lukasiewicz",
    "drastic_product": "drastic",
    "einstein_product": "einstein",
    "hamacher_product": "hamacher",
    "nilpotent_minimum": "nilpotent",
}
"""T-norms; the first two are MATLAB's, and all except the last are Octave's."""

T_CONORMS = {
    "max": "max",
    "probor": "probabilistic",
    "algebraic_sum": "probabilistic",
    "bounded_sum": "lukasiewicz",
    "drastic_sum": "drastic",
    "einstein_sum": "einstein",
    "hamacher_sum": "hamacher",
    "nilpotent_maximum": "nilpotent",
}
"""T-conorms; the first two are MATLAB's."""

AGGREGATIONS = {**T_CONORMS, "sum": SUM}

MATLAB_NORMS = ("min", "prod", "max", "probor", "sum")
"""Operators that MATLAB knows."""

KINDS = {"mamdani": "mamdani", "larsen": "mamdani", "sugeno": "sugeno", "tsukamoto": "tsukamoto"}

DEFUZZIFIERS = {
    ("mamdani", "matlab"): {
        "centroid": "centroid",
        "bisector": "bisector",
        "mom": "mean_of_maxima",
        "som": "smallest_absolute_maximum",
        "lom": "largest_absolute_maximum",
    },
    ("mamdani", "octave"): {
        "centroid": "centroid",
        "centroid_integral": "centroid",
        "mom": "mean_of_maxima",
        "som": "smallest_of_maxima",
        "lom": "largest_of_maxima",
    },
    ("sugeno", "matlab"): {"wtaver": "center_of_sets", "wtsum": "weighted_sum"},
    ("sugeno", "octave"): {"wtaver": "center_of_sets", "wtsum": "weighted_sum"},
    ("tsukamoto", "matlab"): {"wtaver": "tsukamoto"},
    ("tsukamoto", "octave"): {"wtaver": "tsukamoto"},
}
"""Defuzzifiers by kind of system and dialect; the first one is the default.

Octave's bisector returns the number of a point instead of the point, and is left out. Its centroid
integrates by trapezoids up to version 0.6.1; the next one calls that ``centroid_integral``.
"""

_OCTAVE = re.compile(
    r"^\s*(?:[#%].*\bfuzzy-logic-toolkit\b"
    r"|(?:And|Or|Imp|Agg|Defuzz)Method\s*=\s*'(?:centroid_integral|algebraic_(?:product|sum)"
    r"|bounded_(?:difference|sum)|(?:drastic|einstein|hamacher)_(?:product|sum))')",
    re.MULTILINE,
)


def is_of_octave(text: str) -> bool:
    """Return whether a file names Octave's toolkit, or uses features that MATLAB does not have.

    fuzzylite uses the same names of norms, so check for fuzzylite first.
    """
    return _OCTAVE.search(text) is not None


REDUCERS = {"karnikmendel": "km", "ekm": "ekm", "iasc": "iasc", "eiasc": "eiasc"}

OPEN_TOOLBOX_REDUCERS = {
    "KM": "km",
    "Karnik-Mendel": "km",
    "EKM": "ekm",
    "IASC": "iasc",
    "EIASC": "eiasc",
    # Exact like the others, with a different search for the same switch points.
    "EODS": "eiasc",
    "WM": "wu_mendel",
    "NT": "nie_tan",
}

_BEGIAN_MELEK_MENDEL = re.compile(r"BMM\s*\(\s*([0-9.eE+-]+)\s*,\s*([0-9.eE+-]+)\s*\)")


def type_reduction(key: str, name: str) -> dict[str, Any]:
    """Return the method of type reduction that a file names, with its shares.

    Raises
    ------
    NotExpressible
        If there is no method of this name.
    """
    known = REDUCERS if key == "TypeReductionMethod" else OPEN_TOOLBOX_REDUCERS
    if name in known:
        return {"method": known[name]}
    if key == "TypeRedMethod" and (found := _BEGIAN_MELEK_MENDEL.fullmatch(name)):
        try:
            return {
                "method": "begian_melek_mendel",
                "shares": (float(found[1]), float(found[2])),
            }
        except ValueError:
            pass
    names = [*known, *(["BMM(a,b)"] if known is OPEN_TOOLBOX_REDUCERS else [])]
    raise NotExpressible(f"{key}={name!r}", "fuzzy2", f"known are {', '.join(names)}")

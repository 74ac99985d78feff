"""A warning where exported code has no answer to inputs that Python answers."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from fuzzy2.errors import UnansweredInC
from fuzzy2.support.checks import Array
from fuzzy2.systems.compiled_outputs import reduced_by_loop
from fuzzy2.systems.union_rows import Unions

INPUTS = 500
"""Number of inputs that are tried, drawn over the ranges."""


def warn_of_unanswered(system: Any, parts: Iterable[Any], name: str) -> None:
    """Warn if unions of output sets need more pieces than exported code has room for.

    Python takes more room then.

    Parameters
    ----------
    system : FuzzySystem
        The system, which has the ranges.
    parts : iterable of FuzzySystem
        The systems whose tables are exported: itself, or its α-planes.
    name : str
        Name of the code.
    """
    unions = [part for part in parts if isinstance(part.reducer, Unions)]
    if not unions:
        return
    inputs = _drawn(system)
    refused = [reduced_by_loop(part.reducer, inputs, part.n_outputs)[1] for part in unions]
    count = int(np.any(refused, axis=0).sum())
    if count:
        warnings.warn(UnansweredInC(name, count, INPUTS), stacklevel=4)


def _drawn(system: Any) -> Array:
    ranges = system.domain() if system.input_ranges is None else system.input_ranges
    # An eighth of the widest range of floats has a finite width.
    low, high = np.transpose(ranges) / 8.0
    return 8.0 * np.random.default_rng(0).uniform(low, high, (INPUTS, len(low)))

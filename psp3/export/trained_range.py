"""What is true of a learned controller's rules wherever its inputs can be."""

from __future__ import annotations

import itertools

import numpy as np

from fuzzy2.systems.kernels import firing
from psp3.fuzzy_control.kernels import BASE, Fuzzy

HELD = 1e-250
"""A firing strength that is a float with all its digits, with room to spare for rounding."""

MOST_INPUTS = 12
"""Of a rule base whose range is looked at in all its corners, 4096."""


def fires_everywhere(controller: Fuzzy) -> bool:
    """Tell whether firing strengths are floats with all their digits all over the trained range.

    It is enough that the lower one of some rule is, or the upper ones of all are, see
    ``fuzzy2.systems.log_firing_kernels.lost``. Outside of it rules are not asked: inputs are
    clamped, or the exact model takes over. Each grade rises to its middle and falls from there, and
    so does a rule's firing along each input; where it fires least is a corner of the range.

    Parameters
    ----------
    controller : Fuzzy
        A trained controller as kernels take it.
    """
    widths = controller.planes[1] if controller.planes.size else np.zeros(1)
    bases, o = controller.bases.astype(np.int64), 1
    for _ in range(bases[0]):
        start, size, rules = bases[o], bases[o + 1], bases[o + 3]
        inputs, outputs = bases[o + 4], bases[o + 5]
        if inputs > MOST_INPUTS:
            return False
        table = np.ascontiguousarray(controller.system[start : start + size])
        ranges = controller.ranges[:, bases[o + BASE : o + BASE + inputs]]
        corners = np.array(list(itertools.product(*ranges.T)))
        strengths = np.empty((len(corners), rules, 2))
        for width in widths:
            firing(table, corners.ravel(), float(width), strengths.reshape(-1))
            least, all_upper = strengths[..., 0].min(axis=0), strengths[..., 1].min()
            if not max(least.max(), all_upper) > HELD:
                return False
        o += BASE + inputs + outputs
    return True

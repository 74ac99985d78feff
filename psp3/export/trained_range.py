"""A property of a learned controller's rules over the whole range of its inputs."""

from __future__ import annotations

import itertools

import numpy as np

from fuzzy2.systems.kernels import firing
from psp3.fuzzy_control.kernels import BASE, Fuzzy

HELD = 1e-250
"""A firing strength above this is a float with all its digits, with a margin for rounding."""

MOST_INPUTS = 12
"""Most inputs of a rule base whose range is checked in all its corners, 4096."""


def fires_everywhere(controller: Fuzzy) -> bool:
    """Return whether firing strengths keep all their digits over the whole trained range.

    It suffices that the lower strength of one rule does, or the upper strengths of all rules do,
    see ``fuzzy2.systems.log_firing_kernels.lost``. Outside of the range rules are not evaluated:
    inputs are clamped, or the exact model takes over. Each grade rises to its middle and then
    falls, and so does a rule's firing strength along each input. It is therefore least in a corner
    of the range.

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

"""Tests of kernels that are answered once for all where they depend on a symbol.

Each asks whether the numbers are such that the kernel can answer as it stands, or whether a step
that would change nothing can be left out. To follow both ways would make the functions larger, and
their derivatives NaN where the way that is not taken divides by zero.
"""

from __future__ import annotations

_LOOPS, _SOLVE = "psp3.multibody.loops", "psp3.multibody.least_squares"
_FORCES, _INERTIA = "psp3.multibody.forces", "psp3.multibody.inertia"
_FIRING, _SYSTEMS = "fuzzy2.systems.firing_kernels", "fuzzy2.systems.kernels"

GUARDS: dict[tuple[str, str], bool] = {
    # Two frames that are joined have turned against each other by nothing, or nearly: the residual
    # is the sine of the angle along its axis.
    (f"{_LOOPS}._logarithm", "sine > 1e-07"): False,
    (f"{_LOOPS}._logarithm", "cosine > 0.0"): True,
    (f"{_LOOPS}._turn", "square > 0.0001"): False,
    # Zeros that are none by their form are not left out.
    (f"{_SOLVE}.factor", "square > 0.0"): True,
    (f"{_SOLVE}.factor", "dot != 0.0"): True,
    (f"{_SOLVE}.reflect", "weight != 0.0"): True,
    (f"{_SOLVE}.reflect", "dot != 0.0"): True,
    (f"{_FORCES}._driven_by", "speed != 0.0"): True,
    (f"{_INERTIA}.add_damping", "damping != 0.0"): True,
    # A mass matrix is positive definite. Of another one the root is NaN.
    (f"{_INERTIA}.factor_positive", "value > 0.0"): True,
    # Grades of a type-2 term differ.
    (f"{_FIRING}._fire", "grades[2 * t] != grades[2 * t + 1]"): True,
    # Some rule fires, and by more than numbers that are about to vanish; else 0 / 0 is NaN. What
    # adds nothing to a sum is not left out.
    (f"{_SYSTEMS}._center_of_sets", "fires > 0.0"): True,
    (f"{_SYSTEMS}._center_of_sets", "uncertainty > 0.0"): True,
    (f"{_SYSTEMS}._center_of_sets", "low[r] > 0.0"): True,
    (f"{_SYSTEMS}.evaluate_in", "low[0] < VANISHED"): False,
    # Where rounding decides on a switch point, either one gives the same end to rounding.
    (f"{_SYSTEMS}._center_of_sets", "settled"): True,
}
"""Answers by the kernel and the text of its test."""

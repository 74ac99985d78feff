"""Conditions in kernels that have a fixed answer if they depend on a symbol.

Each condition checks whether the kernel can handle the numbers, or whether a step without effect
can be skipped. If both ways were followed, the functions would be larger, and their derivatives
would be NaN if the other way divides by zero.
"""

from __future__ import annotations

_LOOPS, _SOLVE = "psp3.multibody.loops", "psp3.multibody.least_squares"
_FORCES, _INERTIA = "psp3.multibody.forces", "psp3.multibody.inertia"
_FIRING, _SYSTEMS = "fuzzy2.systems.firing_kernels", "fuzzy2.systems.kernels"

GUARDS: dict[tuple[str, str], bool] = {
    # Two joined frames are rotated relative to each other by nearly nothing: the residual is the
    # sine of the angle along its axis.
    (f"{_LOOPS}._logarithm", "sine > 1e-07"): False,
    (f"{_LOOPS}._logarithm", "cosine > 0.0"): True,
    (f"{_LOOPS}._turn", "square > 0.0001"): False,
    # Only structural zeros are skipped.
    (f"{_SOLVE}.factor", "square > 0.0"): True,
    (f"{_SOLVE}.factor", "dot != 0.0"): True,
    (f"{_SOLVE}.reflect", "weight != 0.0"): True,
    (f"{_SOLVE}.reflect", "dot != 0.0"): True,
    (f"{_FORCES}._driven_by", "speed != 0.0"): True,
    (f"{_INERTIA}.add_damping", "damping != 0.0"): True,
    # A mass matrix is positive definite. If it is not, the square root is NaN.
    (f"{_INERTIA}.factor_positive", "value > 0.0"): True,
    # The two grades of a type-2 term differ.
    (f"{_FIRING}._fire", "grades[2 * t] != grades[2 * t + 1]"): True,
    # Some rule fires with more than a vanishing strength; otherwise 0 / 0 is NaN. Terms that add
    # nothing to a sum are not skipped.
    (f"{_SYSTEMS}._center_of_sets", "fires > 0.0"): True,
    (f"{_SYSTEMS}._center_of_sets", "uncertainty > 0.0"): True,
    (f"{_SYSTEMS}._center_of_sets", "low[r] > 0.0"): True,
    (f"{_SYSTEMS}.evaluate_in", "low[0] < VANISHED"): False,
    # If rounding decides between two switch points, both give the same end to rounding.
    (f"{_SYSTEMS}._center_of_sets", "settled"): True,
}
"""Answers, by the kernel and the text of its condition."""

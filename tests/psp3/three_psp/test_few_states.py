"""The closed form at a few states: in Python, with the bits of the compiled one."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from fuzzy2.support.interpreted import few_calls, twin_of
from psp3.three_psp import closed_form, few_states, many_states

WIDTHS = {
    "forward_kinematics": (1, 18),
    "configuration": (1, 15),
    "inverse_kinematics_tip": (1, 3),
    "tip_jacobian": (1, 9),
    "tip_rates": (3, 3),
    "energies": (2, 2),
    "equation_of_motion": (2, 21),
    "inverse_dynamics": (3, 3),
    "forward_dynamics": (3, 3),
}


def test_every_quantity_is_compared() -> None:
    assert set(WIDTHS) == set(many_states._KERNELS)


@pytest.mark.parametrize("name", WIDTHS)
def test_python_and_the_compiler_have_the_same_bits(name: str) -> None:
    """Row by row, also of rows that are refused."""
    inputs, width = WIDTHS[name]
    kernel, rng = getattr(closed_form, name), np.random.default_rng(1)
    p, outs = psp3.load().parameters.as_array(), 2 if name == "tip_rates" else 1
    refused = 0
    for size in [*np.geomspace(1e-3, 1.0, 30), np.nan]:
        given = [size * rng.uniform(-1.0, 1.0, 3) for _ in range(inputs)]
        kept = []
        for ask in (kernel, twin_of(kernel)):
            out = [np.zeros(width) for _ in range(outs)]
            row = ask(*given, p, *out)
            refused += row >= 0
            # What is left of a refused row nobody reads.
            kept.append((row, [one.tobytes() for one in out] if row < 0 else None))
        assert kept[0] == kept[1]
    assert refused >= 2


def test_few_states_are_asked_in_python_and_many_of_the_compiler(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    robot, asked = psp3.load(), []
    monkeypatch.setattr(few_states, "is_ready", lambda _: False)
    monkeypatch.setattr(few_states, "twin_of", lambda one: asked.append(one) or twin_of(one))
    with few_calls():
        one = robot.inverse_dynamics(*np.full((3, 3), 0.01))
        some = robot.inverse_dynamics(*np.full((3, few_states.FEW, 3), 0.01))
        assert len(asked) == 2
        many = robot.inverse_dynamics(*np.full((3, few_states.FEW + 1, 3), 0.01))
    later = robot.inverse_dynamics(*np.full((3, 3), 0.01))
    assert len(asked) == 2
    assert (some == one).all()
    assert (many == one).all()
    assert (later == one).all()

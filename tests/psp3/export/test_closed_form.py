"""The 3-PSP's closed form in C: what the class answers, to the last bit, refusals and NaN alike."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import psp3
from fuzzy2.errors import NotExportable
from psp3.errors import PSP3Error
from psp3.export.face import c_code
from tests.c_code import STATES, Library, checked_at_run_time, compiled, same
from tests.helpers import Array
from tests.project_folder import check_statically, needs_c, needs_clang, needs_cppcheck

ROBOT = psp3.load("psp3")


def _refused(answer: Callable[[], Any]) -> Any:
    """Return an answer as one array, or None where the class refuses."""
    try:
        parts = answer()
    except PSP3Error:
        return None
    parts = parts if isinstance(parts, tuple) else (parts,)
    return np.concatenate([np.ravel(part) for part in parts])


def _pose(heights: Array) -> tuple[Array, ...]:
    pose = ROBOT.forward_kinematics(heights)
    return pose.center, pose.rotation, pose.arms, pose.tip


def _asked(q: Array, v: Array, a: Array, point: Array) -> dict[str, tuple[Any, Any]]:
    return {
        "forward_kinematics": ((q,), lambda: _pose(q)),
        "configuration": ((q,), lambda: ROBOT.configuration(q)),
        "tip_heights": ((point,), lambda: ROBOT.inverse_kinematics_tip(point)),
        "tip_jacobian": ((q,), lambda: ROBOT.tip_jacobian(q)),
        "inverse_dynamics": ((q, v, a), lambda: ROBOT.inverse_dynamics(q, v, a)),
        "forward_dynamics": ((q, v, a), lambda: ROBOT.forward_dynamics(q, v, a)),
        "mass_matrix": ((q,), lambda: ROBOT.mass_matrix(q)),
        "equation_of_motion": ((q, v), lambda: ROBOT.equation_of_motion(q, v)),
    }


def _states(count: int) -> Any:
    rng = np.random.default_rng(0)
    for number in range(count):
        q = 0.2 + rng.choice([1e-6, 0.03, 0.1, 0.4]) * rng.normal(size=3)
        v, a = rng.normal(size=3), 5.0 * rng.normal(size=3)
        if number % 101 == 3:
            q[1] = np.nan
        if number % 101 == 7:
            v[1] = np.inf
        if number % 101 == 9:
            q = np.full(3, 0.2)
        if number % 101 == 11:
            v, a = rng.choice([1e160, 1e300]) * v, 1e300 * a
        yield q, v, a, rng.choice([0.01, 0.05, 0.2]) * rng.normal(size=3)


def test_every_number_is_the_same(tmp_path: Path) -> None:
    code = c_code(ROBOT)
    library, refused = Library(code, compiled(code, tmp_path)), set()
    names = {one.name.removeprefix("psp3_") for one in code.functions}
    assert names == set(_asked(*np.zeros((4, 3))))
    assert not any(one.has_state for one in code.functions)
    for state in _states(STATES):
        for name, (arguments, answer) in _asked(*state).items():
            became, written = library.call(name, *arguments)
            flat, right = np.concatenate(written), _refused(answer)
            if right is None:
                assert became == 1
                assert np.isnan(flat).all()
                refused.add(name)
            else:
                assert became == 0
                assert same(flat, right), (name, state)
    assert refused == set(_asked(*np.zeros((4, 3))))


@needs_c
@needs_clang
@needs_cppcheck
@pytest.mark.parametrize("precision", ["double", "single"])
def test_compilers_sanitizers_and_cppcheck_have_nothing_to_say(
    precision: Any, tmp_path: Path
) -> None:
    code = c_code(ROBOT, precision=precision)
    checked_at_run_time(code, tmp_path, "clang", {"heights": np.full(3, 0.2)})
    code.write(tmp_path / "code")
    check_statically(tmp_path / "code")
    assert "while (" not in code.source


def test_single_precision_keeps_six_digits(tmp_path: Path) -> None:
    """Seven digits in, and sums of some hundred products: 1e-5 of the largest number.

    ``tip_heights`` divides what a rounding moves the tip by by how the tip moves with the heights,
    and its iteration ends there: some roundings of 0.1 m are 1e-6 m.
    """
    code = c_code(ROBOT, precision="single")
    library, asked = Library(code, compiled(code, tmp_path)), Counter()
    for q, v, a, point in _states(STATES):
        if not np.isfinite(q).all() or not np.abs(v).max() < 1e3 or np.ptp(q) > 0.15:
            continue
        tip = ROBOT.tip(q) + 0.1 * point
        q, v, a, tip = (x.astype(np.float32).astype(float) for x in (q, v, a, tip))
        for name, (arguments, answer) in _asked(q, v, a, tip).items():
            right = _refused(answer)
            became, written = library.call(name, *arguments)
            flat = np.concatenate(written).astype(float)
            if right is None:
                assert name == "tip_heights"
                assert became == 1
                assert np.isnan(flat).all()
            else:
                assert became == 0, name
                bound = 1e-5 * np.abs(right).max()
                assert np.abs(flat - right).max() <= bound, (name, arguments)
                asked[name] += 1
    assert min(asked[name] for name in _asked(*np.zeros((4, 3)))) > 0.2 * STATES


def test_frames_are_those_of_the_core() -> None:
    assert c_code(ROBOT, frames=["tip"]).functions
    with pytest.raises(NotExportable, match="core"):
        c_code(ROBOT, frames=["star"])
    only = c_code(ROBOT, functions=["inverse_dynamics"], name="r")
    assert [one.name for one in only.functions] == ["r_inverse_dynamics"]

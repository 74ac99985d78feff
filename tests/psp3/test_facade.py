"""What ``import psp3`` loads, and that every public name is there.

Seconds are measured by the benchmarks, not here.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import psp3

ROOT = Path(psp3.__file__).resolve().parent.parent


def run(code: str, *options: str, directory: Path = ROOT) -> str:
    """Run code in a new interpreter that finds this psp3, and return what it prints."""
    program = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{code}"
    result = subprocess.run(
        [sys.executable, *options, "-c", program],
        capture_output=True,
        text=True,
        cwd=directory,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_importing_psp3_loads_nothing_heavy() -> None:
    """They load when first needed: listing names and catching errors needs none of them."""
    heavy = ["numba", "scipy", "matplotlib", "meshcat", "typer", "rich", "yaml", "mujoco"]
    assert (
        run(
            "import psp3; dir(psp3); psp3.PSP3Error; psp3.Parameters(); print([m for m in "
            f"{heavy} if m in sys.modules])"
        )
        == "[]"
    )


@pytest.mark.slow
def test_loading_the_robot_draws_nothing_and_plots_nothing() -> None:
    """The compiled closed form needs numba (which looks for scipy).

    Pictures wait until they are asked for.
    """
    code = "import psp3; psp3.load('psp3').forward_kinematics([0, 0, 0])"
    assert (
        run(f"{code}; print([m for m in ['matplotlib', 'meshcat', 'typer'] if m in sys.modules])")
        == "[]"
    )


@pytest.mark.parametrize("name", psp3.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(psp3, name) is not None
    assert name in dir(psp3)


def test_unknown_name_is_an_attribute_error() -> None:
    """As for any module, so that hasattr and import errors work as people expect."""
    assert not hasattr(psp3, "delta_robot")
    with pytest.raises(AttributeError, match="'psp3' has no attribute 'delta_robot'"):
        _ = psp3.delta_robot


@pytest.mark.slow
def test_psp3_works_from_any_directory_without_a_warning(tmp_path: Path) -> None:
    """Robot files are found from the code's place.

    The first call of a process takes another path through numba than later ones.

    Broadcast arguments are the ones that numba looks at twice.
    """
    code = "import psp3; print(psp3.load('psp3').mass_matrix([[0.0, 0.0, 0.0]]).shape)"
    assert run(code, "-W", "error", directory=tmp_path) == "(1, 3, 3)"


def test_fuzzy2_knows_nothing_of_psp3() -> None:
    assert (
        run(
            "import fuzzy2, fuzzy2.support.compiled; print('psp3' in sys.modules, 'pinocchio' in "
            "sys.modules)"
        )
        == "False False"
    )

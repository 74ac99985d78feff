"""What ``import fuzzy2`` loads.

That every public name is there, and that it works where nothing can be written.

Seconds are measured by the benchmarks, not here.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import fuzzy2

PACKAGE = Path(fuzzy2.__file__).resolve().parent
# Nothing can be made under it, by nobody, not even by root, for whom no directory is read-only.
UNWRITABLE = "/proc/none"

COMPUTE = (
    "import fuzzy2; print(fuzzy2.centroid([0.0, 1.0, 2.0], [0.1, 0.5, 0.1], [0.2, 1.0, "
    "0.4]).round(12).tolist())"
)
# By hand: left (0 * 0.2 + 1 * 0.5 + 2 * 0.1) / 0.8, right (0 * 0.1 + 1 * 0.5 + 2 * 0.4) / 1.0.
COMPUTED = "[0.875, 1.3]"


def run(code: str, root: Path = PACKAGE.parent, **environment: str) -> str:
    """Run code in a new interpreter and return what it prints.

    It finds the fuzzy2 under ``root``, and warnings are errors.
    """
    program = f"import sys; sys.path.insert(0, {str(root)!r})\n{code}"
    settings = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **environment}
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        capture_output=True,
        text=True,
        env=settings,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_importing_fuzzy2_loads_nothing_heavy() -> None:
    """They load when first needed.

    Listing names, making sets and evaluating them needs none of them.
    """
    heavy = ["numba", "scipy", "matplotlib", "sklearn", "psp3", "pinocchio"]
    code = (
        "import fuzzy2; dir(fuzzy2); fuzzy2.Fuzzy2Error; fuzzy2.GaussianUncertainMean(mean=(0, "
        "1), sigma=1).lower(0.5)"
    )
    assert run(f"{code}; print([name for name in {heavy} if name in sys.modules])") == "[]"


def test_computing_loads_numba_and_draws_nothing() -> None:
    code = (
        f"{COMPUTE}; print([name for name in ['numba', 'matplotlib', 'psp3'] if name in "
        "sys.modules])"
    )
    assert run(code).splitlines() == [COMPUTED, "['numba']"]


@pytest.mark.parametrize("name", fuzzy2.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(fuzzy2, name) is not None
    assert name in dir(fuzzy2)


def test_the_version_is_that_of_the_project() -> None:
    settings = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8"))
    assert fuzzy2.__version__ == settings["project"]["version"]


def test_unknown_name_is_an_attribute_error() -> None:
    """As for any module, so that hasattr and import errors work as people expect."""
    assert not hasattr(fuzzy2, "crisp_logic")
    with pytest.raises(AttributeError, match="'fuzzy2' has no attribute 'crisp_logic'"):
        _ = fuzzy2.crisp_logic


@pytest.mark.slow
def test_the_cache_may_be_where_nothing_can_be_written(tmp_path: Path) -> None:
    """Code is kept in a private folder below the temporary directory then."""
    environment = {"NUMBA_CACHE_DIR": UNWRITABLE, "HOME": UNWRITABLE, "XDG_CACHE_HOME": UNWRITABLE}
    assert run(COMPUTE, TMPDIR=str(tmp_path), **environment) == COMPUTED
    assert list((tmp_path / f"psp3-{os.getuid()}").rglob("*.nbc"))


@pytest.mark.slow
def test_nothing_at_all_need_be_writable(tmp_path: Path) -> None:
    """The kernels are compiled anew then.

    A file that bars the way to the cache stands for a temporary directory that cannot be written.
    """
    shutil.copytree(PACKAGE, tmp_path / "fuzzy2", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / f"psp3-{os.getuid()}").touch()
    environment = {"NUMBA_CACHE_DIR": UNWRITABLE, "HOME": UNWRITABLE, "XDG_CACHE_HOME": UNWRITABLE}
    environment["TMPDIR"] = str(tmp_path)
    assert run(COMPUTE, root=tmp_path, **environment) == COMPUTED
    where = run("import fuzzy2; print(fuzzy2.__file__)", root=tmp_path, **environment)
    assert where.startswith(str(tmp_path))

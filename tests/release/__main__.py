"""``python -m tests.release``: build wheel and sdist, and try the wheel on every Python there is.

A Python that is not on this machine is named, and it is looked whether all that psp3 runs on has
wheels for it. With ``UV_PYTHON_DOWNLOADS=automatic`` uv fetches those that are missing.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.release.texts import (
    PYTHONS,
    changelog_section,
    sdist_faults,
    versions,
    wheel_faults,
)

ROOT = Path(__file__).resolve().parents[2]
LOCKED = ROOT / "requirements" / "run.txt"
BY_HASH = ("--require-hashes", "--only-binary", ":all:", "--requirement", str(LOCKED))
UV = (sys.executable, "-m", "uv", "--quiet")

TRIAL = """
import fuzzy2, psp3

terms = {
    "small": fuzzy2.GaussianUncertainMean(mean=(-1.2, -0.8), sigma=0.8),
    "large": fuzzy2.GaussianUncertainMean(mean=(0.8, 1.2), sigma=0.8),
}
rules = "IF error is small THEN force is weak \\n IF error is large THEN force is strong"
forces = {"weak": -1.0, "strong": 1.0}
system = fuzzy2.IntervalType2System({"error": terms}, rules, {"force": forces})
assert abs(system([0.3])[0] - 0.404) < 5e-4, system([0.3])
assert psp3.__version__ == fuzzy2.__version__ == VERSION, (psp3.__version__, VERSION)
"""
"""What the README says, asked of an installed wheel."""

GONE = """
import importlib.util

assert not any(map(importlib.util.find_spec, ("psp3", "fuzzy2")))
"""


def run(*command: str | Path, quiet: bool = False) -> bool:
    """Run a command away from the sources; tell whether it succeeded."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "VIRTUAL_ENV")
    }
    environment.setdefault("UV_PYTHON_DOWNLOADS", "never")
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            list(map(str, command)),
            cwd=folder,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL if quiet else None,
        )
    return done.returncode == 0


def steps_of_trial(folder: Path, wheel: Path, version: str) -> Iterator[tuple[str, bool]]:
    """Yield what is done with a wheel in a virtual environment, and whether it worked."""
    python, psp3 = folder / "bin" / "python", folder / "bin" / "psp3"
    into = ("pip", "install", "--python", python)
    yield "install what it runs on", run(*UV, *into, *BY_HASH)
    yield "install the wheel", run(*UV, *into, "--no-deps", "--no-index", wheel)
    yield "psp3 --version", run(psp3, "--version")
    yield "psp3 info", run(psp3, "info")
    yield "psp3 pose", run(psp3, "pose", "--heights", "0.05,0,-0.02")
    yield "fuzzy2", run(python, "-I", "-W", "error", "-c", f"VERSION = {version!r}\n{TRIAL}")
    yield "uninstall", run(*UV, "pip", "uninstall", "--python", python, "psp3")
    yield "nothing is left", run(python, "-I", "-c", GONE)


def tried(python: str, wheel: Path, version: str, folder: Path) -> list[str]:
    """Try a wheel on a version of Python; return what failed."""
    environment = folder / python
    if not run(*UV, "venv", "--no-project", "--python", python, environment, quiet=True):
        print(f"  Python {python}: not on this machine, so nothing is run", flush=True)
        return _without_wheels(python, folder)
    for step, worked in steps_of_trial(environment, wheel, version):
        if not worked:
            return [f"Python {python}: {step} failed"]
    print(f"  Python {python}: installed, run, removed", flush=True)
    return []


def _without_wheels(python: str, folder: Path) -> list[str]:
    """Look whether all that the package runs on can be installed by hash on a Python."""
    place = ("--dry-run", "--python-version", python, "--target", str(folder / f"for-{python}"))
    if run(*UV, "pip", "install", "--python", sys.executable, *place, *BY_HASH):
        print(f"  Python {python}: all that psp3 runs on has wheels", flush=True)
        return []
    return [f"Python {python}: requirements/run.txt cannot be installed"]


def check(unreleased: bool) -> list[str]:
    """Return all that keeps this state from being released."""
    said = versions(ROOT)
    version = said["pyproject.toml"]
    faults = []
    if len(set(said.values())) > 1:
        faults.append(f"versions differ: {said}")
    if not changelog_section((ROOT / "CHANGELOG.md").read_text("utf-8"), version):
        missing = f"CHANGELOG.md has no dated section for {version}"
        print(f"  {missing}", flush=True)
        faults += [] if unreleased else [missing]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # The wheel is built from the source distribution: it has all that is needed.
        built = run(*UV, "build", "--no-build-isolation", "--offline", "--out-dir", folder, ROOT)
        if not built:
            return [*faults, "wheel and source distribution cannot be built"]
        (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
        print(f"  {wheel.name}, {sdist.name}: built", flush=True)
        faults += wheel_faults(wheel) + sdist_faults(sdist)
        for python in PYTHONS:
            faults += tried(python, wheel, version, folder)
    return faults


def main() -> None:
    """Check, say what was found, and exit with 1 if it cannot be released."""
    parser = argparse.ArgumentParser(prog="python -m tests.release", description=__doc__)
    parser.add_argument(
        "--unreleased", action="store_true", help="the changelog need not have the version yet"
    )
    faults = check(parser.parse_args().unreleased)
    for fault in faults:
        print(f"  {fault}", file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()

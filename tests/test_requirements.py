"""Versions and hashes of all that the README's two commands download."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
LOCKS = ("run", "dev")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
HASH = re.compile(r"--hash=sha256:[0-9a-f]{64}(?: |$)")


def locked(name: str) -> dict[str, list[tuple[Requirement, int]]]:
    """Return the packages of a file, by name: each with its version and number of hashes."""
    text = (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8")
    found: dict[str, list[tuple[Requirement, int]]] = {}
    for line in re.sub(r"\\\n", "", text).splitlines():
        asked = Requirement(line.split(" --hash")[0].strip())
        found.setdefault(_name(asked), []).append((asked, len(HASH.findall(line))))
    return found


def _name(asked: Requirement) -> str:
    return re.sub(r"[-_.]+", "-", asked.name).lower()


def _asked(extras: tuple[str, ...]) -> Iterator[Requirement]:
    lines = list(PROJECT["dependencies"])
    for extra in extras:
        lines += PROJECT["optional-dependencies"][extra]
    build = (ROOT / "requirements" / "build.in").read_text(encoding="utf-8").splitlines()
    lines += [line for line in build if not line.startswith("#")]
    yield from (one for one in map(Requirement, lines) if one.name != PROJECT["name"])


@pytest.mark.parametrize("name", LOCKS)
def test_every_package_has_one_version_and_hashes(name: str) -> None:
    packages = locked(name)
    assert len(packages) > 50
    for several in packages.values():
        for asked, hashes in several:
            assert str(asked.specifier).startswith("=="), asked
            assert hashes > 0, asked
            assert len(several) == 1 or asked.marker, asked


@pytest.mark.parametrize(("name", "extras"), [("run", ()), ("dev", ("docs", "test", "dev"))])
def test_versions_are_those_that_the_project_asks_for(name: str, extras: tuple[str, ...]) -> None:
    packages = locked(name)
    for asked in _asked(extras):
        for one, _ in packages[_name(asked)]:
            version = str(one.specifier).removeprefix("==")
            assert asked.specifier.contains(version), f"make lock: {asked}, locked {version}"


def test_what_runs_is_what_is_tested() -> None:
    tested = locked("dev")
    for name, several in locked("run").items():
        assert {one.specifier for one, _ in several} == {one.specifier for one, _ in tested[name]}


def test_what_builds_the_project_is_locked() -> None:
    """It is installed without isolation, and so built by what the file has."""
    system = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]
    assert {_name(Requirement(line)) for line in system["requires"]} <= set(locked("run"))

"""What keeps a release from being one is found: each fault is planted, and told."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from tests.release.texts import (
    PYTHONS,
    changelog_section,
    description_faults,
    metadata_faults,
    versions,
)

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
CHANGELOG = """# Changelog

## [Unreleased]

- To come.

## [0.2.0] - 2026-12-01

### Added

- A thing.

## [0.1.0] - 2026-01-01
"""
METADATA = """Metadata-Version: 2.4
Name: psp3
Version: 0.2.0
Requires-Python: >={oldest}
Description-Content-Type: {kind}
{classifiers}

{description}
"""


def metadata(
    oldest: str = PYTHONS[0],
    kind: str = "text/markdown",
    more: tuple[str, ...] = (),
    description: str = "# psp3\n\n```sh\npsp3 view\n```",
) -> bytes:
    names = [f"Programming Language :: Python :: {python}" for python in PYTHONS]
    lines = "\n".join(f"Classifier: {name}" for name in (*names, *more))
    return METADATA.format(
        oldest=oldest, kind=kind, classifiers=lines, description=description
    ).encode()


def test_a_section_of_the_changelog_is_dated_and_not_empty() -> None:
    assert changelog_section(CHANGELOG, "0.2.0") == "### Added\n\n- A thing."
    assert changelog_section(CHANGELOG, "Unreleased") == ""
    assert changelog_section(CHANGELOG, "0.1.0") == ""
    assert changelog_section(CHANGELOG, "0.3.0") == ""


def test_all_files_say_one_version() -> None:
    assert set(versions(ROOT).values()) == {PROJECT["version"]}


def test_metadata_without_a_fault_have_none() -> None:
    assert metadata_faults(metadata()) == []


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"more": ("Topic :: Robots",)}, "no such classifier: Topic :: Robots"),
        ({"oldest": "3.12"}, "Python 3.11 is not in Requires-Python: >=3.12"),
        ({"kind": "text/plain"}, "the long description is text/plain"),
        ({"description": "psp3\n"}, "headings or code are not rendered"),
        ({"description": ""}, "there is no long description"),
    ],
)
def test_each_fault_of_the_metadata_is_told(given: dict[str, object], fault: str) -> None:
    assert fault in metadata_faults(metadata(**given))  # type: ignore[arg-type]


def test_the_long_description_is_rendered_without_the_repository() -> None:
    """The README is not: its links lead to files beside it."""
    assert description_faults((ROOT / PROJECT["readme"]).read_text("utf-8")) == []
    faults = description_faults((ROOT / "README.md").read_text("utf-8"))
    assert "a link into the repository: docs/robots.md" in faults
    assert "a link into the repository: docs/pictures/tracking.gif" in faults


def test_the_oldest_python_is_the_one_that_is_asked_for() -> None:
    assert PROJECT["requires-python"] == f">={PYTHONS[0]}"


def test_the_workflow_sets_up_every_python_and_pins_what_it_uses() -> None:
    workflow = (ROOT / ".github" / "workflows" / "release-check.yml").read_text("utf-8")
    assert re.findall(r"^ +(3\.\d+)$", workflow, flags=re.MULTILINE) == list(reversed(PYTHONS))
    used = re.findall(r"uses: (\S+)", workflow)
    assert len(used) == 2
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", one) for one in used)

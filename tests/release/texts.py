"""What a release says of itself: versions, changelog, classifiers, and its long description."""

from __future__ import annotations

import re
import tarfile
import tomllib
import zipfile
from pathlib import Path

from packaging.metadata import Metadata
from packaging.specifiers import SpecifierSet
from trove_classifiers import classifiers

PYTHONS = ("3.11", "3.12", "3.13", "3.14")
"""From the oldest that is supported to the newest that pin has a wheel for."""

HEADING = re.compile(r"^## \[(.+?)\](?: - (\d{4}-\d{2}-\d{2}))?$", flags=re.MULTILINE)
RELATIVE = re.compile(r'(?:src|href)="((?!https://)[^"]*)"')
PACKED = {
    "psp3/urdf/delta.urdf",
    "psp3/urdf/delta.yaml",
    "psp3/urdf/biped.xml",
    "psp3/visualize/scene.html",
    "psp3/py.typed",
    "fuzzy2/py.typed",
}
"""Some of what is no Python and must be in a wheel."""


def changelog_section(changelog: str, version: str) -> str:
    """Return what the changelog says of a version; nothing if it has no dated section of it."""
    headings = list(HEADING.finditer(changelog))
    ends = [heading.start() for heading in headings[1:]] + [len(changelog)]
    for heading, end in zip(headings, ends, strict=True):
        if heading[1] == version and heading[2]:
            return changelog[heading.end() : end].strip()
    return ""


def versions(root: Path) -> dict[str, str]:
    """Return the version by each file that says it."""
    found = {
        "pyproject.toml": str(
            tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]["version"]
        )
    }
    for name, pattern in (
        ("CITATION.cff", r"^version: (\S+)$"),
        ("psp3/version.py", r'^__version__ = "(\S+)"$'),
        ("fuzzy2/support/version.py", r'^__version__ = "(\S+)"$'),
    ):
        said = re.search(pattern, (root / name).read_text("utf-8"), flags=re.MULTILINE)
        found[name] = said[1] if said else "none"
    return found


def metadata_faults(text: bytes) -> list[str]:
    """Return what is wrong with the metadata of a distribution."""
    metadata = Metadata.from_email(text, validate=True)
    faults = [
        f"no such classifier: {one}" for one in metadata.classifiers or [] if one not in classifiers
    ]
    supported = metadata.requires_python or SpecifierSet()
    for python in PYTHONS:
        if f"Programming Language :: Python :: {python}" not in (metadata.classifiers or []):
            faults.append(f"Python {python} is no classifier")
        if not supported.contains(python):
            faults.append(f"Python {python} is not in Requires-Python: {supported}")
    if metadata.description_content_type != "text/markdown":
        faults.append(f"the long description is {metadata.description_content_type}")
    return faults + description_faults(metadata.description or "")


def description_faults(text: str) -> list[str]:
    """Return why a page of a package index would not show a long description whole.

    It renders Markdown, but knows no files of the repository.
    """
    from markdown_it import MarkdownIt

    if not text.strip():
        return ["there is no long description"]
    page = MarkdownIt("commonmark", {"html": False}).enable("table").render(text)
    faults = [f"a link into the repository: {found}" for found in RELATIVE.findall(page)]
    if "<h1>" not in page or "<pre>" not in page:
        faults.append("headings or code are not rendered")
    return faults


def wheel_faults(wheel: Path) -> list[str]:
    """Return what is wrong with a wheel: what it lacks, or has besides the packages."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        faults = metadata_faults(archive.read(metadata))
    faults += [f"the wheel has no {name}" for name in sorted(PACKED - set(names))]
    strange = {name.split("/")[0] for name in names} - {"psp3", "fuzzy2", metadata.split("/")[0]}
    return (
        faults
        + [f"the wheel also has {name}" for name in sorted(strange)]
        + [
            f"the wheel has {name}"
            for name in names
            if name.endswith((".nbi", ".nbc", ".pyc")) or "__pycache__" in name
        ]
    )


def sdist_faults(sdist: Path) -> list[str]:
    """Return what a source distribution lacks of what a user or a packager looks for."""
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
        faults = []
        with archive.extractfile(f"{sdist.name.removesuffix('.tar.gz')}/PKG-INFO") as file:  # type: ignore[union-attr]
            faults += metadata_faults(file.read())
    wanted = ("LICENSE", "README.md", "CHANGELOG.md", "CITATION.cff", "pyproject.toml", "Makefile")
    folders = (
        "tests/test_requirements.py",
        "docs/index.md",
        "examples/README.md",
        "urdf/psp3.urdf",
    )
    return faults + [
        f"the source distribution has no {name}"
        for name in (*wanted, *folders)
        if name not in names
    ]

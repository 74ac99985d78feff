"""README, the pages on the thesis and notebook 5 say what the job finds, number by number.

The job is done once, with its default seeds. A wrong number fails with the sentence as it should
be, and a number that no template has fails with its place.
"""

from __future__ import annotations

import json
import pkgutil
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest

from psp3.study.study import Study
from psp3.thesis import replication
from psp3.thesis.plan import Plan
from tests.documents import notebook_5, readme, results_page, thesis_page
from tests.documents.numbers import FIELD, NUMBER, exempt, free_numbers, problems, prose
from tests.documents.sources import LEVELS, sources
from tests.maps.named_tests import functions_of
from tests.processes import ROOT

THESIS, RESULTS = ROOT / "docs" / "thesis.md", ROOT / "docs" / "results.md"


def notebook_text() -> str:
    """Return the text of notebook 5, without code and what it prints."""
    notebook = json.loads((ROOT / "notebooks" / "05_results.ipynb").read_text(encoding="utf-8"))
    cells = ("".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "markdown")
    return "\n\n".join(cells)


class Document(NamedTuple):
    """A document: how it is read, and what it must say."""

    read: Callable[[], str]
    said: ModuleType

    @property
    def text(self) -> str:
        """What is checked."""
        return prose(self.read())


DOCUMENTS = {
    "README.md": Document(lambda: (ROOT / "README.md").read_text(encoding="utf-8"), readme),
    "docs/results.md": Document(lambda: RESULTS.read_text(encoding="utf-8"), results_page),
    "docs/thesis.md": Document(lambda: THESIS.read_text(encoding="utf-8"), thesis_page),
    "notebook 5": Document(notebook_text, notebook_5),
}


@pytest.fixture(params=DOCUMENTS)
def document(request: pytest.FixtureRequest) -> Document:
    return DOCUMENTS[request.param]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Do the job, with the seeds that it takes unless asked for others.

    Without its drawings, and with few steps timed, of which the documents say nothing.
    """
    out: Path = tmp_path_factory.mktemp("documents")
    with pytest.MonkeyPatch.context() as patch:
        for name in ("_figures", "_animation"):
            patch.setattr(replication, name, lambda *arguments: None)
        for name in ("STEPS", "SLOW_STEPS"):
            patch.setattr(replication, name, 60)
        outcome = replication.reproduce(out)
    numbers = json.loads((out / "results.json").read_text(encoding="utf-8"))
    runs = Study(out / "study.sqlite", Plan.of(replication.SEEDS).runs()).rows()
    return sources(outcome, numbers, runs)


@pytest.mark.slow
def test_every_number_has_its_source(document: Document, found: Mapping[str, Any]) -> None:
    wrong = problems(document.text, document.said.TEMPLATES, found)
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
def test_comparisons_in_words_are_so(document: Document, found: Mapping[str, Any]) -> None:
    """They are in the document, and the numbers say the same."""
    for words, so in document.said.comparisons(found):
        assert words in document.text, f"not in the document: {words}"
        assert so, f"the numbers do not say: {words}"


@pytest.mark.slow
def test_levels_and_noise_are_those_of_the_job(found: Mapping[str, Any]) -> None:
    """The documents may name these without a template."""
    assert [f"{level:g}" for level in found["settings"]["levels"]] == LEVELS == ["20", "15", "10"]


@pytest.mark.slow
def test_any_other_digit_is_noticed(document: Document, found: Mapping[str, Any]) -> None:
    """Each number is changed in its last digit, one at a time, and every change is a problem.

    But for those of the exempt kinds, and those in words.
    """
    text = document.text
    numbers = [
        match
        for match in NUMBER.finditer(text)
        if match[0][-1].isdigit() and not exempt(text)[match.start()]
    ]
    assert len(numbers) > 15
    for match in numbers:
        other = str((int(match[0][-1]) + 1) % 10)
        changed = text[: match.end() - 1] + other + text[match.end() :]
        assert problems(changed, document.said.TEMPLATES, found), match[0]


@pytest.mark.slow
def test_a_number_that_moves_is_noticed(found: Mapping[str, Any]) -> None:
    """A result that is another one fails with the sentence as it should be."""
    moved = {**found, "noise_on_gravity_at_20_dB": {"noise": 3.0, "standard_deviation": 0.6}}
    for name in ("docs/results.md", "docs/thesis.md", "notebook 5"):
        document = DOCUMENTS[name]
        wrong = problems(document.text, document.said.TEMPLATES, moved)
        assert any("3.0 N" in problem and "8.7 N" in problem for problem in wrong)


def test_templates_have_no_numbers_of_their_own(document: Document) -> None:
    """What is outside of the fields is of an exempt kind."""
    for template in document.said.TEMPLATES:
        assert not free_numbers(FIELD.sub("§", template)), template


def test_an_added_number_is_noticed() -> None:
    sentence = "Type-2 wins by 12 % at 20 dB, a third of it in Table 6.3."
    assert free_numbers(sentence) == ["12", "a third"]
    assert len(problems(sentence, (), {})) == 2


def test_numbers_in_words_count_if_they_measure() -> None:
    assert free_numbers("It grows sixfold, twice in three rows, and ten times here.") == [
        "sixfold",
        "twice",
        "ten times",
    ]


def test_a_wrong_number_is_said_beside_the_right_one() -> None:
    (wrong, left) = problems("PD sags by 88 mm.", ("PD sags by {sag:mm.0f} mm.",), {"sag": 0.0866})
    assert "PD sags by 87 mm." in wrong
    assert "PD sags by 88 mm." in wrong
    assert "'88'" in left


def test_what_a_test_is_said_to_assert_it_asserts() -> None:
    place = "asserted cross/test_derivations.py::test_1_39_has_k_squared_in_it"
    assert not problems("It is 234.7.", (f"It is {{{place} 234.7}}.",), {})
    with pytest.raises(AssertionError, match=r"does not assert 234\.8"):
        problems("It is 234.8.", (f"It is {{{place} 234.8}}.",), {})


def test_names_on_the_page_are_there() -> None:
    """Functions and tests, by their names."""
    page = THESIS.read_text(encoding="utf-8")
    tests = re.findall(r"`([\w/]+\.py)::(test_\w+)`", page)
    assert len(tests) > 60
    for file, name in tests:
        assert name in functions_of(file), f"{file}::{name}"
    names = re.findall(r"`((?:psp3|fuzzy2)(?:\.\w+)+)`", page)
    assert len(names) > 10
    for name in names:
        pkgutil.resolve_name(name)


@pytest.mark.slow
def test_keys_on_the_page_are_in_the_file(found: Mapping[str, Any]) -> None:
    """The last column names keys of results.json."""
    keys = set(re.findall(r"`([a-z_\d]+)`", THESIS.read_text(encoding="utf-8")))
    keys -= {"snr_reference", "noisy_entries", "psp3"}
    assert len(keys) > 10
    assert keys <= set(found), keys - set(found)

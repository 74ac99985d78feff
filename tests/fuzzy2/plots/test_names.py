"""Names of others in figures: drawn letter by letter, whatever matplotlib would take them for."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import fuzzy2
from fuzzy2.errors import printable
from fuzzy2.plots.names import literal

HOSTILE = [
    r"$\foo$",
    r"\$5 and $6$",
    "a $ b",
    "_hidden",
    "$",
    "--></text><script>",
    "\x1b[31m\x07\x00\r",
    "\u202eback\udcff",
    "two\nlines",
    "",
]


def drawn(name: str) -> str:
    """Return what matplotlib draws of a label, by its own rules."""
    shown, mathematics = Text(text=literal(name))._preprocess_math(literal(name))  # type: ignore[attr-defined]
    assert not mathematics
    return str(shown).removeprefix("\N{ZERO WIDTH SPACE}")


@pytest.mark.parametrize("name", HOSTILE)
def test_a_name_is_drawn_as_it_is(name: str) -> None:
    assert drawn(name) == printable(name)
    assert not literal(name).startswith("_"), "which legends leave out"


def system(names: list[str]) -> fuzzy2.Type1System:
    """Return a system all of whose names are hostile."""
    inputs = [{name: fuzzy2.Gaussian(float(k), 1.0) for k, name in enumerate(names)}] * 2
    return fuzzy2.Type1System(
        [list(terms.values()) for terms in inputs],
        [[0, 0], [1, 1]],
        [[fuzzy2.Gaussian(0.0, 1.0)], [fuzzy2.Gaussian(1.0, 1.0)]],
        input_names=names[:2],
        output_names=[names[2]],
        term_names=[names, names],
    )


def as_svg(figure: Figure) -> str:
    file = io.BytesIO()
    figure.savefig(file, format="svg")
    return file.getvalue().decode()


def test_figures_of_systems_with_any_names_are_drawn_and_are_well_formed() -> None:
    named = system([name for name in HOSTILE if name])
    x = np.array([0.3, 0.4])
    panels = [
        named.view()[0],
        named.explain(x).view()[0],
        fuzzy2.plots.figure_of_response(named)[0],
        fuzzy2.plots.figure_of_rule_surface(named)[0],
        fuzzy2.view(dict.fromkeys(HOSTILE, fuzzy2.Gaussian(0.0, 1.0)))[0],
    ]
    for panel in panels:
        text = as_svg(panel.figure)
        ET.fromstring(text)
        assert "<script" not in text


def test_no_name_is_left_out_of_a_legend() -> None:
    (panel,) = fuzzy2.view({name: fuzzy2.Gaussian(0.0, 1.0) for name in HOSTILE})
    shown = [text.get_text() for text in panel.get_legend().get_texts()]
    assert shown == [literal(name) for name in HOSTILE if name]

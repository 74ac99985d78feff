"""What systems show of themselves in notebooks."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np

import fuzzy2
from fuzzy2.systems.pictures import MOST_RULES, bars


def test_a_system_shows_its_terms_and_rules() -> None:
    terms = fuzzy2.automf(0.0, 1.0, 5)
    rules = "\n".join(f"IF a is {name} THEN p is {name}" for name in terms)
    system = fuzzy2.Type1System({"a": terms}, rules, {"p": terms}, type_reduction="centroid")
    shown = ElementTree.fromstring(f"<div>{system._repr_html_()}</div>")
    assert len(shown.findall(".//{http://www.w3.org/2000/svg}svg")) == 2
    assert [item.text for item in shown.iter("li")] == rules.splitlines()


def test_of_many_rules_the_first_are_shown() -> None:
    terms = [fuzzy2.Gaussian(float(k), 0.5) for k in range(MOST_RULES + 5)]
    system = fuzzy2.Type1System([terms], np.arange(len(terms))[:, None], np.ones((len(terms), 1)))
    shown = system._repr_html_()
    assert shown.count("<li>") == MOST_RULES
    assert "and 5 more rules" in shown


def test_bars_are_as_long_as_shares() -> None:
    assert ["width:25px" in bar for bar in bars([0.25, 0.5])] == [True, False]

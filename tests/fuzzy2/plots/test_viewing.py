"""The picture of anything."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue
from tests.fuzzy2.plots.subjects import FUZZY, SYSTEM, TERMS

pytestmark = pytest.mark.usefixtures("styled")


def test_sets_and_partitions_are_their_memberships() -> None:
    (panel,) = fuzzy2.view(fuzzy2.automf(0.0, 10.0))
    assert [line.get_label() for line in panel.lines] == ["poor", "average", "good"]
    assert len(fuzzy2.view(TERMS[0])[0].collections) == 1
    assert len(FUZZY.view()) == 1


def test_a_system_is_the_terms_of_its_inputs_and_outputs() -> None:
    assert [panel.get_xlabel() for panel in SYSTEM.view()] == ["a [m]", "b [m]"]
    terms = fuzzy2.automf(0.0, 1.0)
    rules = "IF a is poor THEN p is good\nIF a is good THEN p is poor"
    system = fuzzy2.Type1System({"a": terms}, rules, {"p": terms}, type_reduction="centroid")
    first, second = system.view()
    assert second.get_xlabel() == "p"
    assert [line.get_label() for line in second.lines] == ["good", "poor"]
    assert fuzzy2.view(system, [first, second]) == (first, second)


def test_clouds_are_their_data_and_densities() -> None:
    firing = fuzzy2.Trapezoidal(0.0, 1.0, np.inf, np.inf)
    said = fuzzy2.Type1System([[firing]] * 2, [[0, -1], [-1, 0]], [[1.0], [2.0]])
    system = fuzzy2.AnYaSystem([[1.0, 3.0], [5.0]], [0, 1], said, ["a", "b"])
    panels = system.view()
    assert [panel.get_xlabel() for panel in panels] == ["a", "b"]
    density, data = panels[0].lines
    assert data.get_xdata().tolist() == [1.0, 3.0]
    assert density.get_ydata().max() == pytest.approx(0.5, rel=1e-12)  # 1 / (1 + 1) between them
    # The picture of an explanation is that of what the densities do: a row a rule and the result.
    assert len(system.explain([2.0, 5.0]).view()) == 3 * 3


def test_a_learner_is_its_system() -> None:
    X = np.random.default_rng(0).normal(size=(60, 2))
    model = fuzzy2.ANFIS(most_epochs=0)
    with pytest.raises(InvalidValue, match="after fit"):
        model.view()
    assert len(model.fit(X, X[:, 0]).view()) == 2


@pytest.mark.parametrize("thing", [None, 3.0, "set"])
def test_what_has_no_picture_is_refused(thing: object) -> None:
    with pytest.raises(InvalidValue, match="a fuzzy set, a system"):
        fuzzy2.view(thing)

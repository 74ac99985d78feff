"""The rule viewer: what is drawn is what the system does."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue
from fuzzy2.plots import figure_of_inference
from tests.fuzzy2.plots.drawn import band, edges
from tests.fuzzy2.plots.subjects import SYSTEM

pytestmark = pytest.mark.usefixtures("styled")

TERMS = fuzzy2.automf(0.0, 10.0)
TIPS = {"low": fuzzy2.Triangular(0.0, 6.0, 13.0), "high": fuzzy2.Triangular(13.0, 19.0, 25.0)}
RULES = "IF food is poor or service is poor THEN tip is low\nIF food is good THEN tip is high"


def tipper() -> fuzzy2.Type1System:
    return fuzzy2.Type1System(
        {"food": TERMS, "service": TERMS},
        RULES,
        {"tip": TIPS},
        "min",
        type_reduction="centroid",
        output_ranges=[(0.0, 25.0)],
    )


def test_a_row_a_rule_with_inputs_marked_and_the_union_below() -> None:
    """Firing 0.3 and 0.5 by hand; the union is both clipped triangles."""
    explanation = tipper().explain([7.5, 3.5])
    panels = np.array(explanation.view(), dtype=object).reshape(3, 3)
    assert [row[0].get_ylabel() for row in panels] == ["rule 1", "rule 2", ""]
    assert panels[0, 0].get_title() == "food: poor"
    for i, value in enumerate((7.5, 3.5)):
        marked = panels[0, i].lines[-1].get_xdata()
        np.testing.assert_array_equal(marked, [value, value])
    assert not panels[1, 1].lines
    result = panels[2, 2]
    union = result.lines[0]
    x = np.asarray(union.get_xdata(), dtype=float)
    expected = np.maximum(np.minimum(TIPS["low"](x), 0.3), np.minimum(TIPS["high"](x), 0.5))
    np.testing.assert_allclose(union.get_ydata(), expected, atol=1e-15)
    (crisp,) = (line for line in result.lines if line.get_label() == "output")
    assert crisp.get_xdata()[0] == tipper()([7.5, 3.5])[0]
    assert result.get_xlabel() == f"tip = {tipper()([7.5, 3.5])[0]:.5g}"


def test_the_clipped_set_of_an_interval_system_lies_between_both_firings() -> None:
    terms = [fuzzy2.GaussianUncertainMean((m - 0.1, m + 0.1), 0.5) for m in (0.0, 1.0)]
    said = [
        fuzzy2.IntervalType2Set(
            fuzzy2.Triangular(m, m + 1, m + 2, 0.6), fuzzy2.Triangular(m - 1, m + 1, m + 3)
        )
        for m in (0.0, 2.0)
    ]
    system = fuzzy2.IntervalType2System(
        [terms], [[0], [1]], [[one] for one in said], "product", type_reduction="centroid"
    )
    panels = np.array(system.explain([0.4]).view(), dtype=object).reshape(3, 2)
    low, high = system.firing([0.4])[0]
    clipped, result = panels[0, 1], panels[2, 1]
    assert edges(band(clipped, index=0), 1.0)[1] == pytest.approx(0.6 * low, abs=1e-3)
    assert edges(band(clipped, index=1), 1.0)[1] == pytest.approx(high, abs=1e-3)
    (reduced,) = (patch for patch in result.patches if patch.get_label() == "reduced")
    left, right = system.type_reduced([0.4])[0]
    assert reduced.get_x() == left  # type: ignore[attr-defined]
    assert reduced.get_x() + reduced.get_width() == pytest.approx(right)  # type: ignore[attr-defined]


def test_numbers_stand_as_high_as_their_rules_fire() -> None:
    """Also those of Takagi-Sugeno-Kang rules, at the input."""
    terms = [[fuzzy2.Triangular(-1.0, 0.0, 1.0), fuzzy2.Triangular(0.0, 1.0, 2.0)]]
    linear = fuzzy2.Linear([[[1.0, 2.0]], [[0.0, -4.0]]])
    panels = fuzzy2.Type1System(terms, [[0], [1]], linear).explain([0.25]).view()
    (stem, *_) = panels[1].collections[0].get_segments()  # type: ignore[attr-defined]
    np.testing.assert_allclose(stem, [[1.5, 0.0], [1.5, 0.75]])


def test_general_type_2_systems_have_their_lowest_plane_drawn() -> None:
    terms = [fuzzy2.GaussianType2Set(fuzzy2.Gaussian(m, 0.7), 0.1) for m in (-1.0, 1.0)]
    system = fuzzy2.GeneralType2System([terms], [[0], [1]], [[-1.0], [1.0]])
    panels = np.array(system.explain([0.3]).view(), dtype=object).reshape(3, 2)
    plane = terms[0].alpha_plane(system.alphas[0])
    upper = panels[0, 0].lines[0]
    np.testing.assert_allclose(upper.get_ydata(), plane.upper(upper.get_xdata()), atol=1e-12)
    (crisp,) = (line for line in panels[2, 1].lines if line.get_label() == "output")
    assert crisp.get_xdata()[0] == system([0.3])[0]
    gaussian = system.replace(reduction="gaussian")
    mean, deviation = gaussian.type_reduced([0.3])[0]
    result = gaussian.explain([0.3]).view()[-1]
    (reduced,) = (patch for patch in result.patches if patch.get_label() == "reduced")
    assert reduced.get_x() == pytest.approx(mean - deviation)


def test_where_no_rule_fires_the_first_rules_are_drawn() -> None:
    panels = tipper().explain([5.0, 5.0]).view()
    assert len(panels) == 9
    assert panels[-1].get_xlabel() == "tip = no rule fires"


def test_other_outputs_and_numbers_of_axes_are_refused() -> None:
    explanation = SYSTEM.explain([0.1, 0.2])
    with pytest.raises(InvalidValue, match="output"):
        figure_of_inference(explanation, 2)
    panels = figure_of_inference(explanation, 1)
    assert len(panels) == 3 * (len(explanation.ranking(1)[:12]) + 1)
    with pytest.raises(InvalidValue, match="axes"):
        explanation.view(panels[0])

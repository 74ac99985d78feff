"""Figures of systems: outputs and bounds are those of the system."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fuzzy2 import plots
from fuzzy2.errors import ApproximationWarning, InvalidValue
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.shapes import Gaussian, Triangular
from fuzzy2.systems import GeneralType2System, Type1System
from tests.fuzzy2.plots.drawn import band, curve, edges
from tests.fuzzy2.plots.subjects import SYSTEM

Array = NDArray[np.float64]

pytestmark = pytest.mark.usefixtures("styled")


def test_response_shows_output_and_bounds() -> None:
    (panel,) = plots.figure_of_response(SYSTEM, varied=1, held=[0.3, 0.0], domain=(-0.5, 0.8))
    b, y = curve(panel, "output")
    X = np.stack([np.full_like(b, 0.3), b], axis=-1)
    np.testing.assert_array_equal(y, [SYSTEM(one)[0] for one in X])
    low, high = edges(band(panel, "type-reduced set"), b[100])
    np.testing.assert_array_equal([low, high], SYSTEM.type_reduced(X[100])[0])
    assert (b[0], b[-1]) == (-0.5, 0.8)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("b [m]", "force [N]")


def test_response_has_no_line_where_no_rule_fires_and_no_band_without_uncertainty() -> None:
    system = Type1System(
        [[Triangular(0.0, 1.0, 2.0), Triangular(3.0, 4.0, 5.0)]], [[0], [1]], [[1.0], [7.0]]
    )
    (panel,) = plots.figure_of_response(system, domain=(0.0, 5.0))
    x, y = curve(panel, "output")
    np.testing.assert_array_equal(np.isnan(y), (x <= 0.0) | ((x >= 2.0) & (x <= 3.0)) | (x >= 5.0))
    assert not panel.collections
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x1", "y1")


def test_bounds_of_the_gaussian_corollary_are_one_standard_deviation() -> None:
    terms = [GaussianType2Set(principal=Gaussian(m, 1.0), sigma=0.05) for m in (0.0, 2.0)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ApproximationWarning)
        system = GeneralType2System([terms], [[0], [1]], [[0.0], [1.0]], reduction="gaussian")
    (panel,) = plots.figure_of_response(system)
    x, y = curve(panel, "output")
    mean, sigma = system.type_reduced([x[200]])[0]
    np.testing.assert_allclose(
        [y[200], *edges(band(panel, "type-reduced set"), x[200])],
        [mean, mean - sigma, mean + sigma],
        rtol=1e-12,
    )


def test_rule_surface_lies_between_its_bounds(drawn: list[Array]) -> None:
    panel: Any = plots.figure_of_rule_surface(SYSTEM, domains=((-1.0, 1.0), (-0.5, 0.5)))[0]
    surface, lower, upper = drawn
    X = np.moveaxis(surface[:2], 0, -1)
    np.testing.assert_array_equal([X[0, 0], X[-1, -1]], [[-1.0, -0.5], [1.0, 0.5]])
    np.testing.assert_allclose(surface[2], SYSTEM(X)[..., 0], rtol=1e-14)
    np.testing.assert_array_equal(
        np.stack([lower[2], upper[2]], axis=-1), SYSTEM.type_reduced(X)[..., 0, :]
    )
    assert (lower[2] < surface[2]).all()
    assert (surface[2] < upper[2]).all()
    assert [one.get_label() for one in panel.collections[1:]] == ["lower bound", "upper bound"]
    assert (panel.get_xlabel(), panel.get_ylabel(), panel.get_zlabel()) == (
        "a [m]",
        "b [m]",
        "force [N]",
    )


def test_rule_surface_of_a_constant_type_1_system(drawn: list[Array]) -> None:
    term = Gaussian(0.0, 1.0)
    system = Type1System([[term], [term]], [[0, 0]], [[2.0]])
    panel: Any = plots.figure_of_rule_surface(system, domains=((-1.0, 1.0), (-1.0, 1.0)))[0]
    (surface,) = drawn
    np.testing.assert_allclose(surface[2], 2.0, rtol=1e-14)
    assert panel.get_legend() is None


def test_held_inputs_must_be_one_for_each_input() -> None:
    with pytest.raises(InvalidValue, match="one value for each of the 2 inputs"):
        plots.figure_of_response(SYSTEM, held=[1.0])


def test_a_domain_must_have_two_different_ends() -> None:
    with pytest.raises(InvalidValue, match="two different numbers"):
        plots.figure_of_response(SYSTEM, domain=(1.0, 1.0))

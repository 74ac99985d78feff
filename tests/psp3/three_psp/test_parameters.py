"""Parameters: the thesis's Table 3.1, the named readings of it, and what is refused."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from psp3 import PARAMETER_SETS, Parameters, PSP3Error
from psp3.errors import InvalidValue, UnknownName
from psp3.three_psp.parameters import named_parameters


def test_default_is_table_3_1_with_the_star_inertia_divided_by_ten() -> None:
    """The table's numbers typed in again; equality, because they are literals."""
    parameters = Parameters()
    assert (parameters.screw_radius, parameters.tool_length) == (0.181, 0.070)
    assert (parameters.nut_mass, parameters.ball_mass, parameters.star_mass) == (
        7.175,
        0.357,
        1.758,
    )
    assert parameters.nut_inertia == (0.003, 0.39, 0.3294)
    assert (parameters.ball_transverse_inertia, parameters.ball_axial_inertia) == (
        0.094e-3,
        0.1117e-3,
    )
    # In the print the large moment is the second one: the thesis's star axis is its y.
    assert parameters.star_inertia == (0.6451 / 10, 0.6451 / 10, 1.2901 / 10)
    assert parameters.gravity == 9.81


def test_named_sets_differ_in_star_inertia_and_gravity_only() -> None:
    default = PARAMETER_SETS["default"]
    assert set(PARAMETER_SETS) == {"default", "table_3_1", "table_5_1"}
    assert PARAMETER_SETS["table_3_1"].star_inertia == (0.6451, 0.6451, 1.2901)
    assert PARAMETER_SETS["table_3_1"].gravity == 9.81
    assert PARAMETER_SETS["table_5_1"].star_inertia == (0.06451, 0.12901, 0.06451)
    assert PARAMETER_SETS["table_5_1"].gravity == 9.806
    for parameters in PARAMETER_SETS.values():
        for field in fields(Parameters):
            if field.name not in {"star_inertia", "gravity"}:
                assert getattr(parameters, field.name) == getattr(default, field.name)


def test_total_mass_is_that_of_the_thirteen_bodies() -> None:
    """Three nuts, nine ball bodies and the star weigh 26.496 kg; 1e-14 is rounding."""
    assert Parameters().total_mass == pytest.approx(26.496, rel=1e-14)
    own = Parameters(nut_mass=1.0, ball_mass=0.1, star_mass=0.5)
    assert own.total_mass == pytest.approx(3 * 1.0 + 9 * 0.1 + 0.5, rel=1e-14)


def test_named_parameters_returns_sets_by_name_and_instances_as_they_are() -> None:
    own = Parameters(tool_length=0.1)
    assert named_parameters(own) is own
    assert named_parameters("table_5_1") is PARAMETER_SETS["table_5_1"]


def test_unknown_set_is_refused_with_the_known_names() -> None:
    with pytest.raises(UnknownName, match=r"table_9_9.*default, table_3_1, table_5_1") as caught:
        named_parameters("table_9_9")
    assert caught.value.name == "table_9_9"
    assert caught.value.known == ("default", "table_3_1", "table_5_1")
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, PSP3Error)


@pytest.mark.parametrize(
    "name", ["screw_radius", "tool_length", "nut_mass", "ball_mass", "star_mass"]
)
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_lengths_and_masses_must_be_positive(name: str, value: float) -> None:
    with pytest.raises(InvalidValue, match=name) as caught:
        Parameters(**{name: value})
    assert caught.value.name == name
    assert caught.value.value is value


@pytest.mark.parametrize("name", ["ball_axial_inertia", "ball_transverse_inertia", "gravity"])
@pytest.mark.parametrize("value", [-1e-9, np.nan, np.inf])
def test_moments_and_gravity_must_not_be_negative(name: str, value: float) -> None:
    with pytest.raises(InvalidValue, match=name):
        Parameters(**{name: value})
    assert getattr(Parameters(**{name: 0.0}), name) == 0.0


@pytest.mark.parametrize("name", ["nut_inertia", "star_inertia"])
@pytest.mark.parametrize(
    "moments", [(1.0, 2.0), (1.0, 2.0, 3.0, 4.0), 1.0, (1.0, -2.0, 3.0), (1.0, np.nan, 3.0)]
)
def test_moments_of_a_body_must_be_three_numbers(name: str, moments: object) -> None:
    """A pair or a scalar must not wait for a stray TypeError in the middle of loading."""
    with pytest.raises(InvalidValue, match=name):
        Parameters(**{name: moments})  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["long", None, (0.1, 0.2)])
def test_a_length_must_be_a_number(value: object) -> None:
    with pytest.raises(InvalidValue, match="screw_radius"):
        Parameters(screw_radius=value)  # type: ignore[arg-type]


def test_as_dict_gives_back_the_same_parameters() -> None:
    own = Parameters(tool_length=0.1, star_inertia=(0.1, 0.2, 0.15))
    assert Parameters(**own.as_dict()) == own  # type: ignore[arg-type]


def test_array_for_the_closed_form_sums_what_moves_together() -> None:
    """Each body's moment counts for the rotations that turn it; 1e-15 is rounding."""
    p = Parameters(
        ball_axial_inertia=2e-3, ball_transverse_inertia=3e-3, star_inertia=(0.1, 0.2, 0.3)
    )
    expected = [
        0.181,
        0.070,
        7.175 + 3 * 0.357,
        1.758,
        # Three lambda bodies turn with the star, their own axes along its axis.
        0.1 + 3 * 3e-3,
        0.2 + 3 * 3e-3,
        0.3 + 3 * 2e-3,
        # The phi body turns about its own axis; the theta body feels phi across its own axis.
        2e-3 + 3e-3,
        2e-3,
        9.81,
    ]
    np.testing.assert_allclose(p.as_array(), expected, rtol=1e-15)

"""What documents of IEEE 1855 cannot say."""

from __future__ import annotations

import math
from typing import Any

import pytest

from fuzzy2.errors import NotExpressible
from fuzzy2.files.fml import format_fml
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.sets.shapes import Gaussian, Trapezoidal
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet
from fuzzy2.systems import IntervalType2System, Type1System

G, N = Gaussian(0, 1), [[1.0]]


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (IntervalType2System([[GaussianUncertainMean((0, 1), 1)]], [[0]], N), "type-1 sets only"),
        (
            Type1System([[G]], [[0]], [G], type_reduction="center_of_sums"),
            "its accumulation unites",
        ),
        (Type1System([[G]], [[0]], [G]), "type reduction 'center_of_sets'"),
        (Type1System([[G]], [[0]], [[[1.0, 2.0]]]), "its constants are crisp"),
        (Type1System([[Bell(0, 1, 2)]], [[0]], N), "it has no such shape"),
        (Type1System([[PiShaped(0, 1, 2, 3)]], [[0]], N), "it has no such shape"),
        (Type1System([[TwoSidedGaussian((0, 1), (1, 2))]], [[0]], N), "it has no such shape"),
        (Type1System([[Complement(Complement(G))]], [[0]], N), "it has no such shape"),
        (Type1System([[Gaussian(0, 1, 0.5)]], [[0]], N), "its membership functions reach 1"),
        (
            Type1System([[SampledSet([0, 1], [0.5, 0]), G]], [[0]], N),
            "let its first and last grade be 0",
        ),
        (
            Type1System([[Trapezoidal(-math.inf, -math.inf, math.inf, math.inf), G]], [[1]], N),
            "it has no such shape",
        ),
        (Type1System([[G]], [[-1]], N), "a rule without an antecedent"),
        (Type1System([[G]], [[0]], N, input_names=["y1"]), "an input and an output of one name"),
        (Type1System([[G]], [[0]], N, term_names=[["a\x00"]]), "the name 'a\\x00'"),
    ],
)
def test_what_fml_cannot_say_is_refused(system: Any, said: str) -> None:
    with pytest.raises(NotExpressible, match="cannot be expressed in FML") as caught:
        format_fml(system)
    assert said in str(caught.value)

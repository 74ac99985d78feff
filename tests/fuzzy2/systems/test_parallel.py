"""Systems side by side answer as each does alone."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2 import ParallelSystem, Triangular, Type1System, from_json, to_json
from fuzzy2.errors import InvalidValue, ReadOnly


def system(output: str, **options: object) -> Type1System:
    terms = {"low": Triangular(-1.0, 0.0, 1.0), "high": Triangular(0.0, 1.0, 2.0)}
    return Type1System(
        {"x": terms, "z": terms},
        ["IF x is low or z is high THEN " + f"{output} is a", f"IF x is high THEN {output} is b"],
        {output: {"a": 1.0, "b": 3.0}},
        **options,  # type: ignore[arg-type] # options differ in type
    )


def test_outputs_side_by_side() -> None:
    first, second = system("u", t_norm="min"), system("v", disjunction="probabilistic")
    both = ParallelSystem([first, second])
    X = np.random.default_rng(0).uniform(-0.5, 1.5, (4, 5, 2))
    np.testing.assert_array_equal(both(X), np.concatenate([first(X), second(X)], axis=-1))
    reduced = both.type_reduced(X)
    assert reduced.shape == (4, 5, 2, 2)
    np.testing.assert_array_equal(reduced[..., 1, :], second.type_reduced(X)[..., 0, :])
    np.testing.assert_array_equal(both(x=0.3, z=0.2), both([0.3, 0.2]))
    assert (both.input_names, both.output_names, both.n_outputs) == (("x", "z"), ("u", "v"), 2)
    assert repr(both).startswith("ParallelSystem([Type1System(2 inputs")
    np.testing.assert_array_equal(from_json(to_json(both))(X), both(X))


def test_what_is_refused() -> None:
    one = system("u")
    for systems in ([], [one, one], [one, 3], [one, one.replace(input_names=["x", "y"])]):
        with pytest.raises(InvalidValue):
            ParallelSystem(systems)  # type: ignore[arg-type] # what is refused
    with pytest.raises(ReadOnly):
        ParallelSystem([one]).systems = ()  # type: ignore[misc]

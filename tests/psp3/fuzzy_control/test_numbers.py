"""M, C and G as one row."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.fuzzy_control.numbers import (
    count_of_numbers,
    joints_of,
    output_names,
    pack,
    places_of,
    unpack,
)


@pytest.mark.parametrize("joints", range(1, 13))
def test_numbers_go_there_and_back_and_their_names_say_which(joints: int) -> None:
    rng = np.random.default_rng(joints)
    root = rng.normal(size=(4, joints, joints))
    M, C, G = root + np.swapaxes(root, 1, 2), rng.normal(size=(4, joints, joints)), root[:, 0]
    numbers = pack(M, C, G)
    assert numbers.shape[-1] == count_of_numbers(joints) == len(output_names(joints))
    assert joints_of(numbers.shape[-1]) == joints
    for found, expected in zip(unpack(numbers), (M, C, G), strict=True):
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(numbers[:, places_of("G", joints)], G)
    assert output_names(3)[:7] == ("M11", "M12", "M13", "M22", "M23", "M33", "C11")
    assert len(set(output_names(joints))) == numbers.shape[-1]

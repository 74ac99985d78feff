"""The places of a tree's arrays: each name has one of its own, and the arrays are as long."""

from __future__ import annotations

import numpy as np

from psp3.multibody import tree
from psp3.multibody.tree import (
    AT_BEFORE,
    AT_BODIES,
    AT_CONFIGURATION,
    AT_DRIVEN,
    AT_ELEMENTS,
    AT_ENDS,
    AT_FREE_FALL,
    AT_SIGNS,
    AT_VECTORS,
    COUNTS,
    ELEMENTS,
    FLOATING,
    HEADER,
    ROWS_OF_KIND,
    SIZE,
)
from tests.psp3.multibody.flat import Flat

PLACES = {name: place for name, place in vars(tree).items() if name.startswith("AT_")}


def test_every_entry_of_the_header_has_one_name() -> None:
    """Counts first, then where parts begin, last the size of the memory."""
    assert (ELEMENTS, FLOATING) == (0, COUNTS - 1)
    assert sorted(PLACES.values()) == list(range(COUNTS, SIZE))
    assert HEADER == SIZE + 1


def test_parts_of_each_array_follow_on_one_another(flat: Flat) -> None:
    """Whole numbers after the header, the other numbers and the memory from their beginnings."""
    integers = flat.tree[AT_ELEMENTS : AT_ENDS + 1]
    numbers = flat.tree[AT_BODIES : AT_FREE_FALL + 1]
    memory = flat.tree[AT_CONFIGURATION : SIZE + 1]
    for begins, first, length in (
        (integers, HEADER, len(flat.tree)),
        (numbers, 0, len(flat.numbers)),
        (memory, 0, len(flat.memory)),
    ):
        assert begins[0] == first
        assert (np.diff(begins) >= 0).all()
        assert begins[-1] <= length
    assert flat.at(AT_FREE_FALL) + 3 == len(flat.numbers)
    assert flat.at(AT_VECTORS) + 42 == len(flat.memory)


def test_a_pose_is_what_stands_before_the_room(flat: Flat) -> None:
    """It can be copied as a whole: signs of the groups are its last part."""
    assert AT_CONFIGURATION < AT_DRIVEN < AT_SIGNS < AT_BEFORE
    assert flat.at(AT_SIGNS) + flat.count(tree.GROUPS) == flat.at(AT_BEFORE)


def test_kinds_of_closures_have_as_many_equations_as_they_take_freedoms() -> None:
    """Of six: a point leaves three, a hinge one, a frame none; a coupling is one equation."""
    kinds = (tree.POINT, tree.HINGE, tree.FRAME, tree.COUPLING)
    assert [ROWS_OF_KIND[kind] for kind in kinds] == [6 - 3, 6 - 1, 6, 1]

"""Parts of a memory that are needed at the same time never share a place."""

from __future__ import annotations

import pytest

import psp3
from psp3.export.robot_memory import (
    CLOSING,
    COLUMNS,
    DYNAMICS,
    FORCES,
    POSE,
    RATES,
    THROUGHOUT,
    laid_out,
)
from psp3.multibody.tree import (
    AT_BEFORE,
    AT_CONFIGURATION,
    AT_FIELDS,
    AT_RATES,
    AT_SECOND_RATES,
    SIZE,
)


@pytest.mark.parametrize("name", ["five_bar", "delta", "biped", "agile_eye"])
@pytest.mark.parametrize("asked", [POSE, FORCES, COLUMNS, RATES])
def test_no_part_lies_over_another(name: str, asked: int) -> None:
    core = psp3.load(name)._core
    tree = laid_out(core.tree, asked)
    pose = int(core.tree[AT_BEFORE])
    assert (tree[AT_CONFIGURATION:AT_BEFORE] == core.tree[AT_CONFIGURATION:AT_BEFORE]).all()
    assert (tree[SIZE + 1 :] == core.tree[SIZE + 1 :]).all()
    full = {at: int(core.tree[at + 1] - core.tree[at]) for at in (*CLOSING, *DYNAMICS, *THROUGHOUT)}
    together = [*CLOSING, *THROUGHOUT], [*DYNAMICS, *THROUGHOUT]
    for parts in together if asked > POSE else together[:1]:
        places = sorted(int(tree[at]) for at in parts)
        assert places[0] >= pose
        ends = [*places[1:], int(tree[SIZE])]
        sizes = {at: ends[places.index(int(tree[at]))] - int(tree[at]) for at in parts}
        assert sum(max(size, 0) for size in sizes.values()) <= tree[SIZE] - pose
    if asked == RATES:
        for at in DYNAMICS[:-1]:
            assert tree[at + 1] - tree[at] == full[at]
    else:
        assert tree[SIZE] < laid_out(core.tree, asked + 1)[SIZE]
    assert tree[AT_SECOND_RATES] == tree[SIZE] < core.tree[SIZE]


def test_columns_are_there_where_they_are_asked_for() -> None:
    tree = psp3.load("delta")._core.tree
    forces, columns = laid_out(tree, FORCES), laid_out(tree, COLUMNS)
    assert forces[AT_FIELDS + 1] == forces[AT_FIELDS]
    assert columns[AT_FIELDS + 1] - columns[AT_FIELDS] == tree[AT_FIELDS + 1] - tree[AT_FIELDS]
    assert columns[AT_RATES + 1] == columns[AT_RATES]

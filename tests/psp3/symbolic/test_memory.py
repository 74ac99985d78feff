"""Arrays whose parts share their entries, and changes that are undone, done again and merged."""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np
import pytest

from psp3.symbolic.memory import Journal, Piece, chosen, piece_of, piece_with, symbols_in

X = casadi.SX.sym("x")


def test_parts_share_their_entries() -> None:
    table = piece_of(np.arange(12.0).reshape(3, 4))
    row = table.row(1)
    part = row.part(slice(1, None))
    assert part.numbers() == [5.0, 6.0, 7.0]
    assert (table.size, row.size, part.size) == (12, 4, 3)
    part.cells[part.place(0)] = -1.0
    assert table.cells[table.place((1, 1))] == -1.0
    assert row.part(slice(1, 4)).is_same(part)
    assert not row.is_same(part)


@pytest.mark.parametrize("index", [-1, 3])
def test_what_is_beyond_the_shape_is_no_entry(index: int) -> None:
    """Not from the end either: compiled kernels do not count so."""
    with pytest.raises(IndexError):
        piece_of(np.zeros(3)).place(index)
    with pytest.raises(IndexError):
        piece_of(np.zeros((3, 2))).row(index)


def test_a_place_that_a_symbol_says_is_none() -> None:
    with pytest.raises(TypeError, match="symbol"):
        piece_of(np.zeros(3)).place(X)


def test_changes_are_undone_and_done_again() -> None:
    journal, cells, names = Journal(), [1.0, 2.0], {"a": 1}

    def change() -> str:
        journal.write(cells, 0, 5.0)
        journal.write(cells, 0, 6.0)
        journal.write(names, "b", 2)
        return "done"

    answer, changes = journal.tried(change)
    assert (answer, cells, names) == ("done", [1.0, 2.0], {"a": 1})
    journal.redo(changes)
    assert (cells, names) == ([6.0, 2.0], {"a": 1, "b": 2})


def test_changes_within_changes_are_undone_together() -> None:
    journal, cells = Journal(), [1.0, 2.0]

    def outer() -> None:
        journal.write(cells, 0, 5.0)
        _, inner = journal.tried(lambda: journal.write(cells, 1, 7.0))
        assert cells == [5.0, 2.0]
        journal.redo(inner)

    _, changes = journal.tried(outer)
    assert cells == [1.0, 2.0]
    journal.redo(changes)
    assert cells == [5.0, 7.0]


def test_merged_changes_are_choices() -> None:
    journal, cells, names = Journal(), [1.0, 2.0], {}
    _, one = journal.tried(lambda: journal.write(cells, 0, 5.0))
    _, other = journal.tried(lambda: journal.write(names, "a", 3.0))
    journal.redo(journal.merged(X > 0.0, one, other))
    first = casadi.Function("f", [X], [cells[0]])
    assert (float(first(1.0)), float(first(-1.0)), cells[1]) == (5.0, 1.0, 2.0)
    # Nobody reads it where it was not written.
    assert names == {"a": 3.0}


def test_values_of_one_kind_are_chosen_between() -> None:
    row = piece_with([1.0])
    assert chosen(X > 0.0, (row, 2.0), (row, 2.0)) == (row, 2.0)
    assert chosen(X > 0.0, row, Piece(row.cells, 0, (1,))) is row
    pair: Any = chosen(X > 0.0, (1.0, 2.0), (3.0, 2.0))
    assert pair[1] == 2.0
    with pytest.raises(TypeError, match="Piece"):
        chosen(X > 0.0, row, piece_with([1.0]))


def test_symbols_of_a_vector() -> None:
    v = casadi.SX.sym("v", 2, 2)
    assert [str(entry) for entry in symbols_in(v).cells] == ["v_0", "v_2", "v_1", "v_3"]

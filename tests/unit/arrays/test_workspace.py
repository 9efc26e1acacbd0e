"""Memory of a thread, kept from one call to the next."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

from contiga.arrays.workspace import MAX_KEPT_ROWS, PAGE_SIZE, Workspace


def test_it_is_the_same_until_more_is_asked_for() -> None:
    space = Workspace()
    few, most, more = 100, PAGE_SIZE // 64, PAGE_SIZE // 64 + 1
    first = space.rows(few, 8)
    assert first.shape == (few, 8)
    assert np.shares_memory(first, space.rows(most, 8))  # a whole page from the first call on
    assert not np.shares_memory(first, space.rows(more, 8))
    assert np.shares_memory(space.rows(more, 8), space.rows(few, 8))


def test_tables_of_other_columns_lie_elsewhere() -> None:
    space = Workspace()
    assert not np.shares_memory(space.rows(100, 8), space.rows(100, 12))


@pytest.mark.parametrize("n", [1, 7, 1000, 100_000])
def test_tables_start_with_a_large_page(n: int) -> None:
    for columns in (8, 12):
        space = Workspace()
        table = space.rows(n, columns)
        assert table.ctypes.data % PAGE_SIZE == 0
        assert space._tables[columns].nbytes >= PAGE_SIZE
        assert table.flags.c_contiguous


def test_threads_have_their_own() -> None:
    space, both = Workspace(), Barrier(2)

    def place(_: int) -> int:
        both.wait()
        return int(space.rows(1000, 8).ctypes.data)

    with ThreadPoolExecutor(2) as pool:
        places = set(pool.map(place, range(2)))
    assert len({*places, space.rows(1000, 8).ctypes.data}) == 3


def test_what_is_large_is_given_back() -> None:
    space = Workspace()
    small = space.rows(10, 2)
    large = space.rows(MAX_KEPT_ROWS + 1, 2)
    assert large.shape == (MAX_KEPT_ROWS + 1, 2)
    assert np.shares_memory(small, space.rows(10, 2))

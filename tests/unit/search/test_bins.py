"""Rows are put in the order of their elements, handed to the lanes and fetched from them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.records import empty_projection, rows_of
from contiga.search.kernels import bins_nb
from contiga.search.kernels.lanes_nb import BY_ROW, LOST, RECORD
from contiga.search.tables import tables_of
from contiga.statuses import Feature, Status

pytestmark = pytest.mark.interpreted


@njit
def bin_rows(tables, feet):
    return bins_nb.bin_rows(tables, feet)


@njit
def hand_rows(path, starts, records):
    bins_nb.hand_rows(path, starts, records)


@njit
def fetch_rows(records, n, first, results):
    bins_nb.fetch_rows(records, n, first, results)


def test_rows_come_in_the_order_of_their_elements_and_blocks_hold_them():
    tables = tables_of(cg.Body([cg.shapes.bumpy_plate(waves=1)]))
    n = 75
    uv = np.random.default_rng(2).random((n, 2))
    patch = np.zeros(n, np.int32)
    patch[[8, 15, 45]] = -1
    order, blocks = bin_rows(tables, (patch, uv))
    np.testing.assert_array_equal(np.sort(order), np.delete(np.arange(n), [8, 15, 45]))
    box = tables.elements.table["box"]
    assert (np.diff(blocks[:, 0]) >= 0).all()
    assert (blocks[0, 1], blocks[-1, 2]) == (0, len(order))
    np.testing.assert_array_equal(blocks[1:, 1], blocks[:-1, 2])
    for e, first, last in blocks:
        assert 0 < last - first <= 16
        rows = order[first:last]
        assert (np.diff(rows) > 0).all()
        assert ((box[e, ::2] <= uv[rows]) & (uv[rows] <= box[e, 1::2])).all()


def test_what_is_handed_stands_at_the_head_of_a_record():
    rng = np.random.default_rng(3)
    before, now = rng.random((2, 3, 3))
    uv, patch = rng.random((3, 2)), np.array([1, -1, 0], np.int32)
    records = np.full((3, RECORD), np.nan)
    hand_rows((before, now), (patch, uv), records)
    for i in (0, 2):
        np.testing.assert_array_equal(records[i, :8], [*now[i], *before[i], *uv[i]])
    assert records[1, 0] == LOST
    assert np.isnan(records[:, 8:]).all()
    without = np.full((3, RECORD), np.nan)
    hand_rows((np.empty((0, 3)), now), (patch, uv), without)
    assert np.isnan(without[:, 3:6]).all()


def test_what_is_found_is_fetched_by_its_flag():
    rng = np.random.default_rng(4)
    out, back = empty_projection(5), np.zeros(4, np.uint8)
    for array in out:
        array[:] = 7
    was = rows_of(out, np.arange(5))
    records = rng.random((4, RECORD))
    records[:, 0] = [BY_ROW, 0.0, LOST, 0.0]
    records[:, 1], records[:, 11] = [1.0, 1.0, 0.0, 0.0], [3.0, 4.0, 9.0, 2.0]
    fetch_rows(records, 4, 1, (out, back))
    assert back.tolist() == [BY_ROW, 0, LOST, 0]
    for own, other in zip(out, was, strict=True):
        np.testing.assert_array_equal(own[[0, 1, 3]], other[[0, 1, 3]])
    found = records[[1, 3]]
    for name, columns in (("uv", [2, 3]), ("point", [4, 5, 6]), ("normal", [7, 8, 9])):
        np.testing.assert_array_equal(getattr(out, name)[[2, 4]], found[:, columns])
    np.testing.assert_array_equal(out.gap[[2, 4]], found[:, 10])
    assert out.patch.tolist() == [7, 7, 4, 7, 2]
    assert (out.feature[2], out.status[2]) == (Feature.FACE, Status.OK)
    assert out.certified[[2, 4]].tolist() == [1, 0]

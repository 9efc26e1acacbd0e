"""Rows are put in the order of their elements, handed to the lanes and fetched from them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.records import empty_projection, rows_of
from contiga.search.kernels import bins_nb
from contiga.search.kernels.lanes_nb import BY_ROW, FOUND, HANDED
from contiga.search.tables import tables_of
from contiga.statuses import Feature, Status

pytestmark = pytest.mark.interpreted


@njit
def bin_rows(tables, feet):
    return bins_nb.bin_rows(tables, feet)


@njit
def hand_rows(place, path, starts, handed):
    bins_nb.hand_rows(place, path, starts, handed)


@njit
def fetch_rows(place, found, first, results):
    bins_nb.fetch_rows(place, found, first, results)


def test_places_are_those_of_the_elements_in_order_and_blocks_hold_them():
    tables = tables_of(cg.Body([cg.shapes.bumpy_plate(waves=1)]))
    n = 75
    uv = np.random.default_rng(2).random((n, 2))
    patch = np.zeros(n, np.int32)
    patch[[8, 15, 45]] = -1
    place, blocks = bin_rows(tables, (patch, uv))
    left = np.isin(np.arange(n), [8, 15, 45])
    assert (place[left] == -1).all()
    np.testing.assert_array_equal(np.sort(place[~left]), np.arange(72))
    box = tables.elements.table["box"]
    assert (np.diff(blocks[:, 0]) >= 0).all()
    np.testing.assert_array_equal(blocks[1:, 1], blocks[:-1, 2])
    for e, first, last in blocks:
        assert 0 < last - first <= 16
        rows = [int(np.flatnonzero(place == at)[0]) for at in range(first, last)]
        assert rows == sorted(rows)
        assert ((box[e, ::2] <= uv[rows]) & (uv[rows] <= box[e, 1::2])).all()


def test_what_is_handed_stands_in_its_place():
    rng = np.random.default_rng(3)
    before, now = rng.random((2, 3, 3))
    uv, place = rng.random((3, 2)), np.array([1, -1, 0], np.int32)
    handed = np.full((2, HANDED), np.nan)
    hand_rows(place, (before, now), uv, handed)
    for i, at in ((0, 1), (2, 0)):
        np.testing.assert_array_equal(handed[at], [*now[i], *before[i], *uv[i]])
    without = np.full((2, HANDED), np.nan)
    hand_rows(place, (np.empty((0, 3)), now), uv, without)
    assert np.isnan(without[:, 3:6]).all()


def test_what_is_found_is_fetched_by_its_flag():
    rng = np.random.default_rng(4)
    out, back = empty_projection(5), np.zeros(4, np.uint8)
    for array in out:
        array[:] = 7
    was = rows_of(out, np.arange(5))
    found = rng.random((3, FOUND))
    found[:, 0], found[:, 1], found[:, 11] = [0.0, 0.0, BY_ROW], [1.0, 0.0, 1.0], [4.0, 2.0, 3.0]
    place = np.array([2, 0, -1, 1], np.int32)
    fetch_rows(place, found, 1, (out, back))
    assert back.tolist() == [BY_ROW, 0, 0, 0]
    for own, other in zip(out, was, strict=True):
        np.testing.assert_array_equal(own[[0, 1, 3]], other[[0, 1, 3]])
    for name, columns in (("uv", [2, 3]), ("point", [4, 5, 6]), ("normal", [7, 8, 9])):
        np.testing.assert_array_equal(getattr(out, name)[[2, 4]], found[:2][:, columns])
    np.testing.assert_array_equal(out.gap[[2, 4]], found[:2, 10])
    assert out.patch.tolist() == [7, 7, 4, 7, 2]
    assert (out.feature[2], out.status[2]) == (Feature.FACE, Status.OK)
    assert out.certified[[2, 4]].tolist() == [1, 0]

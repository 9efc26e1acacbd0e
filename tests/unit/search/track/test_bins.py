"""Rows are put in the order of their elements, handed to the lanes and fetched from them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.unit.search import plain

import contiga as cg
from contiga.arrays.codes import TO_SEARCH, TO_WALK
from contiga.records import SurfacePlaces, empty_projection, rows_of
from contiga.search.track.kernels import bins_nb
from contiga.search.track.kernels.lanes_nb import RECORD_SIZE
from contiga.search.track.track_records import Chunk, Path, empty_pending
from contiga.statuses import Feature, Status

pytestmark = pytest.mark.interpreted


NOBODY = empty_projection(0)
NO_POINTS = np.empty((0, 3))


@njit
def fill_records(tables, path, starts, chunk, records):
    return bins_nb.fill_records(tables, path, starts, chunk, records)


@njit
def order_rows(element, counts):
    return bins_nb.order_rows(element, counts)


@njit
def collect_rows(records, path, starts, chunk, left, out):
    return bins_nb.collect_rows(records, path, starts, chunk, left, 0, out)


@pytest.mark.parametrize("faces", [1, few(121, 9)])
def test_rows_come_in_the_order_of_their_elements_and_blocks_hold_them(faces):
    side = round(faces**0.5)
    plate, even = cg.shapes.bumpy_plate(waves=1), np.linspace(0.0, 1.0, side + 1)
    spans = list(pairwise(even.tolist()))
    tables = plain.joined(cg.Body([plate.restricted(u, v) for u in spans for v in spans]))
    box, home = tables.elements.table["box"], tables.elements.table["patch"]
    assert len(box) > faces
    rng = np.random.default_rng(2)
    n, first, lost = 400, 20, [28, 35, 65]
    patch = rng.integers(0, faces, n).astype(np.int32)
    domain = np.array(
        [[box[home == p].min(0)[[0, 2]], box[home == p].max(0)[[1, 3]]] for p in patch]
    )
    uv = domain[:, 0] + rng.random((n, 2)) * (domain[:, 1] - domain[:, 0])
    patch[lost] = -1
    records = np.empty((n, RECORD_SIZE))
    path = Path(NO_POINTS, rng.random((n, 3)), NOBODY)
    element, counts = fill_records(tables, path, SurfacePlaces(patch, uv), Chunk(first, n), records)
    assert counts.sum() == n - first - len(lost)
    order, blocks = order_rows(element, counts)
    np.testing.assert_array_equal(np.sort(order), np.flatnonzero(patch[first:] >= 0))
    assert (np.diff(blocks[:, 0]) >= 0).all()
    assert (blocks[0, 1], blocks[-1, 2]) == (0, len(order))
    np.testing.assert_array_equal(blocks[1:, 1], blocks[:-1, 2])
    for e, a, b in blocks:
        assert 0 < b - a <= 16
        rows = order[a:b]
        assert (np.diff(rows) > 0).all()
        assert (patch[first + rows] == home[e]).all()
        assert (box[e, ::2] <= uv[first + rows]).all()
        assert (uv[first + rows] <= box[e, 1::2]).all()


def scene():
    """Four points over a plate and their feet, of which the second has none, the third no place."""
    tables, rng = plain.joined(cg.Body([cg.shapes.plane()])), np.random.default_rng(3)
    feet = empty_projection(4)
    for array in feet:
        array[:] = 0
    feet.certified[:] = 1
    feet.point[:], feet.normal[:], feet.uv[:] = rng.random((4, 3)), rng.random((4, 3)), 0.5
    feet.gap[:] = [0.1, 0.2, 0.3, -0.4]
    feet.patch[1], feet.status[2:] = -1, (Status.NOT_FINITE, Status.BRANCH_EVENT)
    was = feet.point + feet.gap[:, None] * feet.normal
    was[2] = np.nan
    return tables, rng.random((4, 3)), feet, was


@pytest.mark.parametrize("told", ["not", "by points", "by feet"])
def test_what_is_handed_stands_at_the_head_of_a_record(told):
    tables, now, feet, was = scene()
    path = Path(
        was if told == "by points" else NO_POINTS, now, feet if told == "by feet" else NOBODY
    )
    records = np.full((3, RECORD_SIZE), np.nan)
    fill_records(tables, path, SurfacePlaces(feet.patch, feet.uv), Chunk(1, 4), records)
    for i in (1, 2):
        np.testing.assert_array_equal(records[i, :3], now[1 + i])
        np.testing.assert_array_equal(records[i, 6:8], feet.uv[1 + i])
        before = np.full(3, np.nan) if told == "not" else was[1 + i]
        np.testing.assert_allclose(records[i, 3:6], before, rtol=1e-15)
    assert records[0, 0] == TO_SEARCH
    assert np.isnan(records[:, 8:]).all()


@pytest.mark.parametrize("told", ["not", "by points", "by feet"])
def test_what_is_found_is_fetched_by_its_flag_and_the_rest_is_kept(told):
    rng = np.random.default_rng(4)
    _, _, out, was = scene()
    out = rows_of(out, np.array([0, 0, 1, 2, 3]))
    was = was[[0, 0, 1, 2, 3]]
    out.patch[:] = [5, 6, 7, 8, 9]
    last = rows_of(out, np.arange(5))
    records = rng.random((4, RECORD_SIZE))
    records[:, 0] = [TO_WALK, 0.0, TO_SEARCH, 0.0]
    records[:, 1], records[:, 11] = [1.0, 1.0, 0.0, 0.0], [3.0, 4.0, 9.0, 2.0]
    records = records[[0, 1, 3, 2]]
    path = Path(was if told == "by points" else NO_POINTS, np.empty((5, 3)), NOBODY)
    path = path._replace(feet=out) if told == "by feet" else path
    # The feet that were started from are written over.
    room = empty_pending(4)
    m = collect_rows(records, path, SurfacePlaces(out.patch, out.uv), Chunk(1, 5), room, out)
    rows, flags, before, patch, uv = (column[:m] for column in room)
    left = [1, 4] if told == "not" else [1, 3, 4]
    assert rows.tolist() == left
    assert flags.tolist() == [{1: TO_WALK, 3: 0, 4: TO_SEARCH}[k] for k in left]
    np.testing.assert_array_equal(patch, last.patch[left])
    np.testing.assert_array_equal(uv, last.uv[left])
    if told != "not":
        np.testing.assert_allclose(before, was[left], rtol=1e-15)
    for own, other in zip(out, last, strict=True):
        np.testing.assert_array_equal(own[[0, 1, 4]], other[[0, 1, 4]])
    found, done = records[[1, 2]], [2, 3]
    for name, columns in (("uv", [2, 3]), ("point", [4, 5, 6]), ("normal", [7, 8, 9])):
        np.testing.assert_array_equal(getattr(out, name)[done], found[:, columns])
    np.testing.assert_array_equal(out.gap[done], found[:, 10])
    assert out.patch[done].tolist() == [4, 2]
    assert (out.feature[2], out.status[3]) == (Feature.FACE, Status.OK)
    assert out.certified[done].tolist() == [1, 0]

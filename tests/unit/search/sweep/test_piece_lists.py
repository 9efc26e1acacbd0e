"""Pieces near voxels say of a path that it is clear only where it crosses nothing."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search.closest.test_global import rough
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.records import empty_hit
from contiga.search.sweep import piece_lists
from contiga.search.sweep.kernels import hit_nb, piece_lists_nb
from contiga.search.tables import tables_of
from contiga.statuses import Status


@njit
def clear_ones(lists, a, b, spare):
    out = np.empty(len(a), np.bool_)
    for i in range(len(a)):
        p, q = (a[i, 0], a[i, 1], a[i, 2]), (b[i, 0], b[i, 1], b[i, 2])
        out[i] = piece_lists_nb.is_clear(lists, p, q, spare)
    return out


BODIES = {
    "rough": lambda: cg.Body([rough(1)]),
    "trimmed": holed_plate,
    "with poles": lambda: cg.Body([cg.shapes.sphere()]),
    "far off": lambda: cg.Body([cg.shapes.torus().translated([3e3, -2e3, 1e3])]),
}


def paths(body, n=4000, seed=1):
    """Paths of every length beside, along and through a body: ends (n, 3)."""
    rng = np.random.default_rng(seed)
    on = np.concatenate([cg.clouds.random_on(p, n, seed=seed) for p in body.patches])[:n]
    size = body.size
    way = rng.normal(size=(n, 3)) * size * 10.0 ** rng.uniform(-9.0, -0.5, (n, 1))
    a = on + rng.normal(size=(n, 3)) * size * 10.0 ** rng.uniform(-9.0, -1.0, (n, 1))
    a -= rng.random((n, 1)) * way
    return a, a + way


def hits(tables, lists, a, b):
    """First entries and last crossings."""
    first, last, verdict = empty_hit(len(a)), empty_hit(len(a)), np.zeros((len(a), 2))
    rows = np.arange(len(a), dtype=np.int32)
    hit_nb.first_hits(tables, lists, a, b, rows, first, 0, len(a))
    hit_nb.last_crossings(tables, lists, a, b, (0.0, 2.0), last, verdict, 0, len(a))
    return (*first, *last, verdict)


@pytest.mark.parametrize("name", BODIES)
def test_hits_are_the_same_bits_with_lists_and_without(name):
    body = BODIES[name]()
    tables = tables_of(body)
    a, b = paths(body)
    lists = piece_lists.build_lists(tables)
    found = hits(tables, lists, a, b)
    for own, other in zip(found, hits(tables, piece_lists.NO_LISTS, a, b), strict=True):
        np.testing.assert_array_equal(own, other)
    assert (found[4] == Status.OK).sum() > 300
    # And they tell of most of what is not very close to the surface that it crosses nothing.
    nothing = found[-1][:, 0] == 0.0
    short = nothing & (np.linalg.norm(b - a, axis=1) < 0.01 * body.size)
    assert clear_ones(lists, a[short], b[short], 0.0).mean() > 0.35


def test_every_piece_is_listed_where_its_surface_lies():
    body = cg.Body([rough(2)])
    lists = piece_lists.build_lists(tables_of(body))
    p = cg.clouds.random_on(body.patches[0], 3000, seed=2) - lists.origin
    voxel = np.ravel_multi_index(tuple((p * lists.scale).astype(int).T), lists.voxels)
    for x, v in zip(p, voxel, strict=True):
        own = lists.pieces[lists.listed[lists.first[v] : lists.first[v + 1]]]
        height = own[:, 6:9] @ x
        held = ((own[:, :3] <= x) & (x <= own[:, 3:6])).all(axis=1)
        assert (held & (own[:, 9] <= height) & (height <= own[:, 10])).any()


def test_nothing_is_said_of_long_paths_of_what_is_no_number_and_beyond_the_grid():
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    lists = piece_lists.build_lists(tables_of(body))
    over = np.array([0.1, 0.1, 0.05])
    voxel = 1.0 / lists.scale
    a = np.array([over, over, [np.nan, 0.0, 0.05], over + 5.0, [0.1, 0.1, -0.01]])
    b = a + np.array([0.1 * voxel, 0.0, 0.0])
    b[1, 0] = a[1, 0] + 20.0 * voxel
    b[4, 2] = 0.01
    assert clear_ones(lists, a, b, 0.0).tolist() == [True, False, False, False, False]
    assert not clear_ones(lists, a, b, 2.0 * lists.reach).any()
    assert not clear_ones(piece_lists.NO_LISTS, a, b, 0.0).any()


def test_nothing_is_listed_where_edges_are_so_wide_that_all_pieces_are_everywhere():
    tables = tables_of(cg.Body([rough(2)]))
    elements = tables.elements._replace(table=tables.elements.table.copy())
    elements.table["edge_tolerance"] = 0.05 * float(tables.scale[0])
    assert piece_lists.build_lists(tables) is not piece_lists.NO_LISTS
    assert piece_lists.build_lists(tables._replace(elements=elements)) is piece_lists.NO_LISTS


def test_lists_are_made_once_they_are_worth_it(monkeypatch):
    tables = tables_of(cg.Body([cg.shapes.torus()]))
    monkeypatch.setattr(piece_lists, "MIN_PATHS", 100)
    assert piece_lists.lists_of(tables, 60) is piece_lists.NO_LISTS
    lists = piece_lists.lists_of(tables, 60)
    assert len(lists.pieces) > 0
    assert piece_lists.lists_of(tables, 1) is lists

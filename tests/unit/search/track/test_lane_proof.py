"""The quick certificate in lanes proves what it proves of each foot alone."""

from __future__ import annotations

import re

import numpy as np
import pytest
from tests.laws.test_search_laws import surface
from tests.unit.search.folds import ring
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.records import empty_projection
from contiga.search.certify.kernels import branch_nb
from contiga.search.hierarchy.table_types import NEIGHBOURHOOD
from contiga.search.track.kernels import lanes_nb
from contiga.search.track.track_records import PendingRows

from .test_lanes import PATCHES, in_lanes, vector_code

BODIES = {
    **{name: [patch] for name, patch in PATCHES.items()},
    "with creases": [surface(6, (2, 2), (3, 3), log_weights=0.3, multiplicity=2)],
    "in four": [b for a in cg.shapes.torus().split(u=0.3) for b in a.split(v=0.6)],
}


def test_numbers_of_a_record_are_where_lanes_look_for_them():
    places = {name: NEIGHBOURHOOD.fields[name][1] for name in NEIGHBOURHOOD.names}
    rows = lanes_nb
    expected = {
        "curvature": rows.CURVATURE,
        "room": rows.ROOM,
        "speed": rows.SPEED,
        "width": rows.WIDTH,
        "block": rows.BLOCK,
        "ends": rows.ENDS,
    }
    assert {name: places[name] for name in expected} == {n: 8 * r for n, r in expected.items()}
    assert NEIGHBOURHOOD.itemsize == 8 * rows.NEIGHBOURHOOD_SIZE
    assert NEIGHBOURHOOD["ends"].shape == (4,)
    assert NEIGHBOURHOOD["ends"].base == np.int8


@pytest.mark.parametrize("kind", BODIES)
def test_lanes_prove_what_the_bounds_around_a_foot_prove_one_by_one(kind):
    """All of it, but for ways over a pole."""
    body = cg.Body(BODIES[kind])
    tables, rng = tracking_tables_of(body), np.random.default_rng(4)
    low, high = body.bounds()
    at = body.project(low + (high - low) * rng.uniform(0.0, 1.0, (3000, 3)))
    p = at.point + 0.02 * body.size * rng.uniform(-1.0, 1.0, (3000, 1)) * at.normal
    start = body.project(p)
    q = p + 10.0 ** rng.uniform(-6.0, -2.0, (3000, 1)) * body.size * rng.normal(size=p.shape)
    out = empty_projection(len(q))
    back = in_lanes(tables, q, start, out, p)
    done = back == 0
    in_lanes_proved = out.certified.copy()
    assert set(np.unique(in_lanes_proved[done])) == {0, 1}
    out.certified[:] = 0
    rows = np.flatnonzero(done)
    few = type(out)(*(x[rows] for x in out))
    n = len(rows)
    own, flags = np.arange(n, dtype=np.int32), np.zeros(n, np.uint8)
    left = PendingRows(own, flags, p[rows], start.patch[rows], start.uv[rows])
    branch_nb.certify_rows(tables, q[rows], left, n, few)
    alone = few.certified == 1
    told = in_lanes_proved[rows] == 1
    assert not (told & ~alone).any()
    if "pole" not in kind:
        np.testing.assert_array_equal(told, alone)
    assert told.sum() > 500


def test_where_no_bounds_are_kept_nothing_is_proved():
    """Behind the empty array lie the bounds, where a proof would find them."""
    body = cg.Body([PATCHES["rational"]])
    tables, rng = tracking_tables_of(body), np.random.default_rng(7)
    p = body.project(rng.normal(size=(500, 3))).point + 0.01
    start, q = body.project(p), p + 1e-4
    found = []
    for kept in (tables, tables._replace(neighbourhoods=tables.neighbourhoods[:0])):
        out = empty_projection(len(q))
        done = in_lanes(kept, q, start, out, p) == 0
        found.append((out.certified[done], out.point[done]))
    assert found[0][0].mean() > 0.9
    assert not found[1][0].any()
    np.testing.assert_array_equal(found[0][1], found[1][1])


def test_the_ball_of_a_proof_ends_before_the_face_does():
    """On a plate that ends, of one element: it is as large as the motion, and a tenth more."""
    body = cg.Body([cg.shapes.plane()])
    tables, rng = tracking_tables_of(body), np.random.default_rng(6)
    p = np.column_stack([rng.uniform(-0.49, 0.49, (3000, 2)), np.full(3000, 0.1)])
    start = body.project(p)
    q = p + rng.uniform(-0.1, 0.1, (3000, 3)) * [1.0, 1.0, 0.0]
    out = empty_projection(len(q))
    back = in_lanes(tables, q, start, out, p)
    off, far = 0.5 - np.abs(q[:, :2]).max(axis=1), np.linalg.norm(q - p, axis=1)
    proved = (out.certified == 1) & (back == 0)
    assert (off[proved] > 1.1 * far[proved]).all()
    assert (proved & (off < 1.7 * far)).sum() > 50


def test_lanes_look_at_holes_within_the_ball_of_a_proof():
    plate = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
    body = cg.Body([plate], trims=[[ring(0.0, 1.0), ring(0.4, 0.6)]])
    tables = tracking_tables_of(body)
    rng = np.random.default_rng(5)
    p = np.column_stack([rng.uniform(0.05, 0.35, (2000, 2)), np.full(2000, 0.1)])
    start = body.project(p)
    q = p + rng.uniform(-0.05, 0.05, (2000, 3)) * [1.0, 1.0, 0.0]
    out = empty_projection(len(q))
    back = in_lanes(tables, q, start, out, p)
    far = np.linalg.norm(q - p, axis=1)
    off = np.minimum(q[:, :2], np.maximum(0.0, 0.4 - q[:, :2]).max(axis=1)[:, None]).min(axis=1)
    proved = (out.certified == 1) & (back == 0)
    assert (off[proved] > far[proved]).all()
    assert proved[(off > 4.0 * far) & (back == 0)].mean() > 0.9


def test_the_loop_over_the_lanes_of_a_proof_is_vector_code():
    lanes, told = (
        np.zeros((lanes_nb.BANKS, lanes_nb.ROWS * lanes_nb.BANK_WIDTH)),
        np.ones(lanes_nb.ELEMENT_SIZE),
    )
    kernel = getattr(lanes_nb, "prove_lanes")  # noqa: B009
    code = vector_code(kernel, lanes, lanes_nb.BANKS, told, 1e-12)
    assert len(re.findall(r"fmul <\d+ x double>", code)) > 30

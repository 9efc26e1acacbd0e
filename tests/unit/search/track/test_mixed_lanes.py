"""Rows that share a vector, an element each, find what those of one element find together."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numba import njit
from tests.stress.tracking import slivers
from tests.unit.search.folds import ring
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.arrays.codes import TO_WALK
from contiga.elements.element_arrays import ELEMENT
from contiga.records import empty_projection, rows_of
from contiga.search.track.kernels import lanes_nb, mixed_lanes_nb

from .test_lanes import PATCHES, in_lanes, vector_code

PLATE = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
BODIES = {
    **{name: cg.Body([patch]) for name, patch in PATCHES.items()},
    "turned about": cg.Body(slivers(PATCHES["rational"])),
    "of both kinds": cg.Body([cg.shapes.bumpy_plate(), cg.shapes.torus(major=0.5, minor=0.2)]),
    "with a hole": cg.Body([PLATE], trims=[[ring(0.0, 1.0), ring(0.4, 0.6)]]),
}


def step(body, way, n=1200):
    """Points near a body, their feet, and where the points are after a step."""
    rng = np.random.default_rng(7)
    low, high = body.bounds()
    at = body.project(low + (high - low) * rng.uniform(0.0, 1.0, (n, 3)))
    p = at.point + 0.02 * body.size * rng.uniform(-1.0, 1.0, (n, 1)) * at.normal
    return p, body.project(p), p + way * body.size * rng.normal(size=p.shape)


def tracked(body, p, start, q, rows):
    """Of these rows, in the order of `rows`, and which are done."""
    out = empty_projection(len(rows))
    back = in_lanes(tracking_tables_of(body), q[rows], rows_of(start, rows), out, p[rows])
    return out, back == 0


@pytest.mark.parametrize("way", [1e-6, 1e-2])
@pytest.mark.parametrize("kind", BODIES)
def test_a_row_alone_finds_the_bits_that_it_finds_among_others_of_its_element(kind, way):
    p, start, q = step(BODIES[kind], way)
    all_rows = np.arange(len(p))
    whole, done = tracked(BODIES[kind], p, start, q, all_rows)
    assert done.mean() > 0.5
    assert whole.certified[done].mean() > 0.2
    # Their elements have dozens of all rows or hundreds, so most find theirs in lanes of their own.
    for few in (*all_rows[:, None], *np.array_split(all_rows[::-1], 100)):
        out, back = tracked(BODIES[kind], p, start, q, few)
        np.testing.assert_array_equal(back, done[few])
        for own, other in zip(out, whole, strict=True):
            assert own[back].tobytes() == other[few][back].tobytes()


def test_a_row_that_leaves_its_element_waits_again_and_one_that_leaves_two_is_flagged():
    body = cg.Body(cg.shapes.plane().split(u=0.5))
    tables = tracking_tables_of(body)
    box = tables.elements.table["box"]
    far = np.array([0.0, 0.1, 0.3, 0.8, 0.9, 2.0])
    p = np.column_stack([np.full(6, -0.2), np.zeros(6), np.full(6, 0.1)])
    q = p + far[:, None] * [1.0, 0.0, 0.0]
    start = body.project(p)
    assert len(box) == 2
    for rows in (np.arange(6), *np.arange(6)[:, None]):
        out, done = tracked(body, p, start, q, rows)
        inside = far[rows] < 0.5
        np.testing.assert_array_equal(done, inside)
        np.testing.assert_allclose(out.point[done][:, 0], q[rows][done][:, 0], atol=1e-15)
        assert (out.patch[done] == (q[rows][done][:, 0] > 0.0)).all()


@njit
def gone_on(tables, e, left, point):
    """The record of one row that was at (s, t) = left of element e, however it got there."""
    lanes, records = lanes_nb.new_lanes(lanes_nb.ROWS), np.zeros((1, lanes_nb.RECORD_SIZE))
    queue = mixed_lanes_nb.new_queue()
    bank, n = lanes[0], lanes_nb.BANK_WIDTH
    for c in range(3):
        bank[(lanes_nb.ROW_NOW + c) * n] = point[c]
        bank[(lanes_nb.ROW_BEFORE + c) * n] = point[c]
    bank[lanes_nb.ROW_S * n], bank[lanes_nb.ROW_T * n] = left
    bank[lanes_nb.ROW_F * n] = 1.0
    bank[lanes_nb.ROW_START * n] = bank[(lanes_nb.ROW_START + 1) * n] = 0.5
    mixed_lanes_nb.enqueue_left(tables, e, bank, 0, 0, queue, 0)
    waiting = mixed_lanes_nb.process_queue(tables, True, queue, 1, records)
    return records[0], waiting


def test_a_row_that_has_left_for_nowhere_is_flagged_wherever_its_foot_would_be():
    """Over the border of a plate, and over the edge that two plates meet at at an angle."""
    wall = cg.shapes.bilinear([1, 0, 0], [1, 0, 1], [1, 1, 0], [1, 1, 1])
    for body in (cg.Body([PLATE]), cg.Body([PLATE, wall])):
        record, waiting = gone_on(tracking_tables_of(body), 0, (0.7, 0.0), (0.5, 0.5, 0.1))
        assert (record[lanes_nb.FLAG], waiting) == (TO_WALK, 0)
    flat = cg.Body([PLATE, PLATE.translated([1.0, 0.0, 0.0])])
    record, waiting = gone_on(tracking_tables_of(flat), 0, (0.7, 0.0), (1.2, 0.5, 0.1))
    assert (record[lanes_nb.FLAG], waiting) == (0.0, 0)
    np.testing.assert_allclose(record[lanes_nb.FOOT : lanes_nb.FOOT + 3], [1.2, 0.5, 0.0])


def test_what_is_told_of_an_element_is_where_lanes_look_for_it():
    assert ELEMENT.itemsize == 8 * mixed_lanes_nb.ELEMENT_NUMBERS
    assert ELEMENT.fields["cubic"][1] == 8 * mixed_lanes_nb.CUBIC
    assert ELEMENT["cubic"].shape == (lanes_nb.ORIGIN,)
    assert 8 * mixed_lanes_nb.CUBIC <= 64 * mixed_lanes_nb.HEAD_LINES
    assert ELEMENT.itemsize <= 64 * mixed_lanes_nb.RECORD_LINES


@pytest.mark.parametrize("name", ["newton_mixed", "finish_mixed", "prove_mixed"])
def test_the_loop_over_the_lanes_is_vector_code(name):
    lanes = np.ones((lanes_nb.BANKS, mixed_lanes_nb.MIXED_ROWS * lanes_nb.BANK_WIDTH))
    tolerance = () if name == "finish_mixed" else (1e-12,)
    code = vector_code(getattr(mixed_lanes_nb, name), lanes, lanes_nb.BANKS, *tolerance)
    assert len(re.findall(rf"fmul <{lanes_nb.BANK_WIDTH} x double>", code)) > 20

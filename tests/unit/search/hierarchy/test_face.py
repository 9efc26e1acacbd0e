"""What trims leave of elements, and which of them have a pole."""

from __future__ import annotations

import numpy as np
from numba import njit
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.arrays.codes import CUT, POLE
from contiga.search.hierarchy.kernels import face_nb
from contiga.search.tables import tables_of


@njit
def in_face(elements, trims, e, s, t):
    return face_nb.in_face(elements, trims, e, s, t)


@njit
def has_pole(elements, e):
    return face_nb.has_pole(elements, e)


def test_places_of_a_holed_plate_are_left_outside_of_its_hole():
    tables = tables_of(holed_plate())
    rng = np.random.default_rng(0)
    states = set()
    for e, row in enumerate(tables.elements.table):
        box = row["box"]
        for s, t in rng.uniform(-0.5, 0.5, (40, 2)):
            u, v = box[0] + (s + 0.5) * (box[1] - box[0]), box[2] + (t + 0.5) * (box[3] - box[2])
            left = np.hypot(u - 0.5, v - 0.5) > 0.2
            assert in_face(tables.elements, tables.trims, e, s, t) == left
        states.add(int(row["trim"]))
    assert CUT in states


def test_only_the_ends_of_a_sphere_have_poles():
    tables = tables_of(cg.Body([cg.shapes.sphere()]))
    poles = np.array([has_pole(tables.elements, e) for e in range(len(tables.elements.table))])
    at_ends = (tables.elements.table["kind"] == POLE).any(axis=1)
    assert poles.any()
    flat = tables_of(cg.Body([cg.shapes.torus()]))
    assert not any(has_pole(flat.elements, e) for e in range(len(flat.elements.table)))
    np.testing.assert_array_equal(poles, at_ends)

"""Inside and outside, at faces, edges and corners."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg


def box(faces_turned=False):
    c = [cg.shapes.plane(centre=0.5 * n, axis=n) for n in (*np.eye(3), *-np.eye(3))]
    return cg.Body([f.flipped() for f in c] if faces_turned else c)


def test_points_about_a_box():
    p = np.random.default_rng(0).uniform(-1, 1, (3000, 3))
    np.testing.assert_array_equal(box().contains(p), (np.abs(p) < 0.5).all(axis=1))


@pytest.mark.parametrize("k", [-6, -9, -12])
def test_points_just_beside_corners_and_edges(k):
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.5
    edge = corner * [1, 1, 0.3]
    for place in (corner, edge):
        assert not box().contains(place * (1 + 10.0**k)).any()
        assert box().contains(place * (1 - 10.0**k)).all()


def test_a_box_turned_inside_out_contains_the_outside():
    p = np.random.default_rng(1).uniform(-1, 1, (500, 3))
    np.testing.assert_array_equal(box(True).contains(p), ~box().contains(p))


def test_a_sharp_tetrahedron_against_its_planes():
    """Needle of height 10 over a base of 1: the signs at its tip are those of its planes."""
    v = np.array([[1.0, 0, 0], [-0.5, 0.8, 0], [-0.5, -0.8, 0], [0.3, 0, 10.0]])
    faces = []
    planes = []
    for skip in range(4):
        a, b, c = (v[i] for i in range(4) if i != skip)
        n = np.cross(b - a, c - a)
        if n @ (v[skip] - a) > 0:
            b, c, n = c, b, -n
        faces.append(cg.shapes.bilinear(a, b, c, c))
        if faces[-1].normal([[0.3, 0.3]])[0] @ n < 0:
            faces[-1] = faces[-1].flipped()
        planes.append((n, n @ a))
    body = cg.Body(faces)
    rng = np.random.default_rng(2)
    p = np.concatenate(
        [rng.uniform([-2, -2, -1], [2, 2, 12], (2000, 3)), v[3] + rng.normal(size=(2000, 3))]
    )
    inside = np.all([p @ n < d for n, d in planes], axis=0)
    np.testing.assert_array_equal(body.contains(p), inside)


def test_behind_an_open_sheet_but_not_past_its_border():
    body = cg.Body([cg.shapes.plane()])
    p = [[0, 0, -0.1], [0, 0, 0.1], [0.6, 0, -0.1], [0, 0, -50.0]]
    assert body.contains(p).tolist() == [True, False, False, True]


@pytest.mark.interpreted
def test_inside_without_compilation():
    assert cg.Body([cg.shapes.plane()]).contains([[0, 0, -0.1], [0, 0, 0.1]]).tolist() == [
        True,
        False,
    ]


def test_corners_that_miss_each_other_by_more_than_rounding_keep_their_sides():
    """Where cylinders cross, a corner of three faces is 1e-11 of the size inside two of them, and
    the third has an edge of 1e-11 there: each face counts with its angle all the same."""
    import warnings

    from tests.stress import fields, pieces, unions
    from tests.stress.solids import written

    heap = unions._heap(5)
    path = written("corners", pieces.together(*heap).shape)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        body = cg.read_cad(path)
    corner = np.array([2.451273, -7.041569, -10.784478])
    p = corner + np.random.default_rng(0).normal(size=(400, 3)) * 0.05
    inside = fields.union(*(piece.field for piece in heap))(p) < 0.0
    np.testing.assert_array_equal(body.contains(p), inside)

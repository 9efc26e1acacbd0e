"""The fold next to a foot: both faces of a trimmed edge, seen from one of them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.search.kernels import about_edge_nb
from contiga.search.tables import tables_of

from .folds import trimmed_fold

pytestmark = pytest.mark.interpreted


@njit
def fold_about(tables, foot, r):
    """Whether a fold is known, the frame of its first face and of its second, the way to it."""
    found = about_edge_nb.fold_about(tables, foot, r, about_edge_nb.edge_work())
    return found[0], found[1], found[2], found[3]


def place(body, point):
    """The element of a roof's face that a point lies on, and where in it."""
    foot = body.project([point])
    tables = tables_of(body)
    for e, row in enumerate(tables.elements.table):
        u0, u1, v0, v1 = row["box"]
        u, v = foot.uv[0]
        if row["patch"] == foot.patch[0] and u0 <= u <= u1 and v0 <= v <= v1:
            return e, (u - u0) / (u1 - u0) - 0.5, (v - v0) / (v1 - v0) - 0.5
    raise AssertionError("no element there")


@pytest.mark.parametrize("turn", [0.1, 1.0])
@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_both_faces_of_a_fold_are_known_with_their_frames(turn, sense):
    body = trimmed_fold(turn)
    half = 0.5 * turn
    away = 0.05
    foot = place(body, [sense * away * np.cos(half), 0.2, -away * np.sin(half)])
    known, first, second, way = fold_about(tables_of(body), foot, 0.3)
    assert known
    assert way == pytest.approx(away, rel=1e-6)
    for frame, own in ((first, sense), (second, -sense)):
        point, tangent, b, normal = (np.array(v) for v in frame[:4])
        np.testing.assert_allclose(point[[0, 2]], 0.0, atol=1e-6)
        np.testing.assert_allclose(np.abs(tangent), [0.0, 1.0, 0.0], atol=1e-6)
        np.testing.assert_allclose(b, [own * np.cos(half), 0.0, -np.sin(half)], atol=1e-6)
        np.testing.assert_allclose(np.abs(normal), [np.sin(half), 0.0, np.cos(half)], atol=1e-6)


def test_far_from_the_edge_there_is_no_fold():
    body = trimmed_fold(1.0)
    assert not fold_about(tables_of(body), place(body, [0.4, 0.0, -0.2]), 0.05)[0]

"""What the certificate of trimmed edges says of a strip along one holds for all within bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit
from tests.unit.search.strips import creases, geodesics, turned

from contiga.search.certify.certify_records import EdgeFold, EdgeFrame, EdgeJoint, Reach
from contiga.search.certify.kernels import about_edge_nb, crease_nb, edge_nb

pytestmark = pytest.mark.interpreted


@njit
def reach_of(tangent, segment, joint, ends):
    nothing = (0.0, 0.0, 0.0)
    frame = EdgeFrame(nothing, tangent, nothing, nothing)
    there, own = (0, 0.0, 0.0), EdgeJoint(joint[0], joint[1], joint[2])
    fold = EdgeFold(True, frame, frame, 0.0, segment[0], segment[1], segment[2], there, own)
    return edge_nb._reach_of(fold, ends)


@njit
def seen_along(bend, b, ends, reach, bent):
    return crease_nb.seen_along(bend, b, ends, reach, bent)


@njit
def least_of(bend, way, arc, ends, r):
    nothing = (0.0, 0.0, 0.0)
    frame = EdgeFrame(nothing, (0.0, 1.0, 0.0), nothing, (0.0, 0.0, 1.0))
    joint = EdgeJoint(0.0, 0.0, 0.0)
    fold = EdgeFold(True, frame, frame, way, arc, 0.0, 1, (0, 0.0, 0.0), joint)
    return edge_nb._least_of(fold, bend, frame, ends, r)


@njit
def least_and_drop(curvature, segment_bend, half, joint, ends, r):
    """μ and D of a roof along x: its faces bend up by curvature[0] and [1], its edge, of length
    0.02, by `segment_bend`; each leans down by `half`."""
    work = about_edge_nb.edge_work()
    bends, segment, _ = work
    h, rest = bends[3][0], bends[3][1]
    h[:] = 0.0
    rest[:] = 0.0
    h[0, 1] = h[1, 2] = 0.01
    h[2, 3] = 1e-4 * segment_bend
    bends[0][:] = 0.0
    bends[1][:] = 0.0
    bends[0][0], bends[1][0] = curvature
    n = about_edge_nb.side_segment(2, segment)
    c, s = math.cos(half), math.sin(half)
    nothing, e = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    first = EdgeFrame(nothing, e, (0.0, -c, -s), (0.0, -s, c))
    second = EdgeFrame(nothing, e, (0.0, c, -s), (0.0, s, c))
    there, own = (0, 0.0, 0.0), EdgeJoint(joint[0], joint[1], joint[2])
    fold = EdgeFold(True, first, second, 0.0, 0.01, segment_bend, n, there, own)
    return edge_nb._least_and_drop(fold, ends, r, work)


def test_f_is_as_convex_beside_an_edge_as_told():
    """In a ball about a foot some way from the edge, of surfaces that bend within their bounds."""
    rng = np.random.default_rng(2)
    n = 300
    inner, outer = rng.choice([0.0, 0.2, 1.0], (2, n))
    way, r, arc = 10.0 ** rng.uniform(-2.0, -0.3, (3, n))
    w = rng.normal(size=(2, n, 3))
    w[:, rng.random(n) < 0.3] *= [0.1, 0.1, 1.0]
    x, _, normal = geodesics(rng, n, inner, outer, way + r)
    m = ((w[:, :, None] - x) * normal).sum(-1)
    truth = 1.0 - np.maximum(inner[:, None] * m, -outer[:, None] * m).max(axis=(0, 2))
    for k in range(n):
        bend = np.array([inner[k], outer[k], 0.0, 0.0, 0.0, 0.0])
        told = least_of(bend, way[k], arc[k], (tuple(w[0, k]), tuple(w[1, k])), r[k])
        assert told <= truth[k] + 1e-12


@pytest.mark.parametrize("part", ["first", "second", "edge segment"])
@pytest.mark.parametrize("half", [0.0, 0.3])
def test_both_faces_and_the_edge_are_asked_how_convex_f_is(part, half):
    """Of a point at height one; 1 − κ m ends in each where it bends up by 1/m."""
    ends = ((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    height = 1.0 if part == "edge segment" else np.cos(half)
    for bent, good in ((0.8, True), (1.1, False)):
        curvature = [bent / height if part == name else 0.0 for name in ("first", "second")]
        segment = bent if part == "edge segment" else 0.0
        told = least_and_drop(tuple(curvature), segment, half, (0.0, 0.0, 0.0), ends, 0.01)[0]
        assert told <= 1.0 - bent + 1e-9
        assert (told > 0.0) == good


def test_slopes_fall_by_the_width_of_an_edge_and_on_its_inner_side_by_its_turn_too():
    """The outer side has to be as sure as tangents are; a real fold is not gone over inside."""
    width, slip = 1e-6, 1e-4

    def drop(half, turn, up=1.0, bent=0.0, r=0.01):
        ends = ((0.0, 0.0, up), (0.0, 0.0, up))
        return least_and_drop((0.0, 0.0), bent, half, (width, slip, turn), ends, r)[1]

    assert drop(0.1, 0.2) == width
    # w·(b_1 + b_2) is −2 sin(half); by 2 |w| σ it may be more
    assert drop(1.02 * slip, 0.2) == width
    assert drop(0.98 * slip, 0.2) == np.inf
    assert drop(0.1, 0.2, up=-1.0) == np.inf
    for turn in (1e-5, 9e-4):
        assert drop(0.5 * turn, turn, up=-1.0) >= width + turn
        assert drop(0.5 * turn, turn, up=-1.0) <= 1.1 * (width + turn)
    assert drop(6e-4, 1.2e-3, up=-1.0) == np.inf
    # a shortest way can cross an edge that bends aside again and again
    assert drop(2e-4, 4e-4, up=-1.0, bent=10.0, r=0.1) >= 3.0 * 4e-4


def test_what_is_seen_from_an_edge_is_no_farther_off_and_leads_no_more_along_it_than_told():
    """From an edge segment within its bend, off by its width, whose tangents are off by its slip or
    turn.

    A face that is off by one of these and not by the other is not off by more.
    """
    rng = np.random.default_rng(0)
    n = 300
    bent, arc = rng.choice([0.0, 1.0], n), 10.0 ** rng.uniform(-3.0, 0.0, n)
    x, e, _, _ = creases(rng, n, bent, np.zeros((2, n)), arc)
    w = rng.normal(size=(2, n, 3))
    w[:, rng.random(n) < 0.5, 0] *= 0.01
    give = rng.choice([0.0, 0.01, 0.3], n)
    axis = rng.normal(size=(n, 1, 3))
    axis *= give[:, None, None] / np.linalg.norm(axis, axis=-1, keepdims=True)
    width = rng.choice([0.0, 0.01, 0.3], n)
    off = rng.normal(size=(n, 1, 3))
    off *= width[:, None, None] / np.linalg.norm(off, axis=-1, keepdims=True)
    far = np.linalg.norm(w[:, :, None] - x - off, axis=-1).max(axis=(0, 2))
    along = np.abs(((w[:, :, None] - x) * turned(e, axis)).sum(-1)).max(axis=(0, 2))
    for k in range(n):
        ends = (tuple(w[0, k]), tuple(w[1, k]))
        for joint in ((width[k], give[k], 1.0), (width[k], 1.0, give[k])):
            told = reach_of((1.0, 0.0, 0.0), (arc[k], bent[k], 1), joint, ends)
            assert told[0] == arc[k]
            assert told[1] >= far[k] - 1e-12
            assert told[2] >= along[k] - 1e-9


def test_a_face_is_seen_along_an_edge_within_what_is_told():
    rng = np.random.default_rng(1)
    n = 300
    bent, arc = rng.choice([0.0, 1.0], n), 10.0 ** rng.uniform(-3.0, 0.0, n)
    torsion = rng.choice([0.0, 1.0], (2, n))
    x, e, _, b = creases(rng, n, bent, torsion, arc)
    w = rng.normal(size=(2, n, 3))
    at = w[:, :, None] - x
    far = np.linalg.norm(at, axis=-1).max(axis=(0, 2))
    along = np.abs((at * e).sum(-1)).max(axis=(0, 2))
    seen = (at * b[0]).sum(-1)
    for k in range(n):
        bend = np.array([2.0, 0.0, 0.0, 0.0, 0.0, 0.0]) * torsion[0, k]
        ends = (tuple(w[0, k]), tuple(w[1, k]))
        told = seen_along(bend, tuple(b[0, k, 0]), ends, Reach(arc[k], far[k], along[k]), bent[k])
        for (low, high), truth in zip(told, seen[:, k], strict=True):
            assert low <= truth.min() + 1e-9
            assert high >= truth.max() - 1e-9

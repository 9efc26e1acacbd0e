"""The edge segment of an edge in a cell of a trimmed face."""

from __future__ import annotations

from itertools import pairwise
from math import comb

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.unit.search import plain
from tests.unit.search.sheets import SHEETS

import contiga as cg
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.search.certify.kernels import bend_nb, edge_segment_nb

pytestmark = pytest.mark.interpreted


@njit
def segment_in(trims, patch, cell):
    work = edge_segment_nb.segment_work()
    edge, n = edge_segment_nb.segment_in(trims, patch, cell, work)
    places = np.empty((n, 3, 2))
    for k in range(n):
        for i in range(3):
            found = edge_segment_nb.place_on(work, k, 0.5 * i)
            places[k, i, 0], places[k, i, 1] = found[0], found[1]
    return edge, n, places


def holed():
    """A unit plate with a round hole that an edge names."""
    patch = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
    outer = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(square)
    )
    hole = cg.shapes.circle(radius=0.25, centre=[0.5, 0.5, 0]).reversed()
    edge = BodyEdge(hole, 1e-9, (EdgeUse(0, 1, 0, False),), (hole.domain,))
    return cg.Body([patch], trims=[(outer, (hole,))], edges=[edge])


def test_a_cell_over_the_rim_of_a_hole_holds_its_edge_segment():
    trims = plain.joined(holed()).trims
    cell = (0.72, 0.78, 0.45, 0.55)
    edge, n, places = segment_in(trims, 0, cell)
    assert edge == 0
    assert n >= 1
    # places are by the cell's middle and half sides
    u = 0.75 + 0.03 * places[..., 0]
    v = 0.50 + 0.05 * places[..., 1]
    np.testing.assert_allclose(np.hypot(u - 0.5, v - 0.5), 0.25, atol=1e-9)


def test_a_cell_beside_all_edges_holds_none():
    edge, n, _ = segment_in(plain.joined(holed()).trims, 0, (0.8, 0.9, 0.1, 0.2))
    assert (edge, n) == (-1, 0)


def test_a_cell_over_the_whole_hole_holds_no_one_edge_segment():
    assert segment_in(plain.joined(holed()).trims, 0, (0.2, 0.8, 0.2, 0.8))[0] == -2


def plate(points, named):
    """A unit plate whose outer border goes round `points`; piece k from point k belongs to the edge
    named[k]. Edges of more than one piece are one p-curve."""
    patch = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
    points = [[*p, 0.0] for p in [*points, points[0]]]
    loop, edges = [], []
    first = 0
    while first < len(named):
        last = first + 1
        while last < len(named) and named[last] == named[first]:
            last += 1
        inner = np.arange(1, last - first) / (last - first)
        knots = [0.0, 0.0, *inner, 1.0, 1.0]
        curve = cg.NurbsCurve(1, knots, points[first : last + 1])
        uses = (EdgeUse(0, 0, len(loop), False),)
        edges.append(BodyEdge(curve, 1e-9, uses, (curve.domain,)))
        loop.append(curve)
        first = last
    return cg.Body([patch], trims=[(tuple(loop),)], edges=edges)


ROUND = [(0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8)]


@pytest.mark.parametrize(
    ("points", "named", "edge"),
    [
        ([*ROUND[:1], (0.5, 0.2), *ROUND[1:]], [0, 0, 1, 2, 3], 0),
        ([*ROUND[:1], (0.5, 0.2), *ROUND[1:]], [0, 1, 2, 3, 4], -2),
        ([*ROUND[:1], (0.5, 0.21), *ROUND[1:]], [0, 0, 1, 2, 3], -2),
        ([*ROUND[:1], (0.51, 0.3), (0.5, 0.2), *ROUND[1:]], [0, 0, 0, 1, 2, 3], -2),
    ],
    ids=["straight on", "another edge", "kink", "spike"],
)
def test_a_edge_segment_is_one_smooth_stretch_of_one_edge(points, named, edge):
    """In a cell about the middle of the lower side of a square, where two pieces meet."""
    found, n, _ = segment_in(plain.joined(plate(points, named)).trims, 0, (0.45, 0.55, 0.15, 0.25))
    assert found == edge
    assert n == (2 if edge >= 0 else 0)


@njit
def stretch_bend(coefs, bending):
    work = edge_segment_nb.segment_work()
    work.coefs[0, : len(coefs)] = coefs
    work.degree[0] = len(coefs) - 1
    return edge_segment_nb.stretch_bend(work, 0, bending)


def rational(coefs, t):
    """Place of a piece at t, and its first and second derivative there: (2, places) each."""
    n = len(coefs) - 1

    def value(c, n):
        basis = [comb(n, i) * t**i * (1.0 - t) ** (n - i) for i in range(n + 1)]
        return np.einsum("ik,ic->ck", basis, c) if n >= 0 else np.zeros((3, len(t)))

    a, b, c = (value(np.diff(coefs, k, axis=0), n - k) for k in range(3))
    b, c = n * b, n * (n - 1) * c
    x = a[:2] / a[2]
    dx = (b[:2] - x * b[2]) / a[2]
    return x, dx, (c[:2] - 2.0 * dx * b[2] - x * c[2]) / a[2]


def along(patch, box, cell, coefs, t):
    """First and second derivative in space of a piece, given in a cell of a patch."""
    low, high = np.reshape(cell, (2, 2)).T
    half = np.array([box[1] - box[0], box[3] - box[2]]) * 0.5 * (high - low)
    middle = np.array([box[0], box[2]]) + (0.5 * (low + high) + 0.5) * half * 2.0 / (high - low)
    (x, y), d1, d2 = rational(coefs, t)
    D = patch.derivatives(middle + np.column_stack([x, y]) * half, order=2).transpose(3, 0, 1, 2)
    (p, q), (pp, qq) = d1 * half[:, None], d2 * half[:, None]
    first = D[..., 1, 0] * p + D[..., 0, 1] * q
    second = D[..., 2, 0] * p * p + 2.0 * D[..., 1, 1] * p * q + D[..., 0, 2] * q * q
    return first, second + D[..., 1, 0] * pp + D[..., 0, 1] * qq


def stretch(rng, n, off, spread):
    """Coefficients of a piece in a cell: evenly from place to place, then off that."""
    coefs = np.ones((n, 3))
    coefs[:, :2] = np.linspace(*rng.uniform(-1.0, 1.0, (2, 2)), n)
    coefs[1:-1, :2] += off * rng.normal(size=(n - 2, 2))
    weights = rng.uniform(1.0 - spread, 1.0 + spread, (n, 1))
    if off == 0.0:
        weights[-1] = weights[0]
    return coefs * weights


PIECES = {
    "straight": lambda rng: stretch(rng, 2, 0.0, 0.0),
    "bent": lambda rng: stretch(rng, rng.integers(2, 5), 0.2, 0.0),
    "weighted": lambda rng: stretch(rng, rng.integers(2, 5), 0.2, 0.25),
    "straight and weighted": lambda rng: stretch(rng, 3, 0.0, 0.05),
}


@pytest.mark.parametrize("sheet", SHEETS)
@pytest.mark.parametrize("piece", PIECES)
def test_a_stretch_bends_and_runs_within_what_is_told(sheet, piece):
    rng = np.random.default_rng(0)
    t, bending = np.linspace(0.0, 1.0, 33), bend_nb.bend_work()
    known = 0
    for _ in range(few(12, 3)):
        patch = SHEETS[sheet](rng)
        elements = plain.elements(cg.Body([patch]))
        box = elements.table[0]["box"]
        for _ in range(6):
            size = rng.choice([0.02, 0.1, 0.3])
            low = rng.uniform(-0.5, 0.5 - size, 2)
            cell = (low[0], low[0] + size, low[1], low[1] + size)
            coefs = PIECES[piece](rng)
            if not bend_nb.bend_bounds(elements, 0, cell, np.empty(6), bending):
                continue
            middle, rest, least, most, bent = stretch_bend(coefs, bending)
            if not rest < np.inf:
                continue
            known += 1
            first, second = along(patch, box, cell, coefs, t)
            speed = np.linalg.norm(first, axis=0)
            k = np.linalg.norm(np.cross(first, second, axis=0), axis=0) / speed**3
            assert rest >= np.linalg.norm(second.T - middle, axis=1).max() * (1 - 1e-9) - 1e-12
            assert least <= speed.min() * (1 + 1e-9)
            assert most >= speed.max() * (1 - 1e-9)
            assert bent >= k.max() * (1 - 1e-9) - 1e-9
    assert known > few(20, 1)

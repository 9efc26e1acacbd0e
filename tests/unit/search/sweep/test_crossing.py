"""Degenerate geometry: no row raises, none is lost beside it, and what is given up is said."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.search.sweep.kernels import crossing_nb
from contiga.statuses import Status


def net(a=5, b=5, lift=0.0):
    x, y = np.meshgrid(np.linspace(-1, 1, a), np.linspace(-1, 1, b), indexing="ij")
    return np.stack([x, y, lift + 0.1 * np.sin(2 * x) * np.cos(y)], axis=-1)


def uniform(n, p):
    return np.concatenate([np.zeros(p), np.linspace(0, 1, n - p + 1), np.ones(p)])


def sheet(points, weights=None, knots=None, degrees=(2, 2)):
    if knots is None:
        knots = [uniform(n, p) for n, p in zip(points.shape[:2], degrees, strict=True)]
    return cg.NurbsSurface(degrees, knots, points, weights)


def collapsed_span():
    """Two columns of control points in one place: a strip of the patch has no width."""
    points = net(6, 5)
    points[3] = points[2]
    points[4] = points[2]
    return sheet(points)


def tiny_span():
    """Knots 1e-13 apart."""
    knots = uniform(5, 2)
    knots[3], knots[4] = 0.5, 0.5 + 1e-13
    return sheet(net(), knots=[knots, uniform(5, 2)])


def no_area():
    """A patch that is a line beside one that is a sheet."""
    points = np.repeat(net()[:, :1], 5, axis=1)
    return sheet(points)


def crease():
    """A line across which only the position is continuous."""
    points = net(5, 5)
    points[2, :, 2] += 0.3
    return sheet(points, knots=[np.array([0, 0, 0, 0.5, 0.5, 1, 1, 1.0]), uniform(5, 2)])


def sliver():
    points = net()
    points[..., 1] *= 1e-9
    return sheet(points)


def triangle():
    """One side collapsed to a point, all normals there defined by a limit."""
    points = net()
    points[0] = points[0, 2]
    return sheet(points)


def uneven_weights(decades=6, seed=0):
    rng = np.random.default_rng(seed)
    return sheet(net(), 10 ** rng.uniform(-0.5 * decades, 0.5 * decades, (5, 5)))


def folded():
    """Control points that turn back: the normal vanishes along a line and turns over."""
    points = net()
    points[3, :, 0] = -0.6
    return sheet(points)


SURFACES = {
    "collapsed span": [collapsed_span],
    "tiny span": [tiny_span],
    "no area beside a sheet": [no_area, lambda: sheet(net())],
    "crease": [crease],
    "sliver": [sliver],
    "triangle": [triangle],
    "uneven weights": [uneven_weights],
    "folded": [folded],
    "twice the same": [lambda: sheet(net())] * 2,
    "almost the same": [lambda: sheet(net()), lambda: sheet(net(lift=1e-12))],
}


@pytest.fixture(params=sorted(SURFACES))
def body(request):
    return cg.Body([make() for make in SURFACES[request.param]], name=request.param)


def paths(body, n, seed):
    rng = np.random.default_rng(seed)
    uv = rng.random((n, 2))
    uv[::5] = rng.choice([0.0, 0.25, 0.5, 0.75, 1.0], (len(uv[::5]), 2))
    p = body.patches[0].evaluate(uv)
    d = rng.normal(size=(n, 3))
    d[::3] = [0.0, 0.0, -1.0]
    d *= 10 ** rng.uniform(-10, 0.5, (n, 1))
    return p - d * rng.uniform(size=(n, 1)), p + d


def test_no_row_raises_and_no_other_row_is_lost(body):
    a, b = paths(body, 2000, 1)
    a[0], b[0] = np.nan, np.inf
    hit = body.first_hit(a, b)
    known = (Status.OK, Status.NOT_FINITE, Status.NO_HIT, Status.AT_START, Status.BUDGET)
    assert np.isin(hit.status, known).all()
    assert hit.status[0] == Status.NOT_FINITE
    body.surface.last_crossings(a, b, np.arange(len(a), dtype=np.int32))
    assert (hit.status == Status.BUDGET).mean() < 0.002


def test_hits_lie_on_the_path_and_on_the_surface(body):
    a, b = paths(body, 2000, 2)
    hit = body.first_hit(a, b)
    rows = np.flatnonzero(hit.patch >= 0)
    assert len(rows) > 0 or body.name in ("sliver",)
    on_path = a[rows] + hit.fraction[rows, None] * (b - a)[rows]
    # Beyond an end a crossing counts up to the rounding of heights over its slope.
    np.testing.assert_allclose(on_path, hit.point[rows], rtol=0, atol=3e-7)
    for k, patch in enumerate(body.patches):
        own = rows[hit.patch[rows] == k]
        np.testing.assert_allclose(patch.evaluate(hit.uv[own]), hit.point[own], atol=1e-10)


def entered_from_above(body, seed, n=1500):
    """Paths straight down through single-valued sheets: exactly one entry each."""
    rng = np.random.default_rng(seed)
    p = body.patches[-1].evaluate(rng.uniform(0.02, 0.98, (n, 2)))
    up = 10 ** rng.uniform(-8, 0, (n, 1)) * np.array([0.0, 0, 1])
    return body.first_hit(p + up, p - up)


@pytest.mark.parametrize(
    "name", ["collapsed span", "tiny span", "no area beside a sheet", "crease", "triangle"]
)
def test_beside_degenerate_elements_no_entry_is_missed(name):
    body = cg.Body([make() for make in SURFACES[name]])
    hit = entered_from_above(body, 3)
    assert (hit.patch >= 0).all()
    assert (hit.status == Status.OK).all()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_weights_over_six_decades_do_not_run_out(seed):
    """Seen from above the sheet is single-valued: x and y of its net are a regular grid."""
    body = cg.Body([uneven_weights(6, seed)])
    hit = entered_from_above(body, 4)
    assert (hit.status != Status.BUDGET).all()
    # Where weights fold the sheet over itself a path may meet it more than once.
    assert (hit.patch >= 0).mean() > 0.999


@pytest.mark.skipif("__import__('numba').config.DISABLE_JIT")
def test_a_search_that_is_given_up_says_so():
    """A path along a whole isoline of a folded sheet: no cell of it can be proved."""
    points = net()
    points[..., 1] = 0.0  # every normal lies in one plane, the sheet has no area
    points[..., 2] = 0.0
    x, y = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 5), indexing="ij")
    points[..., 0] = x + 0.3 * y
    body = cg.Body([sheet(points), sheet(net(lift=3.0))])
    hit = body.first_hit([[-2.0, 0, 0]], [[2.0, 0, 0]])
    assert hit.status.tolist() == [Status.BUDGET]
    assert crossing_nb.MAX_CELLS >= 1000

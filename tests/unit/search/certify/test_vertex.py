"""Feet at a vertex and on a crease up to it: what is joined, and what must not be.

Each scene of the second kind breaks one condition of the theorem, and no other.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from numba import njit
from tests.laws.test_search_laws import surface
from tests.unit.search import plain
from tests.unit.search.folds import at_crease, focal, natural_fold, ring

import contiga as cg
from contiga.search.certify.certify_records import Near
from contiga.search.certify.kernels import joined_nb, vertex_nb
from contiga.search.certify.neighbourhoods import build_neighbourhoods
from contiga.search.tables import RELATIVE_TOLERANCE
from contiga.statuses import Feature, Status


@njit
def stays_at_vertex(near, foot, path):
    return vertex_nb.stays_at_vertex(near, foot, path, np.empty((4, 6)))


@njit
def along_crease(near, foot, last, side, path):
    return vertex_nb.along_crease(near, foot, last, side, path, joined_nb.prove_work())


@njit
def leaves_vertex(near, foot, path):
    return vertex_nb.leaves_vertex(near, foot, path, joined_nb.prove_work())


@lru_cache(1)
def near(body):
    tables = plain.joined(body)
    neighbourhoods, tolerance = (
        build_neighbourhoods(tables.elements),
        RELATIVE_TOLERANCE * body.size,
    )
    return Near(tables.elements, neighbourhoods, tables.trims.trimmed, tolerance)


def pyramid(slopes=(1.0, 1.0, 1.0, 1.0)):
    """Four flat faces that meet at a top (0, 0, 1), over a square; from there creases fall along
    −x, +x, −y and +y by `slopes`."""
    x = np.linspace(-1.0, 1.0, 3)
    net = np.empty((3, 3, 3))
    net[..., 0], net[..., 1] = np.meshgrid(x, x, indexing="ij")
    along_x = np.array([slopes[0], 0.0, slopes[1]])
    along_y = np.array([slopes[2], 0.0, slopes[3]])
    net[..., 2] = 1.0 - along_x[:, None] - along_y
    return cg.Body([cg.NurbsSurface((1, 1), ([0, 0, 0.5, 1, 1],) * 2, net)])


TOP = (0, 0.5, 0.5)
"""The top of a pyramid, and its crease along −x there: the side t = 1/2."""


def hole(u0, u1, v0, v1):
    corners = [[u0, v0, 0], [u0, v1, 0], [u1, v1, 0], [u1, v0, 0]]
    return [cg.shapes.line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def on_crease(x):
    """The foot on the crease along −x of a pyramid."""
    return 0, 0.5 + x, 0.5


def over_crease(x, high, fall=1.0):
    """The point so high over the crease along −x, square to it; x < 0."""
    e = np.array([fall, 0.0, 1.0]) / np.hypot(fall, 1.0)
    return np.array([x, 0.0, 1.0 + fall * x]) + high * e * [-1.0, 0.0, 1.0]


def joined(body, foot, last, before, after, side=3):
    return along_crease(near(body), foot, last, side, (tuple(before), tuple(after)))


@pytest.mark.interpreted
def test_a_vertex_stays_if_f_rises_along_all_its_sides_before_and_after():
    """The corner between four faces of a pyramid, of points over it and beside that."""
    body = pyramid()
    over = (0.0, 0.0, 1.5)
    assert stays_at_vertex(near(body), TOP, (over, (0.1, 0.05, 1.5)))
    for way in np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False):
        beside = (0.9 * np.cos(way), 0.9 * np.sin(way), 1.2)
        assert not stays_at_vertex(near(body), TOP, (over, beside))
        assert not stays_at_vertex(near(body), TOP, (beside, over))


@pytest.mark.interpreted
def test_a_foot_leaves_a_vertex_along_a_crease_and_comes_back():
    body = pyramid()
    over, beside = (0.0, 0.0, 1.3), over_crease(-0.02, 0.3)
    assert joined(body, on_crease(-0.02), TOP, over, beside)
    assert joined(body, TOP, on_crease(-0.02), beside, over)
    assert joined(body, on_crease(-0.01), on_crease(-0.02), beside, over_crease(-0.01, 0.3))


@pytest.mark.interpreted
@pytest.mark.parametrize("away", [-1.0, 1.0])
def test_a_foot_does_not_stay_on_a_crease_that_f_falls_away_from(away):
    """From there it goes on over one face or the other."""
    body = pyramid()
    before = over_crease(-0.3, 0.02)
    off = np.array([0.0, 0.018 * away, 0.0])
    for path in ((before + off, before), (before, before + off), (before + off, before + off)):
        assert not joined(body, on_crease(-0.3), on_crease(-0.3), *path)
    assert joined(body, on_crease(-0.3), on_crease(-0.3), before + 0.7 * off, before)
    assert joined(body, on_crease(-0.3), on_crease(-0.3), before, before + 0.7 * off)


@pytest.mark.interpreted
def test_a_foot_does_not_come_by_a_crease_to_a_vertex_that_f_falls_from():
    """The crease on the other side of it falls off less: along that the point is beyond it."""
    body = pyramid((1.0, 0.1, 1.0, 1.0))
    on, over = over_crease(-0.01, 0.3), np.array([0.0, 0.0, 1.3])
    beyond = over + np.array([0.1, 0.0, 0.0])
    assert joined(body, TOP, on_crease(-0.01), on, over)
    assert not joined(body, TOP, on_crease(-0.01), on, beyond)
    assert not joined(body, on_crease(-0.01), TOP, beyond, on)


@pytest.mark.interpreted
@pytest.mark.parametrize("holed", [False, True])
def test_nothing_is_proved_along_a_crease_of_a_trimmed_face(holed):
    """A hole stands on the crease between two feet."""
    trims = [[ring(0.0, 1.0), hole(0.3, 0.35, 0.45, 0.55)]] if holed else None
    body = cg.Body(pyramid().patches, trims=trims)
    path = over_crease(-0.2, 0.02), over_crease(-0.5, 0.02)
    assert joined(body, on_crease(-0.5), on_crease(-0.2), *path) != holed


@pytest.mark.interpreted
def test_what_is_no_foot_is_not_joined():
    body = pyramid()
    on = over_crease(-0.02, 0.3)
    assert not joined(body, on_crease(-0.03), on_crease(-0.02), on, on)
    assert not joined(body, TOP, on_crease(-0.02), on, on)
    assert not leaves_vertex(near(body), TOP, (tuple(on), tuple(on)))


@pytest.mark.interpreted
def test_a_foot_that_has_hardly_left_its_vertex_is_joined_with_it():
    body = pyramid()
    over, tolerance = (0.0, 0.0, 1.3), near(body)[3]
    hair = np.array([-1.0, 0.0, -1.0]) / np.sqrt(2.0) * 100.0 * tolerance
    edge = over_crease(0.0, 0.3) + hair
    assert not stays_at_vertex(near(body), TOP, (over, tuple(edge)))
    assert leaves_vertex(near(body), TOP, (over, tuple(edge)))
    assert not leaves_vertex(near(body), TOP, (over, tuple(edge + 1e3 * hair)))


@pytest.mark.interpreted
@pytest.mark.parametrize(("turn", "past"), [(2.4, 4e-4), (0.6, 0.3)])
def test_two_minima_on_a_hollow_crease_are_not_joined(turn, past):
    """Its faces fall off so steeply that f rises into both."""
    body = natural_fold(turn, bow=1.0)
    high, d = focal(1.0, past)
    feet = at_crease(body, 0, 0.0, -d), at_crease(body, 0, 0.0, d)
    still = ((0.0, 0.0, high),) * 2
    assert not joined(body, *feet, *still)
    assert not joined(body, *feet[::-1], *still)
    for foot in feet:
        assert joined(body, foot, foot, *still) == (past > 0.1)
    low = ((0.0, 0.0, 0.3 * high),) * 2
    assert joined(body, at_crease(body, 0, 0.0, 0.0), at_crease(body, 0, 0.0, 0.0), *low)


@pytest.mark.interpreted
@pytest.mark.parametrize("flip", [False, True])
def test_the_face_beyond_is_asked_beside_the_foot(flip):
    """At the other end of the crease it bends so much that nothing would be known."""
    knots = [0.0] * 4 + [1.0] * 4
    x, y = np.meshgrid([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0], np.linspace(-1.0, 1.0, 4), indexing="ij")
    up = np.zeros((4, 4))
    # In Bernstein form x² is (0, 0, 1/3, 1), and ((1 − y)/2)³ is (1, 0, 0, 0).
    up[:, 0] = 400.0 * np.array([0.0, 0.0, 1.0 / 3.0, 1.0])
    right = np.stack([x, y, up - x], axis=-1)
    left = np.stack([-x, y, -x], axis=-1)[::-1]
    if flip:
        right = right[:, ::-1]
    body = cg.Body([cg.NurbsSurface((3, 3), (knots, knots), net) for net in (left, right)])
    ends = (0.0, 0.6, 0.3), (0.0, 0.55, 0.3)
    assert joined(body, (0, 0.5, 0.275), (0, 0.5, 0.3), *ends, side=1)
    ends = (0.0, -0.6, 0.3), (0.0, -0.55, 0.3)
    assert not joined(body, (0, 0.5, -0.275), (0, 0.5, -0.3), *ends, side=1)


@pytest.mark.parametrize("size", [1e-4, 1e-2, 0.1])
def test_feet_about_the_top_of_a_pyramid_are_certified(size):
    """From its faces to creases and its vertex and back; outside the closest point is the foot."""
    rng = np.random.default_rng(5)
    body = pyramid((0.5, 0.5, 0.5, 0.5))
    a = np.array([0.0, 0.0, 1.0]) + rng.uniform(-1.0, 1.0, (2000, 3)) * [0.2, 0.2, 0.0]
    a[:, 2] += rng.uniform(0.1, 0.5, 2000)
    way = rng.normal(size=a.shape)
    b = a + size * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    feet = body.project(b, start=start, mode="track")
    assert (start.feature == Feature.VERTEX).sum() > 100
    assert (feet.status == Status.OK).all()
    np.testing.assert_allclose(feet.point, body.project(b).point, atol=1e-9)
    assert feet.certified.mean() >= 0.998


@pytest.mark.parametrize(("size", "share"), [(1e-3, 0.999), (1e-2, 0.998), (0.1, 0.99)])
def test_feet_on_a_net_of_bilinear_pieces_are_certified(size, share):
    """Creases bent either way meet at each of its vertices; `size` is in widths of a piece."""
    rng = np.random.default_rng(8)
    body = cg.Body([surface(9, (1, 1), (4, 3), log_weights=0.0, rough=0.2)])
    low, high = body.bounds()
    width = 0.25 * np.linalg.norm(high - low)
    at = body.project(low + (high - low) * rng.uniform(0.0, 1.0, (3000, 3)))
    a = at.point + 0.05 * width * rng.uniform(-1.0, 1.0, (3000, 1)) * at.normal
    start = body.project(a)
    way = rng.normal(size=a.shape)
    b = a + size * width * way / np.linalg.norm(way, axis=1)[:, None]
    feet = body.project(b, start=start, mode="track")
    going = (start.status == Status.OK) & (feet.status == Status.OK)
    moved = (start.feature == Feature.VERTEX) != (feet.feature == Feature.VERTEX)
    assert (going & moved).sum() > 3000 * 0.01 * size / 0.1
    assert feet.certified[going].mean() >= share
    assert feet.certified[going & moved].mean() >= 0.9

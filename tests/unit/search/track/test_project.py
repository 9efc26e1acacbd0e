"""Projection: inputs, records, edges between faces, tracking over them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.sample import FULL

import contiga as cg
from contiga.errors import InputError
from contiga.records import empty_projection
from contiga.search.closest.kernels import nearest_nb
from contiga.search.track.kernels import track_nb
from contiga.statuses import Feature, Status


@pytest.mark.interpreted
def test_a_point_over_a_plane_and_one_past_its_corner():
    feet = cg.Body([cg.shapes.plane()]).project([[0.1, 0.2, 0.3], [1.5, 1.5, 1.0]])
    np.testing.assert_allclose(feet.gap, [0.3, np.sqrt(3.0)], atol=1e-14)
    assert feet.feature.tolist() == [Feature.FACE, Feature.VERTEX]
    assert feet.status.tolist() == [Status.OK, Status.BORDER]


@pytest.mark.interpreted
def test_tracking_without_compilation():
    body = cg.Body([cg.shapes.plane()])
    feet = body.project([[0.1, 0.2, 0.3]])
    feet = body.project([[0.2, 0.1, 0.4]], start=feet, mode="track")
    np.testing.assert_allclose(feet.point, [[0.2, 0.1, 0.0]], atol=1e-14)


def test_bad_input_is_refused():
    body = cg.Body([cg.shapes.plane()])
    feet = body.project(np.zeros((2, 3)))
    with pytest.raises(InputError, match="mode"):
        body.project([[0, 0, 0]], mode="nearest")
    with pytest.raises(InputError, match="start"):
        body.project([[0, 0, 0]], mode="track")
    with pytest.raises(InputError, match="one row a point"):
        body.project([[0, 0, 0]], start=feet, mode="track")
    with pytest.raises(InputError):
        body.project([[0, 0]])
    start = feet._replace(patch=np.array([0, 5], np.int32))
    with pytest.raises(InputError, match="patch that is not there"):
        body.project(np.zeros((2, 3)), start=start, mode="track")


@pytest.mark.parametrize("mode", ["global", "track"])
def test_feet_written_over_those_of_the_step_before_are_the_same_bits(mode):
    """In a ring cut in two, whose points go over edges and close by its middle line."""
    body = cg.Body(cg.shapes.torus(major=2.0, minor=0.5).split(u=0.3))
    rng = np.random.default_rng(6)
    a, b = rng.uniform(0.0, 2.0 * np.pi, (2, 2000 if FULL else 400, 1))
    round_it = np.hstack([np.cos(a), np.sin(a), 0.0 * a])
    aside = np.cos(b) * round_it + np.sin(b) * [0.0, 0.0, 1.0]
    p = 2.0 * round_it + 0.3 * aside
    own = other = body.project(p)
    into, seen = empty_projection(len(p)), set()
    for _ in range(4):
        p = 2.0 * round_it + rng.uniform(-0.4, 0.4, a.shape) * aside
        p += 1e-3 * rng.normal(size=p.shape)
        p[7], own.patch[11], other.patch[11] = np.nan, -1, -1
        new = body.project(p, start=other, mode=mode)
        assert body.project(p, start=other, mode=mode, out=into) is into
        assert body.project(p, start=own, mode=mode, out=own) is own
        for found, *others in zip(new, into, own, strict=True):
            for written in others:
                np.testing.assert_array_equal(written, found)
        seen.update(zip(new.status.tolist(), new.certified.tolist(), strict=True))
        other = new
    assert (Status.OK, 1) in seen
    assert ((Status.OK, 0) in seen) == (mode == "track")


def test_points_that_may_not_be_written_to_compile_nothing():
    body = cg.Body([cg.shapes.plane()])
    p = np.random.default_rng(2).random((5, 3))
    feet = body.project(body.project(p).point + 0.1)
    feet = body.project(p, start=feet, mode="track")
    kernels = (nearest_nb.project_global, track_nb.track_chunks)
    count = [len(getattr(kernel, "signatures", [])) for kernel in kernels]
    for array in (p, *feet):
        array.flags.writeable = False
    body.project(body.project(p, start=feet, mode="track").point)
    body.project(p)
    assert [len(getattr(kernel, "signatures", [])) for kernel in kernels] == count


@pytest.mark.parametrize("sizes", [1e6, 1e13, 1e16, 1e40, 1e160, 1e300])
def test_points_however_far_off_have_the_outermost_foot_in_their_direction(sizes):
    """On a ring from outside: that of the point of the same direction on its circles."""
    body = cg.Body([cg.shapes.torus(major=2.0, minor=0.5)])
    way = np.random.default_rng(5).normal(size=(200, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    feet = body.project(sizes * way)
    assert (feet.status == Status.OK).all()
    level = np.hypot(way[:, 0], way[:, 1])[:, None]
    wanted = 2.0 * way * [1.0, 1.0, 0.0] / level + 0.5 * way
    np.testing.assert_allclose(feet.point, wanted, atol=5.0 / sizes + 1e-9)
    np.testing.assert_allclose(feet.gap, sizes, rtol=3.0 / sizes + 1e-11)


def test_no_points_give_no_feet():
    body = cg.Body([cg.shapes.sphere()])
    feet = body.project(np.zeros((0, 3)))
    again = body.project(np.zeros((0, 3)), start=feet, mode="track")
    assert len(feet.gap) == len(again.gap) == 0


def test_rows_without_a_start_are_found_globally():
    body = cg.Body([cg.shapes.torus()])
    p = np.random.default_rng(0).normal(size=(20, 3))
    whole = body.project(p)
    start = whole._replace(patch=np.where(np.arange(20) % 2, whole.patch, -1).astype(np.int32))
    mixed = body.project(p, start=start, mode="track")
    np.testing.assert_allclose(mixed.gap, whole.gap, atol=1e-12)


def test_a_start_that_is_far_off_still_ends_at_a_local_minimum():
    patch = cg.shapes.bumpy_plate(waves=4, amplitude=0.02)
    body = cg.Body([patch])
    rng = np.random.default_rng(1)
    uv = rng.random((500, 2))
    p = patch.evaluate(uv) + np.array([0, 0, 0.01])
    start = body.project(p)._replace(uv=rng.random((500, 2)))
    feet = body.project(p, start=start, mode="track")
    assert np.isin(feet.status, (Status.OK, Status.BORDER)).all()


def square_with_hole():
    """Plane of 2 by 2 with a round hole of radius 0.5."""
    patch = cg.shapes.plane(width=2.0, length=2.0)
    square = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    outer = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(square)
    )
    hole = (cg.shapes.circle(radius=0.25, centre=[0.5, 0.5, 0.0]),)
    return cg.Body([patch], trims=[(outer, hole)])


def test_a_foot_never_stands_in_a_hole():
    body = square_with_hole()
    p = np.random.default_rng(2).uniform([-0.9, -0.9, -1], [0.9, 0.9, 1], (500, 3))
    rho = np.hypot(p[:, 0], p[:, 1])
    away = np.hypot(np.maximum(0.5 - rho, 0.0), p[:, 2])
    feet = body.project(p)
    over = rho < 0.5
    np.testing.assert_allclose(np.abs(feet.gap), away, atol=1e-12)
    assert (feet.status[over] == Status.TRIMMED).all()
    assert (feet.feature[over] == Feature.EDGE).all()
    assert (feet.status[~over] == Status.OK).all()
    np.testing.assert_array_equal(np.sign(feet.gap), np.sign(p[:, 2]))


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0, 1.5, np.inf])
@pytest.mark.parametrize("shape", ["torus", "square_with_hole"])
def test_a_distance_that_is_known_changes_no_foot(shape, share):
    # What is less than the distance is no foot's: the search sees that and goes on.
    body = square_with_hole() if shape == "square_with_hole" else cg.Body([cg.shapes.torus()])
    low, high = body.bounds()
    p = np.random.default_rng(3).uniform(low - 0.5, high + 0.5, (300, 3))
    rows = np.arange(len(p), dtype=np.int32)
    plain, bounded = empty_projection(len(p)), empty_projection(len(p))
    surface = body.surface
    surface.closest(p, rows, plain)
    away = np.linalg.norm(plain.point - p, axis=1)
    surface.closest(p, rows, bounded, away * share if np.isfinite(share) else away + share)
    np.testing.assert_array_equal(bounded.status, plain.status)
    np.testing.assert_array_equal(bounded.feature, plain.feature)
    np.testing.assert_allclose(bounded.point, plain.point, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(bounded.gap, plain.gap, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("off", [0.1, 1e-2, 1e-4, 1e-7])
def test_points_near_the_axis_of_a_round_hole(off):
    """The rim is almost equally far all round: the curvature of the distance is almost nothing."""
    body = square_with_hole()
    angle = np.linspace(0, 6, 80)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    feet = body.project(off * ring + [0, 0, 0.4])
    np.testing.assert_allclose(np.abs(feet.gap), np.hypot(0.5 - off, 0.4), atol=1e-13)
    np.testing.assert_allclose(feet.point, 0.5 * ring, atol=1e-13 / off**1.5 + 1e-9)


@pytest.mark.parametrize("speed", [0.01, 0.3])
def test_a_tracked_foot_stops_at_the_rim_of_a_hole(speed):
    body = square_with_hole()
    x = np.arange(0.8037, 0.1, -speed)
    feet = body.project([[0.8037, 0.0, -0.1]])
    for at in x:
        p = np.array([[at, 0.0, -0.1]])
        feet = body.project(p, start=feet, mode="track")
        assert np.hypot(*feet.point[0, :2]) >= 0.5 - 1e-9
        assert feet.status[0] == (Status.OK if at > 0.5 else Status.TRIMMED)
        np.testing.assert_allclose(feet.point[0], [max(at, 0.5), 0, 0], atol=1e-9)


@pytest.mark.parametrize("away", [1e-3, 1e-7, 1e-10])
def test_points_a_hair_from_a_trim(away):
    body = square_with_hole()
    angle = np.linspace(0, 6, 50)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    inner = body.project((0.5 - away) * ring + [0, 0, 0.1])
    outer = body.project((0.5 + away) * ring + [0, 0, 0.1])
    assert (inner.status == Status.TRIMMED).all()
    assert (outer.status == Status.OK).all()
    np.testing.assert_allclose(inner.point, 0.5 * ring, atol=1e-9)
    np.testing.assert_allclose(outer.point, (0.5 + away) * ring, atol=1e-9)


def folded(z):
    """A strip along x, folded at x = 0, as degree 1 and as degree 3 with a C0 knot."""
    net = np.array([[[x, y, h] for y in (0.0, 1.0)] for x, h in zip((-1.0, 0, 1), z, strict=True)])
    flat = cg.NurbsSurface((1, 1), ([0, 0, 1, 2, 2], [0, 0, 1, 1]), net)
    return [cg.Body([flat]), cg.Body([flat.elevate(u=2, v=2)]), cg.Body(list(flat.split(u=1.0)))]


@pytest.mark.parametrize("body", folded([0, 1, 0]), ids=["linear", "cubic", "two patches"])
@pytest.mark.parametrize("steps", [9, 200])
def test_a_foot_tracked_over_a_ridge_stands_on_it_while_the_point_is_above(body, steps):
    feet = body.project([[-0.9, 0.5, 1.5]])
    for x in np.linspace(-0.9, 0.9, steps):
        p = np.array([[x, 0.5, 1.5]])
        feet = body.project(p, start=feet, mode="track")
        best = body.project(p)
        np.testing.assert_allclose(feet.point, best.point, atol=1e-11)
        np.testing.assert_allclose(feet.gap, best.gap, atol=1e-12)
        assert feet.status[0] == Status.OK
        assert feet.feature[0] == (Feature.EDGE if abs(x) < 0.5 else Feature.FACE)


@pytest.mark.parametrize("body", folded([1, 0, 1]), ids=["linear", "cubic", "two patches"])
@pytest.mark.parametrize("steps", [9, 200])
def test_a_foot_tracked_into_a_valley_keeps_its_side_until_it_meets_the_bottom(body, steps):
    """There it jumps, as there are two minima; that is not proved."""
    feet = body.project([[-0.5, 0.5, 0.2]])
    path = np.linspace(-0.5, 0.51, steps)
    proved = []
    for x in path:
        feet = body.project([[x, 0.5, 0.2]], start=feet, mode="track")
        foot = 0.5 * (x - 0.2) if x < 0.2 else 0.5 * (x + 0.2)
        np.testing.assert_allclose(feet.point, [[foot, 0.5, abs(foot)]], atol=1e-11)
        proved.append(feet.certified[0])
        assert feet.status[0] == Status.OK
    assert proved[np.searchsorted(path, 0.2)] == 0


def test_the_teapot_with_its_collapsed_edges(data_dir):
    body = cg.read_cad(data_dir / "utah_teapot_32bezier_gismo.xml")
    rng = np.random.default_rng(3)
    low, high = body.bounds()
    p = rng.uniform(low - 0.2, high + 0.2, (400, 3))
    feet = body.project(p)
    assert np.isin(feet.status, (Status.OK, Status.BORDER)).all()
    distance = np.linalg.norm(p - feet.point, axis=1)
    alone = np.min(
        [np.linalg.norm(p - cg.Body([s]).project(p).point, axis=1) for s in body.patches], axis=0
    )
    np.testing.assert_allclose(distance, alone, atol=1e-11 * body.size)
    top = p + 0.01 * rng.normal(size=p.shape)
    later = body.project(top, start=feet, mode="track")
    assert (later.status != Status.MAX_ITERATIONS).all()

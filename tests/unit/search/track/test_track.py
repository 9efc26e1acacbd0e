"""Chunks of tracked points: whatever their size, each point has the foot it has alone."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.records import Projection, SurfacePlaces, empty_projection
from contiga.search.certify.kernels.branch_nb import certify_rows
from contiga.search.track import project
from contiga.search.track.track_records import PendingRows
from contiga.statuses import Status


def _tracked(
    body: cg.Body,
    path: tuple[np.ndarray, np.ndarray],
    start: tuple[np.ndarray, np.ndarray],
    size: int,
) -> Projection:
    """As `project.track`, in chunks of `size` points."""
    before, now = path
    out = empty_projection(len(now))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(project, "rows_per_chunk", lambda *_: size)
        known = before if len(before) else None
        project.track(tracking_tables_of(body), now, SurfacePlaces(*start), out, known)
    return out


def _scene() -> tuple[cg.Body, np.ndarray, np.ndarray, Projection]:
    """A ring; points in it, of which some go through its middle line, where all feet end."""
    body = cg.Body([cg.shapes.torus(major=2.0, minor=0.5)])
    rng = np.random.default_rng(8)
    a, b = rng.uniform(0.0, 2.0 * np.pi, (2, 900))
    out = np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=1)
    aside = np.cos(b)[:, None] * out + np.sin(b)[:, None] * [0.0, 0.0, 1.0]
    before = 2.0 * out + 0.3 * aside
    now = 2.0 * out + rng.uniform(-0.4, 0.4, (900, 1)) * aside + 1e-3 * rng.normal(size=(900, 3))
    return body, before, now, body.project(before)


def test_chunks_of_any_size_give_the_same_bits() -> None:
    body, before, now, feet = _scene()
    patch, uv = feet.patch.copy(), feet.uv.copy()
    patch[::17] = -1  # to be found as closest points
    now[5], before[12] = np.nan, np.inf
    whole = _tracked(body, (before, now), (patch, uv), len(now))
    for size in (1, 64, 333):
        for a, b in zip(whole, _tracked(body, (before, now), (patch, uv), size), strict=True):
            np.testing.assert_array_equal(a, b)
    assert {Status.OK, Status.NOT_FINITE} <= set(whole.status)
    assert 0.3 < whole.certified.mean() < 1.0


def test_points_without_a_foot_get_their_closest_points_and_so_do_those_without_a_minimum() -> None:
    """Of points on the axis of a foot, past the focal point, Newton's method stays at a maximum."""
    body, _, _, _ = _scene()
    angle = np.linspace(0.0, 6.0, 40)
    ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    before, now = 2.3 * ring, 1.8 * ring
    feet = body.project(before)
    patch = feet.patch.copy()
    anew = np.arange(len(now)) % 2 == 0
    patch[anew] = -1
    out = _tracked(body, (before, now), (patch, feet.uv), 16)
    closest = body.project(now)
    for name in ("point", "gap", "certified"):
        np.testing.assert_array_equal(getattr(out, name), getattr(closest, name))
    assert (out.status[anew] == Status.OK).all()
    assert (out.status[~anew] == Status.BRANCH_EVENT).all()


def test_nothing_is_certified_where_nobody_knows_where_the_points_were() -> None:
    body, _, now, feet = _scene()
    some = feet.patch >= 0
    start = feet.patch[some], np.ascontiguousarray(feet.uv[some])
    out = _tracked(body, (np.zeros((0, 3)), now[some]), start, 128)
    assert not out.certified.any()
    assert not (out.status == Status.BRANCH_EVENT).any()


@pytest.mark.interpreted
def test_a_chunk_without_compilation() -> None:
    body = cg.Body([cg.shapes.plane()])
    before = np.array([[0.1, 0.2, 0.2], [0.0, 0.1, 0.6], [-0.2, 0.0, 0.1]])
    feet = body.project(before)
    now = before + 0.01
    patch = feet.patch.copy()
    patch[2] = -1
    out = _tracked(body, (before, now), (patch, feet.uv), 2)
    np.testing.assert_allclose(out.gap, now[:, 2], atol=1e-12)
    assert out.certified.tolist() == [1, 1, 1]


def test_rows_without_a_place_or_a_foot_are_not_certified() -> None:
    body, before, now, feet = _scene()
    patch = feet.patch.copy()
    patch[::17] = -1
    before[12] = np.nan
    out = _tracked(body, (before, now), (patch, feet.uv), len(now))
    told, out.certified[:] = out.certified.copy(), 0
    rows, flags = np.arange(len(now), dtype=np.int32), np.zeros(len(now), np.uint8)
    left = PendingRows(rows, flags, before, patch, feet.uv)
    certify_rows(tracking_tables_of(body), now, left, len(now), out)
    lost = (patch < 0) | np.isnan(before[:, 0])
    assert not out.certified[lost].any()
    followed = ~lost & (out.status == Status.OK)
    np.testing.assert_array_equal(out.certified[followed], told[followed])
    assert out.certified.sum() > 100

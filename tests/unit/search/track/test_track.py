"""Chunks of tracked points: whatever their size, each point has the foot it has alone."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.arrays.codes import TO_FOLLOW, TO_SEARCH
from contiga.records import Projection, SurfacePlaces, empty_projection
from contiga.search.certify.kernels.branch_nb import certify_rows
from contiga.search.certify.kernels.follow_nb import follow_rows
from contiga.search.tables import tracking_tables_of
from contiga.search.track import project
from contiga.search.track.track_records import Left
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
        patched.setattr(project, "_chunk", lambda *_: size)
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
    assert {Status.OK, Status.BRANCH_EVENT, Status.NOT_FINITE} <= set(whole.status)
    assert 0.3 < whole.certified.mean() < 1.0


def test_points_without_a_foot_get_their_closest_points_and_so_do_those_whose_branch_ends() -> None:
    body, before, now, feet = _scene()
    patch = feet.patch.copy()
    patch[::2] = -1
    out = _tracked(body, (before, now), (patch, feet.uv), 100)
    closest = body.project(now)
    anew = np.arange(len(now)) % 2 == 0
    events = (out.status == Status.BRANCH_EVENT) & (out.certified == 1)
    assert events.sum() > 3
    for own in (anew, events):
        np.testing.assert_array_equal(out.point[own], closest.point[own])
        np.testing.assert_array_equal(out.gap[own], closest.gap[own])


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


def test_only_rows_that_are_flagged_are_followed() -> None:
    body, before, now, feet = _scene()
    out = _tracked(body, (before, now), (feet.patch, feet.uv), len(now))
    rows = np.flatnonzero(out.certified == 1).astype(np.int32)
    flags = np.arange(len(rows), dtype=np.uint8) % 2 * np.uint8(TO_FOLLOW)
    out.certified[:] = 0
    left = Left(rows, flags, before[rows], feet.patch[rows], feet.uv[rows])
    follow_rows(tracking_tables_of(body), now, left, len(rows), out)
    np.testing.assert_array_equal(out.certified[rows], flags == TO_FOLLOW)


def test_of_rows_to_be_certified_flags_are_what_is_left_to_follow() -> None:
    body, before, now, feet = _scene()
    patch = feet.patch.copy()
    patch[::17] = -1
    before[12] = np.nan
    out = _tracked(body, (before, now), (patch, feet.uv), len(now))
    rows, flags = np.arange(len(now), dtype=np.int32), np.full(len(now), TO_SEARCH, np.uint8)
    left = Left(rows, flags, before, patch, feet.uv)
    m = certify_rows(tracking_tables_of(body), now, left, len(now), out)
    assert m == (flags == TO_FOLLOW).sum()
    assert set(np.unique(flags)) == {0, TO_FOLLOW}
    assert (flags[(patch < 0) | np.isnan(before[:, 0])] == 0).all()

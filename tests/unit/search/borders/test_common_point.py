"""Places on two leaves are led to points that both leaves pass through."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.borders.test_crossings import UPRIGHT, wall

import contiga as cg
from contiga.search.borders.crossing_records import CommonPoints, Starts
from contiga.search.borders.kernels.common_point_nb import (
    PLACES,
    find_common_points,
    nearest_starts,
)
from contiga.search.tables import tables_of

SHARES = np.array([0.1, 0.5, 0.9])


def led(body: cg.Body, shares: np.ndarray) -> CommonPoints:
    """Where places of the first leaves of two faces are led: shares (count, 2, 2)."""
    tables = tables_of(body)
    first = [int(np.flatnonzero(tables.leaves["patch"] == k)[0]) for k in (0, 1)]
    starts = Starts(np.array([first]), shares[None], np.full((1, len(shares)), body.size))
    common = CommonPoints.of(1, len(shares))
    find_common_points(tables.elements, tables.leaves, starts, 1e-11 * body.size, common, 0, 1)
    return common


def all_shares() -> np.ndarray:
    grid = np.stack(np.meshgrid(*[SHARES] * 4, indexing="ij"), axis=-1)
    return np.ascontiguousarray(grid.reshape(-1, 2, 2))


def test_walls_that_cross_are_met_on_their_line_with_their_own_derivatives() -> None:
    body = cg.Body([UPRIGHT, wall((-1.0, -0.5), (1.0, 2.0), 1.0)])
    common = led(body, all_shares())
    met = common.is_common[0]
    assert met.any()
    point = common.point[0, met]
    assert np.abs(point[:, :, :2]).max() < 1e-10
    for side, patch in enumerate(body.patches):
        d = patch.derivatives(common.uv[0, met, side], 1)
        np.testing.assert_allclose(d[:, 0, 0], point[:, side], atol=1e-12)
        along = np.stack([d[:, 1, 0], d[:, 0, 1]], axis=1)
        np.testing.assert_allclose(along, common.tangents[0, met, side], atol=1e-12)


def test_a_point_is_met_once_by_each_pair() -> None:
    body = cg.Body([UPRIGHT, wall((-1.0, 0.999), (1.0, 2.0), 1.0)])
    shares = np.repeat(all_shares()[:1], 5, axis=0)
    assert led(body, shares).is_common.tolist() == [[True, False, False, False, False]]


@pytest.mark.parametrize("gap", [1e-6, 0.1])
def test_walls_apart_are_not_met_and_places_stay_in_their_leaves(gap: float) -> None:
    body = cg.Body([UPRIGHT, wall((-1.0, 1.0 + gap), (1.0, 2.0), 1.0)])
    common = led(body, all_shares())
    assert not common.is_common.any()
    for side, patch in enumerate(body.patches):
        low, high = np.array(patch.domain).T
        assert (low <= common.uv[0, :, side]).all()
        assert (common.uv[0, :, side] <= high).all()


def test_a_curved_face_is_met_by_a_flat_one() -> None:
    sides = cg.shapes.saddle(), cg.shapes.plane(width=2.0, length=2.0)
    body = cg.Body(list(sides))
    tables, rng = tables_of(body), np.random.default_rng(0)
    leaf = [np.flatnonzero(tables.leaves["patch"] == k) for k in (0, 1)]
    pairs = np.array([(a, b) for a in leaf[0] for b in leaf[1]])
    share = rng.uniform(size=(len(pairs), 4, 2, 2))
    starts = Starts(pairs, share, np.full((len(pairs), 4), body.size))
    common = CommonPoints.of(len(pairs), 4)
    find_common_points(
        tables.elements, tables.leaves, starts, 1e-11 * body.size, common, 0, len(pairs)
    )
    point = common.point[common.is_common]
    assert len(point) > 20
    assert np.abs(point[:, 0] - point[:, 1]).max() <= 1e-11 * body.size
    assert np.abs(point[:, :, 2]).max() < 1e-10 * body.size


def test_starts_are_the_nearest_pairs_of_places_the_nearest_first() -> None:
    tables = tables_of(cg.Body([cg.shapes.saddle(), cg.shapes.plane(width=2.0, length=2.0)]))
    plates = tables.plates
    pairs = np.array([(k, len(plates) - 1 - k) for k in range(len(plates) // 2)])
    count = 4
    starts = Starts(pairs, np.empty((len(pairs), count, 2, 2)), np.empty((len(pairs), count)))
    nearest_starts(plates, starts)
    for pair, share, distance in zip(*starts, strict=True):
        on = [plates["middle"][k] + PLACES @ [plates["x"][k], plates["y"][k]] for k in pair]
        off = np.linalg.norm(on[0][:, None] - on[1], axis=2)
        np.testing.assert_allclose(distance, np.sort(off.ravel())[:count], rtol=1e-12)
        at = 2.0 * share - 1.0
        ends = [
            plates["middle"][k] + at[:, side] @ [plates["x"][k], plates["y"][k]]
            for side, k in enumerate(pair)
        ]
        np.testing.assert_allclose(np.linalg.norm(ends[0] - ends[1], axis=1), distance, rtol=1e-12)
        assert len(np.unique(share.reshape(count, 4), axis=0)) == count

"""What facets close: volume, gradient and areas of a box, and how stiff the volume is."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.dynamics.kernels.closed_skin_nb import AT_NODES, measure_facets, sum_at_nodes
from contiga.matter.kernels.lanes_nb import LANES

pytestmark = pytest.mark.interpreted

SIDES = np.array([2.0, 3.0, 5.0])
CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
FACETS = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))], np.int32)


def closed(points: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Measure the box with its nodes at points (8, 3)."""
    corners = np.zeros((1, 3, LANES), np.int32)
    corners[0, :, : len(FACETS)] = FACETS.T
    places = [np.flatnonzero((node == FACETS).any(axis=1)) for node in range(8)]
    starts = np.cumsum([0, *map(len, places)]).astype(np.int32)
    rows = np.concatenate(places).astype(np.int32)
    facets, areas, volumes = np.empty((LANES, AT_NODES)), np.empty((1, LANES)), np.empty(1)
    measure_facets(points, corners, facets.reshape(1, LANES, AT_NODES), areas, volumes, 0, 1)
    gradient, stiffness = np.empty((8, 3)), np.empty(8)
    sum_at_nodes(facets, starts, rows, gradient, stiffness, 0, 8)
    return float(volumes[0]), gradient, stiffness, areas[0, : len(FACETS)]


def test_a_box_has_its_volume_and_areas() -> None:
    volume, gradient, _, areas = closed(SIDES * CORNERS + 100.0)
    assert volume == pytest.approx(30.0, rel=1e-13)
    assert areas.sum() == pytest.approx(62.0, rel=1e-13)
    np.testing.assert_allclose(gradient.sum(axis=0), 0.0, atol=1e-12)


def test_the_gradient_is_that_of_the_volume_and_its_change_is_bounded() -> None:
    rng = np.random.default_rng(0)
    points = SIDES * CORNERS + 0.2 * rng.normal(size=(8, 3))
    _, gradient, stiffness, _ = closed(points)
    for _ in range(5):
        way = rng.normal(size=(8, 3))
        (after, up, *_), (before, down, *_) = (
            closed(points + 1e-6 * way),
            closed(points - 1e-6 * way),
        )
        assert (after - before) / 2e-6 == pytest.approx(np.sum(gradient * way), abs=1e-7)
        change = np.abs(up - down).max(axis=1) / 2e-6
        assert (change <= stiffness * np.abs(way).max()).all()

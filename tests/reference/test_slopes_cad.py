"""Derivatives of feet on CAD parts, trimmed faces and their edges, against differences of feet."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import full
from tests.unit.search.slopes import test_slopes as rig

import contiga as cg

pytestmark = pytest.mark.usefixtures("kept")


@pytest.mark.parametrize(
    ("name", "edges"),
    [("occt_bearing.iges", 0), *full(("nist_ctc_02_asme1_ap242.stp", 100))],
)
def test_depths_and_normals_change_as_they_say(data_dir, monkeypatch, name, edges):
    part = cg.read_cad(data_dir / name)
    step = 2e-6 * part.size
    monkeypatch.setattr(rig, "STEP", step)
    low, high = part.bounds()
    points = np.random.default_rng(0).uniform(low, high, (40_000 if edges else 3_000, 3))
    feet = part.project(points)
    near = (np.abs(feet.gap) < 0.03 * part.size) & (np.abs(feet.gap) > 1e-3 * part.size)
    points = points[near & (feet.status == cg.Status.OK)][:6000]
    feet = part.project(points)
    calm = ~rig.beside_a_knot(part, feet)
    for way in 2.0 * step * np.vstack([np.eye(3), -np.eye(3)]):
        moved = part.project(points + way)
        calm &= (moved.feature == feet.feature) & (moved.patch == feet.patch)
        calm &= np.linalg.norm(moved.point - feet.point, axis=1) < 100.0 * step
    points, feet = points[calm], cg.Projection(*(values[calm] for values in feet))
    assert len(points) > 500
    assert np.count_nonzero(feet.feature != cg.Feature.FACE) >= edges
    found, wanted = rig.slopes_of(part, points, feet), rig.differences(part, points)
    np.testing.assert_allclose(found.depth, wanted.depth, rtol=0.0, atol=1e-8)
    turning = np.maximum(np.abs(wanted.normal).max(axis=(1, 2)), 1.0 / part.size)
    miss = np.abs(found.normal - wanted.normal).max(axis=(1, 2)) / turning
    assert np.quantile(miss, 0.99) < 1e-8
    assert miss.max() < 1e-6  # differences of feet that are exact to 1e-12 of the size

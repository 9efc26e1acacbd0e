"""Closest points of trimming curves in space."""

from __future__ import annotations

import numpy as np
from tests.unit.search.holed import holed_plate


def test_feet_on_a_trimmed_edge_against_dense_sampling():
    body = holed_plate(waves=3)
    angle = np.linspace(0, 2 * np.pi, 20001)
    ring = np.column_stack([0.5 + 0.2 * np.cos(angle), 0.5 + 0.2 * np.sin(angle)])
    border = body.patches[0].evaluate(ring)
    p = np.random.default_rng(0).uniform([-0.1, -0.1, -0.3], [0.1, 0.1, 0.3], (300, 3))
    feet = body.project(p)
    least = np.array([np.linalg.norm(border - x, axis=1).min() for x in p])
    distance = np.linalg.norm(feet.point - p, axis=1)
    assert (distance <= least + 1e-12).all()
    at_edge = feet.feature == 1
    assert at_edge.sum() > 100
    assert (least - distance < 1e-6)[at_edge].all()
    assert (np.hypot(*(feet.uv - 0.5).T) >= 0.2 - 1e-12).all()

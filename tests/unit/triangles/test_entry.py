"""Crossings of a swept point with a mesh, against every triangle."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg


def crossings(mesh, p, q):
    """Shares of the way at which p → q goes through each triangle, and the slopes there."""
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    n = np.cross(b - a, c - a)
    d = q - p
    slope = n @ d
    x = ((a - p) * n).sum(axis=1) / slope
    at = p + x[:, None] * d
    inside = np.ones(len(a), bool)
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(end - start, at - start) * n).sum(axis=1) >= 0.0
    keep = inside & (x >= 0.0) & (x <= 1.0)
    return x[keep], slope[keep]


def test_the_first_entry_is_the_first_of_all_triangles():
    mesh = cg.Body([cg.shapes.torus()]).tessellate(0.02)
    rng = np.random.default_rng(0)
    p, q = rng.uniform(-5.0, 5.0, (2, 300, 3))
    hit = mesh.first_hit(p, q)
    entered = 0
    for i in range(300):
        x, slope = crossings(mesh, p[i], q[i])
        into = x[slope < 0.0]
        if len(into):
            entered += 1
            assert hit.fraction[i] == pytest.approx(into.min(), abs=1e-10)
        else:
            assert np.isnan(hit.fraction[i])
    assert 30 < entered < 270

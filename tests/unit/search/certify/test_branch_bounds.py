"""What the certificate of a tracked foot concludes from bounds holds whatever is within them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search.strips import geodesics

from contiga.search.certify.certify_records import Motion
from contiga.search.certify.kernels import branch_nb


@njit
def proof_holds(curvature, seen, r):
    return branch_nb.proof_holds(curvature, seen, r)


@njit
def ball_radius(curvature, way, seen):
    return branch_nb.ball_radius(curvature, np.inf, np.inf, way, seen, 0.0)


@pytest.mark.interpreted
@pytest.mark.parametrize("given", ["ball", "way"])
def test_the_theorem_holds_on_every_surface_within_its_bounds(given):
    """Along geodesics from a foot that bend as badly as they may f is convex, and rises at the end
    of them, before the motion and after: nothing of the condition can be left out."""
    rng = np.random.default_rng(0)
    n = 8000
    inner, outer = rng.uniform(0.0, 1.0, (2, n)) ** rng.choice([0.0, 1.0, 4.0], (2, n))
    r = 10.0 ** rng.uniform(-2.0, 0.3, n)
    m = np.zeros((2, n))
    m[1] = rng.choice([0.1, 1.0], n) * rng.uniform(0.0, 1.0, n)
    m[1] *= np.where(
        rng.random(n) < 0.5, 1.0 / np.maximum(inner, 0.2), -1.0 / np.maximum(outer, 0.2)
    )
    m[0] = m[1] + rng.choice([0.0, 0.3, 1.5], n) * r * rng.normal(size=n)
    slip = rng.choice([0.0, 0.1, 1.0], n) * r * rng.uniform(0.0, 1.0, n)
    aside = rng.choice([0.0, 1.0], n) * rng.uniform(0.0, 2.0 * np.pi, n)
    points = np.zeros((2, n, 3))
    points[..., 2] = m
    points[0, :, 0] = rng.choice([-1.0, 1.0], n) * slip * np.cos(aside)
    points[0, :, 1] = slip * np.sin(aside)
    far = np.linalg.norm(points, axis=-1).max(axis=0)
    bend, high = list(zip(inner, outer, strict=True)), list(zip(*m, strict=True))
    seen = [Motion(high[k], far[k], slip[k]) for k in range(n)]
    if given == "ball":
        held = np.array([proof_holds(bend[k], seen[k], r[k]) for k in range(n)])
    else:
        r = np.array(
            [ball_radius(bend[k], r[k] / branch_nb.BALL_MARGIN, seen[k]) for k in range(n)]
        )
        held = r > 0.0
    assert held.sum() > 2000
    x, tangent, normal = geodesics(rng, held.sum(), inner[held], outer[held], r[held])
    w = points[:, held, None] - x
    high = (w * normal).sum(-1)
    assert (np.maximum(inner[held, None] * high, -outer[held, None] * high) < 1.0).all()
    assert ((w * tangent).sum(-1)[..., -1] < 0.0).all()

"""First entries of segments: none missed, none false."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.statuses import Status


def valid(body, a, b, hit):
    """Every hit lies on the segment and on the surface, and enters from the free side."""
    rows = np.flatnonzero(hit.patch >= 0)
    d = b[rows] - a[rows]
    on_path = a[rows] + hit.fraction[rows, None] * d
    np.testing.assert_allclose(on_path, hit.point[rows], rtol=0, atol=1e-10 * body.size)
    for k, patch in enumerate(body.patches):
        own = rows[hit.patch[rows] == k]
        found = patch.evaluate(hit.uv[own])
        np.testing.assert_allclose(found, hit.point[own], rtol=0, atol=1e-10 * body.size)
        slope = (patch.normal(hit.uv[own]) * (b[own] - a[own])).sum(axis=1)
        assert (slope < 1e-7 * np.linalg.norm(b[own] - a[own], axis=1)).all()
    return rows


def entries_into_plate(patch, a, b, samples):
    """Oracle: first sampled change of sign of z − F(x, y) along the path, bisected.

    The plate's x and y are linear in u and v, so that F is its z at (u, v) of (x, y).
    """

    def height(tau):
        p = a + tau[:, None] * (b - a)
        inside = (np.abs(p[:, :2]) <= 0.5).all(axis=1)
        z = patch.evaluate(np.clip(p[:, :2] + 0.5, 0, 1))[:, 2]
        return np.where(inside, p[:, 2] - z, np.nan)

    n = len(a)
    bracket = np.full(n, np.nan)
    before = height(np.zeros(n))
    for k in range(1, samples + 1):
        now = height(np.full(n, k / samples))
        bracket[np.isnan(bracket) & (before > 0) & (now <= 0)] = k / samples
        before = now
    rows = np.flatnonzero(~np.isnan(bracket))
    a, b = a[rows], b[rows]
    low, high = bracket[rows] - 1 / samples, bracket[rows]
    for _ in range(45):
        middle = 0.5 * (low + high)
        up = height(middle) > 0
        low, high = np.where(up, middle, low), np.where(up, high, middle)
    bracket[rows] = high
    return bracket


def check_plate(n, samples, seed):
    patch = cg.shapes.bumpy_plate(amplitude=0.08, waves=(3, 2))
    body = cg.Body([patch])
    rng = np.random.default_rng(seed)
    a = rng.uniform([-0.7, -0.7, -0.1], [0.7, 0.7, 0.15], (n, 3))
    b = a + rng.normal(size=(n, 3)) * 10 ** rng.uniform(-2.5, 0, (n, 1)) * [1, 1, 0.4]
    expected = np.concatenate(
        [
            entries_into_plate(patch, a[k : k + 5000], b[k : k + 5000], samples)
            for k in range(0, n, 5000)
        ]
    )
    hit = body.first_hit(a, b)
    valid(body, a, b, hit)
    fraction = np.where(np.isnan(hit.fraction), np.inf, hit.fraction)
    missed = ~np.isnan(expected) & ~(fraction <= expected + 1e-9)
    # The oracle bisects along the border too, where a path leaves the plate.
    foot = a + np.nan_to_num(expected)[:, None] * (b - a)
    missed &= (np.abs(foot[:, :2]) < 0.5 - 1e-9).all(axis=1)
    return int(missed.sum()), int((hit.patch >= 0).sum())


def test_no_entry_into_a_bumpy_plate_is_missed():
    missed, found = check_plate(100_000, 24, seed=0)
    assert missed == 0
    assert found > 5_000


@pytest.mark.full
def test_no_entry_is_missed_in_ten_million_segments():
    for seed in range(100):
        assert check_plate(100_000, 100, seed=seed)[0] == 0


def test_entries_into_a_torus_against_the_roots_of_its_quartic():
    body = cg.Body([cg.shapes.torus(major=2.0, minor=0.7)])
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-3, 3, (2, 1500, 3))
    hit = body.first_hit(a, b)
    valid(body, a, b, hit)
    for p, q, fraction in zip(a, b, hit.fraction, strict=True):
        d = q - p
        # (|x|² + R² − r²)² = 4 R² (x² + y²) along x = p + τ d
        s = np.array([d @ d, 2 * p @ d, p @ p + 4 - 0.49])
        flat = np.array([d[:2] @ d[:2], 2 * p[:2] @ d[:2], p[:2] @ p[:2]])
        f = np.polysub(np.polymul(s, s), 16 * flat)
        roots = np.roots(f)
        real = np.sort(roots[np.abs(roots.imag) < 1e-9].real)
        entering = [t for t in real if 0 <= t <= 1 and np.polyval(np.polyder(f), t) < 0]
        if entering:
            assert abs(fraction - entering[0]) < 1e-8
        else:
            assert np.isnan(fraction)


def test_paths_that_hit_seams_knot_lines_corners_and_common_edges():
    patch = cg.shapes.bumpy_plate(waves=2)
    left, right = patch.split(u=0.5)
    for body in (cg.Body([patch]), cg.Body([left, right])):
        marks = np.unique(patch.knots[0])
        uv = np.stack(np.meshgrid(marks, marks, indexing="ij"), -1).reshape(-1, 2)
        s = patch.evaluate(uv)
        for tilt in ([0, 0, 1.0], [0.3, 0, 1], [0.2, -0.4, 1]):
            hit = body.first_hit(s + 0.1 * np.array(tilt), s - 0.3 * np.array(tilt))
            np.testing.assert_allclose(hit.fraction, 0.25, atol=1e-10)


def test_a_crease_is_entered_over_its_ridge():
    """A path that meets the ridge of a roof exactly, from above: neither side may say no."""
    a = cg.shapes.bilinear([-1, 0, 0], [0, 0, 1], [-1, 1, 0], [0, 1, 1])
    b = cg.shapes.bilinear([0, 0, 1], [1, 0, 0], [0, 1, 1], [1, 1, 0])
    body = cg.Body([a, b])
    y = np.linspace(0, 1, 11)
    top = np.column_stack([0 * y, y, 0 * y + 2])
    hit = body.first_hit(top, top - [0, 0, 2])
    np.testing.assert_allclose(hit.fraction, 0.5, atol=1e-10)


def test_degenerate_segments():
    body = cg.Body([cg.shapes.sphere()])
    p = np.array([[2.0, 0, 0], [0, 0, 0], [np.nan, 0, 0]])
    hit = body.first_hit(p, p)
    assert hit.status.tolist() == [Status.NO_HIT, Status.NO_HIT, Status.NOT_FINITE]
    assert len(body.first_hit(np.zeros((0, 3)), np.zeros((0, 3))).fraction) == 0
    with pytest.raises(InputError, match="as many ends"):
        body.first_hit(p, p[:2])


@pytest.mark.interpreted
def test_one_entry_without_compilation():
    body = cg.Body([cg.shapes.plane()])
    hit = body.first_hit([[0.1, 0.2, 1.0]], [[0.1, 0.2, -1.0]])
    assert hit.fraction[0] == pytest.approx(0.5, abs=1e-14)
    np.testing.assert_allclose(hit.point, [[0.1, 0.2, 0.0]], atol=1e-14)


def test_paths_that_graze_a_cylinder_at_its_seam_meet_it_where_it_is():
    """Cells along a seam grow thin and stay long: flat along the path, but no points."""
    body = cg.Body([cg.shapes.cylinder(radius=25.0, height=40.0)])
    rng = np.random.default_rng(0)
    n = 3000
    seam = np.column_stack([np.full(n, 25.0), np.zeros(n), rng.uniform(-15.0, 15.0, n)])
    slope, angle = 10.0 ** rng.uniform(-6.0, 0.0, n), rng.uniform(0.0, 2.0 * np.pi, n)
    flat = np.sqrt(1.0 - slope**2)
    d = np.column_stack([-slope, flat * np.cos(angle), flat * np.sin(angle)])
    length, share = 10.0 ** rng.uniform(-6.0, 2.0, (n, 1)), rng.random((n, 1))
    a = seam - share * length * d
    b = a + length * d
    hit = body.first_hit(a, b)
    assert (hit.patch == 0).all()
    on_path = a + hit.fraction[:, None] * (b - a)
    np.testing.assert_allclose(on_path, hit.point, rtol=0, atol=1e-8)
    np.testing.assert_allclose(np.hypot(*on_path.T[:2]), 25.0, rtol=0, atol=1e-12)

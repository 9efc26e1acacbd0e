"""What must hold of every projection and first hit, whatever the surface."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest

import contiga as cg
from contiga.statuses import Feature, Status


def surface(seed, degrees=(3, 3), spans=(3, 2), *, log_weights=3.0, multiplicity=1, rough=0.3):
    """A random sheet over the unit square; weights from 10^-log_weights to 10^log_weights."""
    rng = np.random.default_rng(seed)
    knots = []
    for p, n in zip(degrees, spans, strict=True):
        inner = np.repeat(np.arange(1, n) / n, min(multiplicity, p))
        knots.append(np.concatenate([np.zeros(p + 1), inner, np.ones(p + 1)]))
    a, b = (len(k) - p - 1 for k, p in zip(knots, degrees, strict=True))
    x, y = np.meshgrid(np.linspace(0, 1, a), np.linspace(0, 1, b), indexing="ij")
    net = np.stack([x, y, 0 * x], axis=-1)
    net += rough * rng.normal(size=(a, b, 3)) * [0.3, 0.3, 1.0]
    weights = 10 ** rng.uniform(-log_weights, log_weights, (a, b)) if log_weights else None
    return cg.NurbsSurface(degrees, knots, net, weights)


def points_about(patch, n, seed):
    """Points off the surface on both sides, by 1e-6 to 1 of its size, and some anywhere."""
    rng = np.random.default_rng(seed)
    uv = rng.random((n, 2))
    offset = rng.choice([-1.0, 1.0], (n, 1)) * 10 ** rng.uniform(-6, 0, (n, 1))
    p = patch.evaluate(uv) + patch.normal(uv) * offset
    low, high = patch.bounds()
    p[::4] = low + (high - low) * rng.uniform(-0.3, 1.3, p[::4].shape)
    return p


def oracle_distance(patch, points, per=10, keep=6, rounds=40):
    """Distance by brute force: the best local minima of a fine grid, zoomed in on."""
    marks = [
        np.unique(np.concatenate([np.linspace(a, b, per + 1) for a, b in pairwise(k)]))
        for k in map(np.unique, patch.knots)
    ]
    (u0, u1), (v0, v1) = patch.domain
    grid = np.stack(np.meshgrid(*marks, indexing="ij"), axis=-1)
    shape = grid.shape[:2]
    grid = grid.reshape(-1, 2)
    square = ((points[:, None] - patch.evaluate(grid)[None]) ** 2).sum(axis=2)
    field = square.reshape(-1, *shape)
    padded = np.pad(field, ((0, 0), (1, 1), (1, 1)), constant_values=np.inf)
    lowest = np.ones(field.shape, bool)
    for i in range(3):
        for j in range(3):
            lowest &= field <= padded[:, i : i + shape[0], j : j + shape[1]]
    order = np.argsort(np.where(lowest.reshape(square.shape), square, np.inf), axis=1)[:, :keep]
    uv = grid[order]
    best = np.take_along_axis(square, order, axis=1)
    width = np.array([np.diff(m).max() for m in marks]) * np.ones(uv.shape)
    cross = np.stack(np.meshgrid(*[np.linspace(-1, 1, 5)] * 2, indexing="ij"), -1).reshape(-1, 2)
    for _ in range(rounds):
        tried = np.clip(uv[:, :, None] + width[:, :, None] * cross, [u0, v0], [u1, v1])
        values = patch.evaluate(tried.reshape(-1, 2)).reshape(*tried.shape[:3], 3)
        result = ((values - points[:, None, None]) ** 2).sum(axis=-1)
        at = result.argmin(axis=2)[..., None]
        best = np.minimum(best, np.take_along_axis(result, at, axis=2)[..., 0])
        uv = np.take_along_axis(tried, at[..., None], axis=2)[:, :, 0]
        width = np.where(at == 12, 0.5 * width, 0.9 * width)
    return np.sqrt(best.min(axis=1))


def distances(feet, points):
    return np.linalg.norm(points - feet.point, axis=1)


def check_feet(body, points, feet):
    """What every record of a projection must satisfy."""
    size = body.size
    assert np.isin(feet.status, (Status.OK, Status.BORDER, Status.TRIMMED)).all()
    np.testing.assert_allclose(np.abs(feet.gap), distances(feet, points), atol=1e-11 * size)
    np.testing.assert_allclose(np.linalg.norm(feet.normal, axis=1), 1.0, atol=1e-12)
    for k, patch in enumerate(body.patches):
        own = feet.patch == k
        np.testing.assert_allclose(
            patch.evaluate(feet.uv[own]), feet.point[own], rtol=0, atol=2e-11 * size
        )


CASES = [
    ((3, 3), (3, 2), 3.0, 1, 0.3),
    ((3, 3), (2, 2), 3.0, 3, 0.1),
    ((3, 3), (3, 3), 0.5, 1, 0.3),
    ((2, 1), (3, 3), 1.0, 1, 0.3),
    ((1, 1), (4, 3), 0.0, 1, 0.5),
    ((2, 2), (3, 3), 0.5, 2, 0.3),
    ((6, 3), (2, 2), 0.5, 1, 0.3),
    ((5, 4), (2, 1), 1.0, 1, 0.3),
    ((15, 2), (1, 2), 0.3, 1, 0.2),
]


@pytest.mark.parametrize("case", CASES, ids=str)
@pytest.mark.parametrize("seed", [1, 2])
def test_no_foot_is_farther_than_brute_force_finds(case, seed):
    degrees, spans, log_weights, multiplicity, rough = case
    patch = surface(
        seed, degrees, spans, log_weights=log_weights, multiplicity=multiplicity, rough=rough
    )
    body = cg.Body([patch])
    p = points_about(patch, 60, seed)
    feet = body.project(p)
    check_feet(body, p, feet)
    assert (distances(feet, p) - oracle_distance(patch, p)).max() <= 1e-9 * body.size


@pytest.mark.parametrize("share", [1e-6, 0.3, 0.99])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_round_trip_up_to_the_focal_surface(share, sign):
    """P = S + g n leads back to (u, v) by tracking, as long as 1 − g κ stays positive."""
    patch = surface(5, log_weights=0.5, rough=0.15)
    rng = np.random.default_rng(6)
    uv = rng.uniform(0.02, 0.98, (300, 2))
    D = patch.derivatives(uv, order=2)
    n = patch.normal(uv)
    first = np.einsum("kax,kbx->kab", *[np.stack([D[:, 1, 0], D[:, 0, 1]], axis=1)] * 2)
    second = np.einsum(
        "kabx,kx->kab",
        np.stack([np.stack([D[:, 2, 0], D[:, 1, 1]], 1), np.stack([D[:, 1, 1], D[:, 0, 2]], 1)], 1),
        n,
    )
    kappa = np.linalg.eigvals(np.linalg.solve(first, second)).real
    worst = (sign * kappa).max(axis=1)
    gap = sign * np.minimum(share / np.maximum(worst, 1e-3), 0.5)
    body = cg.Body([patch])
    start = body.project(patch.evaluate(uv))
    feet = start._replace(patch=np.zeros(300, np.int32), uv=uv.copy())
    feet = body.project(patch.evaluate(uv) + gap[:, None] * n, start=feet, mode="track")
    assert (feet.status == Status.OK).all()
    np.testing.assert_allclose(feet.gap, gap, atol=1e-11)
    np.testing.assert_allclose(feet.uv, uv, atol=1e-9 / (1.0 - share) if share < 1 else 0)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_scale_does_not_matter(scale):
    patch = surface(7, log_weights=0.5)
    p = points_about(patch, 200, 8)
    here = cg.Body([patch]).project(p)
    there = cg.Body([patch.scaled(scale)]).project(scale * p)
    np.testing.assert_allclose(there.gap, scale * here.gap, rtol=0, atol=1e-11 * scale)
    np.testing.assert_array_equal(there.feature, here.feature)
    np.testing.assert_array_equal(there.status, here.status)


def test_an_offset_of_a_million_costs_its_digits_and_no_more():
    patch = surface(7, log_weights=0.5)
    p = points_about(patch, 200, 8)
    d = np.array([1e6, -1e6, 5e5])
    body = cg.Body([patch.translated(d)])
    here, there = cg.Body([patch]).project(p), body.project(p + d)
    np.testing.assert_allclose(there.gap, here.gap, rtol=0, atol=2e-9)
    np.testing.assert_array_equal(there.status, here.status)
    moved = p + d + 0.01
    again = body.project(moved, start=there, mode="track")
    assert np.isin(again.status, (Status.OK, Status.BORDER)).all()


def test_reparametrised_knots_and_rigid_motion_and_order():
    patch = surface(9, log_weights=1.0)
    p = points_about(patch, 300, 10)
    body = cg.Body([patch])
    here = body.project(p)
    stretched = cg.NurbsSurface(
        patch.degrees,
        (patch.knots[0] * 1e4 - 3.0, patch.knots[1] * 1e-5),
        patch.control_points,
        patch.weights,
    )
    there = cg.Body([stretched]).project(p)
    np.testing.assert_allclose(there.gap, here.gap, rtol=0, atol=1e-11)
    np.testing.assert_allclose(there.uv, here.uv * [1e4, 1e-5] - [3.0, 0.0], rtol=1e-7, atol=1e-4)

    turned = cg.Body([patch.rotated([1, 2, 3], 0.7).translated([1, -2, 0.5])])
    q = cg.shapes.line([0, 0, 0], [1, 0, 0])  # any curve moves as points do
    q = cg.NurbsCurve(1, np.r_[0, np.linspace(0, 1, len(p)), 1], p)
    moved = q.rotated([1, 2, 3], 0.7).translated([1, -2, 0.5]).control_points
    np.testing.assert_allclose(turned.project(moved).gap, here.gap, rtol=0, atol=1e-11)

    order = np.random.default_rng(0).permutation(len(p))
    mixed = body.project(p[order])
    for a, b in zip(mixed, here, strict=True):
        np.testing.assert_array_equal(a, b[order])


def pieces(patch, n):
    """The patch cut into n × n, every second piece reversed, every third transposed as well."""
    (u0, u1), (v0, v1) = patch.domain
    result = []
    for i in range(n):
        for j in range(n):
            part = patch.restricted(
                (u0 + (u1 - u0) * i / n, u0 + (u1 - u0) * (i + 1) / n),
                (v0 + (v1 - v0) * j / n, v0 + (v1 - v0) * (j + 1) / n),
            )
            k = i * n + j
            if k % 3 == 1:  # both: the normal stays
                part = part.transposed().flipped()
            result.append(part)
    return result


def test_a_surface_in_sixty_four_pieces_is_the_same_surface():
    patch = surface(11, log_weights=0.5, rough=0.15)
    p = points_about(patch, 300, 12)
    rng = np.random.default_rng(13)
    whole, parts = cg.Body([patch]), cg.Body(pieces(patch, 8))
    a, b = whole.project(p), parts.project(p)
    np.testing.assert_allclose(b.gap, a.gap, rtol=0, atol=1e-12 * whole.size)
    np.testing.assert_array_equal(b.feature, a.feature)
    np.testing.assert_array_equal(b.status, a.status)
    uv = rng.random((300, 2))  # near enough to stay on one branch
    p = patch.evaluate(uv) + rng.uniform(-0.02, 0.02, (300, 1)) * patch.normal(uv)
    a, b = whole.project(p), parts.project(p)
    for _ in range(30):
        p = p + 0.004 * rng.normal(size=p.shape)
        a = whole.project(p, start=a, mode="track")
        b = parts.project(p, start=b, mode="track")
        np.testing.assert_allclose(b.point, a.point, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(b.status, a.status)
    q = p[:, ::-1] * 0.5
    hits, again = whole.first_hit(p, q), parts.first_hit(p, q)
    np.testing.assert_allclose(hits.fraction, again.fraction, atol=1e-10)


def test_tracked_feet_are_local_minima():
    for seed, multiplicity in ((1, 1), (2, 3)):
        patch = surface(seed, log_weights=0.3, rough=0.1, multiplicity=multiplicity)
        body, rng = cg.Body([patch]), np.random.default_rng(seed)
        p = points_about(patch, 200, seed)
        feet = body.project(p)
        for _ in range(20):
            p = p + 0.02 * rng.normal(size=p.shape)
            feet = body.project(p, start=feet, mode="track")
            # A minimum that vanished gives way to the closest point, which is one too.
            kinds = (Status.OK, Status.BORDER, Status.BRANCH_EVENT)
            assert np.isin(feet.status, kinds).all()
            near = np.clip(feet.uv[:, None] + 1e-6 * rng.normal(size=(1, 10, 2)), 0, 1)
            other = patch.evaluate(near.reshape(-1, 2)).reshape(len(p), 10, 3)
            least = np.linalg.norm(other - p[:, None], axis=2).min(axis=1)
            away = (np.abs(feet.uv * [3, 2] - np.round(feet.uv * [3, 2])) > 1e-4).all(axis=1)
            on = feet.feature != Feature.FACE
            keep = away | on
            assert (distances(feet, p) - least)[keep].max() <= 1e-10


def test_rows_that_are_not_finite_are_marked_and_harm_no_others():
    patch = surface(3, log_weights=0.3)
    body = cg.Body([patch])
    p = points_about(patch, 50, 3)
    clean = body.project(p)
    p[3], p[7, 1], p[11, 2] = np.nan, np.inf, -np.inf
    bad = [3, 7, 11]
    good = np.setdiff1d(np.arange(50), bad)
    for feet in (body.project(p), body.project(p, start=clean, mode="track")):
        assert (feet.status[bad] == Status.NOT_FINITE).all()
        assert (feet.patch[bad] == -1).all()
        assert np.isnan(feet.gap[bad]).all()
        np.testing.assert_allclose(feet.point[good], clean.point[good], atol=1e-10)
    hit = body.first_hit(p, p + 1.0)
    assert (hit.status[bad] == Status.NOT_FINITE).all()
    doubled = body.project(np.repeat(p[good], 3, axis=0))
    np.testing.assert_array_equal(doubled.gap[::3], doubled.gap[1::3])
    np.testing.assert_array_equal(doubled.uv[::3], doubled.uv[2::3])


THREADS = """
import hashlib, sys
import numpy as np, contiga as cg
body = cg.Body([cg.shapes.bumpy_plate(), cg.shapes.torus()])
rng = np.random.default_rng(0)
p = rng.normal(size=(3000, 3))
feet = body.project(p)
later = body.project(p + 0.05, start=feet, mode="track")
hits = body.first_hit(p, p[::-1].copy())
parts = [np.ascontiguousarray(x).tobytes() for x in (*feet, *later, *hits)]
print(hashlib.sha256(b"".join(parts)).hexdigest())
"""


def test_one_thread_and_two_give_the_same_bits():
    actual = set()
    for threads in ("1", "2"):
        environment = {**os.environ, "NUMBA_NUM_THREADS": threads}
        done = subprocess.run(
            [sys.executable, "-c", THREADS], env=environment, capture_output=True, check=True
        )
        actual.add(done.stdout)
    assert len(actual) == 1

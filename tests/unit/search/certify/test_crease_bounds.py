"""What the certificate of creases says of a strip along it holds for all strips within bounds.

The strips of `strips` bend as badly as the bounds allow: none of the terms can be left out.
"""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search.strips import creases, geodesics

from contiga.search.certify.certify_records import Curve, Reach
from contiga.search.certify.kernels import crease_nb

pytestmark = pytest.mark.interpreted


@njit
def least_in_face(bend, normal, w0, w1, wide):
    return crease_nb.least_in_face(bend, normal, w0, w1, wide)


@njit
def least_along(curve, ends, reach):
    return crease_nb.least_along(curve, ends, reach)


@njit
def most_jump(bends, faces, ends, reach, bent):
    return crease_nb.most_jump(bends, faces, ends, reach, bent)


@njit
def fall_from(w, tangent, b_1, b_2):
    return crease_nb.fall_from(w, tangent, b_1, b_2)


def motions(rng, n):
    """Points as seen from the origin, before and after a motion: (2, n, 3). Some lie nearly along
    the first axis, some nearly across it; some hardly move."""
    w = rng.normal(size=(2, n, 3))
    w[:, rng.random(n) < 0.3] *= [1.0, 0.01, 0.01]
    w[:, rng.random(n) < 0.3] *= [0.01, 1.0, 1.0]
    w[1] = w[0] + rng.choice([0.0, 0.3, 1.0], n)[:, None] * rng.normal(size=(n, 3))
    return w


def seen(w, x):
    """The same points as seen from ways x (n, places, 3)."""
    return w[:, :, None] - x


def test_f_is_as_convex_in_a_face_as_told():
    """Along geodesics of surfaces whose curvatures keep within bounds."""
    rng = np.random.default_rng(0)
    n = 400
    inner, outer = rng.choice([0.0, 0.2, 1.0], (2, n)) * rng.uniform(0.5, 1.0, (2, n))
    way = 10.0 ** rng.uniform(-2.0, 0.0, n)
    w = motions(rng, n)
    x, _, normal = geodesics(rng, n, inner, outer, way)
    at = seen(w, x)
    far = np.linalg.norm(at, axis=-1).max(axis=(0, 2))
    m = (at * normal).sum(-1)
    truth = 1.0 - np.maximum(inner[:, None] * m, -outer[:, None] * m).max(axis=(0, 2))
    for k in range(n):
        bend = np.array([inner[k], outer[k], 0.0, 0.0, 0.0, 0.0])
        ends = (tuple(w[0, k]), tuple(w[1, k]))
        told = least_in_face(bend, (0.0, 0.0, 1.0), *ends, (far[k], way[k]))
        assert told <= truth[k] + 1e-12


def test_f_is_as_convex_along_a_crease_as_told():
    """Along cubics C(y), |y| ≤ 1, whose bounds are those of their coefficients."""
    rng = np.random.default_rng(1)
    y = np.linspace(-1.0, 1.0, 41)[:, None]
    for _ in range(400):
        a = rng.normal(size=3)
        c, d = rng.normal(size=(2, 3)) * rng.choice([0.0, 0.1, 0.5], (2, 1))
        slope, bend = a + y * c + 0.5 * y**2 * d, c + y * d
        speed = np.linalg.norm(slope, axis=1)
        if speed.min() < 0.2 * speed.max():
            continue
        e = slope / speed[:, None]
        at = motions(rng, 1) * 3.0 - (a * y + 0.5 * y**2 * c + y**3 / 6.0 * d)
        w0, w1 = (tuple(p[20]) for p in at)
        far, along = np.linalg.norm(at, axis=-1).max(), np.abs((at * e).sum(-1)).max()
        curve = Curve(tuple(c), np.linalg.norm(d), speed.min(), 0.0)
        reach = Reach(0.5 * np.ptp(y) * speed.max(), far, along)
        told = least_along(curve, (w0, w1), reach)
        k = (bend - (bend * e).sum(-1, keepdims=True) * e) / speed[:, None] ** 2
        assert told <= 1.0 - max((at * k).sum(-1).max(), 0.0) + 1e-12


def test_slopes_fall_over_a_crease_no_more_than_told():
    rng = np.random.default_rng(2)
    n = 400
    bent = rng.uniform(0.0, 1.0, n) * rng.choice([0.0, 1.0], n)
    torsion = rng.uniform(0.0, 1.0, (2, n)) * rng.choice([0.0, 1.0], (2, n))
    arc = 10.0 ** rng.uniform(-2.0, 0.0, n)
    w = motions(rng, n)
    x, tangent, _, b = creases(rng, n, bent, torsion, arc)
    at = seen(w, x)
    far = np.linalg.norm(at, axis=-1).max(axis=(0, 2))
    along = np.abs((at * tangent).sum(-1)).max(axis=(0, 2))
    truth = (at * (b[0] + b[1])).sum(-1).max(axis=(0, 2))
    for k in range(n):
        bends = tuple(np.array([t, t, 0.0, 0.0, 0.0, 0.0]) for t in torsion[:, k])
        faces = (tuple(b[0, k, 0]), tuple(b[1, k, 0]))
        reach = Reach(arc[k], far[k], along[k])
        told = most_jump(bends, faces, (tuple(w[0, k]), tuple(w[1, k])), reach, bent[k])
        assert told >= truth[k] - 1e-9


def test_f_falls_from_a_crease_as_fast_as_told():
    """Of all ways into either face and along the crease, to 1 %."""
    rng = np.random.default_rng(3)
    turn = np.linspace(0.0, np.pi, 181)
    for _ in range(100):
        b = np.zeros((2, 3))
        angle = rng.uniform(-np.pi, np.pi, 2)
        b[:, 1], b[:, 2] = np.cos(angle), np.sin(angle)
        w = motions(rng, 1)[0, 0]
        ways = [np.cos(turn)[:, None] * [1.0, 0.0, 0.0] + np.sin(turn)[:, None] * v for v in b]
        truth = (np.concatenate(ways) @ w).max()
        assert fall_from(tuple(w), (1.0, 0.0, 0.0), *map(tuple, b)) == pytest.approx(
            truth, rel=1e-3
        )

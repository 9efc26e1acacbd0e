"""What must hold of every path against every surface, whatever its length and place."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sample import FULL

import contiga as cg

SETTINGS = settings(max_examples=40 if FULL else 10, deadline=None, derandomize=True)

seeds = st.integers(0, 2**31 - 1)
logs = st.floats(-10.0, 2.0)
scales = st.sampled_from([1e-6, 1e-2, 1.0, 37.0, 1e5])
offsets = st.sampled_from([0.0, 3.0, 1e3, 1e6])
N = 200


def sphere_gap(p: np.ndarray) -> np.ndarray:
    return np.linalg.norm(p, axis=1) - 1.0


def torus_gap(p: np.ndarray) -> np.ndarray:
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - 2.0, p[:, 2]) - 0.7


def cylinder_gap(p: np.ndarray) -> np.ndarray:
    return np.hypot(p[:, 0], p[:, 1]) - 1.0


GAPS = {
    "sphere": (cg.shapes.sphere, {}, sphere_gap),
    "torus": (cg.shapes.torus, {"major": 2.0, "minor": 0.7}, torus_gap),
    "cylinder": (cg.shapes.cylinder, {"height": 1e3}, cylinder_gap),
}


def moved(shape: str, scale: float, offset: float) -> tuple[cg.Body, np.ndarray]:
    make, sizes, _ = GAPS[shape]
    centre = scale * offset * np.array([1.0, -0.6, 0.3])
    matrix = scale * np.eye(4)
    matrix[:3, 3] = centre
    matrix[3, 3] = 1.0
    return cg.Body([make(**sizes).transformed(matrix)]), centre


def paths(gap, seed: int, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Segments that pass near the unscaled surface, at every angle to it."""
    rng = np.random.default_rng(seed)
    p = rng.uniform(-2.5, 2.5, (8 * N, 3))
    for _ in range(60):  # onto the surface, by the gap's own gradient
        steps = np.eye(3) * 1e-6
        slope = np.stack([(gap(p + s) - gap(p - s)) / 2e-6 for s in steps], axis=1)
        p -= gap(p)[:, None] * slope
    p = p[np.abs(gap(p)) < 1e-9][:N]
    d = rng.normal(size=p.shape)
    slope = np.stack([(gap(p + s) - gap(p - s)) / 2e-6 for s in np.eye(3) * 1e-6], axis=1)
    tilt = 10 ** rng.uniform(-4, 0, (len(p), 1)) * rng.choice([-1, 1], (len(p), 1))
    d -= (1.0 - tilt) * (d * slope).sum(axis=1, keepdims=True) * slope
    d *= length / np.linalg.norm(d, axis=1, keepdims=True)
    return p - rng.uniform(size=(len(p), 1)) * d, p + rng.uniform(size=(len(p), 1)) * d


@SETTINGS
@given(shape=st.sampled_from(sorted(GAPS)), seed=seeds, log=logs, scale=scales, offset=offsets)
def test_an_end_inside_is_explained_and_the_last_crossing_tells_the_state(
    shape: str, seed: int, log: float, scale: float, offset: float
) -> None:
    gap = GAPS[shape][2]
    body, centre = moved(shape, scale, offset)
    a, b = (centre + scale * p for p in paths(gap, seed, 10.0**log))
    # What the points are after rounding, about the surface's own middle.
    first, last = (gap((p - centre) / scale) for p in (a, b))
    tolerance = 100 * np.finfo(float).eps * (offset + body.size / scale)
    sure = (np.abs(first) > tolerance) & (np.abs(last) > tolerance)
    hit = body.first_hit(a, b)
    assert (hit.patch[sure & (first > 0) & (last < 0)] == 0).all()
    _, sense = body.surface.last_crossings(a, b, np.arange(len(a), dtype=np.int32))
    inside = np.where(sense == 0, first < 0.0, sense == 1)
    np.testing.assert_array_equal(inside[sure], last[sure] < 0.0)


@SETTINGS
@given(seed=seeds, log=st.floats(-6.0, 0.5))
def test_a_path_cut_in_two_is_entered_in_one_of_its_parts(seed: int, log: float) -> None:
    rng = np.random.default_rng(seed)
    body = cg.Body([cg.shapes.bumpy_plate(amplitude=0.08, waves=(3, 2))])
    patch = body.patches[0]
    d = 10.0**log * rng.normal(size=(N, 3))
    a = patch.evaluate(rng.random((N, 2))) - rng.uniform(size=(N, 1)) * d
    b = a + d
    whole = body.first_hit(a, b)
    at = np.where(np.isnan(whole.fraction), 0.5, whole.fraction)[:, None]
    for middle in (0.5 * (a + b), a + at * d):  # anywhere, and at the entry itself
        parts = body.first_hit(a, middle), body.first_hit(middle, b)
        actual = (parts[0].patch >= 0) | (parts[1].patch >= 0)
        assert actual[whole.patch >= 0].all()

"""Measure how far a face's p-curve on its surface is from the edge's curve."""

from __future__ import annotations

import math

import numpy as np

from contiga.geometry.kernel_records import CurveWork, ImageWork, Samples
from contiga.geometry.kernels.evaluate_nb import curve_range, make_scratch, surface_point
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

MAX_STEPS = 40
SAMPLES_PER_SPAN = 6
"""Samples of each knot span of a p-curve, and of an edge's curve."""
N_SECTIONS = 8
"""Golden sections of the interval around the farthest sample."""
CONFIRMED_SHARE = 0.999
"""A gap that finer samples reduce below this share of itself is measured again."""
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
MAX_SAMPLES = 512
"""Largest number of samples of an edge's curve that are all compared for the nearest one."""
N_NEIGHBOURS = 64
"""Samples before and after the previous nearest one that are compared."""
REFINEMENT = 8
"""Factor on the number of samples for a second measurement."""


@inner()
def _image(s, image, domain, t, work):
    """Write work.point: the surface at the p-curve's point at t, clipped to the rectangle."""
    work.t[0] = t
    curve_range(image, work.t, 0, work.uv)
    u = min(max(work.uv[0, 0, 0], domain[0]), domain[1])
    v = min(max(work.uv[0, 0, 1], domain[2]), domain[3])
    surface_point(s, u, v, 0, work.bases, work.point)


@inner()
def _square_distance(table, k, point):
    """Return the squared distance of sample k from a point."""
    total = 0.0
    for c in range(3):
        total += (table[k, 0, c] - point[c]) ** 2
    return total


@inner()
def _descend(table, k, point):
    """Return the sample reached from k by steps to nearer ones, and its squared distance."""
    min_square = _square_distance(table, k, point)
    for step in (-1, 1):
        while 0 <= k + step < table.shape[0]:
            square = _square_distance(table, k + step, point)
            if square >= min_square:
                break
            k += step
            min_square = square
    return k, min_square


@inner()
def _scan(table, start, stop, step, point):
    """Return the nearest of every `step`-th sample from start to stop, and its squared distance."""
    best = start
    min_square = math.inf
    for k in range(start, stop, step):
        square = _square_distance(table, k, point)
        if square < min_square:
            min_square = square
            best = k
    return best, min_square


@inner()
def _nearest(table, point, last):
    """Return the nearest sample that a coarse scan and one around `last` find, and its distance².

    From both results the search goes on to nearer neighbours.
    """
    n = table.shape[0]
    best, _ = _scan(table, 0, n, 1 + n // MAX_SAMPLES, point)
    best, min_square = _descend(table, best, point)
    near_last, _ = _scan(
        table, max(last - N_NEIGHBOURS, 0), min(last + N_NEIGHBOURS + 1, n), 1, point
    )
    near_last, square = _descend(table, near_last, point)
    return (near_last, square) if square < min_square else (best, min_square)


@inner()
def _newton_foot(curve, ts, best, point, work):
    """Return the least squared distance of a point from a curve that Newton steps meet.

    They start from sample `best`, and stay between its neighbours.
    """
    min_square = math.inf
    low = ts[max(best - 1, 0)]
    high = ts[min(best + 1, ts.size - 1)]
    t = ts[best]
    for _ in range(MAX_STEPS):
        work.t[0] = t
        curve_range(curve, work.t, 2, work.derivatives)
        square = slope = bend = 0.0
        for c in range(3):
            r = work.derivatives[0, 0, c] - point[c]
            square += r * r
            slope += r * work.derivatives[0, 1, c]
            bend += work.derivatives[0, 1, c] ** 2 + r * work.derivatives[0, 2, c]
        min_square = min(min_square, square)
        if slope < 0.0:
            low = t
        else:
            high = t
        new = t - slope / bend if bend > 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - t) <= 1e-15 * (ts[-1] - ts[0]):
            break
        t = new
    return min_square


@inner()
def _distance_to_curve(curve, samples, point, work):
    """Return the distance of a point from a curve, by Newton steps from its nearest sample.

    That sample is kept in work.nearest for the next point.
    """
    ts = samples.t
    best, min_square = _nearest(samples.point, point, min(work.nearest[0], ts.size - 1))
    work.nearest[0] = best
    min_square = min(min_square, _newton_foot(curve, ts, best, point, work))
    if best == 0 or best == ts.size - 1:
        # The foot on a closed curve may be on the other side of its seam.
        min_square = min(min_square, _newton_foot(curve, ts, ts.size - 1 - best, point, work))
    return math.sqrt(min_square)


@inner()
def _samples(curve, per_span):
    """Return `Samples` of a curve, `per_span` equal steps in each knot span, ends included."""
    knots = curve.knots
    spans = 0
    for k in range(knots.size - 1):
        if knots[k + 1] > knots[k]:
            spans += 1
    ts = np.empty(spans * per_span + 1)
    n = 0
    for k in range(knots.size - 1):
        if knots[k + 1] > knots[k]:
            for i in range(per_span):
                ts[n] = knots[k] + (knots[k + 1] - knots[k]) * i / per_span
                n += 1
    ts[n] = knots[-1]
    points = np.empty((ts.size, 1, 3))
    curve_range(curve, ts, 0, points)
    return Samples(ts, points)


@inner()
def _image_distance(s, image, curve, domain, t, samples, image_work, curve_work):
    """Return the distance of the image at t from the curve with these `samples`."""
    _image(s, image, domain, t, image_work)
    return _distance_to_curve(curve, samples, image_work.point[0, 0], curve_work)


@inner()
def _write_point(point, out):
    """Write the point (1, 1, 3) to out[1:]."""
    for c in range(3):
        out[1 + c] = point[0, 0, c]


@inner()
def _farthest(s, image, curve, domain, samples, image_work, curve_work, out):
    """Write `out` as `image_gap` does; return the p-curve's parameter of the largest distance.

    The farthest of the p-curve's samples is refined by golden sections between its neighbours.
    `curve_work.nearest` becomes the curve's sample near there.
    """
    ts = _samples(image, SAMPLES_PER_SPAN).t
    out[0] = -1.0
    at = 0
    nearest_sample = 0
    for k in range(ts.size):
        distance = _image_distance(s, image, curve, domain, ts[k], samples, image_work, curve_work)
        if distance > out[0]:
            out[0] = distance
            _write_point(image_work.point, out)
            at = k
            nearest_sample = curve_work.nearest[0]
    best = ts[at]
    low = ts[max(at - 1, 0)]
    high = ts[min(at + 1, ts.size - 1)]
    for _ in range(N_SECTIONS):
        a = high - GOLDEN * (high - low)
        b = low + GOLDEN * (high - low)
        curve_work.nearest[0] = nearest_sample
        distance_a = _image_distance(s, image, curve, domain, a, samples, image_work, curve_work)
        distance_b = _image_distance(s, image, curve, domain, b, samples, image_work, curve_work)
        if max(distance_a, distance_b) > out[0]:
            best = a if distance_a > distance_b else b
            out[0] = _image_distance(s, image, curve, domain, best, samples, image_work, curve_work)
            _write_point(image_work.point, out)
        if distance_a > distance_b:
            high = b
        else:
            low = a
    curve_work.nearest[0] = nearest_sample
    return best


@kernel()
def image_gap(s, image, curve, domain, recheck, out):
    """Write the largest distance of an edge's image on a surface to the edge's curve, and where.

    `image` is the p-curve, `domain` (4,) u0, u1, v0, v1 of the surface. A distance above `recheck`
    that finer samples of the curve reduce is measured again with these. `out` (4,) gets the
    distance, and the point of the image; between samples of the image it may be a little larger.
    """
    image_work = ImageWork(
        scratch(1), scratch(1, 1, 3), make_scratch(s.p, s.q, 0), scratch(1, 1, 3)
    )
    curve_work = CurveWork(scratch(1), scratch(1, 3, 3), np.zeros(1, np.int64))
    coarse = _samples(curve, SAMPLES_PER_SPAN)
    at = _farthest(s, image, curve, domain, coarse, image_work, curve_work, out)
    if out[0] > recheck:
        fine = _samples(curve, SAMPLES_PER_SPAN * REFINEMENT)
        curve_work.nearest[0] *= REFINEMENT
        if (
            _image_distance(s, image, curve, domain, at, fine, image_work, curve_work)
            < CONFIRMED_SHARE * out[0]
        ):
            _farthest(s, image, curve, domain, fine, image_work, curve_work, out)

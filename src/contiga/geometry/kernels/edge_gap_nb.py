"""Measure how far a face's p-curve on its surface is from the edge's curve."""

from __future__ import annotations

import math

import numpy as np

from contiga.geometry.kernel_records import CurveWork, ImageWork, Samples
from contiga.geometry.kernels.evaluate_nb import curve_range, make_scratch, surface_point
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

ROUNDS = 40
PER_SPAN = 6
"""Samples of each knot span of a p-curve, and of an edge's curve."""
REFINED = 8
"""Golden sections of the interval around the sample that is farthest off."""
SURE = 0.999
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
MAX_SAMPLES = 512
"""Samples of an edge's curve that are all looked at for the nearest one."""
AROUND = 64
DENSER = 8
"""Where the curve seems off, it is sampled this many times more densely before that is believed."""


@inner()
def _image(s, image, domain, t, work):
    """Fills work.point: the surface at the p-curve's point at t, moved into the rectangle."""
    work.t[0] = t
    curve_range(image, work.t, 0, work.uv)
    u = min(max(work.uv[0, 0, 0], domain[0]), domain[1])
    v = min(max(work.uv[0, 0, 1], domain[2]), domain[3])
    surface_point(s, u, v, 0, work.bases, work.point)


@inner()
def _square(table, k, point):
    total = 0.0
    for c in range(3):
        total += (table[k, 0, c] - point[c]) ** 2
    return total


@inner()
def _downhill(table, k, point):
    """The sample reached from sample k as long as the next comes nearer, and its square."""
    least = _square(table, k, point)
    for way in (-1, 1):
        while 0 <= k + way < table.shape[0]:
            square = _square(table, k + way, point)
            if square >= least:
                break
            k += way
            least = square
    return k, least


@inner()
def _scanned(table, start, stop, step, point):
    """The nearest of some samples, and its square."""
    best = start
    least = math.inf
    for k in range(start, stop, step):
        square = _square(table, k, point)
        if square < least:
            least = square
            best = k
    return best, least


@inner()
def _nearest(table, point, last):
    """Sample nearest to a point: from the best of so many, and of those around the one before."""
    n = table.shape[0]
    best, _ = _scanned(table, 0, n, 1 + n // MAX_SAMPLES, point)
    best, least = _downhill(table, best, point)
    other, _ = _scanned(table, max(last - AROUND, 0), min(last + AROUND + 1, n), 1, point)
    other, square = _downhill(table, other, point)
    return (other, square) if square < least else (best, least)


@inner()
def _from_sample(curve, ts, best, point, work):
    """Square of the distance of a point to a curve around one sample: Newton in a bracket."""
    least = math.inf
    low = ts[max(best - 1, 0)]
    high = ts[min(best + 1, ts.size - 1)]
    t = ts[best]
    for _ in range(ROUNDS):
        work.t[0] = t
        curve_range(curve, work.t, 2, work.derivatives)
        square = slope = bend = 0.0
        for c in range(3):
            r = work.derivatives[0, 0, c] - point[c]
            square += r * r
            slope += r * work.derivatives[0, 1, c]
            bend += work.derivatives[0, 1, c] ** 2 + r * work.derivatives[0, 2, c]
        least = min(least, square)
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
    return least


@inner()
def _foot(curve, samples, point, work):
    """Distance of a point to a curve, from its nearest sample."""
    ts = samples.t
    best, least = _nearest(samples.point, point, min(work.nearest[0], ts.size - 1))
    work.nearest[0] = best
    least = min(least, _from_sample(curve, ts, best, point, work))
    if best == 0 or best == ts.size - 1:
        # Of a closed curve the nearest place may be on the other side of its seam.
        least = min(least, _from_sample(curve, ts, ts.size - 1 - best, point, work))
    return math.sqrt(least)


@inner()
def _samples(curve, per_span):
    """A curve's `Samples`, `per_span` to a span between its breaks."""
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
def _off(s, image, curve, domain, t, samples, of_image, of_curve):
    """Distance of the image at t to the curve, whose `samples` are given."""
    _image(s, image, domain, t, of_image)
    return _foot(curve, samples, of_image.point[0, 0], of_curve)


@inner()
def _take(point, out):
    """Write the point (1, 1, 3) behind the distance."""
    for c in range(3):
        out[1 + c] = point[0, 0, c]


@inner()
def _farthest(s, image, curve, domain, samples, of_image, of_curve, out):
    """Fills `out` as `image_gap` does; returns the p-curve's parameter of the largest distance.

    `of_curve.nearest` then is the curve's sample near there.
    """
    ts = _samples(image, PER_SPAN).t
    out[0] = -1.0
    at = 0
    near = 0
    for k in range(ts.size):
        distance = _off(s, image, curve, domain, ts[k], samples, of_image, of_curve)
        if distance > out[0]:
            out[0] = distance
            _take(of_image.point, out)
            at = k
            near = of_curve.nearest[0]
    best = ts[at]
    low = ts[max(at - 1, 0)]
    high = ts[min(at + 1, ts.size - 1)]
    for _ in range(REFINED):
        a = high - GOLDEN * (high - low)
        b = low + GOLDEN * (high - low)
        of_curve.nearest[0] = near
        off_a = _off(s, image, curve, domain, a, samples, of_image, of_curve)
        off_b = _off(s, image, curve, domain, b, samples, of_image, of_curve)
        if max(off_a, off_b) > out[0]:
            best = a if off_a > off_b else b
            out[0] = _off(s, image, curve, domain, best, samples, of_image, of_curve)
            _take(of_image.point, out)
        if off_a > off_b:
            high = b
        else:
            low = a
    of_curve.nearest[0] = near
    return best


@kernel()
def image_gap(s, image, curve, domain, near, out):
    """Largest distance of the image of an edge on a surface to the edge's curve.

    `image` is the p-curve, `domain` (4,) u0, u1, v0, v1 of the surface; distances up to `near`
    are believed at once. Fills out[4]: the distance, and the point of the image where it is found.
    """
    of_image = ImageWork(scratch(1), scratch(1, 1, 3), make_scratch(s.p, s.q, 0), scratch(1, 1, 3))
    of_curve = CurveWork(scratch(1), scratch(1, 3, 3), np.zeros(1, np.int64))
    coarse = _samples(curve, PER_SPAN)
    at = _farthest(s, image, curve, domain, coarse, of_image, of_curve, out)
    if out[0] > near:
        fine = _samples(curve, PER_SPAN * DENSER)
        of_curve.nearest[0] *= DENSER
        if _off(s, image, curve, domain, at, fine, of_image, of_curve) < SURE * out[0]:
            _farthest(s, image, curve, domain, fine, of_image, of_curve, out)

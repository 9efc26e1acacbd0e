"""Evaluate the curvature of a surface at a point, and the metric for triangles around it.

The metric is |II| / 2e, the second fundamental form without its signs: in it the best triangles for
the sag e have a circumradius of 1 (Shewchuk, What is a good linear finite
element?, 2002; Pottmann et al., On piecewise linear approximation of quadratic functions, 2000).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.geometry.kernels.evaluate_nb import Scratch, SurfaceArrays, surface_point
from contiga.geometry.kernels.triangulation_nb import BORDER, N_FRAME, VERTICES
from contiga.jit import inner, kernel
from contiga.pointer_records import pass_by_pointer

MAX_TURN = 0.3
"""Largest sag as a share of the radius of curvature: sides then turn by at most a quarter."""
SLACK = 2.0
"""Sides that turn more are allowed until the sag is this many times larger."""
SADDLE_FACTOR = 0.75
"""On a saddle no triangle misses inside, so sides may be 1/√SADDLE_FACTOR as long."""
DEGENERATE_TOL = 1e-10
"""S_u × S_v below this share of |S_u| |S_v| has no direction."""
POLE_STEP = 1e-3
"""Distance from a pole at which its form is evaluated, as a share of the face."""
L, M, N, E, F, G, SAG = 0, 1, 2, 3, 4, 5, 6
"""Columns of a form: second fundamental form, metric, sag."""


@pass_by_pointer
class Face(NamedTuple):
    """A surface over the unit square that its trimmed part was mapped to."""

    surface: SurfaceArrays
    frame: np.ndarray
    """(4,) u0, v0 and the extents in u and v."""
    sag: float
    """Largest distance of a triangle from the surface, length."""
    floor: float
    """Least eigenvalue of the metric, 1/length²."""
    work: Scratch
    """For derivatives of order 2."""
    D: np.ndarray
    """(3, 3, 3) derivatives."""


@inner()
def evaluate(face, x, y, order):
    """Write derivatives up to an order (2 at most) at (x, y) of the square to ``face.D``.

    Parameters beyond the surface's domain are clipped.
    """
    s = face.surface
    u = min(max(face.frame[0] + x * face.frame[2], s.U[0]), s.U[-1])
    v = min(max(face.frame[1] + y * face.frame[3], s.V[0]), s.V[-1])
    surface_point(s, u, v, order, face.work, face.D)


@inner()
def dot(a, b):
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner()
def shape_at(face, x, y, point, form):
    """Write point and form at (x, y); the form of a pole is evaluated `POLE_STEP` inside of it.

    If the surface has no normal there either, the form is flat, with the unit metric of the square.
    """
    evaluate(face, x, y, 2)
    for d in range(3):
        point[d] = face.D[0, 0, d]
    if not form_from_derivatives(face, form, MAX_TURN):
        evaluate(face, x + POLE_STEP * (0.5 - x), y + POLE_STEP * (0.5 - y), 2)
        if not form_from_derivatives(face, form, np.inf):
            form[:] = 0.0
            form[E], form[G], form[SAG] = 1.0, 1.0, face.sag


@inner()
def form_from_derivatives(face, form, turning):
    """Write the form from ``face.D``; False, and nothing written, where there is no normal.

    `turning` bounds the sag as a share of the radius of curvature.
    """
    D = face.D
    du, dv = face.frame[2], face.frame[3]
    nx = D[1, 0, 1] * D[0, 1, 2] - D[1, 0, 2] * D[0, 1, 1]
    ny = D[1, 0, 2] * D[0, 1, 0] - D[1, 0, 0] * D[0, 1, 2]
    nz = D[1, 0, 0] * D[0, 1, 1] - D[1, 0, 1] * D[0, 1, 0]
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    first = dot(D[1, 0], D[1, 0])
    second = dot(D[0, 1], D[0, 1])
    if not size > DEGENERATE_TOL * math.sqrt(first * second):
        return False
    form[L] = (nx * D[2, 0, 0] + ny * D[2, 0, 1] + nz * D[2, 0, 2]) / size * du * du
    form[M] = (nx * D[1, 1, 0] + ny * D[1, 1, 1] + nz * D[1, 1, 2]) / size * du * dv
    form[N] = (nx * D[0, 2, 0] + ny * D[0, 2, 1] + nz * D[0, 2, 2]) / size * dv * dv
    # First form = RᵀR; the shape operator in the orthonormal frame of R is symmetric.
    r11 = math.sqrt(first) * du
    r12 = dot(D[1, 0], D[0, 1]) * du * dv / r11
    r22 = size * du * dv / r11
    a11 = form[L] / (r11 * r11)
    a12 = (form[M] - r12 * a11 * r11) / (r11 * r22)
    a22 = (form[N] - 2.0 * r12 / r11 * form[M] + r12 * r12 * a11) / (r22 * r22)
    metric_of(face, form, (r11, r12, r22), (a11, a12, a22), turning)
    return True


@inner()
def metric_of(face, form, r, a, turning):
    """Write metric and sag of a form, from the shape operator `a` in the frame `r`.

    The sag is cut to `turning` times the radius of the larger curvature; eigenvalues of the metric
    are at least `face.floor`.
    """
    middle = 0.5 * (a[0] + a[2])
    half = math.sqrt(0.25 * (a[0] - a[2]) ** 2 + a[1] * a[1])
    k1, k2 = middle + half, middle - half
    k_max = max(abs(k1), abs(k2))
    sag = allowed = face.sag
    if k_max > 0.0:
        sag, allowed = min(sag, turning / k_max), min(sag, SLACK * turning / k_max)
    share = (SADDLE_FACTOR if k1 * k2 < 0.0 else 1.0) / (2.0 * sag)
    f1 = max(share * abs(k1), face.floor)
    f2 = max(share * abs(k2), face.floor)
    b11 = b22 = f1
    b12 = 0.0
    if half > 1e-12 * k_max:
        # Projector on the direction of k1.
        p11, p12, p22 = (a[0] - k2) / (2 * half), a[1] / (2 * half), (a[2] - k2) / (2 * half)
        b11 = f2 + (f1 - f2) * p11
        b12 = (f1 - f2) * p12
        b22 = f2 + (f1 - f2) * p22
    form[E] = r[0] * r[0] * b11
    form[F] = r[0] * (r[1] * b11 + r[2] * b12)
    form[G] = r[1] * r[1] * b11 + 2.0 * r[1] * r[2] * b12 + r[2] * r[2] * b22
    form[SAG] = allowed


@inner()
def square(a, b, c, x, y):
    """Return the quadratic form a x² + 2 b x y + c y²."""
    return a * x * x + 2.0 * b * x * y + c * y * y


@inner()
def expected_miss(xy, corners, neighbours, forms):
    """Return the ratio of the expected distance of a triangle from the surface to the allowed sag.

    The surface is taken as the quadratic with the mean second form. Its distance is largest at the
    middle of a side, or, for a bowl, at the circumcentre if that is inside. Middles of sides on the
    border do not count: they cannot be changed.
    """
    second = np.zeros(3)
    sag = 0.0
    for k in range(3):
        for i in range(3):
            second[i] += forms[corners[k], i] / 3.0
        sag += forms[corners[k], SAG] / 3.0
    longest = 0.0
    longest_inner = 0.0
    total = 0.0
    squares = 0.0
    product = 1.0
    for k in range(3):
        p, q = corners[k], corners[(k + 1) % 3]
        x, y = xy[q, 0] - xy[p, 0], xy[q, 1] - xy[p, 1]
        side = abs(square(second[0], second[1], second[2], x, y))
        longest = max(longest, side)
        if neighbours[(k + 2) % 3] != BORDER:
            longest_inner = max(longest_inner, side)
        total += side
        squares += side * side
        product *= side
    miss = 0.125 * longest_inner
    if second[0] * second[2] > second[1] * second[1] and total > 2.0 * longest:
        # Heron: 16 A² = (Σl)² − 2 Σl², in squares l of the sides.
        area = total * total - 2.0 * squares
        if area > 0.0:
            miss = 0.5 * product / area
    return miss / sag


@kernel()
def shapes_at(t, face, points, forms):
    """Write points and forms of all vertices in use except the frame: see `shape_at`."""
    for v in range(N_FRAME, t.used[VERTICES]):
        shape_at(face, t.xy[v, 0], t.xy[v, 1], points[v], forms[v])

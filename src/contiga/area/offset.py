"""Offset surfaces of a master along its normals: ratio of areas, and feet on them."""

from __future__ import annotations

import numpy as np

from contiga.masters.protocol import Master
from contiga.records import FloatArray, Projection
from contiga.statuses import Feature, Status


def offset_ratio(master: Master, feet: Projection) -> FloatArray:
    """Return (n,) area at the point over area at its foot, for a slave parallel to the master.

    The surface S + g n at the gap g has the area element (1 − 2 H g + K g²) dA, with the mean
    and Gaussian curvature H, K of S towards n (do Carmo, Differential Geometry of Curves and
    Surfaces, 3-5, exercise 11). The ratio is 1 where the foot lies on a kink, a pole or a
    master of triangles, and for points beyond a focal point.
    """
    ratio = np.ones(len(feet.patch))
    faces = master.faces
    if faces is None:
        return ratio
    smooth = feet.feature == Feature.FACE
    for k in np.unique(feet.patch[smooth]):
        rows = np.flatnonzero(smooth & (feet.patch == k))
        d = faces.patches[int(k)].derivatives(feet.uv[rows], 2)
        s_u, s_v = d[:, 1, 0], d[:, 0, 1]
        n, g = feet.normal[rows], feet.gap[rows]
        e, f, h = (s_u * s_u).sum(1), (s_u * s_v).sum(1), (s_v * s_v).sum(1)
        l, m, q = (d[:, 2, 0] * n).sum(1), (d[:, 1, 1] * n).sum(1), (d[:, 0, 2] * n).sum(1)
        det = e * h - f * f
        regular = det > 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            mean = (e * q - 2.0 * f * m + h * l) / (2.0 * det)
            gauss = (l * q - m * m) / det
            value = 1.0 - 2.0 * mean * g + gauss * g * g
        ratio[rows] = np.where(regular & (value > 0.0), value, 1.0)
    return ratio


def off_surface(
    feet: Projection, p_B: FloatArray, half: FloatArray, band: float = 0.0
) -> Projection:
    """Return the feet of p_B (k, 3) on the surface that is `half` (k,) off the body.

    They are `feet` on the body moved by `half`. Points, normals and gaps are new. The normal at an
    edge or a border is the direction from there to the point if that is farther than `band`,
    reversed inside the body. The gap of a foot on a border is its distance less `half`.
    """
    arm = p_B - feet.point
    length = np.sqrt(np.square(arm).sum(axis=1))
    on_border = (feet.status == Status.BORDER) | (feet.status == Status.TRIMMED)
    sign = np.where(on_border, 1.0, np.sign(feet.gap))
    on_arm = (feet.feature != Feature.FACE) & (length > band) & (sign != 0.0)
    normal = feet.normal.copy()
    normal[on_arm] = arm[on_arm] * (sign[on_arm] / length[on_arm])[:, None]
    gap = np.where(on_border, np.abs(feet.gap), feet.gap) - half
    return feet._replace(point=feet.point + half[:, None] * normal, normal=normal, gap=gap)

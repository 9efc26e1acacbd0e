"""Faces of one piece that coincide, found from points on both sides of each face.

A point slightly before a face has its foot on that face, with the same positive gap; a point behind
it has a negative gap. If a face that faces the other way coincides with it, the search returns one
of the two for both sides, and the sign of the gap is wrong for the other.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.layout import as_contiguous
from contiga.geometry.faces import Faces
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.geometry.trim import parameter_box
from contiga.records import FloatArray, IndexArray
from contiga.search.track.project import project
from contiga.statuses import Feature

N_TRIALS, N_SAMPLES = 48, 3
"""Number of random places in the rectangle of a face, and number of samples inside the trims."""
OFFSET = 1e-7
"""Distance of the points before and behind a face, as a share of the body's size."""


def coincident_at(body: Faces) -> tuple[int, int, FloatArray] | None:
    """Find two faces of a closed body with a common part; None if no test point shows one.

    Returns the patch of the first test point that does, the other patch, and the point (3,). At
    most `N_SAMPLES` random points of each face are tested, from a fixed seed: a small common part
    may be missed.
    """
    rng = np.random.default_rng(0)
    samples: list[tuple[IndexArray, FloatArray, FloatArray]] = []
    for k, (surface, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        low, high = parameter_box(surface, loops)
        uv = low + (high - low) * rng.random((N_SAMPLES if loops is None else N_TRIALS, 2))
        if loops is not None:
            uv = uv[points_in_trim(body.trim_tables, k, as_contiguous(uv, np.float64))][:N_SAMPLES]
        d = surface.derivatives(uv, 1)
        normal = np.cross(d[:, 1, 0], d[:, 0, 1])
        length = np.linalg.norm(normal, axis=1)
        is_regular = length > 0.0
        unit_normals = normal[is_regular] / length[is_regular, None]
        samples.append((np.full(int(is_regular.sum()), k), d[is_regular, 0, 0], unit_normals))
    patch, points, normals = (np.concatenate(column) for column in zip(*samples, strict=True))
    offset = OFFSET * body.size
    for sign in (1.0, -1.0):
        feet = project(body, points + sign * offset * normals)
        at_offset = np.abs(np.abs(feet.gap) - offset) < 0.1 * offset
        is_wrong = at_offset & (feet.feature == Feature.FACE) & (sign * feet.gap < 0.0)
        rows = np.flatnonzero(is_wrong & (feet.patch != patch))
        if len(rows):
            k = int(rows[0])
            return int(patch[k]), int(feet.patch[k]), points[k]
    return None

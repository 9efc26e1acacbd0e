"""Faces of one piece that lie on each other: found from points on both sides of each face.

A point a hair before a face has that face's foot, and is as far before it; one behind is behind.
Where another face lies there that faces the other way, one of the two is answered for both, and to
the other the sides are wrong.
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

DRAWN, TAKEN = 48, 3
"""Places drawn in the parameters of a face, and how many of those in it are looked at."""
HAIR = 1e-7
"""How far before and behind a face it is looked, in the body's size."""


def coincident_at(body: Faces) -> tuple[int, int, FloatArray] | None:
    """Two faces of a closed body that have a part in common, and a place there; None if none do."""
    patch, places, normals = _places(body)
    hair = HAIR * body.size
    for sign in (1.0, -1.0):
        points = places + sign * hair * normals
        feet = project(body, points)
        beside = (np.abs(np.abs(feet.gap) - hair) < 0.1 * hair) & (feet.feature == Feature.FACE)
        wrong = np.flatnonzero(beside & (sign * feet.gap < 0.0) & (feet.patch != patch))
        if len(wrong):
            k = int(wrong[0])
            return int(patch[k]), int(feet.patch[k]), places[k]
    return None


def _places(body: Faces) -> tuple[IndexArray, FloatArray, FloatArray]:
    """Patch, place and normal of the places looked at."""
    rng = np.random.default_rng(0)
    patch, places, normals = [], [], []
    for k, (surface, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        low, high = parameter_box(surface, loops)
        uv = low + (high - low) * rng.random((TAKEN if loops is None else DRAWN, 2))
        if loops is not None:
            uv = uv[points_in_trim(body.trim_tables, k, as_contiguous(uv, np.float64))][:TAKEN]
        first = surface.derivatives(uv, 1)
        n = np.cross(first[:, 1, 0], first[:, 0, 1])
        size = np.linalg.norm(n, axis=1)
        good = size > 0.0
        patch.append(np.full(int(good.sum()), k))
        places.append(first[good, 0, 0])
        normals.append(n[good] / size[good, None])
    return np.concatenate(patch), np.concatenate(places), np.concatenate(normals)

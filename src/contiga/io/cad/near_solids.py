"""Solids that nearly touch: slits that come from rounded placements, not from a design.

A point that slides over such a slit is pushed sideways, by a face inside the slit. Narrower slits
are closed as the file is read (`contiga.io.cad.unite`); these are reported.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import as_contiguous
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.geometry.trim import parameter_box
from contiga.masters.body import Body
from contiga.records import FloatArray, IntArray
from contiga.statuses import Feature

SLIT_TOL = 1e-5
"""Width of slits that are reported, over the size of the smaller solid.

Clearances are a hundred times as wide.
"""
TOUCH_TOL = 1e-9
"""Distance of touching solids, over the whole size; `Body.flaws` reports them."""
SAMPLES_PER_FACE = 200
"""Random points on each face."""
MIN_SAMPLES = 3
"""Smallest number of points across a slit; solids that touch along a line or less have fewer."""
MAX_SLITS = 4
"""Number of slits after which the search ends."""
MAX_COSINE = -0.99
"""Largest cosine of the angle between normals across a slit."""


class Slit(NamedTuple):
    """A place where two solids nearly touch."""

    patches: tuple[int, int]
    """A face of each."""
    point: tuple[float, float, float]
    """Its place, body frame."""
    width: float
    """Largest sampled width, length."""

    def __str__(self) -> str:
        x, y, z = self.point
        return (
            f"patches {self.patches[0]} and {self.patches[1]} are {self.width:.3g} apart at "
            f"({x:.6g}, {y:.6g}, {z:.6g})"
        )


def slits_between(body: Body) -> list[Slit]:
    """Return slits between pieces of `body`: the widest sample of each pair, up to `MAX_SLITS`.

    A slit is wider than `TOUCH_TOL` of the body and at most `SLIT_TOL` of the smaller piece's box,
    between faces that look at each other, and met by `MIN_SAMPLES` points or more. Random points on
    the faces, the same in every call, are offset along the normal by twice the largest slit width
    and projected: across a slit, the closest surface is the other solid's wall, seen from inside.
    """
    pieces = body.pieces
    if len(pieces) < 2:
        return []
    bounds = np.array([patch.bounds() for patch in body.patches])
    boxes = np.array([[bounds[k, 0].min(axis=0), bounds[k, 1].max(axis=0)] for k in pieces])
    max_width = SLIT_TOL * np.linalg.norm(np.ptp(boxes, axis=1), axis=1)
    boxes += max_width[:, None, None] * np.array([[-1.0], [1.0]])
    piece_of_patch = np.empty(len(bounds), int)
    for i, patches in enumerate(pieces):
        piece_of_patch[patches] = i
    patch, points, normals = _sample_faces(body, piece_of_patch, bounds, boxes)
    if len(patch) == 0:
        return []
    offset = 2.0 * max_width[piece_of_patch[patch]]
    feet = body.project(points + offset[:, None] * normals)
    width = offset - np.abs(feet.gap)
    piece, other = piece_of_patch[patch], piece_of_patch[feet.patch]
    is_facing = np.einsum("ij,ij->i", feet.normal, normals) <= MAX_COSINE
    is_slit = is_facing & (piece != other) & (feet.feature == Feature.FACE)
    is_slit &= width > TOUCH_TOL * body.size
    is_slit &= width <= np.minimum(max_width[piece], max_width[other])
    rows = np.flatnonzero(is_slit)
    pairs = np.sort(np.column_stack([piece[rows], other[rows]]), axis=1)
    slits: list[Slit] = []
    for pair in np.unique(pairs, axis=0):
        pair_rows = rows[(pairs == pair).all(axis=1)]
        if len(pair_rows) >= MIN_SAMPLES and len(slits) < MAX_SLITS:
            k = int(pair_rows[np.argmax(width[pair_rows])])
            x, y, z = points[k].tolist()
            slits.append(Slit((int(patch[k]), int(feet.patch[k])), (x, y, z), float(width[k])))
    return slits


def _sample_faces(
    body: Body, piece_of_patch: IntArray, bounds: FloatArray, boxes: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return patch (n,), place (n, 3) and normal (n, 3) of random points on trimmed faces.

    They are the same in every call. Of `SAMPLES_PER_FACE` in the box of a face's trims those count
    that are within the box of another piece; `bounds` (patches, 2, 3) are those of the patches,
    `boxes` (pieces, 2, 3) those of the pieces.
    """
    rng = np.random.default_rng(0)
    patch, places, normals = [np.zeros(0, int)], [np.zeros((0, 3))], [np.zeros((0, 3))]
    for k, (surface, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        overlaps = ((bounds[k, 0] <= boxes[:, 1]) & (bounds[k, 1] >= boxes[:, 0])).all(axis=1)
        other_boxes = boxes[overlaps & (np.arange(len(boxes)) != piece_of_patch[k])]
        if len(other_boxes) == 0:
            continue
        low, high = parameter_box(surface, loops)
        uv = low + (high - low) * rng.random((SAMPLES_PER_FACE, 2))
        points = surface.evaluate(uv)[:, None]
        is_within = (points >= other_boxes[:, 0]) & (points <= other_boxes[:, 1])
        uv = uv[is_within.all(axis=2).any(axis=1)]
        if loops is not None and len(uv):
            uv = uv[points_in_trim(body.trim_tables, k, as_contiguous(uv, np.float64))]
        if len(uv):
            patch.append(np.full(len(uv), k))
            places.append(surface.evaluate(uv))
            normals.append(surface.normal(uv))
    return np.concatenate(patch), np.concatenate(places), np.concatenate(normals)

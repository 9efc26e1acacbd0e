"""Solids that nearly touch: slits that no design has, but rounded placements leave.

A point that slides over such a slit is pushed sideways, out of a face that nobody sees. Slits that
are narrower are closed as the file is read (`contiga.io.cad.unite`); these are told.
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

NARROW = 1e-5
"""Width of slits that are reported, over the size of the smaller solid.

Clearances are a hundred times as wide.
"""
TOUCHING = 1e-9
"""Distance of touching solids, over the whole size; `Body.flaws` reports those."""
SAMPLES_PER_FACE = 200
"""Random points on each face."""
MIN_SAMPLES = 3
"""Smallest number of points so near the other solid.

Solids that touch in a point or along a line have fewer.
"""
MAX_SLITS = 4
"""Number of slits after which the search ends."""
FACING = -0.99
"""Largest cosine of the angle between normals across a slit."""


class Slit(NamedTuple):
    """A place where two solids nearly touch."""

    patches: tuple[int, int]
    """A face of each."""
    point: tuple[float, float, float]
    """Its place, body frame."""
    width: float
    """Largest width found there, length."""

    def __str__(self) -> str:
        x, y, z = self.point
        return (
            f"patches {self.patches[0]} and {self.patches[1]} are {self.width:.3g} apart at "
            f"({x:.6g}, {y:.6g}, {z:.6g})"
        )


def slits_between(body: Body) -> list[Slit]:
    """Find where pieces of `body` nearly touch: a place for each pair, the first `MAX_SLITS`.

    Random points on the faces are offset along the normal by twice the largest slit width and
    projected: across a slit, the closest surface is the other solid's wall, seen from inside.
    """
    pieces = body.pieces
    if len(pieces) < 2:
        return []
    bounds = np.array([patch.bounds() for patch in body.patches])
    boxes = np.array([[bounds[k, 0].min(axis=0), bounds[k, 1].max(axis=0)] for k in pieces])
    narrow = NARROW * np.linalg.norm(np.ptp(boxes, axis=1), axis=1)
    boxes += narrow[:, None, None] * np.array([[-1.0], [1.0]])
    piece = np.empty(len(bounds), int)
    for i, patches in enumerate(pieces):
        piece[patches] = i
    patch, points, normals = _places(body, piece, bounds, boxes)
    if len(patch) == 0:
        return []
    look = 2.0 * narrow[piece[patch]]
    feet = body.project(points + look[:, None] * normals)
    width = look - np.abs(feet.gap)
    own, other = piece[patch], piece[feet.patch]
    facing = np.einsum("ij,ij->i", feet.normal, normals) <= FACING
    near = facing & (own != other) & (feet.feature == Feature.FACE)
    near &= (width > TOUCHING * body.size) & (width <= np.minimum(narrow[own], narrow[other]))
    rows = np.flatnonzero(near)
    pairs = np.sort(np.column_stack([own[rows], other[rows]]), axis=1)
    slits: list[Slit] = []
    for pair in np.unique(pairs, axis=0):
        here = rows[(pairs == pair).all(axis=1)]
        if len(here) >= MIN_SAMPLES and len(slits) < MAX_SLITS:
            k = int(here[np.argmax(width[here])])
            x, y, z = points[k].tolist()
            slits.append(Slit((int(patch[k]), int(feet.patch[k])), (x, y, z), float(width[k])))
    return slits


def _places(
    body: Body, piece: IntArray, bounds: FloatArray, boxes: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return patch, place and normal of random points on faces within another piece's box."""
    rng = np.random.default_rng(0)
    patch, places, normals = [np.zeros(0, int)], [np.zeros((0, 3))], [np.zeros((0, 3))]
    for k, (surface, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        meets = (bounds[k, 0] <= boxes[:, 1]) & (bounds[k, 1] >= boxes[:, 0])
        others = np.flatnonzero(meets.all(axis=1) & (np.arange(len(boxes)) != piece[k]))
        if len(others) == 0:
            continue
        low, high = parameter_box(surface, loops)
        uv = low + (high - low) * rng.random((SAMPLES_PER_FACE, 2))
        points = surface.evaluate(uv)[:, None]
        uv = uv[
            ((points >= boxes[others, 0]) & (points <= boxes[others, 1])).all(axis=2).any(axis=1)
        ]
        if loops is not None and len(uv):
            uv = uv[points_in_trim(body.trim_tables, k, as_contiguous(uv, np.float64))]
        if len(uv):
            patch.append(np.full(len(uv), k))
            places.append(surface.evaluate(uv))
            normals.append(surface.normal(uv))
    return np.concatenate(patch), np.concatenate(places), np.concatenate(normals)

"""From a z-buffer to a shaded picture: soft light, darker hollows, a pale rim."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import as_contiguous
from contiga.records import FloatArray, IntArray
from contiga.rendering.camera import Camera, project
from contiga.rendering.kernels import shading_groups_nb, shading_nb
from contiga.rendering.kernels.raster_nb import (
    Buffer,
    draw_balls,
    draw_lines,
    draw_triangles,
    empty_buffer,
    values_at_pixels,
)

Picture = NDArray[np.float32]
"""(h, w, 3): single precision is plenty for eight bits a colour and halves the memory."""
_KEY = np.array([-0.45, -0.65, -0.62]) / np.linalg.norm([0.45, 0.65, 0.62])
"""Towards the main light in camera axes (right, down, forward): over the left shoulder."""
_LAMPS = np.stack([_KEY, (_KEY - [0.0, 0.0, 1.0]) / np.linalg.norm(_KEY - [0.0, 0.0, 1.0])])
_CREASE_COSINE = np.cos(np.radians(30.0))
"""Cosine of the angle above which facets meet at a sharp edge."""


class Layer(NamedTuple):
    """A mesh or cloud in the picture of a camera."""

    buffer: Buffer
    axes: FloatArray
    """(3, 3) axes of the camera."""
    corners: FloatArray
    """(m, 3, 3) unit normals at the corners of the facets, no rows for a cloud."""
    triangles: IntArray | None
    """(m, 3) of the mesh, None for a cloud."""

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Pixels (h, w) that this layer covers."""
        return self.buffer.owner >= 0

    def at_pixels(self, values: FloatArray) -> FloatArray:
        """Return (k,) `values` (n,) of the points at the pixels of `seen`, row by row.

        On a mesh they are interpolated; a pixel of a cloud has the value of its ball's point.
        """
        if self.triangles is None:
            return np.asarray(values[self.buffer.owner[self.seen]])
        pixel_values = np.empty(np.count_nonzero(self.seen))
        values = as_contiguous(values, np.float64)
        values_at_pixels(self.buffer, self.triangles, values, pixel_values)
        return pixel_values


def corner_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return (m, 3, 3) unit normals at the corners: smooth, but sharp across creases.

    Corners at one point share a normal if their facets are connected by edges that are no creases,
    where facets meet at less than 30°; a point may belong to several faces, as in the meshes of
    closed bodies. Normals of degenerate facets are zero.
    """
    p = points[triangles]
    facet = _facet_normals(points, triangles)
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    count, group = _smooth_corners(triangles, facet)
    total = np.zeros((count, 3))
    for corner in range(3):
        a = p[:, (corner + 1) % 3] - p[:, corner]
        b = p[:, (corner + 2) % 3] - p[:, corner]
        # by the corner's angle, so that the division of a face into facets does not matter, and by
        # area, so that a flat face stays flat up to a fillet at its end
        weight = area * np.arctan2(
            np.linalg.norm(np.cross(a, b), axis=1), np.einsum("mi,mi->m", a, b)
        )
        for axis in range(3):
            total[:, axis] += np.bincount(
                group[corner::3], weight * facet[:, axis], minlength=count
            )
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)
    return np.asarray(total[group].reshape(-1, 3, 3))


def _smooth_corners(triangles: IntArray, facet: FloatArray) -> tuple[int, IntArray]:
    """Return the number of groups of corners that share a normal, and the group of each corner.

    Corner c of facet f is 3 f + c. Both ends of a smooth edge join the corners that meet there.
    """
    inner = _inner_edges(triangles)
    is_smooth = np.einsum("ei,ei->e", facet[inner.left], facet[inner.right]) >= _CREASE_COSINE
    pairs = np.concatenate([inner.first[is_smooth], inner.second[is_smooth]])
    group = shading_groups_nb.joined(pairs, triangles.size)
    return int(group.max(initial=-1)) + 1, group


class SharpMesh(NamedTuple):
    """A mesh whose points are repeated where facets meet at a crease.

    The smooth shading of browsers, by vertices, then keeps the creases sharp.
    """

    rows: IntArray
    """(k,) point of the original mesh of each vertex."""
    triangles: IntArray
    """(m, 3) vertices, rows of `rows`."""


def sharp_mesh(points: FloatArray, triangles: IntArray) -> SharpMesh:
    """Return the mesh of `triangles` (m, 3) split along creases; unused points are left out."""
    triangles = np.ascontiguousarray(triangles, dtype=np.int32)
    count, group = _smooth_corners(triangles, _facet_normals(points, triangles))
    rows = np.zeros(count, dtype=np.int32)
    rows[group] = triangles.ravel()
    return SharpMesh(rows, group.reshape(-1, 3))


def _facet_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    p = points[triangles]
    facet = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    return np.asarray(facet / np.maximum(np.linalg.norm(facet, axis=1, keepdims=True), 1e-300))


class _Inner(NamedTuple):
    """Edges (k,) of exactly two facets."""

    left: NDArray[np.int64]
    right: NDArray[np.int64]
    """Their facets."""
    first: NDArray[np.int64]
    second: NDArray[np.int64]
    """(k, 2) the corners of both facets at one end and at the other."""
    points: NDArray[np.int64]
    """(k, 2) the ends."""


def _inner_edges(triangles: IntArray) -> _Inner:
    """Return the edges of exactly two facets; those of one, or of three and more, are left out."""
    corners = np.arange(triangles.size, dtype=np.int64).reshape(-1, 3)
    start, end = corners.T.ravel(), np.roll(corners, -1, axis=1).T.ravel()
    flat = triangles.ravel().astype(np.int64)
    is_reversed = flat[start] > flat[end]
    start, end = np.where(is_reversed, end, start), np.where(is_reversed, start, end)
    key = flat[start] * (int(flat.max(initial=0)) + 1) + flat[end]
    order = np.argsort(key, kind="stable")
    _, first, count = np.unique(key[order], return_index=True, return_counts=True)
    left, right = order[first[count == 2]], order[first[count == 2] + 1]
    return _Inner(
        start[left] // 3,
        start[right] // 3,
        np.stack([start[left], start[right]], axis=1),
        np.stack([end[left], end[right]], axis=1),
        np.stack([flat[start[left]], flat[end[left]]], axis=1),
    )


def crease_edges(points: FloatArray, triangles: IntArray) -> IntArray:
    """Return (k, 2) edges of exactly two facets whose normals differ by more than 30°."""
    inner = _inner_edges(triangles)
    facet = _facet_normals(points, triangles)
    is_sharp = np.einsum("ei,ei->e", facet[inner.left], facet[inner.right]) < _CREASE_COSINE
    return np.ascontiguousarray(inner.points[is_sharp], dtype=np.int32)


def mesh_layer(camera: Camera, points: FloatArray, triangles: IntArray) -> Layer:
    """Return the layer of a triangulation, drawn from either side of its facets."""
    buffer = empty_buffer(*camera.size)
    triangles = np.ascontiguousarray(triangles, dtype=np.int32)
    draw_triangles(project(camera, points), triangles, buffer)
    return Layer(buffer, camera.axes, corner_normals(points, triangles), triangles)


def cloud_layer(camera: Camera, points: FloatArray, radius: float) -> Layer:
    """Return the layer of a cloud of points, balls of `radius` pixels at any depth, uncoloured.

    It says which ball is seen in each pixel, where on it, and how deep. Points that are not finite,
    or behind the eye, are left out.
    """
    buffer = empty_buffer(*camera.size)
    screen = project(camera, points)
    depth = float(np.nanmedian(screen[:, 2])) if len(screen) else 1.0
    draw_balls(screen, radius, depth / camera.focus, buffer)
    return Layer(buffer, camera.axes, np.zeros((0, 3, 3)), None)


def hollows(depth: FloatArray, reach: int, size: float) -> FloatArray:
    """Return (⌈h/2⌉, ⌈w/2⌉) in [−1, 1], positive where opposite neighbours are nearer the eye.

    Every other pixel of `depth` (h, w) is enough for a soft shade. Opposite pairs cancel the slope
    of a plane, so that only its bending shows; there is none at the outline and at the border of
    the picture. Neighbours are those at a quarter, a half and all of `reach`, in pixels of the
    result; `size` is the depth that counts as one.
    """
    total = np.zeros(depth[::2, ::2].shape)
    steps = sorted({max(1, reach // 4), max(1, reach // 2), reach})
    for step in steps:
        shading_nb.add_bends(depth, step, size, total)
    total /= 8.0 * len(steps) * size
    return np.clip(total, -1.0, 1.0, out=total)


def paint(
    picture: Picture,
    layer: Layer,
    colours: FloatArray,
    size: float,
    nearest: FloatArray,
    opacity: float = 1.0,
) -> None:
    """Blend a shaded `layer` over `picture` (h, w, 3) where it is not behind `nearest`.

    Parameters
    ----------
    picture : (h, w, 3) picture, changed in place
    layer : the layer
    colours : (3,), or (k, 3) for the pixels of `layer.seen`
    size : size of the scene: a bend of a fiftieth of it has the strongest shade
    nearest : (h, w) depths
    opacity : opacity of the layer
    """
    hollow = hollows(layer.buffer.depth, max(2, len(picture) // 120), 0.02 * size)
    eye, rgb = np.concatenate([layer.axes, _LAMPS]), np.atleast_2d(colours)
    shading_nb.paint(
        layer.buffer, layer.corners, eye, hollow, nearest, rgb, float(opacity), picture
    )


def veil(picture: Picture, layer: Layer, colour: FloatArray) -> None:
    """Blend `colour` (3,) into `picture` (h, w, 3) at `layer`: 5 % face-on, 43 % edge-on."""
    shading_nb.veil(layer.buffer, layer.corners, layer.axes, colour, picture)


def free_edges(triangles: IntArray) -> IntArray:
    """Return the edges (k, 2) that belong to one triangle only: borders of faces and sheets."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    low, high = pairs.min(axis=1).astype(np.int64), pairs.max(axis=1).astype(np.int64)
    n = int(high.max(initial=0)) + 1
    edges, count = np.unique(low * n + high, return_counts=True)
    borders = edges[count == 1]
    return np.ascontiguousarray(np.stack([borders // n, borders % n], axis=1), dtype=np.int32)


def drawn_edges(points: FloatArray, triangles: IntArray) -> IntArray:
    """Return (k, 2) edges to draw as lines: borders, and creases between facets."""
    return np.concatenate([free_edges(triangles), crease_edges(points, triangles)])


def line_ink(
    camera: Camera, points: FloatArray, edges: IntArray, depth: FloatArray, bias: float
) -> NDArray[np.bool_]:
    """Return a mask (h, w) of the pixels at which one of the `edges` (k, 2) is visible.

    An edge is visible where it lies behind `depth` (h, w) by no more than `bias`, length.
    """
    ink = np.zeros(camera.size, np.bool_)
    draw_lines(project(camera, points), edges, depth, bias, ink)
    return ink


def thickened(ink: NDArray[np.bool_], width: int) -> NDArray[np.bool_]:
    """Return the mask (h, w) of pixels within `width` of a pixel in `ink`."""
    out = np.zeros_like(ink)
    rows, columns = np.nonzero(ink)
    reach = np.arange(-width, width + 1)
    for dy in reach:
        for dx in reach:
            if dx * dx + dy * dy <= width * width:
                y, x = rows + dy, columns + dx
                is_inside = (y >= 0) & (y < ink.shape[0]) & (x >= 0) & (x < ink.shape[1])
                out[y[is_inside], x[is_inside]] = True
    return out


def shrunk(picture: Picture, factor: int) -> Picture:
    """Return `picture` (h·f, w·f, c) averaged to (h, w, c), f = `factor`; a remainder is cut."""
    h, w = picture.shape[0] // factor * factor, picture.shape[1] // factor * factor
    total = np.zeros((h // factor, w // factor, picture.shape[2]), picture.dtype)
    for row in range(factor):
        for column in range(factor):
            total += picture[row:h:factor, column:w:factor]
    total /= factor * factor
    return total

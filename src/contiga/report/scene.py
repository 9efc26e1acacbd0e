"""The two views of the peak: the scene from outside, and the contact seen through the body."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray
from contiga.rendering import shading
from contiga.rendering.camera import Camera, look, unit
from contiga.rendering.shading import Picture
from contiga.report.coloured import ColouredField, region_colours
from contiga.report.colours import channels, scale_colours
from contiga.report.peak import Peak
from contiga.report.style import TIES

BODY = np.array([0.56, 0.62, 0.69])
SLAVE = np.array([0.82, 0.79, 0.72])
CLOUD = np.array([0.63, 0.55, 0.42])
"""Colour of points that stands out from the white of the page."""
INK = np.array([0.13, 0.15, 0.18])


def upwards(peak: Peak) -> FloatArray:
    """Return the world axis (3,) that is up in the pictures: z, or y if all points have one z.

    Heights count as equal within 1e-9 of the size of the scene.
    """
    points = np.vstack([peak.body_points, peak.slave_points])
    flat = np.ptp(points[:, 2]) <= 1e-9 * max(float(np.ptp(points)), 1e-300)
    return np.array([0.0, 1.0, 0.0]) if flat else np.array([0.0, 0.0, 1.0])


def _sideways(peak: Peak, up: FloatArray) -> FloatArray:
    side = np.cross(peak.direction, up)
    return unit(side) if np.linalg.norm(side) > 0.3 else np.array([0.6, -0.8, 0.0])


def outside_direction(peak: Peak) -> FloatArray:
    """Return the unit viewing direction (3,) from the side and a little from above.

    The side is across the mean normal of the contact, and fixed if that is upright or zero.
    """
    up = upwards(peak)
    level = peak.direction - (peak.direction @ up) * up
    return unit(-_sideways(peak, up) + 0.45 * level - 0.30 * up)


def outside_view(peak: Peak, size: tuple[int, int]) -> Camera:
    """Return the view from the side and above of the parts that touch, or of all if none does.

    `size` is rows and columns, pixels.
    """
    return look(outside_direction(peak), upwards(peak), peak.seen, size)


def through_view(peak: Peak, size: tuple[int, int]) -> Camera:
    """Return the view of the contact from inside the body, nearly along the mean normal.

    Without a contact it is `outside_view`. `size` is rows and columns, pixels.
    """
    if not peak.in_contact.any():
        return outside_view(peak, size)
    up = upwards(peak)
    direction = peak.direction - 0.42 * _sideways(peak, up) - 0.16 * up
    patch = peak.slave_points[peak.in_contact]
    centre = (patch.min(axis=0) + patch.max(axis=0)) / 2.0
    # shows enough of the part around the contact to locate it, even for a single point
    min_reach = 0.06 * float(np.ptp(peak.seen, axis=0).max())
    frame = min_reach * np.vstack([np.eye(3), -np.eye(3)])
    return look(direction, up, centre + np.vstack([1.7 * (patch - centre), frame]), size)


def _slave_layer(camera: Camera, peak: Peak) -> shading.Layer:
    """Return the layer of the slaves' facets; without any, of balls at their active points."""
    if len(peak.slave_triangles):
        return shading.mesh_layer(camera, peak.slave_points, peak.slave_triangles)
    points = peak.slave_points
    if peak.active is not None:  # a point with NaN is not drawn
        points = np.where(peak.active[:, None], points, np.nan)
    radius = float(np.clip(0.35 * camera.size[0] / np.sqrt(len(points) + 1.0), 3, 14))
    return shading.cloud_layer(camera, points, radius)


def slave_colours(layer: shading.Layer, peak: Peak, field: ColouredField) -> FloatArray:
    """Return the colours (k, 3) of the slave's pixels: by `field` where it has a value, else plain.

    A field of the contact has values at points in contact, one of the inside where it is positive;
    in a facet the nearer points decide.
    """
    has_field = field.values > 0.0 if field.everywhere else peak.in_contact
    is_coloured = layer.at_pixels(has_field.astype(np.float64)) > 0.5
    share = layer.at_pixels(field.values)[is_coloured] / field.top
    plain = CLOUD if layer.triangles is None else SLAVE
    colours = np.broadcast_to(plain, (len(is_coloured), 3)).copy()
    colours[is_coloured] = scale_colours(share)
    return colours


# Layers are painted one after the other, and only their depth is kept: memory that a process has
# not had before costs as much time as the work done with it.
def render(camera: Camera, peak: Peak, field: ColouredField, *, through: bool) -> Picture:
    """Return the picture (h, w, 3) of the scene, channels from 0 to 1.

    Bodies and slaves hide each other, with their edges and with ties that nothing hides. `through`
    draws the bodies as a veil over the slaves instead, without edges and ties, and dots the points
    in contact if there are no outlines.
    """
    picture = np.ones((*camera.size, 3), dtype=np.float32)
    if through:
        nearest = _paint_slave(camera, peak, field, picture)
        body = shading.mesh_layer(camera, peak.body_points, peak.body_triangles)
        shading.veil(picture, body, 0.75 * BODY)
        patch = peak.slave_points[peak.in_contact]
        if len(patch) and not peak.outlines:  # else the dots would hide the lines
            radius = float(np.clip(0.07 * camera.size[0] / np.sqrt(len(patch)), 1.2, 5.0))
            dots = shading.cloud_layer(camera, patch, radius).seen
            picture[dots] = 0.45 * picture[dots] + 0.55 * INK
        _draw_outlines(camera, peak, picture, nearest, np.inf)
        return picture
    body = shading.mesh_layer(camera, peak.body_points, peak.body_triangles)
    shading.paint(picture, body, BODY, _span(camera, peak), body.buffer.depth)
    body_depth = body.buffer.depth
    del body
    nearest = _paint_slave(camera, peak, field, picture, body_depth)
    bias = 2e-3 * _span(camera, peak)
    for points, triangles in (
        (peak.body_points, peak.body_triangles),
        (peak.slave_points, peak.slave_triangles),
    ):
        edges = shading.drawn_edges(points, triangles)
        inked = shading.line_ink(camera, points, edges, nearest, bias)
        picture[inked] = 0.6 * picture[inked] + 0.4 * INK
    # springs and joints, unless something hides them
    for kind, colour in TIES.items():
        ends = peak.ties[[k == kind for k in peak.tie_kinds]].reshape(-1, 3)
        if len(ends):
            edges = np.arange(len(ends), dtype=np.int32).reshape(-1, 2)
            ink = shading.line_ink(camera, ends, edges, nearest, bias)
            picture[shading.thickened(ink, max(1, camera.size[0] // 480))] = channels(colour)
    _draw_outlines(camera, peak, picture, nearest, bias)
    return picture


def _span(camera: Camera, peak: Peak) -> float:
    return float(np.ptp(camera.axes @ peak.seen.T))


def _paint_slave(
    camera: Camera,
    peak: Peak,
    field: ColouredField,
    picture: Picture,
    body_depth: FloatArray | None = None,
) -> FloatArray:
    """Draw the slave into `picture` where the body is not nearer; return the depth (h, w) of both.

    `body_depth`, if there is one, is overwritten with that depth.
    """
    slave = _slave_layer(camera, peak)
    slave_depth = slave.buffer.depth
    nearest = slave_depth if body_depth is None else body_depth
    colours = slave_colours(slave, peak, field)
    shading.paint(picture, slave, colours, _span(camera, peak), nearest)
    return np.minimum(slave_depth, nearest, out=nearest)


def _draw_outlines(
    camera: Camera, peak: Peak, picture: Picture, nearest: FloatArray, bias: float
) -> None:
    """Draw the lines around the regions into `picture`, each in its colour with a pale rim.

    Parts that lie behind `nearest` (h, w) by more than `bias` are hidden.
    """
    width = max(1, camera.size[0] // 360)
    for key, colour in region_colours(peak.outlines).items():
        for line in peak.outlines:
            if (line.contact, line.cluster) != key or len(line.points) < 2:
                continue
            k = np.arange(len(line.points), dtype=np.int32)
            edges = np.stack([k, np.roll(k, -1)], axis=1)
            ink = shading.line_ink(camera, line.points, edges, nearest, bias)
            rim = shading.thickened(ink, width + max(1, width // 2))
            picture[rim] = 0.25 * picture[rim] + 0.75
            picture[shading.thickened(ink, width)] = channels(colour)

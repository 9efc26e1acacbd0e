"""The camera of a picture, and the projection of points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.records import FloatArray

FIELD_OF_VIEW = np.radians(22.0)
"""Narrow, as a long lens: enough perspective to read depth, not enough to distort."""


class Camera(NamedTuple):
    """A pinhole camera; axes are unit vectors in world coordinates."""

    eye: FloatArray
    """(3,) position."""
    axes: FloatArray
    """(3, 3) rows: right, down, forward."""
    focus: float
    """Focal length: pixels of a unit of length at unit depth."""
    size: tuple[int, int]
    """Rows, columns."""


def unit(vector: FloatArray) -> FloatArray:
    """Return `vector` scaled to length one; the zero vector stays."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector


def look(towards: FloatArray, up: FloatArray, points: FloatArray, size: tuple[int, int]) -> Camera:
    """Return a camera that looks along `towards` with all `points` (n, 3) just in its picture.

    It aims at the middle of their bounding box in its axes, and is moved three times until the
    widest ray touches the scene, with 5 % of room. `up` (3,) points up in the picture; if it is
    parallel to `towards`, y does, or x.

    Parameters
    ----------
    towards, up : (3,) of any length
    points : one or more, all finite
    size : rows and columns of the picture, pixels
    """
    forward = unit(towards)
    right = np.cross(forward, up)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross(forward, [0.0, 1.0, 0.0] if abs(forward[1]) < 0.9 else [1.0, 0.0, 0.0])
    right = unit(right)
    axes = np.stack([right, np.cross(forward, right), forward])
    local = points @ axes.T
    low, high = local.min(axis=0), local.max(axis=0)
    centre = (low + high) / 2.0
    half = max(float(np.abs(local - centre).max()), 1e-12)
    slope = np.tan(FIELD_OF_VIEW / 2.0)
    distance = half + half / slope
    focus = size[0] / (2.0 * slope)
    # move the eye until the widest ray of the picture touches the scene
    for _ in range(3):
        depth = local[:, 2] - centre[2] + distance
        slopes = np.array([size[1] / size[0], 1.0]) * slope
        reach = np.abs(local[:, :2] - centre[:2]) / (depth[:, None] * slopes)
        distance = max(distance * float(reach.max()) * 1.05, half * 1.2)
    eye = (centre - np.array([0.0, 0.0, distance])) @ axes
    return Camera(eye, axes, focus, size)


def project(camera: Camera, points: FloatArray) -> FloatArray:
    """Return columns, rows and depths (n, 3) of `points` (n, 3) in the picture.

    Columns and rows are pixels from the centre of the upper left one. Points behind the eye have
    NaN as column and row.
    """
    local = (points - camera.eye) @ camera.axes.T
    depth = local[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(depth > 0.0, camera.focus / depth, np.nan)
    column = local[:, 0] * scale + (camera.size[1] - 1) / 2.0
    row = local[:, 1] * scale + (camera.size[0] - 1) / 2.0
    return np.ascontiguousarray(np.stack([column, row, depth], axis=1))

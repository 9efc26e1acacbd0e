"""Polygons split into triangles: none lost, none overlapping, in their sense, anywhere in space."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.rigid import transform
from contiga.slaves.polygons import split_polygon


def star(corners: int, inner: float) -> np.ndarray:
    angle = np.pi * np.arange(2 * corners) / corners
    radius = np.where(np.arange(2 * corners) % 2, inner, 1.0)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)


def comb(teeth: int) -> np.ndarray:
    top = [[k, (k % 2) * 3.0 + 1.0, 0.0] for k in range(2 * teeth, -1, -1)]
    return np.array([[0.0, 0.0, 0.0], [2.0 * teeth, 0.0, 0.0], *top])


def area(points: np.ndarray) -> float:
    """Of a plane polygon at z = 0, by the shoelace formula."""
    x, y = points[:, 0], points[:, 1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize(
    "polygon",
    [star(3, 0.5), star(5, 0.2), star(40, 0.9), comb(6), star(9, 1.0)],
    ids=["hexagram", "star", "gear", "comb", "convex"],
)
def test_triangles_cover_the_polygon_once(polygon: np.ndarray) -> None:
    triangles = split_polygon(polygon)
    assert len(triangles) == len(polygon) - 2
    areas = [area(polygon[list(triangle)]) for triangle in triangles]
    assert min(areas) > 0.0
    assert sum(areas) == pytest.approx(area(polygon), rel=1e-12)


def test_the_split_turns_and_flips_with_the_polygon() -> None:
    polygon = comb(4)
    matrix = transform.rotation([1.0, 2.0, 0.5], 1.9, [3.0, 1.0, 4.0])
    turned = polygon @ matrix[:3, :3].T + matrix[:3, 3]
    wanted = area(polygon)
    for points in (turned, turned[::-1]):
        corners = points[split_polygon(points)]
        normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(wanted, rel=1e-12)
        assert np.linalg.norm(normals.sum(axis=0)) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("points", [np.zeros((6, 3)), np.full((5, 3), np.nan)])
def test_what_has_no_ears_becomes_a_fan(points: np.ndarray) -> None:
    assert len(split_polygon(points)) == len(points) - 2

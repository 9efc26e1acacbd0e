"""Triangles cut to a size: no side is longer, none hangs, none is lost, angles stay."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contiga as cg
from contiga.errors import InputError
from contiga.geometry.divide import divided
from contiga.triangles.trimesh import TriMesh


def smallest_angle(points: np.ndarray, cells: np.ndarray) -> float:
    corners = points[cells]
    angles = []
    for k in range(3):
        a, b = (corners[:, (k + j) % 3] - corners[:, k] for j in (1, 2))
        cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        angles.append(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return float(np.min(angles))


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 1000), st.floats(0.05, 0.9))
def test_a_closed_mesh_stays_closed_and_sound(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    whole = cg.Body(cg.shapes.sphere(radius=1.0)).tessellate(0.2)
    points = whole.vertices * rng.uniform(0.5, 2.0, 3)
    finer, cells = divided(points, whole.triangles, size)
    sides = np.linalg.norm(finer[cells] - finer[np.roll(cells, 1, axis=1)], axis=-1)
    assert sides.max() <= size
    np.testing.assert_array_equal(finer[: len(points)], points)
    mesh = TriMesh(finer, cells)
    assert mesh.closed
    assert len(np.unique(cells)) == len(finer)
    before = TriMesh(points, whole.triangles)
    assert mesh.area() == pytest.approx(before.area(), rel=1e-12)
    assert mesh.volume() == pytest.approx(before.volume(), rel=1e-12)
    assert smallest_angle(finer, cells) >= 0.5 * smallest_angle(points, whole.triangles) - 1e-9


def test_what_is_fine_already_stays() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    same, cells = divided(points, np.array([[0, 1, 2]]), 1.5)
    assert same is points
    assert cells.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("size", [0.0, -1.0, float("nan"), float("inf")])
def test_a_size_is_positive(size: float) -> None:
    with pytest.raises(InputError, match="size: must be positive"):
        divided(np.eye(3), np.array([[0, 1, 2]]), size)

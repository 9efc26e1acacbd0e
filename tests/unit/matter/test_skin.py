"""Outer faces of elements, of kinds with faces of one width and of two."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.matter import skin as module
from contiga.matter.skin import skin


def test_faces_are_taken_element_by_element() -> None:
    """Contact reads its facets in this order."""
    kind, elements = "tet4", rig.tets((1, 1, 1))
    faces = elements[:, np.array(module.FACES[kind])].reshape(-1, 3)
    sets = [frozenset(face) for face in faces.tolist()]
    outer = [face for face, corners in zip(faces, sets, strict=True) if sets.count(corners) == 1]
    np.testing.assert_array_equal(skin([(kind, elements)]), outer)


def test_a_kind_may_have_triangles_and_quadrilaterals(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two wedges that halve a cube share a quadrilateral; all else is the skin of the cube."""
    wedge = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
    monkeypatch.setitem(module.FACES, "wedge6", wedge)
    cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    halves = np.array([[0, 1, 3, 4, 5, 7], [0, 3, 2, 4, 7, 6]], np.int32)
    triangles = skin([("wedge6", halves)])
    assert len(triangles) == 12
    a, b, c = np.moveaxis(cube[triangles], 1, 0)
    assert np.einsum("ij,ij", a, np.cross(b, c)) / 6.0 == pytest.approx(1.0)

"""Hexahedra: volumes of skewed ones, and springs against hourglass modes."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.materials import Elastic
from contiga.matter import Part, assemble
from contiga.matter.shapes import CUBE, hexahedra, hourglass_modes

STEEL = Elastic(young=3.0)


def test_the_volume_of_a_skewed_hexahedron_is_that_of_its_tetrahedra_on_average() -> None:
    """Faces that are not flat are cut by either diagonal; the trilinear map lies in the middle."""
    corners = rig.ONE_HEX[rig.hexes((1, 1, 1))]
    shapes = hexahedra(corners)
    # ∫ x·n/3 over bilinear faces: the mean of both ways to cut each of them
    total = 0.0
    for face in (
        (0, 3, 2, 1),
        (4, 5, 6, 7),
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 0, 4, 7),
    ):
        a, b, c, d = corners[0, list(face)]
        cuts = (a, b, c), (a, c, d), (a, b, d), (b, c, d)
        total += sum(np.dot(p, np.cross(q, r)) for p, q, r in cuts) / 12.0
    assert shapes.measures[0] == pytest.approx(total, rel=1e-13)
    assert shapes.shares.sum() == pytest.approx(total, rel=1e-13)


def test_mean_gradients_are_exact_for_what_is_linear() -> None:
    corners = rig.ONE_HEX[rig.hexes((1, 1, 1))]
    shapes = hexahedra(corners)
    gradients = shapes.gradients.reshape(8, 3)
    np.testing.assert_allclose(corners[0].T @ gradients, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(gradients.sum(axis=0), 0.0, atol=1e-14)
    vectors = hourglass_modes(corners, shapes.gradients).vectors
    np.testing.assert_allclose(vectors[0] @ corners[0], 0.0, atol=1e-14)
    np.testing.assert_allclose(vectors[0].sum(axis=1), 0.0, atol=1e-14)


def bent(hourglass: float) -> tuple[float, float]:
    """Strain and hourglass energy of a cube of side two that is bent by u = ξη along x."""
    nodes = CUBE
    part = Part(
        kind="hex8", elements=np.arange(8)[None], material=STEEL, density=1.0, hourglass=hourglass
    )
    matter = assemble(nodes, [part])
    q = nodes + np.stack([1e-4 * nodes[:, 0] * nodes[:, 1], np.zeros(8), np.zeros(8)], axis=1)
    energy = matter.forces(matter.start(), q, np.zeros_like(q), 0.0).energy
    return energy.strain, energy.hourglass


def test_springs_bend_a_cube_as_its_material_would() -> None:
    """∫ E ε²/2 with ε = q η over 2 × 2 × 2 is E q² (8/3)/2."""
    strain, stored = bent(1.0)
    assert strain < 1e-12
    assert stored == pytest.approx(0.5 * 3.0 * 1e-8 * 8.0 / 3.0, rel=1e-9)
    assert bent(0.1)[1] == pytest.approx(0.1 * stored, rel=1e-12)

"""Springs that keep slopes: which edges have them, and how stiff they are."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter.iga.shells import made, plate, still, tube

from contiga import shapes
from contiga.errors import InputError
from contiga.matter.iga import Symmetry

ACROSS = np.array([1.0, 0.0, 0.0])


def folded(points: np.ndarray, angle: float) -> np.ndarray:
    """What is beyond x = 1 turned about that line."""
    out, far = points.copy(), points[:, 0] > 1.0
    reach = points[far, 0] - 1.0
    out[far, 0], out[far, 2] = 1.0 + reach * np.cos(angle), reach * np.sin(angle)
    return out


def test_half_of_what_is_symmetric_stores_half() -> None:
    """Two patches in a fold of twice an angle, and the one to the right at a plane of symmetry."""
    right = plate(2, (2, 2), (1.0, 1.0)).translated([1.0, 0.0, 0.0])
    left = right.translated([-1.0, 0.0, 0.0])
    half = made([right], symmetry=[Symmetry("u0", 3.0 * ACROSS)])
    whole = made([left, right])
    angle = 1e-3
    q = folded(whole.nodes, -2.0 * angle)
    _, energy = still(half, folded(half.nodes, angle))
    assert energy > 0.0
    assert 2.0 * energy == pytest.approx(still(whole, q)[1], rel=1e-5)


@pytest.mark.parametrize("turn", ["flipped", "transposed"])
def test_a_fold_stores_the_same_whichever_way_patches_run(turn: str) -> None:
    """Normals to opposite sides make an angle of π at rest."""
    left = plate(2, (3, 2), (1.0, 1.0)).insert_knots(v=[0.3])
    right = left.translated([1.0, 0.0, 0.0])
    energies = []
    for one, other in (
        (left, right),
        (getattr(left, turn)(), right),
        (left, getattr(right, turn)()),
    ):
        shell = made([one, other])
        energies.append(still(shell, folded(shell.nodes, 0.3))[1])
    assert energies[0] > 1e-4
    np.testing.assert_allclose(energies, energies[0], rtol=1e-12)


def test_a_turned_joint_meets_point_by_point() -> None:
    """Uneven elements along the joint, and a fold that differs from place to place."""
    left = plate(2, (1, 1), (1.0, 1.0)).insert_knots(v=[0.2, 0.6])
    right = left.translated([1.0, 0.0, 0.0])
    around = right.transposed().flipped().transposed().flipped()
    energies = []
    for other in (right, around):
        shell = made([left, other], slope_stiffness=1e4)
        x, y, z = shell.nodes.T
        z = z + np.where(x > 1.0, 0.1 * (x - 1.0) * y * y, 0.0)
        energies.append(still(shell, np.stack([x, y, z], axis=1))[1])
    assert energies[0] > 1e-3
    assert energies[1] == pytest.approx(energies[0], rel=1e-10)


def test_lines_within_a_patch_at_which_its_slope_may_jump_have_springs() -> None:
    """A cylinder of four arcs: without springs it folds along its lines for nothing."""
    ring = shapes.cylinder(radius=1.0, height=1.0).elevate(0, 1)
    shell, loose = made([ring]), made([ring], slope_stiffness=1e-12)
    q = shell.nodes.copy()
    corner = np.flatnonzero(np.abs(np.hypot(q[:, 0], q[:, 1]) - 1.0) < 1e-9)
    q[corner] *= [1.02, 0.98, 1.0]
    assert still(shell, shell.nodes)[1] < 1e-20
    assert still(shell, q)[1] > 1.01 * still(loose, q)[1]


@pytest.mark.parametrize(("thickness", "longest"), [(0.01, 1.05), (0.1, 1.3)])
def test_springs_shorten_no_step_if_they_are_not_said_to_be_stiffer(
    thickness: float, longest: float
) -> None:
    """Widths of 25 and 2.5 thicknesses; ω² by row sums."""
    halves = [plate(2, (4, 4), (1.0, 1.0)).translated([x, 0.0, 0.0]) for x in (0.0, 1.0)]
    fastest = []
    for stiffness in (None, 1e-12, 1e4):
        shell = made(halves, thickness=thickness, slope_stiffness=stiffness)
        fastest.append(np.max(shell.stiffness(shell.start()) / shell.mass))
    assert fastest[1] <= fastest[0] < longest * fastest[1]
    assert fastest[2] > 2.0 * fastest[1]


def test_what_does_not_bend_has_none() -> None:
    halves = [plate(2, (1, 1), (1.0, 1.0)).translated([x, 0.0, 0.0]) for x in (0.0, 1.0)]
    shell = made(halves, bending=0.0)
    assert still(shell, folded(shell.nodes, 0.4))[1] < 1e-20


def test_planes_of_symmetry_that_are_not_there_are_told() -> None:
    with pytest.raises(InputError, match=r"Symmetry\(normal\): must be a direction"):
        Symmetry("u0", np.zeros(3))
    arch = tube(1.0, 1.0, (2.0, 1.0), 2, (1, 1))
    with pytest.raises(InputError, match="there is no such edge"):
        made([arch], symmetry=[Symmetry("left", ACROSS)])
    with pytest.raises(InputError, match="there is no such patch"):
        made([arch], symmetry=[Symmetry("u0", ACROSS, 1)])

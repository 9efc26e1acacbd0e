"""Stress, strain and energy of shells, against closed forms and those of triangles."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter import rig
from tests.unit.matter.iga.shells import ELASTIC, made, plate, refined, through, tube

from contiga import shapes
from contiga.materials import Elastic, Fabric, NeoHooke
from contiga.matter.coefficients import Material
from contiga.matter.iga import Shell

TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


def fields_of(shell: Shell, q: np.ndarray, height: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """(e, 13) of elements and (m, 13) of control points."""
    state = shell.start()._replace(points=q)
    inside = shell.element_fields(state, height)
    each = np.concatenate([np.column_stack(part.fields) for part in inside])
    return each, np.column_stack(shell.nodal_fields(state, height))


@pytest.mark.parametrize(
    "material",
    [ELASTIC, NeoHooke(young=3.0, poisson=0.3), Fabric(warp=3.0, shear=1.0, direction=[1, 0.3, 0])],
)
def test_an_even_strain_is_that_of_triangles(material: Material) -> None:
    deform = TURN @ np.array([[1.2, 0.1, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, 1.0]])
    sheet = rig.one_part("tri3", rig.grid((1, 1, 0)), rig.sheet(1, 1), material, thickness=0.1)
    state = sheet.start()._replace(points=sheet.nodes @ deform.T)
    expected = np.column_stack(sheet.nodal_fields(state))[0]
    halves = [plate(2, (2, 1), (1.0, 1.0)), plate(3, (1, 1), (1.0, 1.0))]
    for half in halves:
        shell = made([half], material=material)
        for found in fields_of(shell, shell.nodes @ deform.T):
            np.testing.assert_allclose(found, np.tile(expected, (len(found), 1)), atol=1e-13)


def test_what_is_bent_is_pulled_on_its_outer_side() -> None:
    """σ = E κ t/2 along the strip, ν = 0; a₃ points to the centre of the ring."""
    radius, t = 10.0, 0.1
    shell = made([plate(5, (8, 1), (2.0, 1.0))], material=Elastic(young=3.0), thickness=t)
    x, y, _ = shell.net.sites.T
    ring = np.stack([radius * np.sin(x / radius), y, radius * (1 - np.cos(x / radius))], axis=1)
    q = through(shell, ring)
    for height in (-1.0, 0.0, 1.0):
        each, _ = fields_of(shell, q, height)
        strain = -height * 0.5 * t / radius
        # of the axes at rest, of the element at the middle of the strip
        np.testing.assert_allclose(each[:, 6], strain, atol=1e-8)
        np.testing.assert_allclose(
            np.trace(_tensors(each), axis1=1, axis2=2), 3.0 * strain, atol=1e-7
        )
    points = shell.gauss_points(shell.start()._replace(points=q))[0]
    np.testing.assert_allclose(points.curvature[..., 0], -1.0 / radius, rtol=1e-6)
    np.testing.assert_allclose(points.moment[..., 0], -3.0 * t**3 / 12.0 / radius, rtol=1e-6)


def _tensors(columns: np.ndarray) -> np.ndarray:
    xx, yy, zz, xy, yz, xz = columns[:, :6].T
    return np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3)


def test_a_tube_that_is_blown_up_carries_hoops() -> None:
    """Of patches of two pairs of degrees, strains in the axes of space, which means smooth."""
    hoop, errors = 0.5 * (1.1**2 - 1.0), []
    for count in (6, 12, 24):
        arch = tube(1.0, 1.0, (2.5, 0.6), 3, (count, 1))
        shell = made([arch, arch.translated([0.0, 1.0, 0.0]).elevate(0, 1)])
        state = shell.start()._replace(points=shell.nodes * [1.1, 1.0, 1.1])
        inside = shell.element_fields(state)
        assert [len(part.volumes) for part in inside] == [count, count]
        volume = sum(part.volumes.sum() for part in inside)
        assert volume == pytest.approx(2.0 * 1.9 * 0.1, rel=1e-6)
        nodal, drawn = shell.nodal_fields(state), shell.drawn(2)
        strain = drawn.rows.matrix(len(shell.mass)) @ nodal.strain
        x, _, z = drawn.points(shell.nodes).T
        errors.append(np.abs(strain[:, 0] - hoop * z * z).max() / hoop)
        np.testing.assert_allclose(strain[:, 1], 0.0, atol=1e-12)
        np.testing.assert_allclose(nodal.energy_density, 1.5 / 0.91 * hoop**2, rtol=1e-2)
        assert x.max() < 1.0
    assert errors[2] < 0.02
    assert errors[0] > 1.8 * errors[1] > 3.2 * errors[2]


def test_a_closed_tube_has_no_strain_at_rest() -> None:
    ring = refined(shapes.cylinder(radius=1.0, height=1.0).elevate(1, 1), 3, (1, 2))
    shell = made([ring])
    for found in fields_of(shell, shell.nodes @ TURN.T):
        np.testing.assert_allclose(found, 0.0, atol=1e-12)

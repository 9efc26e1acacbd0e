"""Shells of splines: what `contiga verify` has no case for. Its suite has the benchmarks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.unit.matter import rig
from tests.unit.matter.iga.shells import (
    crooked,
    free_ways,
    made,
    plate,
    settled,
    still,
    through,
)

from contiga import NurbsSurface
from contiga.materials import Elastic, NeoHooke
from contiga.matter.iga import Shell
from contiga.patches.basis import spans_at
from contiga_validation.closed_forms.shells import ROOF, roof


def test_of_degree_two_as_many_gauss_points_lock_less_than_three() -> None:
    """And no deformation is left without an energy."""
    whole, fewer = (abs(roof(2, 16, rule) / ROOF - 1.0) for rule in (3, 2))
    assert fewer < 2e-3 < 0.2 * whole
    shell = made([crooked(2, (4, 3))], rule=2)
    values = np.linalg.eigvalsh(shell.tangent(shell.start()).toarray())
    assert np.count_nonzero(values < 1e-9 * values[-1]) == 6


def end_load(shell: Shell, surface: NurbsSurface, force: float) -> np.ndarray:
    """(m, 3) forces of a load along z that is even along the edge u1 of one element."""
    degree, (low, high) = surface.degrees[1], surface.domain[1]
    points, weights = np.polynomial.legendre.leggauss(degree + 1)
    at = spans_at(surface.knots[1], degree, low + 0.5 * (high - low) * (points + 1.0))
    load = np.zeros_like(shell.nodes)
    load[shell.net.control[-1][-1], 2] = 0.5 * force * (weights @ at.values[:, 0])
    return load


def cantilever(count: int, patches: int = 1) -> np.ndarray:
    """How far the end of Sze's cantilever under 4 goes back and up."""
    length = 10.0 / patches
    strips = [
        plate(3, (count // patches, 1), (length, 1.0)).translated([k * length, 0.0, 0.0])
        for k in range(patches)
    ]
    shell = made(strips, material=Elastic(young=1.2e6), thickness=0.1)
    free = free_ways(shell, (shell.net.edge("u0", rows=2), "xyz"))
    q = settled(shell, free, end_load(shell, strips[-1], 4.0), 8)
    back, _, up = (q - shell.nodes)[shell.net.edge("u1", patches - 1)[0]]
    return np.array([-back, up])


def test_one_of_two_patches_bends_as_far() -> None:
    np.testing.assert_allclose(cantilever(16, 2), [3.289, 6.700], rtol=2e-3)


def test_patches_of_membranes_carry_an_even_strain() -> None:
    """A net that is pushed about in its plane, stretched evenly: no force on what is inside."""
    flat = plate(2, (3, 3), (1.0, 1.0))
    points = np.array(flat.control_points)
    points[1:-1, 1:-1, :2] += 0.05 * np.random.default_rng(0).normal(size=(3, 3, 2))
    for material in (Elastic(young=3.0, poisson=0.3), NeoHooke(young=3.0, poisson=0.3)):
        shell = made([NurbsSurface(flat.degrees, flat.knots, points)], material=material)
        deform = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.0], [0.2, 0.3, 1.0]])
        force, _ = still(shell, shell.nodes @ deform.T)
        inner = shell.net.control[0][1:-1, 1:-1].ravel()
        assert np.abs(force).max() > 1e-3
        assert np.abs(force[inner]).max() < 1e-15


@pytest.mark.parametrize("degree", [2, 3, 5])
def test_patches_of_plates_carry_even_moments(degree: int) -> None:
    """A little deflection of second degree on uneven knots: no force two rows from the border."""
    flat = plate(degree, (1, 1), (1.0, 1.0))
    cuts = [np.add(low, [0.2, 0.3, 0.7]) for low, _ in flat.domain]
    shell = made([flat.insert_knots(*cuts)], thickness=0.1)
    x, y, _ = shell.net.sites.T
    places = shell.net.sites.copy()
    places[:, 2] = 0.3 * x * x - 0.2 * x * y + 0.5 * y * y + x
    u = through(shell, places) - through(shell, shell.net.sites)
    force = -(shell.tangent(shell.start()) @ u.ravel()).reshape(-1, 3)
    inner = shell.net.control[0][2:-2, 2:-2].ravel()
    assert np.abs(force).max() > 5e-4
    assert np.abs(force[inner]).max() < 1e-14


def swung(shell: Shell, q: np.ndarray, steps: int, end: float) -> float:
    """The largest error of the energy of what swings from q, over what there was at the start."""
    dt, v, mass = end / steps, np.zeros_like(q), shell.mass[:, None]
    answer = shell.forces(shell.start(), q, v, 0.0)
    first, worst = answer.energy.strain, 0.0
    for _ in range(steps):
        v = v + 0.5 * dt * answer.force / mass
        q = q + dt * v
        answer = shell.forces(answer.state, q, v, dt)
        v = v + 0.5 * dt * answer.force / mass
        worst = max(worst, abs((answer.energy.strain + 0.5 * np.sum(mass * v * v)) / first - 1.0))
    return worst


@pytest.mark.parametrize(
    "material", [Elastic(young=3.0, poisson=0.3), NeoHooke(young=3, poisson=0.3)]
)
def test_the_balance_of_energy_closes_with_the_square_of_the_step(
    material: Elastic | NeoHooke,
) -> None:
    one = plate(2, (2, 2), (1.0, 1.0))
    shell = made([one, one.translated([1.0, 0.0, 0.0])], material=material)
    step = 2.0 * math.sqrt(np.min(shell.mass / shell.stiffness(shell.start())))
    q = rig.moved(shell.nodes, 0.02)
    errors = [swung(shell, q, n, 60.0 * step) for n in (240, 480)]
    assert errors[1] < 6e-3
    assert errors[0] > 3.0 * errors[1]

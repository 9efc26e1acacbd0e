"""Shells of splines against published benchmarks and closed forms, on nets that are refined.

The obstacle course of Belytschko et al. (CMAME 51, 1985) with the numbers to which Kirchhoff-Love
theory converges, Sze, Liu and Lo (Finite Elem. Anal. Des. 40, 2004) for large displacements.
"""

from __future__ import annotations

import math
from math import comb

import numpy as np
import pytest
from scipy.linalg import eigh
from tests.unit.matter import rig
from tests.unit.matter.iga.shells import (
    bent_little,
    crooked,
    dead,
    free_ways,
    made,
    plate,
    refined,
    settled,
    still,
    through,
    tube,
)

from contiga import NurbsSurface
from contiga.materials import Elastic, NeoHooke
from contiga.matter.iga import Shell, Symmetry
from contiga.patches.basis import spans_at


def nearest(shell: Shell, place: tuple[float, float, float]) -> int:
    """The control point at a place."""
    apart = np.abs(shell.nodes - place).sum(axis=1)
    assert apart.min() < 1e-9
    return int(np.argmin(apart))


def roof(degree: int, count: int, rule: int | None = None) -> float:
    """How far the middle of a free edge of Scordelis and Lo's roof goes down."""
    half = math.radians(40.0)
    arch = tube(25.0, 50.0, (0.5 * np.pi + half, 0.5 * np.pi - half), degree, (count, count))
    shell = made([arch], material=Elastic(young=4.32e8), thickness=0.25, rule=rule)
    edge = shell.net.edge
    held = (edge("v0"), "xz"), (edge("v1"), "xz"), (edge("v0")[:1], "y")
    u = bent_little(shell, free_ways(shell, *held), dead(shell, [0.0, 0.0, -90.0]))
    drawn = shell.drawn(2)
    x = drawn.points(shell.nodes)
    place = [25.0 * math.sin(half), 25.0, 25.0 * math.cos(half)]
    return -float(drawn.points(u)[np.argmin(np.abs(x - place).sum(axis=1)), 2])


def test_scordelis_and_los_roof() -> None:
    """0.300588; at degree 3 the error falls by a hundred from 8 to 16 elements a side."""
    errors = [abs(roof(3, n) / 0.300588 - 1.0) for n in (4, 8, 16)]
    assert errors[2] < 1e-4
    assert errors[0] > 20.0 * errors[1] > 400.0 * errors[2]
    assert abs(roof(4, 8) / 0.300588 - 1.0) < 1e-4


def test_of_degree_two_as_many_gauss_points_lock_less_than_three() -> None:
    """And no deformation is left without an energy."""
    whole, fewer = (abs(roof(2, 16, rule) / 0.300588 - 1.0) for rule in (3, 2))
    assert fewer < 2e-3 < 0.2 * whole
    shell = made([crooked(2, (4, 3))], rule=2)
    values = np.linalg.eigvalsh(shell.tangent(shell.start()).toarray())
    assert np.count_nonzero(values < 1e-9 * values[-1]) == 6


def pinched_cylinder(degree: int, count: int) -> float:
    """How far two loads of one on a cylinder between diaphragms go in, by an eighth of it."""
    part = tube(300.0, 300.0, (0.5 * np.pi, 0.0), degree, (count, count))
    planes = [
        Symmetry("u0", np.array([1.0, 0, 0])),
        Symmetry("u1", np.array([0, 0, 1.0])),
        Symmetry("v1", np.array([0, 1.0, 0])),
    ]
    shell = made(
        [part],
        material=Elastic(young=3e6, poisson=0.3),
        thickness=3.0,
        symmetry=planes,
        slope_stiffness=1e4,
    )
    edge = shell.net.edge
    held = (edge("v0"), "xz"), (edge("v1"), "y"), (edge("u0"), "x"), (edge("u1"), "z")
    top = nearest(shell, (0.0, 300.0, 300.0))
    load = np.zeros_like(shell.nodes)
    load[top, 2] = -0.25
    return -float(bent_little(shell, free_ways(shell, *held), load)[top, 2])


def test_a_pinched_cylinder() -> None:
    """1.8249e-5, symmetric by springs that keep slopes."""
    errors = [1.0 - pinched_cylinder(3, n) / 1.8249e-5 for n in (8, 16, 32)]
    assert 0.0 < errors[2] < 1e-3
    assert errors[0] > 8.0 * errors[1] > 64.0 * errors[2]


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Bernstein coefficients of the product of two polynomials in u and v."""
    (m, n), (k, l) = (np.array(each.shape) - 1 for each in (a, b))
    out = np.zeros((m + k + 1, n + l + 1))
    for i, j, r, s in np.ndindex(m + 1, n + 1, k + 1, l + 1):
        share = comb(m, i) * comb(k, r) / comb(m + k, i + r)
        share *= comb(n, j) * comb(l, s) / comb(n + l, j + s)
        out[i + r, j + s] += share * a[i, j] * b[r, s]
    return out


def octant(radius: float) -> list[NurbsSurface]:
    """An eighth of a sphere by three patches without a pole: a quarter of a disc, projected."""
    c, t = math.cos(np.pi / 8.0), math.tan(np.pi / 8.0)
    centre, middle, rim = [0.42, 0.42], [math.sqrt(0.5)] * 2, np.array([[1.0, 1.0], [c, c], [1, 1]])
    halves = [0.5 * (0.45 + 0.42), 0.5 * 0.42]
    flat = [
        (np.array([[[0, 0], [0, 0.45]], [[0.45, 0], centre]]), np.ones((2, 2))),
        (np.array([[[0.45, 0], halves, centre], [[1, 0], [1, t], middle]]), rim[:, ::-1].T),
        (np.array([[centre, halves[::-1], [0, 0.45]], [middle, [t, 1], [0, 1]]]), rim.T),
    ]
    patches = []
    for points, weights in flat:
        weights = np.array(weights)
        if weights.shape[1] == 3:
            weights[0] = 1.0
        x, y = points[:, :, 0] * weights, points[:, :, 1] * weights
        xx, yy, ww = product(x, x), product(y, y), product(weights, weights)
        whole = ww + xx + yy
        net = np.stack([2.0 * product(x, weights), 2.0 * product(y, weights), ww - xx - yy], axis=2)
        degrees = whole.shape[0] - 1, whole.shape[1] - 1
        knots = tuple([0.0] * (p + 1) + [1.0] * (p + 1) for p in degrees)
        patches.append(NurbsSurface(degrees, knots, radius * net / whole[:, :, None], whole))
    return patches


def hemisphere(degree: int, count: int) -> float:
    """How far two pairs of loads of two on the equator of a hemisphere go in and out, by a quarter
    of it."""
    patches = [refined(patch, degree, (count, count)) for patch in octant(10.0)]
    x, y = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    planes = [("v0", y, 0), ("u0", x, 0), ("v0", y, 1), ("v1", x, 2)]
    shell = made(
        patches,
        material=Elastic(young=6.825e7, poisson=0.3),
        thickness=0.04,
        symmetry=[Symmetry(*plane) for plane in planes],
        slope_stiffness=1e4,
    )
    held = [(shell.net.edge(edge, k), "x" if n is x else "y") for edge, n, k in planes]
    held.append((np.array([nearest(shell, (0.0, 0.0, 10.0))]), "z"))
    load = np.zeros_like(shell.nodes)
    one, other = nearest(shell, (10.0, 0.0, 0.0)), nearest(shell, (0.0, 10.0, 0.0))
    load[one, 0], load[other, 1] = 1.0, -1.0
    u = bent_little(shell, free_ways(shell, *held), load)
    assert u[one, 0] == pytest.approx(-u[other, 1], rel=1e-6)
    return float(u[one, 0])


def test_a_hemisphere_without_a_hole_by_patches_that_keep_their_slopes() -> None:
    """0.092404."""
    errors = [abs(hemisphere(4, n) / 0.092404 - 1.0) for n in (2, 4, 8)]
    assert errors[2] < 1e-3
    assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2]


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


def test_a_cantilever_that_bends_far() -> None:
    """3.289 back and 6.700 up."""
    errors = [np.abs(cantilever(n) / [3.28954, 6.69988] - 1.0).max() for n in (4, 8, 16)]
    assert errors[2] < 1e-4
    assert errors[0] > 8.0 * errors[1] > 64.0 * errors[2]


def test_one_of_two_patches_bends_as_far() -> None:
    np.testing.assert_allclose(cantilever(16, 2), [3.289, 6.700], rtol=2e-3)


def test_the_first_frequency_of_a_cantilever() -> None:
    """1.8751²/2π √(E I/(ρ A L⁴)); with lumped masses the error falls with the square."""
    young, t, length, density = 3.0, 0.1, 10.0, 2.0
    exact = 1.8751040687**2 * math.sqrt(young * t**2 / 12.0 / density / length**4)
    errors = []
    for n in (5, 10, 20):
        shell = made([plate(2, (n, 1), (length, 1.0))], material=Elastic(young=young))
        free = free_ways(shell, (shell.net.edge("u0", rows=2), "xyz"))
        stiffness = shell.tangent(shell.start())[free][:, free].toarray()
        masses = np.diag(np.repeat(shell.mass, 3)[free])
        square = eigh(stiffness, masses, subset_by_index=[0, 0])[0][0]
        errors.append(abs(math.sqrt(square) / exact - 1.0))
    assert errors[2] < 5e-3
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]


def disc(degree: int, count: int) -> NurbsSurface:
    """A disc of radius one as one patch of four sides."""
    c = math.sqrt(0.5)
    rows = [[(-c, -c), (-2 * c, 0), (-c, c)], [(0, -2 * c), (0, 0), (0, 2 * c)]]
    rows.append([(c, -c), (2 * c, 0), (c, c)])
    points = np.zeros((3, 3, 3))
    points[:, :, :2] = rows
    weights = [[1.0, c, 1.0], [c, 1.0, c], [1.0, c, 1.0]]
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    return refined(NurbsSurface((2, 2), (knots, knots), points, weights), degree, (count, count))


def drum(degree: int, count: int, thickness: float, **more: float) -> tuple[Shell, np.ndarray]:
    """A membrane over a disc, and what is free of it."""
    material = Elastic(young=1.0 / thickness, poisson=0.3)
    shell = made([disc(degree, count)], material=material, thickness=thickness, bending=0.0, **more)
    rim = np.concatenate([shell.net.edge(name) for name in ("u0", "u1", "v0", "v1")])
    return shell, free_ways(shell, (rim, "xyz"))


def test_henckys_membrane() -> None:
    """w₀/a = 0.653443 (q a/(E h))^⅓ with ν = 0.3, of rises that are small."""
    rise, errors = 0.02, []
    for n in (2, 4, 8):
        shell, free = drum(3, n, 0.01)
        guess = shell.nodes.copy()
        guess[:, 2] = rise * (1.0 - np.sum(shell.net.sites**2, axis=1))
        q = settled(shell, free, dead(shell, [0.0, 0.0, (rise / 0.653443) ** 3]), 1, guess)
        drawn = shell.drawn(2)
        middle = np.argmin(np.sum(drawn.points(shell.nodes) ** 2, axis=1))
        errors.append(abs(drawn.points(q)[middle, 2] / rise - 1.0))
    assert errors[2] < 3e-4
    assert errors[0] > 5.0 * errors[1] > 10.0 * errors[2]


def test_the_first_frequency_of_a_drum() -> None:
    """2.404826 √(N/(ρ t))/a of a round membrane that is stretched evenly.

    Of fewer elements, and of degree 3, checkerboards of control points are slower: lumped masses
    see them, and the surface does not.
    """
    strain, density = 1e-3, 2.0  # that of `made`
    exact = 2.404825558 * math.sqrt(strain / 0.7 / (density * 0.1))
    errors = []
    for n in (8, 16):
        shell, free = drum(2, n, 0.1)
        state = shell.start()._replace(points=shell.nodes * math.sqrt(1.0 + 2.0 * strain))
        across = free[free % 3 == 2]
        stiffness = shell.tangent(state)[across][:, across].toarray()
        masses = np.diag(shell.mass[across // 3])
        square = eigh(stiffness, masses, subset_by_index=[0, 0])[0][0]
        errors.append(abs(math.sqrt(square) / exact - 1.0))
    assert errors[1] < 1e-2
    assert errors[0] > 3.5 * errors[1]


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

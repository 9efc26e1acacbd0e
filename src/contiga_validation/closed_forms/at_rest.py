"""Slaves that deform, at rest under weight or pressure: a bar, rubber, a balloon, a drumhead."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.case import Answer, Cases, order_of, relative, zero
from contiga_validation.closed_forms.matter import GROUP, column
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.engine.arrays import FloatArray, IntArray

CASES = Cases(GROUP)

MU, NU, THICKNESS = 1.0, 0.4999, 0.01
"""Rubber: shear modulus, Poisson's ratio, thickness."""
RUBBER = cg.materials.NeoHooke(young=2.0 * MU * (1.0 + NU), poisson=NU)
STRETCH = 1.2
"""Stretch of the balloon."""
HENCKY = 0.653443
"""w₀/a over (q a/E h)^⅓ of a clamped membrane with ν = 0.3, by Hencky's series."""


def resting(
    slave: cg.Slave,
    motion: cg.motion.Deforming,
    tolerance: float,
    *,
    gravity_size: float = 0.0,
    contacts: Sequence[cg.Contact] = (),
) -> cg.SystemState:
    """Return the state at rest of a slave named "it", under gravity along −z and fixed masters.

    `tolerance` is that of `cg.Settle`; `gravity_size` is the acceleration of gravity.
    """
    return cg.Simulation(
        bodies={f"body {k}": contact.master for k, contact in enumerate(contacts)},
        slaves={"it": (slave, motion)},
        contacts=contacts,
        gravity=[0.0, 0.0, -gravity_size],
        end=1.0,
        step="auto",
        settling=cg.Settle(tolerance=tolerance, steps=60_000),
    ).settle()


@CASES.add(
    "matter-hung",
    "A bar hangs under its own weight",
    "u(z) = −ρ g (L² − z²)/(2 E)",
    "Ten hexahedra with ν = 0, held at the upper end; they come to rest by kinetic damping.",
)
def _hung() -> Answer:
    young, density, gravity_size, length = 1.0, 1e-3, 1e-3, 20.0
    bar = column(10, length)
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=young),
        density=density,
        fixed={"layer": ([0, 0, 1], 0.0)},
    )
    state = resting(bar, motion, 1e-6, gravity_size=gravity_size)
    heights = bar.points[:, 2]
    displacements = state.slaves["it"].points[:, 2] - heights
    exact = -density * gravity_size * (length**2 - heights**2) / (2.0 * young)
    assert state.rest is not None
    checks = (
        relative("way of the lower end", displacements[0], exact[0], 1e-4),
        zero("largest error of all nodes, by that",
             np.abs(displacements - exact).max() / -exact[0], 1e-4),
        zero("residual", state.rest.residual, 1e-6),
    )  # fmt: skip
    z = np.linspace(0.0, length, 100)
    curve = -density * gravity_size * (length**2 - z**2) / (2.0 * young)
    draw = comparison(
        ("z", "way"), [("formula", z, curve)], [("nodes", heights[::4], displacements[::4])]
    )
    return Answer(checks, draw)


def squares(cells: int) -> tuple[FloatArray, list[Any]]:
    """Return points (n, 3) of the unit square, and four arrays (cells, cells) of corners of cells.

    Corners are in counter-clockwise order; cells are indexed by x, then y.
    """
    line = np.linspace(0.0, 1.0, cells + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(line, line, indexing="ij"))
    rows = np.arange(len(x)).reshape(cells + 1, cells + 1)
    corners = [rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]]
    return np.stack([x, y, np.zeros_like(x)], axis=1), corners


def _pulled(stretch: float, *, biaxial: bool) -> float:
    """Return the Cauchy stress along x of a square sheet stretched in x, or in x and y."""
    rest_points, corners = squares(4)
    a, b, c, d = (block.ravel() for block in corners)
    facets = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    sheet = cg.Slave(rest_points * [stretch, stretch if biaxial else 1.0, 1.0], facets)
    fixed = np.zeros(rest_points.shape, np.bool_)
    fixed[:, 2] = True
    fixed[(rest_points[:, 0] == 0.0) | (rest_points[:, 0] == 1.0), 0] = True
    fixed[(rest_points[:, 1] == 0.0) | (biaxial & (rest_points[:, 1] == 1.0)), 1] = True
    motion = cg.motion.Deforming(
        material=RUBBER, density=1.0, thickness=THICKNESS, fixed=fixed, rest=rest_points
    )
    inside = resting(sheet, motion, 1e-5).slaves["it"].matter
    nominal = -float(inside["force"][rest_points[:, 0] == 1.0, 0].sum()) / THICKNESS
    return stretch * nominal


@CASES.add(
    "matter-rubber",
    "Rubber, stretched in one direction and in two",
    "σ = μ (λ² − 1/λ),  σ = μ (λ² − λ⁻⁴)",
    "A square sheet of 32 triangles with ν = 0.4999, whose borders are held where the stretch "
    "has them; force over the section as it is.",
)
def _rubber() -> Answer:
    def uniaxial(stretch: FloatArray) -> FloatArray:
        return np.asarray(stretch**2 - 1.0 / stretch)

    def equibiaxial(stretch: FloatArray) -> FloatArray:
        return np.asarray(stretch**2 - stretch**-4.0)

    laws = {False: uniaxial, True: equibiaxial}
    names = {False: "in one direction", True: "in two"}
    checks = tuple(
        relative(
            f"stress at λ = 2, {names[biaxial]}",
            _pulled(2.0, biaxial=biaxial),
            MU * float(law(np.array(2.0))),
            1e-3,
        )
        for biaxial, law in laws.items()
    )
    stretches, samples = np.linspace(1.0, 2.2, 100), np.array([1.1, 1.3, 1.6, 2.0])
    draw = comparison(
        ("λ", "σ/μ"),
        [
            (f"formula, {names[biaxial]}", stretches, law(stretches))
            for biaxial, law in laws.items()
        ],
        [
            (
                names[biaxial],
                samples,
                np.array([_pulled(float(x), biaxial=biaxial) for x in samples]) / MU,
            )
            for biaxial in laws
        ],
    )
    return Answer(checks, draw)


def sphere(halved: int) -> tuple[FloatArray, IntArray]:
    """Return points and facets of a sphere of radius 1, from an icosahedron halved so many times.

    Middles of edges are moved onto the sphere; facets point out.
    """
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    top = [(0.0, s, t * golden) for s in (1.0, -1.0) for t in (1.0, -1.0)]
    points = np.array([np.roll(p, k) for k in range(3) for p in top]) / math.hypot(1.0, golden)
    is_neighbour = np.linalg.norm(points[:, None] - points, axis=2) < 1.2
    facets = np.array(
        [
            (a, b, c) if np.linalg.det(points[[a, b, c]]) > 0.0 else (a, c, b)
            for a in range(12)
            for b in range(a + 1, 12)
            for c in range(b + 1, 12)
            if is_neighbour[a, b] and is_neighbour[b, c] and is_neighbour[c, a]
        ]
    )
    for _ in range(halved):
        edges = np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]])
        ends, which = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
        middles = points[ends].sum(axis=1)
        middles /= np.linalg.norm(middles, axis=1)[:, None]
        ab, bc, ca = len(points) + which.reshape(3, -1)
        a, b, c = facets.T
        corners = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        facets = np.concatenate([np.stack(three, axis=1) for three in corners])
        points = np.concatenate([points, middles])
    return points, facets


def _volume(points: FloatArray, facets: IntArray) -> float:
    a, b, c = (points[facets[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def _pressure(stretch: FloatArray | float) -> FloatArray:
    """Return p R/(μ t) of an incompressible balloon at a stretch."""
    x = np.asarray(stretch)
    return np.asarray(2.0 * (1.0 / x - x**-7.0))


def _blown(pressure: float, halved: int) -> float:
    """Return the stretch of a balloon at rest, from its volume; `pressure` is over μ t."""
    points, facets = sphere(halved)
    motion = cg.motion.Deforming(
        material=RUBBER,
        density=1.0,
        thickness=THICKNESS,
        loads=cg.motion.Pressure(-pressure * MU * THICKNESS),
    )
    state = resting(cg.Slave(points, facets), motion, 1e-5)
    now = _volume(state.slaves["it"].points, facets)
    return float(np.cbrt(now / _volume(points, facets)))


@CASES.add(
    "matter-balloon",
    "A balloon of rubber under pressure",
    "p R/(μ t) = 2 (λ⁻¹ − λ⁻⁷)",
    "A sphere of 1280 triangles, held by nothing, comes to rest under pressure on its facets.",
)
def _balloon() -> Answer:
    pressure = float(_pressure(STRETCH))
    stretch = _blown(pressure, 3)
    checks = (
        relative("p R/(μ t) at the stretch it has", float(_pressure(stretch)), pressure, 5e-3),
        relative("stretch", stretch, STRETCH, 2e-3),
    )
    order = order_of(
        "stretch, by the length of edges", 0.25, lambda h: abs(
            _blown(pressure, round(-math.log2(h))) - STRETCH), 3,
    )  # fmt: skip
    curve, samples = np.linspace(1.0, 1.35, 100), np.array([1.05, 1.1, 1.15, 1.2, 1.25])
    pressures = _pressure(samples)
    measured = np.array([_blown(float(p), 3) for p in pressures])
    draw = comparison(
        ("λ", "p R/(μ t)"),
        [("formula", curve, _pressure(curve))],
        [("1280 triangles", measured, pressures)],
    )
    return Answer(checks, draw, order)


def disc(rings: int) -> tuple[FloatArray, IntArray]:
    """Return points and facets of a disc of radius 1 in z = 0, with 6 r nodes in ring r."""
    counts = 6 * np.arange(rings + 1)
    first = np.concatenate([[0, 1], 1 + np.cumsum(counts[1:])])
    points = [np.zeros(3)]
    facets: list[tuple[int, int, int]] = []
    for r in range(1, rings + 1):
        turns = 2.0 * math.pi * np.arange(6 * r) / (6 * r)
        points += [np.array([math.cos(t), math.sin(t), 0.0]) * (r / rings) for t in turns]
        inner = partial(lambda r, k: int(first[r - 1]) + k % max(6 * (r - 1), 1), r)
        for k in range(6 * r):
            sector, place = divmod(k, r)
            a, b = int(first[r]) + k, int(first[r]) + (k + 1) % (6 * r)
            facets.append((a, b, inner(sector * (r - 1) + place)))
            if place < r - 1:
                below = sector * (r - 1) + place
                facets.append((b, inner(below + 1), inner(below)))
    return np.array(points), np.array(facets)


def _drumhead(rings: int) -> tuple[FloatArray, FloatArray]:
    """Return radii, and rises over (q a/E h)^⅓, (n,), of a membrane whose border is held."""
    young, pressure = 1.0, 1e-8
    points, facets = disc(rings)
    radii = np.sqrt((points**2).sum(axis=1))
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=young, poisson=0.3),
        density=1.0,
        thickness=1e-3,
        fixed=radii > 1.0 - 1e-9,
        loads=cg.motion.Pressure(-pressure),
    )
    state = resting(cg.Slave(points, facets), motion, 1e-3)
    return radii, state.slaves["it"].points[:, 2] / math.cbrt(pressure / (young * 1e-3))


@CASES.add(
    "matter-drumhead",
    "A clamped membrane under pressure",
    "w₀/a = 0.653443 (q a/E h)^⅓ at ν = 0.3",
    "Hencky's problem: a flat disc of rings of triangles carries nothing until it bulges.",
)
def _hencky() -> Answer:
    coarse, (radii, rises) = _drumhead(4), _drumhead(8)
    checks = (
        relative("w₀/a over (q a/E h)^⅓", rises[0], HENCKY, 6e-3),
        relative("from meshes of 4 and 8 rings", (4.0 * rises[0] - coarse[1][0]) / 3.0,
                 HENCKY, 2e-3),
    )  # fmt: skip
    series = _hencky_series()
    r = np.linspace(0.0, 1.0, 100)
    draw = comparison(
        ("r/a", "w/a (E h/q a)^⅓"), [("series", r, series(r))], [("8 rings", radii, rises)]
    )
    return Answer(checks, draw)


def _hencky_series() -> np.polynomial.Polynomial:
    """Return w/a over (q a/E h)^⅓ as a polynomial in r/a, by the first four terms of his series."""
    b0 = 1.7244
    terms = np.array([1.0, 1.0 / (2.0 * b0**3), 5.0 / (9.0 * b0**6), 55.0 / (72.0 * b0**9)])
    powers = terms / b0
    polynomial = np.polynomial.Polynomial([powers.sum()])
    for k, term in enumerate(powers):
        polynomial = polynomial - np.polynomial.Polynomial([0.0] * (2 * k + 2) + [term])
    return polynomial

"""Membranes under a point, a ball and a pressure that wrinkles them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import contiga as cg
from contiga_validation.closed_forms.at_rest import disc, resting, squares
from contiga_validation.closed_forms.case import Answer, Cases, relative, zero
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.engine.arrays import FloatArray, IntArray

CASES = Cases(GROUP)

THICKNESS = 1e-3
"""Thickness of discs of radius 1 and modulus 1."""
POINT = math.cbrt(3.0 / math.pi)
"""w₀/a over (P/E h a)^⅓ under a point load P at ν = ⅓: 0.984745."""
LOAD = 1e-3
"""Point load P/(E h a)."""
DEPTH, BALL_LOAD = 0.0535900, 2.28049e-4
"""Depth δ R/a² and load P R³/(E h a⁴) of a ball that touches up to `CONTACT_RADIUS` a at ν = 0.3.

By Föppl's equations: a parabola within, integrated from there to the border.
"""
CONTACT_RADIUS = 0.1
"""Radius of contact over that of the membrane."""


def graded(radii: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return points (n, 3), their radii (n,) and the facets of a disc with rings at `radii`.

    Radii ascend. The first radius is 0. The topology is that of `disc`.
    """
    points, facets = disc(len(radii) - 1)
    even = np.hypot(points[:, 0], points[:, 1])
    ring = np.rint((len(radii) - 1) * even).astype(np.int64)
    scale = np.divide(radii[ring], even, out=np.zeros_like(even), where=even > 0.0)
    return points * scale[:, None], radii[ring], facets


def spaced(fine: int, inner: float, outer: int, end: float) -> FloatArray:
    """Return coordinates with `fine` equal steps from 0 to `inner`, `outer` growing ones to `end`.

    Each growing step is a fixed multiple, between 1 and 10, of the one before.
    """
    first = inner / fine
    powers = np.arange(1, outer + 1)

    def beyond(growth: float) -> float:
        return inner + first * float((growth**powers).sum()) - end

    steps = first * float(brentq(beyond, 1.0, 10.0)) ** powers
    return np.concatenate([np.linspace(0.0, inner, fine + 1), inner + np.cumsum(steps)])


def _loaded(rings: int) -> tuple[FloatArray, FloatArray]:
    """Return radii, and displacements over (P/E h a)^⅓, (n,), of a disc under a central load."""
    rest, radii, facets = graded(np.linspace(0.0, 1.0, rings + 1) ** 1.5)
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=1.0, poisson=1.0 / 3.0),
        density=1.0,
        thickness=THICKNESS,
        fixed=radii == 1.0,
        loads=cg.motion.NodalForce([0.0, 0.0, LOAD * THICKNESS], on={"nodes": [0]}),
    )
    state = resting(cg.Slave(rest, facets), motion, 1e-3)
    return radii, state.slaves["it"].points[:, 2] / math.cbrt(LOAD)


@CASES.add(
    "matter-point",
    "A clamped membrane under a point load",
    "w = (3/π)^⅓ (P/E h a)^⅓ (1 − (r/a)^⅔) a at ν = ⅓",
    "Rings of triangles that are finer in the middle, where the slope has no bound: there the "
    "error falls with the first power of their number.",
)
def _point() -> Answer:
    (_, coarse), (radii, displacements) = _loaded(6), _loaded(12)
    checks = (
        relative("w₀/a over (P/E h a)^⅓, 12 rings", displacements[0], POINT, 0.03),
        relative("from 6 and 12 rings", 2.0 * displacements[0] - coarse[0], POINT, 5e-3),
        zero("largest error of all nodes but the middle, by w₀",
             np.abs(displacements - POINT * (1.0 - np.cbrt(radii**2)))[1:].max() / POINT, 0.01),
    )  # fmt: skip
    r = np.linspace(0.0, 1.0, 300)
    draw = comparison(
        ("r/a", "w/a (E h a/P)^⅓"),
        [("formula", r, POINT * (1.0 - np.cbrt(r**2)))],
        [("12 rings", radii, displacements)],
    )
    return Answer(checks, draw)


class _Sunk(NamedTuple):
    """A membrane under a ball, at rest."""

    radii: FloatArray
    """(n,) radii of its nodes."""
    displacements: FloatArray
    """(n,) displacements along z."""
    force: float
    """Force of the ball on it."""


def _under_a_ball() -> _Sunk:
    """Settle a disc under a ball of radius 1 at the depth `DEPTH`."""
    rest, radii, facets = graded(spaced(7, 1.4 * CONTACT_RADIUS, 7, 1.0))
    down = np.where(
        radii < CONTACT_RADIUS,
        0.5 * radii**2 - DEPTH,
        (DEPTH - 0.5 * CONTACT_RADIUS**2)
        * np.log(np.maximum(radii, CONTACT_RADIUS))
        / -math.log(CONTACT_RADIUS),
    )
    border = radii == radii.max()
    down[~border] -= 1e-7
    start = rest.copy()
    start[:, 2] = np.where(border, 0.0, down)
    slave = cg.Slave(start, facets)
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=1.0, poisson=0.3),
        density=1.0,
        thickness=THICKNESS,
        rest=rest,
        fixed=border,
    )
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, 1.0 - DEPTH))])
    law = cg.PenaltyLaw(100.0 * THICKNESS, per_area=True)
    state = resting(slave, motion, 4e-4, contacts=[cg.Contact(ball, slave, law=law)])
    (contact,) = state.contacts.values()
    return _Sunk(radii, state.slaves["it"].points[:, 2], float(-contact.total_force[2]))


def _shape(radii: FloatArray) -> FloatArray:
    """Return displacements (n,) at `radii` (n,) of the membrane under the ball (Föppl's equations).

    φ = r N, r² φ″ + r φ′ − φ = −r w′²/2 with E h = 1, and φ w′ = P/2π from the ball to the border.
    """
    c, pull = CONTACT_RADIUS, BALL_LOAD / (2.0 * math.pi)
    phi = pull / c  # w′ = r there
    inside = (phi + c**3 / 16.0) / c  # φ = A r − r³/16 under the ball

    def rates(r: float, y: FloatArray) -> list[float]:
        return [y[1], (y[0] - r * y[1]) / r**2 - 0.5 * (pull / y[0]) ** 2 / r, pull / y[0]]

    start = [phi, inside - 3.0 * c**2 / 16.0, 0.5 * c**2 - DEPTH]
    outside = solve_ivp(rates, (c, 1.0), start, rtol=1e-10, atol=1e-14, dense_output=True)
    under = 0.5 * radii**2 - DEPTH
    return np.where(radii < c, under, outside.sol(np.maximum(radii, c))[2])


@CASES.add(
    "matter-ball-on-membrane",
    "A ball sinks into a clamped membrane",
    "δ R/a² = 0.05359,  P R³/(E h a⁴) = 2.28049e-4 at c/a = 0.1, ν = 0.3",
    "An exact ball without friction is held at its depth, and a disc of 14 rings comes to rest "
    "against it.",
)
def _ball() -> Answer:
    sunk = _under_a_ball()
    exact = _shape(sunk.radii)
    checks = (
        relative("P R³/(E h a⁴)", sunk.force / THICKNESS, BALL_LOAD, 4e-3),
        zero("largest error of all nodes, by the depth",
             np.abs(sunk.displacements - exact).max() / DEPTH, 5e-3),
    )  # fmt: skip
    r = np.linspace(0.0, 1.0, 300)
    draw = comparison(
        ("r/a", "w R/a²"),
        [("Föppl", r, _shape(r)), ("ball", r[r < 0.3], 0.5 * r[r < 0.3] ** 2 - DEPTH)],
        [("14 rings", sunk.radii, sunk.displacements)],
    )
    return Answer(checks, draw)


YOUNG, POISSON, BAG_THICKNESS, PRESSURE, HALF = 588e6, 0.4, 0.6e-3, 5e3, 0.6 / math.sqrt(2.0)
"""Square bag: modulus, Poisson's ratio, thickness, pressure, half of its side; in m and Pa."""
RISE, CORNER, SIDE, STRESS = 0.2166, -0.0348, -0.122, 3.91e6
"""Displacements of the middle, the corners (x and y alike) and the middles of the sides, m, and the
stress in the middle, Pa: by finer meshes of the same relaxed energy; published rises are 0.216 to
0.217."""


def _crossed(cells: int) -> tuple[FloatArray, IntArray]:
    """Return points and triangles of the unit square, with diagonals that alternate."""
    points, (a, b, c, d) = squares(cells)
    even = np.indices(a.shape).sum(axis=0) % 2 == 0
    halves = [((a, b, c), even), ((a, c, d), even), ((a, b, d), ~even), ((b, c, d), ~even)]
    facets = [np.stack(corners, axis=-1)[is_cut] for corners, is_cut in halves]
    return points, np.concatenate(facets)


class _Blown(NamedTuple):
    """A quarter of one side of the bag, at rest under pressure."""

    unit: FloatArray
    """(n, 3) nodes on the unit square, of which the flat bag is a multiple."""
    displacements: FloatArray
    """(n, 3) displacements, m."""
    stress: float
    """Stress in the first triangle, in the middle of the bag, Pa."""

    def at(self, x: float, y: float) -> FloatArray:
        """Return the displacement (3,) of the node nearest to (x, y) on the unit square."""
        row = np.argmin(np.abs(self.unit[:, :2] - [x, y]).sum(axis=1))
        return np.asarray(self.displacements[row])


def _blown_up(cells: int) -> _Blown:
    """Settle the bag from flat, of `cells` × `cells` squares of triangles without compression."""
    unit, facets = _crossed(cells)
    rest = HALF * unit
    fixed = unit == 0.0
    fixed[:, 2] = (unit[:, :2] == 1.0).any(axis=1)
    nylon = cg.materials.Elastic(young=YOUNG, poisson=POISSON, compression=False)
    motion = cg.motion.Deforming(
        material=nylon,
        density=1e3,
        thickness=BAG_THICKNESS,
        fixed=fixed,
        loads=cg.motion.Pressure(-PRESSURE),
    )
    points = resting(cg.Slave(rest, facets), motion, 1e-3).slaves["it"].points
    part = cg.matter.Part(
        kind="tri3", elements=facets, material=nylon, density=1e3, thickness=BAG_THICKNESS
    )
    matter = cg.matter.assemble(rest, [part])
    stress = matter.stress(matter.start()._replace(points=points))
    return _Blown(unit, points - rest, float(stress[0, 0]))


@CASES.add(
    "matter-airbag",
    "A square airbag",
    "w = 0.2166 m, corner −0.0348 m, mid-side −0.122 m, σ = 3.91 MPa",
    "Diagonal 1.2 m, 588 MPa, ν = 0.4, 0.6 mm, 5 kPa: an eighth of it, 16 × 16 cells of "
    "triangles that wrinkle instead of carrying compression, from flat.",
)
def _bag() -> Answer:
    coarse, fine = _blown_up(8), _blown_up(16)
    corner, side = fine.at(1.0, 1.0), fine.at(1.0, 0.0)
    checks = (
        relative("rise of the middle", fine.at(0.0, 0.0)[2], RISE, 2e-3),
        relative("way of a corner, along x", corner[0], CORNER, 0.01),
        relative("way of the middle of a side", side[0], SIDE, 0.03),
        relative("stress in the middle", fine.stress, STRESS, 0.03),
        zero("how much a corner goes farther along y", corner[1] - corner[0], 1e-4),
    )
    line = fine.unit[:, 1] == 0.0
    other = coarse.unit[:, 1] == 0.0
    draw = comparison(
        ("x", "z"),
        [("published rise", np.array([0.0, HALF]), np.full(2, RISE))],
        [
            (
                name,
                HALF * bag.unit[rows, 0] + bag.displacements[rows, 0],
                bag.displacements[rows, 2],
            )
            for name, bag, rows in (("16 × 16", fine, line), ("8 × 8", coarse, other))
        ],
    )
    return Answer(checks, draw)

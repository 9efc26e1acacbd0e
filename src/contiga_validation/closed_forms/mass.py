"""Mass, centre and inertia of closed bodies."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.case import Answer, Cases, Check, relative, zero
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import INK, LINES

DENSITY = 2.5
EXACT = 1e-12
CASES = Cases("Mass properties")
_HOW = "Gauss's rule on the exact faces, by the divergence theorem; all ten numbers."


def box(a: float, b: float, c: float) -> cg.Body:
    """Return a box with sides a, b, c about the origin, of six faces."""
    corners = {key: 0.5 * np.array([a, b, c]) * key for key in product((-1.0, 1.0), repeat=3)}
    faces = []
    for k, side in product(range(3), (-1.0, 1.0)):
        i, j = [(1, 2), (2, 0), (0, 1)][k]
        ring = []
        for u, v in ((-1.0, -1.0), (side, -side), (-side, side), (1.0, 1.0)):
            key = [0.0, 0.0, 0.0]
            key[k], key[i], key[j] = side, u, v
            ring.append(corners[tuple(key)])
        faces.append(cg.shapes.bilinear(*ring))
    return cg.Body(faces)


def cone(radius: float, height: float) -> cg.Body:
    """Return a cone about z, with its base in z = 0 and its apex above."""
    outline = cg.shapes.line((radius, 0.0, 0.0), (0.0, 0.0, height))
    base = cg.shapes.line((0.0, 0.0, 0.0), (radius, 0.0, 0.0))
    return cg.Body([cg.shapes.revolved(outline), cg.shapes.revolved(base)])


def hollow_ball(outer: float, void: float, offset: float) -> cg.Body:
    """Return a ball about the origin with a spherical void of radius `void` at x = `offset`."""
    inner = cg.shapes.sphere(radius=void, centre=(offset, 0.0, 0.0))
    return cg.Body([cg.shapes.sphere(radius=outer), inner.flipped()])


def _answer(body: cg.Body, volume: float, centre: FloatArray, inertia: FloatArray) -> Answer:
    """Compare mass, centre and inertia of a body; `inertia` has unit density, about the centre."""
    measured = body.mass_properties(DENSITY)
    size = float(np.ptp(body.bounds(), axis=0).max())
    truth = DENSITY * inertia
    miss = np.abs(measured.inertia - truth).max() / np.abs(truth).max()
    checks: tuple[Check, ...] = (
        relative("mass", measured.mass, DENSITY * volume, EXACT),
        zero("centre, by the size", np.abs(measured.centre - centre).max() / size, EXACT),
        *(
            relative(f"I{axis}{axis}", measured.inertia[k, k], truth[k, k], EXACT)
            for k, axis in enumerate("xyz")
        ),
        zero("inertia, all entries", miss, EXACT),
    )
    return Answer(checks, _outline(body, measured.centre))


def _outline(body: cg.Body, centre: FloatArray) -> Callable[..., None]:
    """Return a drawing of a body, transparent, with its centre of mass."""

    def draw(figure: object) -> None:
        axes = figure.subplots(subplot_kw={"projection": "3d"})  # type: ignore[attr-defined]
        mesh = body.tessellate(0.002 * body.size)
        axes.plot_trisurf(
            *mesh.vertices.T, triangles=mesh.triangles, color=LINES[0], alpha=0.25, lw=0.05,
            edgecolor=INK,
        )  # fmt: skip
        axes.plot(*centre[:, None], "o", color=LINES[1], label="centre of mass")
        axes.set_box_aspect(np.ptp(body.bounds(), axis=0))
        axes.legend()

    return draw


@CASES.add("mass-box", "Box", "m = ρ a b c, I_xx = m (b² + c²)/12", _HOW)
def _box() -> Answer:
    a, b, c = 3.0, 2.0, 1.2
    V = a * b * c
    I = V / 12.0 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    return _answer(box(a, b, c), V, np.zeros(3), I)


@CASES.add(
    "mass-torus", "Torus", "m = 2 π² ρ R r², I_zz = m (R² + 3 r²/4), I_xx = m (R²/2 + 5 r²/8)", _HOW
)
def _torus() -> Answer:
    R, r = 3.0, 1.0
    V = 2.0 * math.pi**2 * R * r * r
    transverse = R * R / 2.0 + 5.0 * r * r / 8.0
    I = V * np.diag([transverse, transverse, R * R + 0.75 * r * r])
    return _answer(cg.Body(cg.shapes.torus(major=R, minor=r)), V, np.zeros(3), I)


@CASES.add(
    "mass-cone",
    "Cone",
    "m = ρ π r² h/3, z = h/4, I_zz = 3 m r²/10, I_xx = m (3 r²/20 + 3 h²/80)",
    _HOW,
)
def _cone() -> Answer:
    r, h = 1.5, 2.0
    V = math.pi * r * r * h / 3.0
    transverse = 3.0 / 20.0 * r * r + 3.0 / 80.0 * h * h
    return _answer(
        cone(r, h),
        V,
        np.array([0.0, 0.0, h / 4.0]),
        V * np.diag([transverse, transverse, 0.3 * r * r]),
    )


@CASES.add(
    "mass-void",
    "Ball with a void off its centre",
    "m = ρ 4 π (R³ − r³)/3, x = −r³ e/(R³ − r³), inertia by the parallel axes",
    _HOW,
)
def _hollow() -> Answer:
    R, r, e = 2.0, 0.7, 1.0
    outer, void = (4.0 / 3.0 * math.pi * s**3 for s in (R, r))
    V = outer - void
    x = -void * e / V
    I = (0.4 * outer * R * R - 0.4 * void * r * r) * np.eye(3)
    transverse = np.diag([0.0, 1.0, 1.0])
    I += (outer * x * x - void * (e - x) ** 2) * transverse
    return _answer(hollow_ball(R, r, e), V, np.array([x, 0.0, 0.0]), I)

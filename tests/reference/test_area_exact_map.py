"""The exact map of hulls against QUADPACK over the same polygons."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.spatial import ConvexHull

import contiga as cg


def bumpy():
    """A rational surface with inner knots, one of them double."""
    rng = np.random.default_rng(3)
    x = np.linspace(0.0, 1.0, 7)
    net = np.stack([*np.meshgrid(x, x, indexing="ij"), 0.2 * rng.normal(size=(7, 7))], axis=-1)
    knots = np.array([0, 0, 0, 0, 0.3, 0.6, 0.6, 1, 1, 1, 1.0])
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.5, 2.0, (7, 7)))


def by_quadpack(surface, polygon):
    """∫ |S_u × S_v| over a polygon by adaptive quadrature between its corners and the knots in u.

    In v the strips are cut at the knots too, where the integrand has kinks.
    """

    def jacobian(v, u):
        d = surface.derivatives([[u, v]], 1)[0]
        return float(np.linalg.norm(np.cross(d[1, 0], d[0, 1])))

    def cross(u, side):
        a, b = polygon, np.roll(polygon, -1, axis=0)
        on = (a[:, 0] != b[:, 0]) & (np.minimum(a, b)[:, 0] <= u) & (u <= np.maximum(a, b)[:, 0])
        t = (u - a[on, 0]) / (b[on, 0] - a[on, 0])
        return side(a[on, 1] + t * (b[on, 1] - a[on, 1]))

    inner = [np.unique(knots)[1:-1] for knots in surface.knots]
    low, high = polygon[:, 0].min(), polygon[:, 0].max()
    # Where a side crosses a knot in v, the strip's own integrand has a kink in u.
    kinks = [
        a[0] + (k - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True)
        for k in inner[1]
        if (a[1] - k) * (b[1] - k) < 0.0
    ]
    stops = np.unique(np.concatenate([polygon[:, 0], inner[0], kinks]))
    stops = stops[(stops >= low) & (stops <= high)]
    total = 0.0
    for a, b in pairwise(stops):
        if b - a < 1e-12:  # sides along v, to rounding
            continue
        middle = 0.5 * (a + b)
        ends = [cross(middle, np.min), *inner[1], cross(middle, np.max)]
        edges = sorted(k for k in ends if ends[0] <= k <= ends[-1])

        def border(v, u0=a, u1=b, bottom=ends[0], top=ends[-1]):
            if v in (bottom, top):
                side = np.min if v == bottom else np.max
                return lambda u: cross(min(max(u, u0), u1), side)
            return v

        for v0, v1 in pairwise(edges):
            total += dblquad(jacobian, a, b, border(v0), border(v1), epsabs=2e-12, epsrel=2e-11)[0]
    return total


SURFACES = {
    "rational, with knots": bumpy(),
    "torus": cg.shapes.torus(major=1.0, minor=0.4),
    "sphere": cg.shapes.sphere(radius=1.0),
    "saddle": cg.shapes.saddle(width=2.0, length=2.0, height=0.25),
}
PLACES = {
    "a triangle": [[0.2, 0.15], [0.65, 0.4], [0.35, 0.6]],
    "a quadrilateral with a point inside": [
        [0.2, 0.15], [0.68, 0.4], [0.5, 0.62], [0.25, 0.55], [0.45, 0.4]
    ],
    "a rectangle": [[0.3, 0.25], [0.7, 0.25], [0.7, 0.6], [0.3, 0.6]],
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "what"),
    [("rational, with knots", what) for what in PLACES]
    + [("torus", "a triangle"), ("sphere", "a rectangle"), ("saddle", "a triangle")],
)
def test_exact_map_of_a_hull_is_the_true_area_of_its_polygon_to_1e_10(name, what):
    surface = SURFACES[name]
    (u0, u1), (v0, v1) = surface.domain
    uv = np.array(PLACES[what]) * [u1 - u0, v1 - v0] + [u0, v0]
    points = surface.evaluate(uv) - 1e-3 * surface.normal(uv)
    contact = cg.Contact(
        cg.Body([surface]),
        cg.Slave(points),
        law=cg.PenaltyLaw(1.0),
        area=cg.HullArea(1, mapping="exact"),
        search="penetration",
    )
    state = contact.start(points)
    assert state.n_contact == len(points)
    polygon = state.uv[ConvexHull(state.uv).vertices]
    assert state.total_area == pytest.approx(by_quadpack(surface, polygon), rel=1e-10)
    linear = cg.Contact(
        contact.master, contact.slave, law=contact.law, area=cg.HullArea(1), search="penetration"
    )
    # What the thesis' one factor from parameters to areas makes of the same polygon.
    assert linear.start(points).total_area != pytest.approx(state.total_area, rel=1e-3)

"""Feet on every face of every CAD file against OpenCASCADE's extrema.

Each face is a body of its own. OpenCASCADE is asked for all stationary points on the same NURBS
surface (Extrema_ExtPS), those inside the trimmed face count, and for all stationary points and
the ends of every border curve on the surface (Extrema_ExtPC). What it finds is an upper bound of
the distance: ours may not be larger by more than 1e-9 of the body's size, and the foot must lie on
the face.
"""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import FULL, full

import contiga as cg
from contiga.geometry.kernels.trim_nb import points_in_trim

pytestmark = pytest.mark.usefixtures("kept")

FILES = (
    "headface_MED_full.step",
    "dtmb5415_bulbous_bow.iges",
    "goteborg_hull.step",
    *full("nist_ctc_02_asme1_ap242.stp"),
    "occt_bearing.iges",
    "utah_teapot_32bezier_gismo.xml",
)
# Points a face, and of a file of many faces; CONTIGA_FULL=1 asks for all.
POINTS, OF_MANY = (1000, 1000) if FULL else (20, 6)
ALLOWED = 1e-9
SAMPLES = 200


def border_curves(body):
    """p-curves around face 0: those of its loops, or the four sides of its rectangle."""
    if body.trims[0] is not None:
        return [list(loop) for loop in body.trims[0]]
    (u0, u1), (v0, v1) = body.patches[0].domain
    corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]
    ends = zip(corners, corners[1:] + corners[:1], strict=True)
    return [[cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in ends]]


def along(curve, n):
    a, b = curve.domain
    return curve.evaluate(np.linspace(a, b, n))[:, :2]


class Inside:
    """Even-odd rule on finely sampled loops: nothing of it is shared with the library."""

    def __init__(self, loops):
        self.loops = [np.concatenate([along(c, SAMPLES)[:-1] for c in loop]) for loop in loops]
        steps = [np.hypot(*np.diff(loop, axis=0, append=loop[:1]).T) for loop in self.loops]
        self.spacing = max(float(step.max()) for step in steps)

    def __call__(self, uv):
        inside = np.zeros(len(uv), bool)
        for loop in self.loops:
            a, b = loop, np.roll(loop, -1, axis=0)
            crosses = (a[:, 1] <= uv[:, 1:]) != (b[:, 1] <= uv[:, 1:])
            with np.errstate(all="ignore"):
                share = (uv[:, 1:] - a[:, 1]) / (b[:, 1] - a[:, 1])
                right = a[:, 0] + share * (b[:, 0] - a[:, 0]) > uv[:, :1]
            inside ^= (crosses & right).sum(axis=1) % 2 == 1
        return inside

    def away(self, uv):
        """Distance of each (u, v) to the nearest sample of a loop, in parameters."""
        samples = np.concatenate(self.loops)
        return np.sqrt(((uv[:, None] - samples[None]) ** 2).sum(axis=2).min(axis=1))


def points_near(body, loops, n, seed):
    """Half about the rectangle around the loops, half about the border; both signs."""
    rng = np.random.default_rng(seed)
    edge = np.concatenate([along(c, 50) for loop in loops for c in loop])
    low, high = edge.min(axis=0), edge.max(axis=0)
    uv = low + rng.random((n, 2)) * (high - low)
    uv[1::2] = edge[rng.integers(len(edge), size=len(uv[1::2]))]
    domain = np.array(body.patches[0].domain)
    uv = np.clip(uv, domain[:, 0], domain[:, 1])
    on_edge = body.patches[0].evaluate(np.clip(edge, domain[:, 0], domain[:, 1]))
    size = np.linalg.norm(np.ptp(on_edge, axis=0))
    normal = body.patches[0].normal(uv)
    offset = size * rng.uniform(-0.05, 0.05, (n, 1)) * np.nan_to_num(normal)
    offset[1::2] += size * rng.normal(0.0, 0.03, (len(offset[1::2]), 3))
    return body.patches[0].evaluate(uv) + offset


class Extrema:
    """OpenCASCADE's smallest distance to one face."""

    def __init__(self, body, loops):
        from OCP.Adaptor3d import Adaptor3d_CurveOnSurface
        from OCP.Extrema import Extrema_ExtPC
        from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
        from OCP.GeomAdaptor import GeomAdaptor_Surface
        from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
        from OCP.gp import gp_Pnt

        self.point, self.curve_extrema = gp_Pnt, Extrema_ExtPC
        self.surface = occ_surface(body.patches[0])
        self.search = GeomAPI_ProjectPointOnSurf()
        (u0, u1), (v0, v1) = body.patches[0].domain
        # Algorithm and range first, points later; the tolerance is OpenCASCADE's finest.
        self.search.Init(self.surface, u0, u1, v0, v1, 1e-12)
        adaptor = GeomAdaptor_Surface(self.surface)
        self.kept = [occ_curve2d(c) for loop in loops for c in loop]
        self.curves = [
            Adaptor3d_CurveOnSurface(Geom2dAdaptor_Curve(curve), adaptor) for curve in self.kept
        ]
        self.inside = Inside(loops)
        self.domain = body.patches[0].domain
        self.trims = body.trim_tables

    def within(self, uv):
        """Inside the polygons; where they are too coarse to tell, the exact trims have a say."""
        clear = self.inside.away(uv) > 4.0 * self.inside.spacing
        exact = points_in_trim(self.trims, 0, uv)
        return self.inside(uv) & (clear | exact)

    def in_rectangle(self, at):
        """p-curves may stray from the patch's rectangle by their tolerance: the face ends there."""
        (u0, u1), (v0, v1) = self.domain
        return u0 <= at.X() <= u1 and v0 <= at.Y() <= v1

    def on_surface(self, p):
        """(k, 3) distance, u, v of the stationary points on the surface."""
        self.search.Perform(self.point(*p))
        rows = []
        for i in range(1, self.search.NbPoints() + 1):
            rows.append((self.search.Distance(i), *self.search.Parameters(i)))
        return np.array(rows).reshape(-1, 3)

    def on_border(self, p, best):
        """Smallest distance on the border curves, or `best`."""
        at = self.point(*p)
        for curve, flat in zip(self.curves, self.kept, strict=True):
            places = [curve.FirstParameter()]
            result = self.curve_extrema(at, curve, places[0], curve.LastParameter())
            if result.IsDone():
                places += [result.Point(i).Parameter() for i in range(1, result.NbExt() + 1)]
            for t in places:
                if self.in_rectangle(flat.Value(t)):
                    best = min(best, curve.Value(t).Distance(at))
        return best


def occ_knots(knots):
    """Distinct knots and their multiplicities."""
    from OCP.collections import Array1_double, Array1_int

    distinct, times = np.unique(knots, return_counts=True)
    values, counts = Array1_double(1, len(times)), Array1_int(1, len(times))
    for i, (value, count) in enumerate(zip(distinct, times, strict=True), start=1):
        values.SetValue(i, float(value))
        counts.SetValue(i, int(count))
    return values, counts


def occ_surface(surface):
    from OCP.collections import Array2_double, Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt

    points = surface.control_points
    n, m = points.shape[:2]
    poles, factors = Array2_gp_Pnt(1, n, 1, m), Array2_double(1, n, 1, m)
    weights = np.ones((n, m)) if surface.weights is None else surface.weights
    for i in range(n):
        for j in range(m):
            poles.SetValue(i + 1, j + 1, gp_Pnt(*map(float, points[i, j])))
            factors.SetValue(i + 1, j + 1, float(weights[i, j]))
    (U, u_times), (V, v_times) = (occ_knots(knots) for knots in surface.knots)
    return Geom_BSplineSurface(poles, factors, U, V, u_times, v_times, *surface.degrees)


def occ_curve2d(curve):
    from OCP.collections import Array1_double, Array1_gp_Pnt2d, Array1_int
    from OCP.Geom2d import Geom2d_BSplineCurve
    from OCP.gp import gp_Pnt2d

    n = len(curve.control_points)
    poles, weights = Array1_gp_Pnt2d(1, n), Array1_double(1, n)
    factors = np.ones(n) if curve.weights is None else curve.weights
    for i in range(n):
        poles.SetValue(i + 1, gp_Pnt2d(*map(float, curve.control_points[i, :2])))
        weights.SetValue(i + 1, float(factors[i]))
    values, times = np.unique(curve.knots, return_counts=True)
    knots, counts = Array1_double(1, len(values)), Array1_int(1, len(values))
    for i, (value, time) in enumerate(zip(values, times, strict=True)):
        knots.SetValue(i + 1, float(value))
        counts.SetValue(i + 1, int(time))
    return Geom2d_BSplineCurve(poles, weights, knots, counts, curve.degree)


def compare_face(patch, trim, n, seed):
    """Feet of n points on one face, and how far beyond OpenCASCADE's best each is."""
    body = cg.Body([patch], trims=[trim])
    loops = border_curves(body)
    p = points_near(body, loops, n, seed)
    feet = body.project(p)
    theirs = Extrema(body, loops)
    distance = np.linalg.norm(p - feet.point, axis=1)
    excess = np.empty(n)
    for i, row in enumerate(p.tolist()):
        result = theirs.on_surface(row)
        closer = result[result[:, 0] < distance[i] - ALLOWED * body.size]
        inner = closer[theirs.within(closer[:, 1:])] if len(closer) else closer
        best = theirs.on_border(row, float(inner[:, 0].min(initial=np.inf)))
        excess[i] = distance[i] - best
    return body, p, feet, excess, theirs


@pytest.mark.parametrize("name", FILES)
def test_no_foot_is_farther_than_opencascades_best(data_dir, name):
    whole = cg.read_cad(data_dir / name)
    worst, n = 0.0, POINTS if len(whole.patches) < 40 else OF_MANY
    for k, (patch, trim) in enumerate(zip(whole.patches, whole.trims, strict=True)):
        body, p, feet, excess, theirs = compare_face(patch, trim, n, seed=k)
        size = body.size
        assert np.isin(feet.status, (0, 1, 2)).all(), (name, k, np.unique(feet.status))
        worst = max(worst, float(excess.max()) / size)
        bad = np.flatnonzero(excess > ALLOWED * size)
        assert len(bad) == 0, (name, k, bad[:5], excess[bad[:5]] / size)
        np.testing.assert_allclose(
            np.abs(feet.gap), np.linalg.norm(p - feet.point, axis=1), rtol=0, atol=1e-11 * size
        )
        np.testing.assert_allclose(patch.evaluate(feet.uv), feet.point, rtol=0, atol=1e-11 * size)
        # On the face: inside the polygon, or on the border where the polygon cannot tell.
        stray = feet.uv[~theirs.inside(feet.uv)]
        if len(stray):
            assert theirs.inside.away(stray).max() <= theirs.inside.spacing, (name, k)
    print(f"{name}: worst excess {worst:.1e} of the face's size")

"""Section 5.2, first part: the sides of points, and intersections of a path with a curve."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga import Body, Hit, NurbsCurve, Projection, clouds, shapes
from contiga.report.view import View
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES, draw_curve, plane
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table
from contiga_validation.thesis.chapter5_splines import weighted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()

CONTACT, FREE = LINES[1], LINES[0]

# ---------------------------------------------------------------- grouping (5.2.1)

_HILLS = shapes.bumpy_plate(width=4.0, length=3.0, amplitude=0.35, waves=(1, 1))
_POINT = np.array([0.6, 0.45, 1.25])


def _height(points: FloatArray) -> FloatArray:
    """Return heights (n,) of points over `_HILLS`, whose x and y are linear in its parameters."""
    foot = _HILLS.evaluate(np.column_stack([points[:, 0] / 4.0 + 0.5, points[:, 1] / 3.0 + 0.5]))
    return np.asarray(points[:, 2] - foot[:, 2])


@EXPERIMENTS.add(
    "5.2.1-grouping",
    "Slave points grouped by the normal",
    "Section 5.2.1, Eq. 4.1 and 4.7, Fig. 5.12",
    "The unit normal points to the non-contact side; slave points there are not in contact.",
)
def _grouping() -> Outcome:
    points = clouds.random_in_box((-1.9, -1.4, -0.8), (1.9, 1.4, 0.8), 20000, seed=11)
    body = Body([_HILLS])
    feet = body.project(points)
    # beside the border the closest point need not be below: those are told by height alone
    inner = feet.status == 0
    outside = _height(points) > 0.0
    rows = (
        ("free side", int(outside[inner].sum()), int((feet.gap > 0.0)[inner].sum())),
        ("contact side", int((~outside[inner]).sum()), int((feet.gap <= 0.0)[inner].sum())),
    )
    return Outcome(
        tables=(
            Table(
                "5.2.1 sides",
                "20 000 random points around a surface (those whose foot is inside its border).",
                ("side", "by height over the surface", "by the normal"),
                rows,
            ),
        ),
        pictures=(
            Picture(
                "5.12",
                "Normal N and tangents S_u, S_v at the foot of a point P. N points to the free "
                "side: P and the blue points are not in contact, the red ones are.",
                _draw_grouping,
                (6.2, 4.0),
            ),
        ),
        claims=_grouping_claims(points, feet),
        difference="The surface and the points are chosen here; the thesis names neither.",
    )


def _grouping_claims(points: FloatArray, feet: Projection) -> tuple[Claim, ...]:
    inner, outside = feet.status == 0, _height(points) > 0.0
    wrong = int(((feet.gap > 0.0) != outside)[inner].sum())
    dot = ((points - feet.point) * feet.normal).sum(axis=1)
    printed = int(((-dot < 0.0) != outside)[inner].sum())
    return (
        Claim(
            "The sign of (P − P̂)·N tells the sides apart.",
            wrong == 0,
            f"{wrong} of {int(inner.sum())} points on the wrong side",
        ),
        Claim(
            "Eq. 4.7 as printed, (P̂ − P)·N < 0, is true of points on the free side.",
            printed == 0,
            "so it tells release with N to the free side, and contact is > 0",
        ),
    )


def _draw_grouping(figure: Figure) -> None:
    points = clouds.random_in_box((-1.9, -1.4, -0.8), (1.9, 1.4, 0.8), 90, seed=11)
    free = _height(points) > 0.0
    foot = Body([_HILLS]).project(_POINT[None])
    first = _HILLS.derivatives(foot.uv, 1)[0]
    scene = np.vstack([_HILLS.control_points.reshape(-1, 3), points, _POINT])
    view = View(figure.subplots(), scene, shape=(900, 600))
    view.surface(_HILLS).iso_lines(_HILLS, 13)
    view.dots(points[free], color=FREE, ms=3.4, label="free side")
    view.dots(points[~free], color=CONTACT, ms=3.4, label="contact side")
    view.dots(_POINT, ms=6.0, color=FREE).text(_POINT, "P")
    p = foot.point[0]
    view.lines([_POINT, p], color=FREE, ls=":")
    for direction, name in ((foot.normal[0], "N"), (first[1, 0], "$S_u$"), (first[0, 1], "$S_v$")):
        tip = p + 0.75 * direction / np.linalg.norm(direction)
        view.arrow(p, tip).text(tip, name)
    view.show()
    figure.legend(loc="upper right", ncols=2, handletextpad=0.2)


# ---------------------------------------------------------------- a line meets a curve (5.2.2)

_PATH = np.array([[1.3, 2.4, 0.0], [2.2, 0.35, 0.0]])


class Entry(NamedTuple):
    """Entry of the path into the curve: the first hit, and the roots of another solver."""

    hit: Hit
    """First hit, with the parameter of the reversed curve: solids lie to the left."""
    roots: list[FloatArray]
    """(u on the curve, share of the path) from each start that ended in a root."""
    starts: int
    """Number of starts."""

    @property
    def share(self) -> float:
        """Share of the path up to the first hit."""
        return float(self.hit.fraction[0])

    @property
    def first(self) -> FloatArray:
        """The root that comes first on the path."""
        return min(self.roots, key=lambda root: float(root[1]))


def _entry(curve: NurbsCurve) -> Entry:
    """Intersect `_PATH` with a curve by `first_hit`, and by scipy's fsolve from 41 starts."""
    from scipy.optimize import fsolve

    a, b = _PATH

    def offset(x: FloatArray) -> FloatArray:
        return (a + x[1] * (b - a) - curve.evaluate(np.clip(x[0], 0.0, 1.0))[0])[:2]

    starts = np.linspace(0.0, 1.0, 41)
    roots = [fsolve(offset, (u, 0.5), xtol=1e-13, full_output=True)[0] for u in starts]
    good = [r for r in roots if np.abs(offset(r)).max() < 1e-12 and 0.0 <= r[1] <= 1.0]
    hit = Body.from_profile(curve.reversed()).first_hit(a[None], b[None])
    return Entry(hit, good, len(starts))


def _least_as_printed(curve: NurbsCurve) -> float:
    """Return the least squared distance of line and curve at one parameter, as in Eq. 4.6."""
    from scipy.optimize import minimize_scalar

    a, b = _PATH

    def squared(u: float) -> float:
        return float(((a + u * (b - a) - curve.evaluate(u)[0]) ** 2).sum())

    return min(
        float(minimize_scalar(squared, bounds=(low, low + 0.1), method="bounded").fun)
        for low in np.linspace(0.0, 0.9, 10)
    )


@EXPERIMENTS.add(
    "5.2.2-intersection",
    "A line meets a curve: the initial guess of type a",
    "Section 5.2.2, Eq. 4.6, Fig. 4.4 and 5.13",
    "The intersection of the path P_i−1 P_i with the curve starts Newton's method for a point "
    "that is newly in contact.",
)
def _intersection() -> Outcome:
    curve = weighted(2.0)
    line_entry = _entry(curve)
    return Outcome(
        tables=(_intersection_table(line_entry),),
        pictures=(
            Picture(
                "5.13",
                "The line from P_i−1 to P_i and the point in which it meets the NURBS curve, the "
                "initial guess of type a; dotted, the foot of P_i that Newton's method finds from "
                "there.",
                _draw_intersection,
                (6.4, 3.8),
            ),
        ),
        claims=_intersection_claims(line_entry, _least_as_printed(curve)),
        difference=(
            "A line and a curve meet at different parameters of their own, so two unknowns are "
            "needed, and three for a surface (u, v and the place on the path). contiga solves "
            "these by interval Newton over its hierarchy, without a detour by iso-curves."
        ),
    )


def _intersection_table(entry: Entry) -> Table:
    hit, (u, share) = entry.hit, entry.first
    (a, b) = _PATH[:, :2]
    measured = (1.0 - float(hit.uv[0, 0]), entry.share, *map(float, hit.point[0, :2]))
    return Table(
        "5.2.2 entry",
        "Where the path enters: the curve's own parameter and the share of the path.",
        ("", "u on the curve", "share of the path", "x", "y"),
        (
            ("first hit", *measured),
            ("two equations, scipy", float(u), float(share), *map(float, a + share * (b - a))),
        ),
    )


def _intersection_claims(entry: Entry, least: float) -> tuple[Claim, ...]:
    a, b = _PATH
    miss = float(np.abs(a + entry.share * (b - a) - entry.hit.point[0]).max())
    differ = abs(float(entry.first[1]) - entry.share)
    return (
        Claim(
            "The point found is on the line and on the curve.",
            miss <= 1e-12,
            f"they are {miss:.1e} apart",
        ),
        Claim(
            "It is the first of the roots another solver finds.",
            differ <= 1e-11,
            f"{len(entry.roots)} of {entry.starts} starts of scipy's fsolve end in a root; the "
            f"shares of the path differ by {differ:.1e}",
        ),
        Claim(
            "Eq. 4.6 as printed, with one u for line and curve, does not find it.",
            least > 1e-3,
            f"its minimum is a distance of {least**0.5:.2f}, not 0",
        ),
    )


def _draw_intersection(figure: Figure) -> None:
    axes = plane(figure.subplots())
    curve = weighted(2.0)
    a, b = _PATH
    body = Body.from_profile(curve.reversed())
    hit = body.first_hit(a[None], b[None])
    start = body.project(hit.point)
    foot = body.project(b[None], start=start, mode="track").point[0]
    draw_curve(axes, curve, label="NURBS curve")
    axes.plot(*_PATH[:, :2].T, color=LINES[5], marker="o", label="path of the point")
    axes.plot(*hit.point[0, :2], "o", ms=8, mfc="none", mec=CONTACT, mew=1.8, label="first hit")
    axes.plot(*np.array([b, foot])[:, :2].T, ":", color=CONTACT, label="its foot")
    axes.plot(*foot[:2], "o", color=CONTACT)
    for at, name in ((a, "$P_{i-1}$"), (b, "$P_i$")):
        axes.annotate(name, at[:2], xytext=(6, 4), textcoords="offset points")
    axes.legend(loc="upper right")

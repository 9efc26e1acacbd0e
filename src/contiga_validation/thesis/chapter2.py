"""Chapter 2: bases, their properties, and refinement that does not change the shape."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contiga import NurbsCurve
from contiga import knots as kv
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES, MUTED, draw_curve, draw_polygon, plane
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()

_FINE = 2001
_UNIFORM = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
EIGHT = NurbsCurve(
    3,
    kv.open_knots(3, 8),
    [
        [0.0, 0.0], [0.4, 1.5], [1.4, 1.9], [1.9, 0.1],
        [2.9, -0.1], [3.2, 1.6], [4.3, 1.8], [4.8, 0.2],
    ],
)  # fmt: skip
"""A cubic with eight control points."""
_FINE_U = np.linspace(0.0, 1.0, 4001)


# ---------------------------------------------------------------- bases (2.2.1)


def cox_de_boor(knots: FloatArray, degree: int, u: FloatArray) -> FloatArray:
    """Return (k, n) basis functions at `u` (k,) by the printed recursion (Eq. 2.2), with 0/0 = 0.

    Functions are right-continuous, except at the last knot. This is independent of the kernels on
    purpose: they are checked against it.
    """
    basis = ((knots[:-1] <= u[:, None]) & (u[:, None] < knots[1:])).astype(np.float64)
    # the last span with a length is closed, so that the right end belongs to the curve
    last = int(np.flatnonzero(np.diff(knots) > 0.0)[-1])
    basis[u == knots[-1], last] = 1.0
    for p in range(1, degree + 1):
        n = len(knots) - p - 1
        left = _ratio(u[:, None] - knots[:n], knots[p : p + n] - knots[:n])
        right = _ratio(knots[p + 1 :] - u[:, None], knots[p + 1 :] - knots[1 : n + 1])
        basis = left * basis[:, :n] + right * basis[:, 1 : n + 1]
    return basis


def _ratio(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Return the quotient, with broadcasting; 0 where the denominator is not positive."""
    out = np.zeros(np.broadcast_shapes(numerator.shape, denominator.shape))
    return np.divide(numerator, denominator, out=out, where=denominator > 0.0)


@EXPERIMENTS.add(
    "2.2-bases",
    "Basis functions add up to one and are never negative",
    "Section 2.2.1, Eq. 2.1–2.4, Fig. 2.1",
    "Basis functions come from the Cox–de Boor recursion, are non-negative, have compact "
    "support and add up to 1.",
)
def _bases() -> Outcome:
    u = np.linspace(0.0, 1.0, _FINE)
    rows: list[tuple[int, float, float, float, float]] = []
    for p in range(1, 8):
        knots = kv.open_knots(p, p + 6)
        basis = kv.basis(knots, p, u, order=1)
        sums = np.abs(basis[:, 0].sum(axis=1) - 1.0).max()
        printed = np.abs(basis[:, 0] - cox_de_boor(knots, p, u)).max()
        slopes = np.abs(basis[:, 1].sum(axis=1)).max() / np.abs(basis[:, 1]).max()
        rows.append((p, float(sums), float(basis[:, 0].min()), float(printed), float(slopes)))
    worst = [max(row[k] for row in rows) for k in (1, 3, 4)]
    smallest = min(row[2] for row in rows)
    return Outcome(
        tables=(
            Table(
                "2.2.1 bases",
                "Open uniform knots, six functions more than the degree, 2001 parameters.",
                (
                    "degree",
                    "largest |sum − 1|",
                    "smallest value",
                    "from the recursion Eq. 2.2",
                    "sum of slopes / largest slope",
                ),
                tuple(rows),
            ),
        ),
        pictures=(
            Picture(
                "2.1",
                "Basis functions of degree 0, 1 and 2 on the uniform knots 0, 1, 2, …; each is "
                "the one before it moved by one knot.",
                _draw_bases,
                (8.2, 2.5),
            ),
        ),
        claims=_bases_claims(smallest, u, worst),
        difference=(
            "The thesis gives no numbers here. Its list of properties repeats the recursion in a "
            "form that is right without interior knots only; the recursion of Eq. 2.2 is used."
        ),
    )


def _bases_claims(smallest: float, u: FloatArray, worst: list[float]) -> tuple[Claim, ...]:
    # Errors of the recursion of 2.2.1 without and with an interior knot.
    bernstein = []
    for inner in ([], [0.5]):
        knots = [np.concatenate([np.zeros(p + 1), inner, np.ones(p + 1)]) for p in (1, 2)]
        low, high = (cox_de_boor(k, p, u) for p, k in enumerate(knots, start=1))
        padded = np.pad(low, ((0, 0), (1, 1)))
        short = (1.0 - u[:, None]) * padded[:, 1:] + u[:, None] * padded[:, :-1]
        bernstein.append(float(np.abs(short - high).max()))
    return (
        Claim("The functions add up to 1.", worst[0] <= 1e-15, f"largest miss {worst[0]:.1e}"),
        Claim("No function is negative.", smallest >= 0.0, f"smallest value {smallest:.1e}"),
        Claim(
            "They are those of the Cox–de Boor recursion (Eq. 2.2).",
            worst[1] <= 1e-14,
            f"largest difference {worst[1]:.1e}",
        ),
        Claim("Their derivatives add up to 0.", worst[2] <= 1e-14, f"largest sum {worst[2]:.1e}"),
        Claim(
            "The recursion under 2.2.1, (1 − u) B_{i,p−1} + u B_{i−1,p−1}, holds for the "
            "Bernstein functions only, not for B-splines as printed.",
            bernstein[0] <= 1e-15 < 1e-2 < bernstein[1],
            f"off by {bernstein[0]:.1e} on knots 0 0 0 1 1 1, by {bernstein[1]:.2f} on knots "
            "with an interior one",
        ),
    )


def _draw_bases(figure: Figure) -> None:
    for p, axes in enumerate(figure.subplots(1, 3, sharey=True)):
        u = np.linspace(0.0, 5.0, 1001)
        values = cox_de_boor(_UNIFORM, p, u)
        for i in range(min(3, values.shape[1])):
            curve = values[:, i] if p else np.where(values[:, i] > 0.0, 1.0, np.nan)
            axes.plot(u, curve, color=LINES[i], label=f"$B_{{{i},{p}}}$", lw=2.2 if p == 0 else 1.6)
        plane(axes, equal=False, labels=("u", ""))
        axes.set_title(f"degree {p}")
        axes.set_ylim(-0.03, 1.08)
        axes.legend(loc="upper right" if p else "center right", handlelength=1.2)


# ---------------------------------------------------------------- properties of curves (2.2.2)


@EXPERIMENTS.add(
    "2.2-hull",
    "A curve lies in the convex hull of its control points",
    "Section 2.2.2, Fig. 2.2",
    "Over the knot span [u_i, u_i+1] the curve lies in the convex hull of P_i−p … P_i.",
)
def _hull() -> Outcome:
    from scipy.spatial import ConvexHull

    misses = []
    curve = EIGHT
    p, knots = curve.degree, curve.knots
    for i in range(p, len(knots) - p - 1):
        u = np.linspace(knots[i], knots[i + 1], 401)
        facets = ConvexHull(curve.control_points[i - p : i + 1, :2]).equations
        outside = curve.evaluate(u)[:, :2] @ facets[:, :2].T + facets[:, 2]
        misses.append((i, float(knots[i]), float(knots[i + 1]), float(outside.max())))
    worst = max(row[3] for row in misses)
    return Outcome(
        tables=(
            Table(
                "2.2.2 hull",
                "A cubic with eight control points: how far the piece over each knot span leaves "
                "the hull of its own four control points (negative: it stays inside).",
                ("span", "from u", "to u", "largest distance outside"),
                tuple(misses),
            ),
        ),
        pictures=(
            Picture(
                "2.2",
                "The piece of a cubic B-spline curve over one knot span lies in the convex hull "
                "of four neighbouring control points; so does every other piece in its own.",
                _draw_hull,
                (6.4, 3.2),
            ),
        ),
        claims=(
            Claim(
                "For u in [u_i, u_i+1] the curve lies in the hull of P_i−p … P_i.",
                worst <= 1e-14,
                f"it leaves it by at most {worst:.1e}",
            ),
        ),
        difference="Fig. 2.2 is taken from elsewhere; the curve here is our own.",
    )


def _draw_hull(figure: Figure) -> None:
    from scipy.spatial import ConvexHull

    axes = plane(figure.subplots())
    curve, i = EIGHT, 5
    corners = curve.control_points[i - 3 : i + 1, :2]
    ring = corners[ConvexHull(corners).vertices]
    axes.fill(*ring.T, color=LINES[4], alpha=0.22, lw=0, label=f"hull of $P_{i - 3}$ … $P_{i}$")
    draw_polygon(axes, curve)
    draw_curve(axes, curve)
    piece = curve.evaluate(np.linspace(curve.knots[i], curve.knots[i + 1], 60))
    axes.plot(piece[:, 0], piece[:, 1], color=LINES[4], lw=3.2, label="its piece of the curve")
    for k, (x, y) in enumerate(curve.control_points[:, :2]):
        axes.annotate(f"$P_{k}$", (x, y), xytext=(4, 4), textcoords="offset points", fontsize=8)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _crossings(values: FloatArray) -> NDArray[np.intp]:
    """Return the numbers (k,) of sign changes along the rows of `values` (k, n), zeros ignored."""
    signs = np.sign(values)
    return np.asarray((signs[:, 1:] * signs[:, :-1] < 0.0).sum(axis=1))


@EXPERIMENTS.add(
    "2.2-variation",
    "A curve varies no more than its control polygon",
    "Section 2.2.2, Fig. 2.3",
    "As the degree rises the curve departs from its polygon and stays inside its hull; this "
    "is given as the variation diminishing property.",
)
def _variation() -> Outcome:
    rng = np.random.default_rng(7)
    polygon = EIGHT.control_points[:, :2]
    angle = rng.uniform(0.0, np.pi, 2000)
    through = rng.uniform(polygon.min(axis=0), polygon.max(axis=0), (2000, 2))
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    offset = (normal * through).sum(axis=1)
    cuts = _crossings(normal @ polygon.T - offset[:, None])
    rows = []
    for p in (1, 2, 3, 5, 7):
        curve = NurbsCurve(p, kv.open_knots(p, 8), polygon)
        # samples cross at most as often as the curve, the fine polygon at least as often
        fine = curve.insert_knots(np.linspace(0.0, 1.0, 402)[1:-1])
        upper = _crossings(normal @ fine.control_points[:, :2].T - offset[:, None])
        lower = _crossings(normal @ curve.evaluate(_FINE_U)[:, :2].T - offset[:, None])
        n_more = int((upper > cuts).sum())
        rows.append((p, float(cuts.mean()), float(lower.mean()), float(upper.mean()), n_more))
    return Outcome(
        tables=(
            Table(
                "2.2.2 variation",
                "2000 random lines against curves of rising degree on the same eight control "
                "points: how often they cut, on average.",
                (
                    "degree",
                    "cuts with the polygon",
                    "cuts with the curve, at least",
                    "at most",
                    "lines that cut the curve more often than the polygon",
                ),
                tuple(rows),
            ),
        ),
        pictures=(
            Picture(
                "2.3",
                "The same control points with curves of rising degree: the higher it is, the "
                "less of the polygon's variation is left. The line cuts none more often than the "
                "polygon.",
                _draw_variation,
                (6.4, 3.2),
            ),
        ),
        claims=_variation_claims(rows),
        difference=(
            "The text under the heading “variation diminishing” explains the convex hull property "
            "again and calls it local control. What the name means is tested here: a curve wiggles "
            "no more than its control polygon."
        ),
    )


def _variation_claims(rows: list[tuple[int, float, float, float, int]]) -> tuple[Claim, ...]:
    falling = all(a[3] >= b[2] for a, b in pairwise(rows))
    return (
        Claim(
            "No line cuts a curve more often than its control polygon.",
            all(row[4] == 0 for row in rows),
            f"{sum(row[4] for row in rows)} of {len(rows) * 2000} lines do",
        ),
        Claim(
            "The higher the degree, the fewer the cuts (Fig. 2.3).",
            falling and rows[0][2] > rows[-1][3] + 0.3,
            f"{rows[0][2]:.2f} cuts a line at degree 1, {rows[-1][3]:.2f} at degree 7",
        ),
    )


def _draw_variation(figure: Figure) -> None:
    axes = plane(figure.subplots())
    draw_polygon(axes, EIGHT, color=MUTED)
    for p, colour in ((2, LINES[0]), (3, LINES[1]), (5, LINES[2]), (7, LINES[3])):
        curve = NurbsCurve(p, kv.open_knots(p, 8), EIGHT.control_points)
        draw_curve(axes, curve, color=colour, label=f"degree {p}")
    axes.axline((0.0, 0.86), slope=0.03, color=LINES[4], lw=1.0, label="a line")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


@EXPERIMENTS.add(
    "2.2-affine",
    "Affine maps of the control points are affine maps of the curve",
    "Section 2.2.2",
    "Translation, rotation and scaling of the control points move the curve alike.",
)
def _affine() -> Outcome:
    rng = np.random.default_rng(3)
    worst = 0.0
    for _ in range(50):
        matrix = np.eye(4)
        matrix[:3, :3] += rng.uniform(-0.8, 0.8, (3, 3))
        matrix[:3, 3] = rng.uniform(-2.0, 2.0, 3)
        weights = rng.uniform(0.5, 3.0, 8)
        curve = NurbsCurve(3, EIGHT.knots, EIGHT.control_points, weights)
        after = curve.evaluate(_FINE_U) @ matrix[:3, :3].T + matrix[:3, 3]
        worst = max(worst, float(np.abs(curve.transformed(matrix).evaluate(_FINE_U) - after).max()))
    return Outcome(
        claims=(
            Claim(
                "Moving the control points by an affine map moves the curve by the same map, "
                "with weights as well.",
                worst <= 1e-13,
                f"largest difference {worst:.1e} over 50 random maps",
            ),
        ),
        difference="The thesis states it without an example; curve and maps are chosen here.",
    )

"""Chapter 2: bases, their properties, and refinement that leaves the shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contiga.geometry import knots as kv
from contiga.geometry.curve import NurbsCurve
from contiga.records import FloatArray
from contiga.thesis.drawing import LINES, plane
from contiga.thesis.records import Claim, Experiment, Outcome, Picture, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FINE = 2001
_UNIFORM = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
_QUADRATIC = np.array([0, 0, 0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1, 1, 1])
_BEZIER = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0])
_CUBIC = NurbsCurve(3, _BEZIER, [[0.0, 0.0], [0.6, 1.6], [2.0, 1.9], [3.0, 0.2]])
_EIGHT = np.array(
    [[0, 0], [0.4, 1.5], [1.4, 1.9], [1.9, 0.3], [2.9, 0.1], [3.2, 1.6], [4.3, 1.8], [4.8, 0.4]]
)


# ---------------------------------------------------------------- bases (2.2.1)


def cox_de_boor(knots: FloatArray, degree: int, u: FloatArray) -> FloatArray:
    """(k, n) basis functions by the recursion as it is printed (Eq. 2.2), 0/0 taken as 0.

    Kept apart from the kernels on purpose: it is what they are checked against.
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


def _ratio(above: FloatArray, below: FloatArray) -> FloatArray:
    out = np.zeros(np.broadcast_shapes(above.shape, below.shape))
    return np.divide(above, below, out=out, where=below > 0.0)


def _bases() -> Outcome:
    u = np.linspace(0.0, 1.0, _FINE)
    rows: list[tuple[int, float, float, float, float]] = []
    for p in range(1, 8):
        knots = kv.open_knots(p, p + 6)
        ours = kv.basis(knots, p, u, order=1)
        sums = np.abs(ours[:, 0].sum(axis=1) - 1.0).max()
        printed = np.abs(ours[:, 0] - cox_de_boor(knots, p, u)).max()
        slopes = np.abs(ours[:, 1].sum(axis=1)).max() / np.abs(ours[:, 1]).max()
        rows.append((p, float(sums), float(ours[:, 0].min()), float(printed), float(slopes)))
    worst = [max(row[k] for row in rows) for k in (1, 3, 4)]
    least = min(row[2] for row in rows)
    bernstein = _bernstein_error(u)
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
        claims=(
            Claim("The functions add up to 1.", worst[0] <= 1e-15, f"largest miss {worst[0]:.1e}"),
            Claim("No function is negative.", least >= 0.0, f"smallest value {least:.1e}"),
            Claim(
                "They are those of the Cox–de Boor recursion (Eq. 2.2).",
                worst[1] <= 1e-14,
                f"largest difference {worst[1]:.1e}",
            ),
            Claim(
                "Their derivatives add up to 0.", worst[2] <= 1e-14, f"largest sum {worst[2]:.1e}"
            ),
            Claim(
                "The recursion under 2.2.1, (1 − u) B_{i,p−1} + u B_{i−1,p−1}, holds for the "
                "Bernstein functions only, not for B-splines as printed.",
                bernstein[0] <= 1e-15 < 1e-2 < bernstein[1],
                f"off by {bernstein[0]:.1e} on knots 0 0 0 1 1 1, by {bernstein[1]:.2f} on knots "
                "with an interior one",
            ),
        ),
        difference=(
            "The thesis gives no numbers here. Its list of properties repeats the recursion in a "
            "form that is right without interior knots only; the recursion of Eq. 2.2 is used."
        ),
    )


def _bernstein_error(u: FloatArray) -> tuple[float, float]:
    """Largest miss of the short recursion without and with an interior knot, degree 2."""
    misses = []
    for inner in ([], [0.5]):
        knots = [np.concatenate([np.zeros(p + 1), inner, np.ones(p + 1)]) for p in (1, 2)]
        low, high = (cox_de_boor(k, p, u) for p, k in enumerate(knots, start=1))
        padded = np.pad(low, ((0, 0), (1, 1)))
        short = (1.0 - u[:, None]) * padded[:, 1:] + u[:, None] * padded[:, :-1]
        misses.append(float(np.abs(short - high).max()))
    return misses[0], misses[1]


def _draw_bases(figure: Figure) -> None:
    for p, axes in enumerate(figure.subplots(1, 3, sharey=True)):
        u = np.linspace(0.0, 5.0, 1001)
        values = cox_de_boor(_UNIFORM, p, u)
        for i in range(min(3, values.shape[1])):
            shown = values[:, i] if p else np.where(values[:, i] > 0.0, 1.0, np.nan)
            axes.plot(u, shown, color=LINES[i], label=f"$B_{{{i},{p}}}$", lw=2.2 if p == 0 else 1.6)
        plane(axes, equal=False, labels=("u", ""))
        axes.set_title(f"degree {p}")
        axes.set_ylim(-0.03, 1.08)
        axes.legend(loc="upper right", handlelength=1.2)


EXPERIMENTS: tuple[Experiment, ...] = (
    Experiment(
        "2.2-bases",
        2,
        "Basis functions add up to one and are never negative",
        "Section 2.2.1, Eq. 2.1–2.4, Fig. 2.1",
        _bases,
        "Basis functions come from the Cox–de Boor recursion, are non-negative, have compact "
        "support and add up to 1.",
    ),
)

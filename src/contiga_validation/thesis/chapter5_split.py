"""Section 5.4.1: splitting the master, net and base area (Algorithms 2 to 4, Eq. 4.8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga import NurbsSurface
from contiga.report.view import View
from contiga_validation.engine.drawing import BODY, LINES, MUTED
from contiga_validation.engine.experiment import Claim, Experiments, Outcome, Picture, Table
from contiga_validation.thesis.play import patches_of
from contiga_validation.thesis.variants import simulation_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()


class SplitStep(NamedTuple):
    """Areas of the master after some rounds of splits in half, in u and in v."""

    pieces: int
    """Number of pieces."""
    net: float
    """Areas of the control nets, summed over the pieces (Algorithm 2)."""
    base: float
    """Areas of the corner triangles, summed over the pieces (Algorithm 4)."""


def split_data(surface: NurbsSurface, rounds: int = 4) -> list[SplitStep]:
    """Return areas before and after each of `rounds` splits of every piece into quarters.

    Algorithms 2 to 4, Eq. 4.8.
    """
    pieces = [surface]
    areas = []
    for k in range(rounds + 1):
        net = sum(piece.net_area() for piece in pieces)
        base = sum(_corner_area(piece) for piece in pieces)
        areas.append(SplitStep(len(pieces), net, base))
        if k < rounds:
            pieces = [half for piece in pieces for half in _quartered(piece)]
    return areas


def _quartered(surface: NurbsSurface) -> list[NurbsSurface]:
    (u0, u1), (v0, v1) = surface.domain
    halves = surface.split(u=0.5 * (u0 + u1))
    return [piece for half in halves for piece in half.split(v=0.5 * (v0 + v1))]


def _corner_area(surface: NurbsSurface) -> float:
    """Return the area of two triangles over the four corners of the patch, Algorithm 4's base."""
    net = surface.control_points
    a, b, c, d = net[0, 0], net[-1, 0], net[-1, -1], net[0, -1]
    first, second = np.cross(b - a, c - a), np.cross(c - a, d - a)
    return float(0.5 * (np.linalg.norm(first) + np.linalg.norm(second)))


@EXPERIMENTS.add(
    "5.4-split",
    "Splitting the master, net and base area",
    "5.4.1, Fig. 5.22, Algorithms 2 to 4, Eq. 4.8",
    "The master is split at u = 0.5 and v = 0.5 so that the areas of its control net and of "
    "its base agree. The surface here is the bumpy master, on the thesis' knots and 20 points.",
)
def _split() -> Outcome:
    (surface,) = patches_of(simulation_of("bumpy_master"))
    steps, true = split_data(surface), surface.area()
    rows = [(s.pieces, s.net, s.base, s.net - s.base, s.net - true, s.base - true) for s in steps]
    bracket = all(s.base <= true + 1e-12 and s.net >= true - 1e-12 for s in steps)
    return Outcome(
        tables=(
            Table(
                "5.22",
                f"Splitting the bumpy master at the middle of every piece; its area is {true:.9f}.",
                ("pieces", "A_net", "A_base", "A_net - A_base", "A_net - A", "A_base - A"),
                tuple(rows),
            ),
        ),
        pictures=(
            Picture("5.22", _CAPTION_SPLIT, lambda f: _draw_split(f, surface), (7.4, 2.9)),
            Picture(
                "5.22-areas",
                "Net and base area approach the surface's own from above and below.",
                lambda f: _draw_convergence(f, steps, true),
                (5.2, 3.2),
            ),
        ),
        claims=_split_claims(bracket, steps, true),
        difference=(
            "Eq. 4.8 compares net and base of one patch, which no refinement of that patch brings "
            "together because its corners stay where they are; summed over the pieces both are "
            "of second order. Algorithm 3's slices are broken as printed: the pieces here come "
            "from knot insertion to full multiplicity."
        ),
    )


def _split_claims(bracket: bool, steps: list[SplitStep], true: float) -> tuple[Claim, ...]:
    gaps = [step.net - step.base for step in steps]
    ratio = gaps[-2] / gaps[-1]
    apart = abs(steps[0].net - steps[0].base)
    return (
        Claim(
            "Summed over the pieces, net and base area close in on the surface's (Eq. 4.8).",
            bracket and ratio > 3.5,
            f"the last split divides their difference by {ratio:.2f}",
        ),
        Claim(
            "Of the one patch they do not, however the net is refined.",
            apart > 0.2 * true,
            f"A_net - A_base = {apart:.3f} before the first split",
        ),
    )


_CAPTION_SPLIT = (
    "The master whole, split at u = 0.5 and at v = 0.5, and in quarters, each with its control net."
)


def _draw_split(figure: Figure, surface: NurbsSurface) -> None:
    shown = (
        ("u = 0.5", list(surface.split(u=0.5))),
        ("v = 0.5", list(surface.split(v=0.5))),
        ("u = v = 0.5", _quartered(surface)),
    )
    net = surface.control_points.reshape(-1, 3)
    for axes, (title, pieces) in zip(figure.subplots(1, 3), shown, strict=True):
        view = View(axes, net, shape=(560, 460))
        for k, piece in enumerate(pieces):
            view.surface(piece, (BODY, "#d9b38c", "#a8c5a0", "#c3b1d6")[k])
        for k, piece in enumerate(pieces):
            view.net(piece, color=LINES[k % len(LINES)], lw=0.6)
        view.show(triad=False)
        axes.set_title(title)


def _draw_convergence(figure: Figure, steps: list[SplitStep], true: float) -> None:
    axes = figure.subplots()
    pieces = [step.pieces for step in steps]
    axes.loglog(pieces, [s.net - true for s in steps], "o-", color=LINES[0], label="$A_{net} - A$")
    axes.loglog(
        pieces, [true - s.base for s in steps], "s-", color=LINES[1], label="$A - A_{base}$"
    )
    start = steps[1].net - true
    line = [start * pieces[1] / n for n in pieces[1:]]
    axes.loglog(pieces[1:], line, color=MUTED, lw=0.8, ls=(0, (4, 3)), label="second order")
    axes.set(xlabel="pieces", ylabel="error of the area")
    axes.legend()

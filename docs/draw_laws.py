"""Draw the pictures of the page on laws: ``python docs/draw_laws.py [FOLDER]``."""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import contiga as cg

INK, PALE, GOOD, BAD = "#22303c", "#d8dee4", "#1a7f5a", "#c0392b"
LOADING = [[0, 0], [0.3, 1.0], [0.6, 1.3], [1.0, 3.0]]
UNLOADING = [[0, 0], [0.2, 0], [0.6, 0.4], [1.0, 2.0]]
SLOPE = 9.0


def _legs(*turns: float) -> np.ndarray:
    return np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(turns)])


def hysteresis(ax: Axes) -> None:
    """A cycle with a small one inside, between its two curves."""
    law = cg.StressLaw(LOADING, 1.0, unloading=UNLOADING, hysteresis_slope=SLOPE)
    path, one = _legs(0.0, 0.75, 0.45, 0.7, 0.95, 0.0), np.ones(1)
    memory, stress, lost = np.zeros((1, 2)), [], 0.0
    for depth in path:
        answer = law.respond(cg.LawInput(depth * one, 0 * one, one, None, None, 0.1, memory))
        memory = answer.memory
        stress.append(answer.force[0])
        assert answer.hysteresis is not None
        lost += float(answer.hysteresis[0])
    for table, colour, text in ((LOADING, GOOD, "loading"), (UNLOADING, BAD, "unloading")):
        ax.plot(*np.array(table).T, "--", color=colour, linewidth=1.2, label=text)
    ax.fill(path, stress, color=PALE, zorder=0, label=f"lost: {lost:.3f}")
    ax.plot(path, stress, color=INK, linewidth=1.8, label="stress")
    ax.set(xlabel="λ/t", ylabel="σ", title=f"between two curves, K = {SLOPE:g}")
    ax.legend(frameon=False)


def friction(ax: Axes) -> None:
    """A block dragged to and fro by ever more: it sticks, and then it slips."""
    law, up = cg.Coulomb(0.4, stiffness=100.0), np.array([[0.0, 0.0, 1.0]])
    path, one = _legs(0.0, 0.03, -0.03, 0.09, -0.09, 0.09), np.ones(1)
    memory, traction, last, lost = np.zeros((1, 7)), [], 0.0, 0.0
    for way in path:
        moved = np.array([[way - last, 0.0, 0.0]])
        inp = cg.FrictionInput(up, up, 10 * one, one, one, moved, 10 * moved, 0.1, memory)
        answer = law.respond(inp)
        memory, last = answer.memory, way
        traction.append(-answer.force[0, 0])
        lost += float(answer.lost[0])
    for cone in (-4.0, 4.0):
        ax.axhline(cone, linestyle="--", color=BAD, linewidth=1.2)
    ax.plot(path, traction, color=INK, linewidth=1.8)
    ax.set(xlabel="way", ylabel="−t", title="a block that sticks and slips, μF = 4, k = 100")
    ax.text(0.098, 0.0, f"lost: {lost:.2f}", ha="right")
    ax.set_xticks([-0.09, -0.03, 0.03, 0.09])


def main() -> None:
    """Write the picture into the folder given, ``docs/images`` by default."""
    default = Path(__file__).parent / "images"
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else default
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
    hysteresis(axes[0])
    friction(axes[1])
    for ax in axes:
        ax.spines[["top", "right"]].set_visible(False)
    figure.savefig(folder / "laws.png", dpi=110)


if __name__ == "__main__":
    main()

"""Draw the pictures of the page on forces: ``python docs/draw_forces.py [FOLDER]``."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import contiga as cg

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from examples import drop

INK, GOOD, BAD = "#22303c", "#1a7f5a", "#c0392b"
LAW = cg.StressLaw(2.0, thickness=60.0)


def energies(ax: Axes) -> None:
    """Total energy of a ball that falls on a pad, over time."""
    ball = cg.Body([cg.shapes.sphere(radius=drop.RADIUS, centre=(0.0, 0.0, drop.RADIUS))])
    for weights, colour in (("area", BAD), ("rest", GOOD)):
        course = drop.drop(ball, drop.pad(20.0), LAW, 0.02, weights=weights)
        time = 0.02 * np.arange(len(course.depth))
        ax.plot(time, 100.0 * course.error, color=colour, label=f'weights = "{weights}"')
    ax.set(xlabel="time [ms]", ylabel="change of energy [%]", title="free ball, elastic pad")
    ax.legend(frameon=False)


def deeper(ax: Axes) -> None:
    """Force of a ball on a coarse sheet, less the exact one, over its depth."""
    ball = cg.Body([cg.shapes.sphere(radius=drop.RADIUS)])
    pad, depth = drop.pad(20.0, half=80.0), np.linspace(0.5, 20.0, 160)
    exact = np.array([_exact(d) for d in depth])
    for options, colour, text in (
        ({"weights": "area"}, BAD, "measured areas"),
        ({}, INK, "nodes"),
        ({"quadrature": 6}, GOOD, "6 points a facet"),
    ):
        contact = cg.Contact(ball, pad, law=LAW, search="penetration", **options)
        places = [pad.points + np.array([3.1, -2.7, drop.RADIUS - d]) for d in depth]
        force = np.array([contact.start(points).total_force[2] for points in places])
        ax.plot(depth, force - exact, color=colour, label=text)
    ax.set(xlabel="depth [mm]", ylabel="error of the force [N]", title="mesh of 20 mm")
    ax.legend(frameon=False)


def _exact(depth: float) -> float:
    """Force of the ball: the integral of σ(λ/t) n over the plane, by Gauss's rule."""
    radius, height = drop.RADIUS, drop.RADIUS - depth
    node, weight = np.polynomial.legendre.leggauss(40)
    end = np.sqrt(radius**2 - height**2)
    r = 0.5 * end * (node + 1.0)
    far = np.hypot(r, height)
    ring = 2.0 * (radius - far) / 60.0 * height / far * 2.0 * np.pi * r
    return float(0.5 * end * (weight * ring).sum())


def main(folder: Path) -> None:
    """Both, side by side."""
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.2), layout="constrained")
    energies(axes[0])
    deeper(axes[1])
    for ax in axes:
        ax.spines[["top", "right"]].set_visible(False)
    figure.savefig(folder / "forces.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images")

"""Draw the pictures of the page on splines: ``python docs/draw_splines.py [FOLDER]``."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import contiga as cg
from contiga.report.style import INK, LINES, MUTED
from contiga.report.view import View

_SHAPE = (360, 330)
"""Width and height of a view, pixels."""
_TOWARDS = (-0.75, -0.5, -0.4)


def quarter_cylinder() -> cg.NurbsSurface:
    """Return the surface of the page: radius 2, height 3."""
    points = np.zeros((3, 2, 3))
    points[:, :, :2] = np.array([[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])[:, None]
    points[:, 1, 2] = 3.0
    weights = np.repeat([[1.0], [np.sqrt(0.5)], [1.0]], 2, axis=1)
    return cg.NurbsSurface((2, 1), ([0, 0, 0, 1, 1, 1], [0, 0, 1, 1]), points, weights)


def trimmed(quarter: cg.NurbsSurface) -> cg.Body:
    """Return the body of the page with a hole."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    ends = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    outer = [cg.shapes.line([*a, 0.0], [*b, 0.0]) for a, b in ends]
    hole = [cg.shapes.circle(radius=0.25, centre=[0.5, 0.5, 0.0])]
    return cg.Body([quarter], trims=[[outer, hole]])


def refinement(quarter: cg.NurbsSurface, path: Path) -> None:
    """Draw the control net, the refined one, and normals with an iso-curve."""
    figure, axes = plt.subplots(1, 3, figsize=(10.8, 3.7))
    refined = quarter.insert_knots(u=[0.25, 0.5, 0.75], v=[1 / 3, 2 / 3])
    scene = quarter.control_points.reshape(-1, 3)
    for ax, surface, title in (
        (axes[0], quarter, "3 × 2 control points"),
        (axes[1], refined, "knots inserted: 6 × 4, the same surface"),
    ):
        view = View(ax, scene, towards=_TOWARDS, shape=_SHAPE).surface(surface)
        view.net(surface).show()
        ax.set_title(title, fontsize=10, color=INK)
    view = View(axes[2], scene, towards=_TOWARDS, shape=_SHAPE).surface(quarter)
    uv = np.stack(np.meshgrid([0.1, 0.5, 0.9], [0.1, 0.4, 0.9]), axis=-1).reshape(-1, 2)
    for foot, normal in zip(quarter.evaluate(uv), quarter.normal(uv), strict=True):
        view.arrow(foot, foot + 0.6 * normal, color=LINES[0], mutation_scale=8)
    curve = quarter.isocurve(v=0.4)
    view.lines(curve.evaluate(np.linspace(*curve.domain, 81)), color=LINES[1], lw=2.0).show()
    axes[2].set_title("normals to the free side, iso-curve v = 0.4", fontsize=10, color=INK)
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def bodies(quarter: cg.NurbsSurface, path: Path) -> None:
    """Draw the closed cylinder, and the trimmed quarter with points and their feet."""
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.8))
    sides = [quarter.rotated([0, 0, 1], k * np.pi / 2) for k in range(4)]
    ceiling = cg.shapes.disc(radius=2.0, centre=[0, 0, 3.0])
    box = np.array([[x, y, z] for x in (-2, 2) for y in (-2, 2) for z in (0, 3)], dtype=float)
    view = View(axes[0], box, towards=_TOWARDS, shape=_SHAPE)
    floor = cg.shapes.disc(radius=2.0).flipped()
    view.surface(cg.Body([*sides, floor, ceiling])).show()
    axes[0].set_title("six patches, closed", fontsize=10, color=INK)
    shell = trimmed(quarter)
    angles = np.radians([10.0, 30.0, 45.0, 60.0, 80.0])
    heights = [0.6, 1.2, 1.6, 2.0, 2.6]
    points = np.column_stack([3.0 * np.cos(angles), 3.0 * np.sin(angles), heights])
    scene = np.concatenate([points, cg.clouds.sample(quarter, 9, 9)])
    view = View(axes[1], scene, towards=_TOWARDS, shape=_SHAPE).surface(shell)
    for point, foot in zip(points, shell.project(points).point, strict=True):
        view.lines([point, foot], color=MUTED, lw=1.0).dots([foot], color=LINES[1], ms=5.0)
    view.dots(points, color=INK, ms=5.0).show()
    axes[1].set_title("trimmed, with points and their feet", fontsize=10, color=INK)
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main() -> None:
    """Write the pictures into the folder given, ``docs/images`` by default."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images"
    quarter = quarter_cylinder()
    refinement(quarter, folder / "splines_quarter.png")
    bodies(quarter, folder / "splines_bodies.png")


if __name__ == "__main__":
    main()

"""The picture of routed paths over their bodies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath

import numpy as np

from contiga.errors import FileError
from contiga.extras import require
from contiga.io.out.files import atomic_write
from contiga.previewing.stage import COLOURS
from contiga.report.style import INK, LINES
from contiga.report.view import View
from contiga.routing.path import Path

_SIZE, _DPI = (9.6, 7.2), 100
_N_SAMPLES = 40
"""Approximate number of points of a path that determine the viewing direction."""


def check_picture(file: FilePath) -> FilePath:
    """Return `file`; refuse a name that is no picture before anything is routed.

    Raises
    ------
    FileError
        Another suffix than .png.
    MissingPackageError
        matplotlib is not installed.
    """
    if file.suffix.lower() != ".png":
        raise FileError("a picture of paths is a .png", where=str(file), allowed=".png")
    require("a picture", "matplotlib")
    return file


def draw_routes(paths: Sequence[Path], file: FilePath) -> None:
    """Draw paths and their bodies to a PNG file; contact with a body is drawn thick.

    Of eight viewing directions the first that shows most points in contact from outside is taken;
    four from above come first.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    bodies = list(dict.fromkeys(body for path in paths for body in path.over.bodies))
    meshes = [body.tessellate(1e-3 * body.size) for body in bodies]
    points = [path.points for path in paths]
    scene = np.concatenate([*(mesh.vertices for mesh in meshes), *points])
    pixels = round(_SIZE[0] * _DPI), round(_SIZE[1] * _DPI)
    normals = np.concatenate([path.normal[:: len(path.normal) // _N_SAMPLES + 1] for path in paths])
    directions = [
        np.array([x, y, z]) for z in (-0.45, 0.45) for x in (-0.55, 0.55) for y in (0.75, -0.75)
    ]
    towards = max(directions, key=lambda d: float((normals @ d < 0.0).sum()))
    view = View(axes, scene, towards=towards, shape=pixels)
    for k, mesh in enumerate(meshes):
        view.surface(mesh, COLOURS[k % len(COLOURS)])
    for path in paths:
        # Raised above the surface by the error of its triangles.
        lifted = path.outside(path.points, 3e-3 * path.over.size)
        view.lines(lifted, color=INK, lw=1.4)
        for wrap in path.wraps:
            rows = (path.arc >= wrap.start) & (path.arc <= wrap.end)
            if rows.sum() > 1:
                view.lines(lifted[rows], color=LINES[1], lw=3.0)
        view.dots(path.points[[0, -1]], color=INK, ms=6.0)
    view.show()
    with atomic_write(file) as temporary:
        figure.savefig(temporary, format="png")

"""Draw shaded surfaces, and lines, dots and arrows, faint where a surface hides them."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.records import FloatArray
from contiga.rendering import shading
from contiga.rendering.camera import look, project
from contiga.report.style import INK, LINES, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from contiga.geometry.surface import NurbsSurface
    from contiga.masters.protocol import Master


_SAMPLES = 2
"""Pixels drawn per pixel shown, in each direction."""
_BEHIND_OPACITY = 0.22
"""Opacity of lines behind a surface, over that in front of it."""
_CHORD_TOL = 4e-4
"""Chord tolerance of the drawing, over the scene's size."""


class View:
    """A shaded 3D picture on matplotlib axes.

    Surfaces are shaded in the order in which they are given; lines and dots come over them, faint
    where a surface hides them.

    Parameters
    ----------
    axes : where to draw; its frame is removed
    scene : (n, 3) points, all of which are to be in the picture
    towards : (3,) direction the eye looks in
    shape : width and height of the picture, pixels
    """

    def __init__(
        self,
        axes: Axes,
        scene: ArrayLike,
        *,
        towards: ArrayLike = (-0.55, 0.75, -0.45),
        shape: tuple[int, int] = (600, 450),
    ) -> None:
        points = np.asarray(scene, dtype=np.float64).reshape(-1, 3)
        columns, rows = shape
        size = (rows * _SAMPLES, columns * _SAMPLES)
        self._axes = axes
        self._camera = look(
            np.asarray(towards, dtype=np.float64), np.array([0, 0, 1.0]), points, size
        )
        self._span = max(float(np.ptp(points, axis=0).max()), 1e-300)
        self._picture = np.ones((*size, 3), dtype=np.float32)
        self._depth = np.full(size, np.inf)
        axes.set_axis_off()
        axes.set_xlim(0.0, columns)
        axes.set_ylim(rows, 0.0)
        axes.set_aspect("equal")

    def surface(
        self,
        shape: NurbsSurface | Master,
        colour: str = "#9fb3c8",
        opacity: float = 1.0,
        *,
        hides: bool = True,
        back: str | None = None,
        colours: ArrayLike | None = None,
    ) -> View:
        """Shade a surface and draw its borders and creases; it hides what is behind it if `hides`.

        Surfaces drawn before hide parts of it. `back` is the colour of facets whose normals point
        away from the eye. `colours` (n, 3) of the vertices of a triangle mesh, red, green and blue
        from 0 to 1, replace `colour`; they are interpolated between vertices.

        Returns
        -------
        View
            This view, so that calls can be chained, as all that draw return it.
        """
        from matplotlib.colors import to_rgb

        mesh = shape.tessellate(_CHORD_TOL * self._span)
        layer = shading.mesh_layer(self._camera, mesh.vertices, mesh.triangles)
        rgb = np.array(to_rgb(colour))
        if colours is not None:
            channels = np.asarray(colours, dtype=np.float64).T
            rgb = np.stack([layer.at_pixels(channel) for channel in channels], axis=1)
        if back is not None:
            corners = mesh.corners()
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            is_back = ((corners[:, 0] - self._camera.eye) * normals).sum(axis=1) > 0.0
            is_back = is_back[layer.buffer.owner[layer.seen]]
            rgb = np.where(is_back[:, None], to_rgb(back), rgb)
        # of surfaces at the same depth the first stays
        before = np.nextafter(self._depth, -np.inf)
        shading.paint(self._picture, layer, rgb, self._span, before, opacity)
        nearest = np.minimum(self._depth, layer.buffer.depth)
        edges = shading.drawn_edges(mesh.vertices, mesh.triangles)
        ink = shading.line_ink(self._camera, mesh.vertices, edges, nearest, 2e-3 * self._span)
        self._picture[ink] *= 0.55
        if hides:
            self._depth = nearest
        return self

    def lines(self, points: ArrayLike, **style: Any) -> View:
        """Draw a polyline through `points` (k, 3), with matplotlib's line styles.

        Parts behind a surface are faint. A `label` becomes one entry of a legend.
        """
        fine = _fine(np.asarray(points, dtype=np.float64), 0.01 * self._span)
        at, seen = self._projected(fine)
        style_ = {"color": INK, "lw": 1.0, "solid_capstyle": "round", **style}
        label = style_.pop("label", None)
        for part, opacity in ((seen, 1.0), (~seen, _BEHIND_OPACITY)):
            # a segment is visible if one of its ends is
            is_drawn = part | np.roll(part, 1) | np.roll(part, -1) if opacity == 1.0 else part
            pieces = np.where(is_drawn[:, None], at, np.nan)
            alpha = opacity * style_.get("alpha", 1.0)
            self._axes.plot(*pieces.T, **{**style_, "alpha": alpha})
        if label:
            self._axes.plot([], [], label=label, **style_)
        return self

    def net(self, surface: NurbsSurface, **style: Any) -> View:
        """Draw the control net of a surface: its points, joined along both directions."""
        net = surface.control_points
        style_ = {"color": LINES[1], "lw": 0.9, "ls": (0, (4, 3)), **style}
        for row in [*net, *net.transpose(1, 0, 2)]:
            self.lines(row, **style_)
        return self.dots(net.reshape(-1, 3), color=style_["color"], ms=3.6)

    def iso_lines(self, surface: NurbsSurface, count: int = 11, **style: Any) -> View:
        """Draw iso-parametric lines of `surface`, `count` in each direction."""
        (u0, u1), (v0, v1) = surface.domain
        along_u, along_v = np.linspace(u0, u1, 121), np.linspace(v0, v1, 121)
        style_ = {"color": "white", "lw": 0.5, "alpha": 0.75, **style}
        for v in np.linspace(v0, v1, count):
            self.lines(surface.evaluate(np.column_stack([along_u, np.full(121, v)])), **style_)
        for u in np.linspace(u0, u1, count):
            self.lines(surface.evaluate(np.column_stack([np.full(121, u), along_v])), **style_)
        return self

    def dots(self, points: ArrayLike, **style: Any) -> View:
        """Draw markers at `points` (k, 3) with matplotlib's styles, faint behind a surface."""
        at, seen = self._projected(np.asarray(points, dtype=np.float64).reshape(-1, 3))
        style_ = {"color": LINES[0], "ls": "", "marker": "o", "ms": 3.0, "mew": 0.0, **style}
        label = style_.pop("label", None)
        for part, opacity in ((~seen, 2.0 * _BEHIND_OPACITY), (seen, 1.0)):
            self._axes.plot(*at[part].T, alpha=opacity, **style_)
        if label:
            self._axes.plot([], [], label=label, **style_)
        return self

    def arrow(self, start: ArrayLike, end: ArrayLike, **style: Any) -> View:
        """Draw an arrow from `start` to `end` (3,), in front of everything."""
        a, b = self._projected(np.array([start, end], dtype=np.float64))[0]
        style_ = {"color": INK, "lw": 1.4, "shrinkA": 0.0, "shrinkB": 0.0, **style}
        self._axes.annotate("", b, a, arrowprops={"arrowstyle": "-|>", **style_})
        return self

    def text(self, at: ArrayLike, text: str, **style: Any) -> View:
        """Write `text` beside the point `at` (3,)."""
        (place,) = self._projected(np.array([at], dtype=np.float64))[0]
        style_ = {"textcoords": "offset points", "xytext": (5, 3), "fontsize": 8.5, **style}
        self._axes.annotate(text, place, **style_)
        return self

    def show(self, *, triad: bool = True) -> None:
        """Draw the shaded surfaces under the lines, and the axes of the world at the lower left.

        To be called last. An axis along the line of sight is not named.
        """
        columns, rows = self._axes.get_xlim()[1], self._axes.get_ylim()[0]
        shaded = shading.shrunk(self._picture, _SAMPLES)
        self._axes.imshow(shaded, extent=(0.0, columns, rows, 0.0), zorder=0, aspect="equal")
        if not triad:
            return
        origin, length = np.array([0.075 * columns, rows - 0.075 * columns]), 0.055 * columns
        style_ = {"arrowstyle": "-|>", "color": MUTED, "lw": 0.9, "shrinkA": 0, "shrinkB": 0}
        for axis, name in zip(self._camera.axes.T[:, :2], "xyz", strict=True):
            tip = tuple(origin + length * axis)
            self._axes.annotate("", tip, tuple(origin), arrowprops={**style_, "mutation_scale": 6})
            x, y = origin + 1.35 * length * axis
            if np.linalg.norm(axis) > 0.2:
                self._axes.text(x, y, name, ha="center", va="center", fontsize=7.5, color=MUTED)

    def placed(self, points: ArrayLike) -> FloatArray:
        """Return the places (n, 2) of points (n, 3) in the picture.

        They are columns and rows from the upper left.
        """
        return self._projected(np.asarray(points, dtype=np.float64).reshape(-1, 3))[0]

    def sees(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return a mask (n,) of the points (n, 3) that no shaded surface hides."""
        return self._projected(np.asarray(points, dtype=np.float64).reshape(-1, 3))[1]

    def _projected(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return places (n, 2) in the picture and a mask (n,) of the points that nothing hides.

        A point up to 0.6 % of the size of the scene behind a surface still counts as seen, and one
        outside the picture is compared with the pixel nearest to it.
        """
        screen = project(self._camera, points)
        rows, columns = self._depth.shape
        column = np.clip(np.nan_to_num(np.rint(screen[:, 0])), 0, columns - 1).astype(np.intp)
        row = np.clip(np.nan_to_num(np.rint(screen[:, 1])), 0, rows - 1).astype(np.intp)
        with np.errstate(invalid="ignore"):
            seen = screen[:, 2] <= self._depth[row, column] + 6e-3 * self._span
        return screen[:, :2] / _SAMPLES, seen


def _fine(points: FloatArray, step: float) -> FloatArray:
    """Return the polyline with points at most `step` apart, so that parts of it can be hidden."""
    pieces = [points[:1]]
    for a, b in pairwise(points):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
        share = np.linspace(0.0, 1.0, count + 1)[1:, None]
        pieces.append(a + share * (b - a))
    return np.concatenate(pieces)

"""The still picture of the peak: the scene as it stands, and the contact seen through the body."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray
from contiga.report import shading
from contiga.report.camera import Camera, look, unit
from contiga.report.peak import Peak

Picture = NDArray[np.float32]

BODY = np.array([0.56, 0.62, 0.69])
SLAVE = np.array([0.90, 0.88, 0.83])
INK = np.array([0.13, 0.15, 0.18])
SCALE = ("#ffe9a8", "#fdbf5a", "#f4813f", "#d9433f", "#a01c5b", "#4a0f57")
"""Penetration from shallow to deep; lightness falls all the way, so it reads without colour."""
_SAMPLES = 2
"""Pixels drawn per pixel shown, in each direction."""


def colour_map() -> Any:
    """`SCALE` as a matplotlib colour map."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("penetration", SCALE)


def upwards(peak: Peak) -> FloatArray:
    """The world axis that is up in the pictures: z, or y where all is in one plane."""
    points = np.vstack([peak.body_points, peak.slave_points])
    flat = np.ptp(points[:, 2]) <= 1e-9 * max(float(np.ptp(points)), 1e-300)
    return np.array([0.0, 1.0, 0.0]) if flat else np.array([0.0, 0.0, 1.0])


def _sideways(peak: Peak, up: FloatArray) -> FloatArray:
    side = np.cross(peak.direction, up)
    return unit(side) if np.linalg.norm(side) > 0.3 else np.array([0.6, -0.8, 0.0])


def outside_direction(peak: Peak) -> FloatArray:
    """(3,) where the eye looks that sees the scene from the side and a little from above."""
    up = upwards(peak)
    level = peak.direction - (peak.direction @ up) * up
    return unit(-_sideways(peak, up) + 0.45 * level - 0.30 * up)


def outside_view(peak: Peak, size: tuple[int, int]) -> Camera:
    """The whole scene from the side, a little from above and from behind the body."""
    points = np.vstack([peak.body_points, peak.slave_points])
    points = points[np.isfinite(points).all(axis=1)]
    return look(outside_direction(peak), upwards(peak), points, size)


def through_view(peak: Peak, size: tuple[int, int]) -> Camera:
    """The contact from inside the body, along the mean normal and a little from the side."""
    if not peak.in_contact.any():
        return outside_view(peak, size)
    up = upwards(peak)
    towards = peak.direction - 0.42 * _sideways(peak, up) - 0.16 * up
    patch = peak.slave_points[peak.in_contact]
    centre = (patch.min(axis=0) + patch.max(axis=0)) / 2.0
    # enough of the part around the contact to see where on it that is
    least = 0.06 * float(np.ptp(peak.body_points, axis=0).max())
    reach = max(1.7, least / max(float(np.abs(patch - centre).max()), 1e-300))
    return look(towards, up, centre + reach * (patch - centre), size)


def _slave_layer(camera: Camera, peak: Peak) -> shading.Layer:
    if len(peak.slave_triangles):
        return shading.mesh_layer(camera, peak.slave_points, peak.slave_triangles)
    radius = float(np.clip(0.35 * camera.size[0] / np.sqrt(len(peak.slave_points) + 1.0), 3, 14))
    return shading.cloud_layer(camera, peak.slave_points, radius)


def slave_colours(layer: shading.Layer, peak: Peak) -> FloatArray:
    """(k, 3) colours of the slave's pixels: by penetration in contact, plain elsewhere."""
    deepest = max(float(peak.penetration.max(initial=0.0)), 1e-300)
    touching = layer.at_pixels(peak.in_contact.astype(np.float64)) > 0.5
    depth = layer.at_pixels(peak.penetration) / deepest
    return np.asarray(np.where(touching[:, None], colour_map()(depth)[:, :3], SLAVE))


def render(camera: Camera, peak: Peak, *, through: bool) -> Picture:
    """(h, w, 3) picture; with `through` the body is only hinted at."""
    span = float(np.ptp(np.nan_to_num(camera.axes @ peak.body_points.T)))
    # single precision is plenty for eight bits a colour and halves the memory
    picture = np.ones((*camera.size, 3), dtype=np.float32)
    body = shading.mesh_layer(camera, peak.body_points, peak.body_triangles)
    slave = _slave_layer(camera, peak)
    picture[slave.seen] = shading.lit(slave, slave_colours(slave, peak), span)
    if through:
        facing = -body.normal[body.seen][:, 2]
        veil = (0.05 + 0.38 * (1.0 - np.clip(facing, 0.0, 1.0)) ** 2)[:, None]
        picture[body.seen] = (1.0 - veil) * picture[body.seen] + veil * (0.75 * BODY)
        _draw_dots(camera, peak, picture)
        return picture
    front = (body.buffer.depth < slave.buffer.depth)[body.seen]
    picture[body.seen] = np.where(front[:, None], shading.lit(body, BODY, span), picture[body.seen])
    nearest = np.minimum(body.buffer.depth, slave.buffer.depth)
    for points, triangles in (
        (peak.body_points, peak.body_triangles),
        (peak.slave_points, peak.slave_triangles),
    ):
        edges = shading.free_edges(triangles)
        inked = shading.line_ink(camera, points, edges, nearest, 2e-3 * span) > 0.0
        picture[inked] = 0.6 * picture[inked] + 0.4 * INK
    return picture


def _draw_dots(camera: Camera, peak: Peak, picture: Picture) -> None:
    patch = peak.slave_points[peak.in_contact]
    if len(patch):
        radius = float(np.clip(0.07 * camera.size[0] / np.sqrt(len(patch)), 1.2, 5.0))
        dots = shading.cloud_layer(camera, patch, radius).seen
        picture[dots] = 0.45 * picture[dots] + 0.55 * INK


def draw_still(peak: Peak, path: Path, *, length: str, time: str) -> None:
    """Write the picture of `peak` as PNG to `path`; `length` and `time` are the units' names."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    rows, columns = 720, 760
    size = (rows * _SAMPLES, columns * _SAMPLES)
    views = (
        (outside_view(peak, size), False, f"At t = {peak.time:g} {time}"),
        (through_view(peak, size), True, "The contact, seen through the body"),
    )
    figure = Figure(figsize=(16.4, 8.4), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    for k, (camera, through, title) in enumerate(views):
        axes = figure.add_axes((0.005 + 0.466 * k, 0.03, 0.4634, 0.857))
        axes.imshow(shading.shrunk(render(camera, peak, through=through), _SAMPLES))
        axes.set_axis_off()
        axes.text(0.03, 1.03, title, transform=axes.transAxes, fontsize=15, color=INK, va="bottom")
    deepest = float(peak.penetration.max(initial=0.0))
    if deepest > 0.0:
        bar = figure.add_axes((0.948, 0.2, 0.011, 0.52))
        mappable = ScalarMappable(Normalize(0.0, deepest), colour_map())
        figure.colorbar(mappable, cax=bar)
        bar.set_title(f"Penetration\n{length}", fontsize=11, color=INK, loc="left", pad=10)
        bar.tick_params(labelsize=11, colors=tuple(INK), length=3)
        bar.yaxis.set_major_locator(_few_ticks())
        for spine in bar.spines.values():
            spine.set_visible(False)
    figure.savefig(path, format="png")


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(5)

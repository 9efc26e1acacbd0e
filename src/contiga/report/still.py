"""The still picture of the peak: both views side by side, with titles and colour bars.

Composed with Pillow: importing matplotlib takes longer than the drawing.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contiga.rendering import shading
from contiga.rendering.camera import Camera, project
from contiga.report.coloured import ColouredField, fields_of, first_field, region_colours
from contiga.report.colours import scale_colours
from contiga.report.labels import spread
from contiga.report.peak import Peak
from contiga.report.run_folder import Units
from contiga.report.scene import outside_view, render, through_view
from contiga.report.style import INK, number

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFont import FreeTypeFont

_HEIGHT, _ONE_VIEW, _TWO_VIEWS = 840, 770, 1640
"""Height of the picture, and its widths, pixels."""
_COLUMNS, _ROWS, _TOP, _LEFT, _RIGHT = 760, 720, 95, 8, 772
"""Width and height of a view, the row where views begin, and the columns where they do, pixels."""
_BAR_COLUMNS, _BAR_ROWS, _BAR_TOP, _BAR_ROOM = 18, 437, 235, 80
"""Width, height and upper end of a colour bar, and its width with its numbers, pixels."""
SAMPLES = 2
"""Pixels drawn per pixel shown, in each direction."""
_MAX_TICKS, _TICK_DIGITS = 5, (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""Largest number of ticks of a colour bar without zero, and the digits of the smallest."""
_MAX_LABELS = 12
"""Largest number of regions that are named in the picture; more names would hide it."""


def draw_still(peak: Peak, path: Path, units: Units) -> None:
    """Write the picture of `peak` as PNG to `path`.

    Without a contact it has the view from outside only. That view shows the von Mises stress if
    facets have one, and else the field of the other view.
    """
    from PIL import Image

    touches = bool(peak.in_contact.any())
    field = first_field(peak, units)
    stress = fields_of(peak, units).get("von_mises") if len(peak.slave_triangles) else None
    picture = Image.new("RGB", (_TWO_VIEWS if touches else _ONE_VIEW, _HEIGHT), "white")
    title = f"At t = {number(peak.time)} {units.time}".rstrip()
    bar_width = 0 if stress is None else _BAR_ROOM
    size = (_ROWS * SAMPLES, (_COLUMNS - bar_width) * SAMPLES)
    view = render(outside_view(peak, size), peak, stress or field, through=False)
    put_view(picture, view, title if touches else f"{title}, nothing touches", _LEFT)
    if touches:
        camera = through_view(peak, (_ROWS * SAMPLES, _COLUMNS * SAMPLES))
        view = render(camera, peak, field, through=True)
        put_view(picture, view, "The contact, seen through the body", _RIGHT)
        _label_outlines(picture, camera, peak)
        put_bar(picture, field, _RIGHT + _COLUMNS + 8)
    if stress is not None:
        put_bar(picture, stress, 20)
    _save(picture, path)


def halves(picture: bytes) -> list[bytes]:
    """Cut a still picture (PNG) of two views into both, as PNG, from left to right."""
    from PIL import Image

    parts = []
    with Image.open(BytesIO(picture)) as image:
        for start, end in ((0, _ONE_VIEW), (_ONE_VIEW, image.width)):
            file = BytesIO()
            _save(image.crop((start, 0, end, image.height)), file)
            parts.append(file.getvalue())
    return parts


def _save(picture: Image, file: Path | BytesIO) -> None:
    picture.save(file, format="png", compress_level=1)  # in a fifth of the time, 2/5 larger


def put_view(picture: Image, view: shading.Picture, title: str, left: int, top: int = _TOP) -> None:
    """Shrink a view and paste it, right-aligned in `_COLUMNS` columns from `left` on.

    Its first row becomes `top`. Its title stands above it, or in it if there is no room.
    """
    from PIL import Image, ImageDraw

    pixels = (255.0 * shading.shrunk(view, SAMPLES)).round().astype(np.uint8)
    picture.paste(Image.fromarray(pixels), (left + _COLUMNS - pixels.shape[1], top))
    ImageDraw.Draw(picture).text((left + 23, max(top - 23, 45)), title, INK, _font(21), anchor="ls")


def _label_outlines(picture: Image, camera: Camera, peak: Peak) -> None:
    """Write the numbers of `_MAX_LABELS` regions at most above their outlines in the right view."""
    from PIL import ImageDraw

    draw, font = ImageDraw.Draw(picture), _font(17)
    colours = region_colours(peak.outlines)
    several = len({contact for contact, _ in colours}) > 1
    names, tops, sizes = [], [], []
    for key in list(colours)[:_MAX_LABELS]:
        lines = [o.points for o in peak.outlines if (o.contact, o.cluster) == key]
        screen = project(camera, np.concatenate(lines)) / SAMPLES
        top = screen[np.argmin(screen[:, 1])]
        names.append(f"cluster {key[0]}.{key[1]}" if several else f"cluster {key[1]}")
        tops.append([top[0], top[1] - 16.0])
        sizes.append([draw.textlength(names[-1], font), 18.0])
    view_size = np.array([_COLUMNS, _ROWS], dtype=np.float64)
    places = spread(np.reshape(tops, (-1, 2)), np.reshape(sizes, (-1, 2)), view_size)
    places += [_RIGHT, _TOP]
    for name, at, colour in zip(names, places, colours.values(), strict=False):
        draw.text(tuple(at), name, colour, font, anchor="mm", stroke_width=2, stroke_fill="white")


def put_bar(picture: Image, field: ColouredField, column: int) -> None:
    """Draw a colour bar of `field` from `column` on, with a tip if some values are larger."""
    from PIL import Image, ImageDraw

    draw, right = ImageDraw.Draw(picture), column + _BAR_COLUMNS
    shares = 1.0 - (np.arange(_BAR_ROWS) + 0.5) / _BAR_ROWS
    colours = np.repeat(scale_colours(shares)[:, None], _BAR_COLUMNS, axis=1)
    picture.paste(Image.fromarray((255.0 * colours).round().astype(np.uint8)), (column, _BAR_TOP))
    top = _BAR_TOP
    if field.cut:
        top -= 20
        tip = (column, _BAR_TOP - 1), (column + _BAR_COLUMNS / 2, top), (right - 1, _BAR_TOP - 1)
        draw.polygon(tip, tuple((255.0 * colours[0, 0]).round().astype(int)))
    for value in _ticks(field.top):
        row = _BAR_TOP + (1.0 - value / field.top) * (_BAR_ROWS - 1)
        draw.line([(right, row), (right + 3, row)], INK)
        draw.text((right + 8, row), number(value, 3), INK, _font(15), anchor="lm")
    title = f"{field.label}\n{field.unit}"
    draw.text((column, top - 14), title, INK, _font(15), anchor="ld")


def _ticks(top: float) -> list[float]:
    """Return at most six round numbers from 0 to `top`, or up to a step below it.

    >>> _ticks(2.5), _ticks(6e-5)
    ([0.0, 0.5, 1.0, 1.5, 2.0, 2.5], [0.0, 1.5e-05, 3e-05, 4.5e-05, 6e-05])
    """
    min_step = top / _MAX_TICKS
    power = 10.0 ** np.floor(np.log10(min_step))
    step = power * next(k for k in _TICK_DIGITS if k * power >= min_step * (1.0 - 1e-9))
    return [float(f"{k * step:.12g}") for k in range(int(top / step * (1.0 + 1e-9)) + 1)]


@cache
def _font(size: int) -> FreeTypeFont:
    """Return a font of matplotlib: those of Pillow lack squares, Greek and accents."""
    from PIL import ImageFont

    spec = find_spec("matplotlib")
    places = [] if spec is None else spec.submodule_search_locations or []
    for place in places:
        file = Path(place) / "mpl-data/fonts/ttf/DejaVuSans.ttf"
        if file.is_file():
            return ImageFont.truetype(file, size)
    from matplotlib.font_manager import findfont  # a package that keeps them elsewhere

    return ImageFont.truetype(findfont("DejaVu Sans"), size)

"""Colours, number formats and the page layout of reports, for pictures and pages of one's own.

>>> from contiga.report import style
>>> style.number(12.5), style.INK
('12.5', '#21262d')
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from typing import Any

from contiga.io.out.palette import GRID as GRID
from contiga.io.out.palette import INK as INK
from contiga.io.out.palette import LINES as LINES
from contiga.io.out.palette import MUTED as MUTED
from contiga.io.out.palette import PAPER as PAPER

BODY, SLAVE = "#8f9eb0", "#d1c9b8"
TIES = {"spring": "#b07d1e", "joint": "#7a3b8f"}
"""Colours of what ties bodies together."""
SCALE = ("#ffe9a8", "#fdbf5a", "#f4813f", "#d9433f", "#a01c5b", "#4a0f57")
"""Colours from small to large; lightness falls throughout, so that it reads without colour."""
REGIONS = ("#12708f", "#5b3fa8", "#2f7d3b", "#b0306a", "#8a5a00", "#3a4d8f", "#00796b", "#7a4a2a")
"""Colours of regions of contact, in turn: cool and dark, apart from `SCALE`."""

_PAGE_COLOURS = {
    "paper": PAPER,
    "ink": INK,
    "muted": MUTED,
    "line": "#e3e6ea",
    "soft": "#f6f7f9",
    "faint": "#c9ced5",
    "accent": LINES[0],
    "good": "#2f7d4a",
    "bad": "#b3261e",
    "bad-soft": "#fdf0ef",
}
"""Variables of CSS that all rules of pages name their colours by, on light pages."""


def inverted(colour: str) -> str:
    """Return the colour of a dark page for one of a light page: inverted lightness, same hue.

    Colours are ``#rrggbb``. All channels are shifted by 280 less the sum of the largest and the
    smallest, up to 255: white becomes a dark grey, not black. `scheme.js` does the same with the
    colours of figures.

    >>> inverted("#ffffff"), inverted("#21262d"), inverted("#1f5f8b")
    ('#191919', '#ebf0f7', '#8dcdf9')
    """
    channels = bytes.fromhex(colour[1:])
    shift = 280 - max(channels) - min(channels)
    return "#" + bytes(min(255, channel + shift) for channel in channels).hex()


def swatch(colour: str) -> str:
    """Return a patch of a colour of figures as HTML, for the legends of pages."""
    return f'<span class="swatch" style="--light:{colour};--dark:{inverted(colour)}"></span>'


def colour_map() -> Any:
    """Return `SCALE` as a matplotlib colour map."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("contact", SCALE)


def number(value: float, digits: int = 4) -> str:
    """Return `value` as text with `digits` significant digits; thousands are grouped.

    Trailing zeros after the point are left out; digits before it are all written. Magnitudes below
    1e-3 or from 1e9 on have an exponent. NaN and infinity are a dash.

    >>> number(12345.678), number(0.00012345), number(3.0)
    ('12\N{NARROW NO-BREAK SPACE}346', '1.234e-04', '3')
    """
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if size < -3 or size > 8:
        return f"{value:.{digits - 1}e}"
    text = f"{value:,.{max(0, digits - 1 - size)}f}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    return text.rstrip("0").rstrip(".") if "." in text else text


def page(title: str, body: str, *, css: str = "", script: str = "") -> str:
    """Return a whole HTML page in the style of the report, which needs no network.

    It is dark on the screen where the system is dark, and light on paper. Rules in `css` name
    colours by the variables that `style.css` uses.

    Parameters
    ----------
    title : of the browser's tab, plain text
    body : HTML of the page; like `css` and `script` it is inserted as it is, without escapes
    css : rules beside those of the report
    script : JavaScript in the head of the page, which runs before the body exists
    """
    light, dark = (
        "".join(f" --{name}: {turn(colour)};" for name, colour in _PAGE_COLOURS.items())
        for turn in (str, inverted)
    )
    rules = (
        f":root {{ color-scheme: light;{light} }}\n"
        f"@media screen and (prefers-color-scheme: dark) {{\n"
        f":root {{ color-scheme: dark;{dark} }}\n.swatch {{ --shown: var(--dark); }}\n}}\n"
    )
    rules += files("contiga.report").joinpath("style.css").read_text(encoding="utf-8") + css
    scripts = f"<script>{script}</script>" if script else ""
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(title)}</title><link rel="icon" href="data:,"><style>{rules}</style>'
        f"{scripts}</head><body><main>\n{body}\n</main></body></html>\n"
    )


def span_of(criterion: Mapping[str, float]) -> str:
    """Return the times of a criterion as text: ``start to end``, or one time if they read alike.

    >>> span_of({"start": 1.0, "end": 2.5}), span_of({"start": 2.0, "end": 2.0})
    ('1 to 2.5', '2')
    """
    start, end = number(criterion["start"]), number(criterion["end"])
    return end if start == end else f"{start} to {end}"

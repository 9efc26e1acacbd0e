"""Figures of plotly as plain data of its published schema, and their HTML.

Plotly's own Python objects check every property anew for every page, which with their import took
longer than the rest of a page. Tests check the figures with them instead.
"""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Iterable
from dataclasses import dataclass, field
from importlib.resources import files
from importlib.util import find_spec
from json import dumps
from pathlib import Path
from typing import Any

import numpy as np

Trace = dict[str, Any]
"""One item of the legend, with all that it draws."""
_SIZES = {"i": (1, 2, 4), "u": (1, 2, 4), "f": (4, 8)}
"""Bytes of the numbers of a browser's arrays, by their kind."""


@dataclass
class Figure:
    """The data of one figure for plotly's script."""

    data: list[Trace] = field(default_factory=list)
    layout: dict[str, Any] = field(default_factory=dict)


def plotly_script() -> str:
    """Return the script of plotly and the scripts that draw its figures in the colours of the page.

    Its modules are not imported. The scripts print the figures, too.
    """
    spec = find_spec("plotly")
    assert spec is not None
    assert spec.origin is not None
    path = Path(spec.origin).parent / "package_data" / "plotly.min.js"
    folder = files("contiga.report")
    scripts = [path, folder.joinpath("scheme.js"), folder.joinpath("print.js")]
    return "\n".join(script.read_text(encoding="utf-8") for script in scripts)


def side_by_side(figures: Iterable[str]) -> str:
    """Return figures (HTML) in frames, two in a row; the last of an odd number has full width.

    CSS cannot do this: while a page is read, no frame is known to be the last.
    """
    figures = list(figures)
    classes = ["frame"] * len(figures)
    if len(figures) % 2:
        classes[-1] = "frame whole"
    frames = (f'<div class="{k}">{html}</div>' for k, html in zip(classes, figures, strict=True))
    return f'<div class="panels">{"".join(frames)}</div>'


def embedded(figure: Figure, name: str, config: dict[str, Any]) -> str:
    """Return a figure as HTML of a page that has the script of plotly; `name` becomes its id."""
    arguments = ",".join(map(as_json, (figure.data, figure.layout, config)))
    return (
        f'<div style="height:{figure.layout["height"]}px; width:100%;">'
        f'<div id="{name}" class="plotly-graph-div" style="height:100%; width:100%;"></div>'
        f'<script>Plotly.newPlot("{name}",{arguments});</script></div>'
    )


def as_json(value: Any) -> str:
    """Return JSON that may stand in a script: nothing in it ends the script, and NaN is null.

    Arrays become typed arrays of a browser, integers of the smallest type that fits; empty ones and
    those of other types become lists. NaN stays in typed arrays.

    >>> as_json({"name": "</script>", "x": [1.5, float("nan")], "y": np.array([0.0, 2.0])})
    '{"name":"\\\\u003c/script>","x":[1.5,null],"y":{"dtype":"f8","bdata":"AAAAAAAAAAAAAAAAAAAAQA=="}}'
    """
    text = dumps(_plain(value), separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c")


def _plain(value: Any) -> Any:
    """Return a value as `dumps` takes it, with arrays as base64 of little-endian numbers.

    Arrays of integers are stored in the smallest type that holds them; arrays of other types, and
    empty ones, become lists. Numbers that are not finite become None outside base64.
    """
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if not isinstance(value, np.ndarray):
        return None if isinstance(value, float) and not math.isfinite(value) else value
    if value.size and value.dtype.kind in "iu":
        ends = (np.min_scalar_type(end) for end in (value.min(), value.max()))
        value = value.astype(np.result_type(*ends))
    kind = value.dtype
    if not value.size or kind.itemsize not in _SIZES.get(kind.kind, ()):
        return _plain(value.tolist())
    raw = value.astype(kind.newbyteorder("<")).tobytes()
    packed = {"dtype": f"{kind.kind}{kind.itemsize}", "bdata": b64encode(raw).decode("ascii")}
    shape = {"shape": ", ".join(map(str, value.shape))} if value.ndim > 1 else {}
    return packed | shape

"""Colours of values on a map: between two limits, or by bands as in rating protocols."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.records import FloatArray
from contiga.report.style import PAPER, SCALE, colour_map, number

RATED = ("#3a9d4f", "#f2d43d", "#f0973a", "#8f5a2a", "#c8352f")
"""Colours from good to poor, as the five bands of pedestrian protection protocols."""


class Shades(NamedTuple):
    """Colours of values."""

    limits: tuple[float, float]
    """Values at which the colours begin and end."""
    bands: tuple[float, ...] = ()
    """Values at which one colour ends and the next begins; empty for continuous colours."""

    @property
    def steps(self) -> list[str]:
        """Colours of the bands: `RATED` for five bands, else interpolated in it."""
        if len(self.bands) == len(RATED) - 1:
            return list(RATED)
        from matplotlib.colors import LinearSegmentedColormap, to_hex

        rated = LinearSegmentedColormap.from_list("rated", RATED)
        return [to_hex(rated(share)) for share in np.linspace(0.0, 1.0, len(self.bands) + 1)]

    def places(self, values: FloatArray) -> FloatArray:
        """Return the bands (n,) of values, or the values if there are no bands; NaN stays.

        A band includes its lower end.
        """
        if not self.bands:
            return values
        bands = np.searchsorted(self.bands, values, side="right").astype(np.float64)
        return np.where(np.isnan(values), np.nan, bands)

    def colours(self, values: FloatArray) -> FloatArray:
        """Return red, green and blue (n, 3) of values, clipped to the limits.

        NaN has the colour of the lower limit, or of the first band.
        """
        from matplotlib.colors import to_rgb

        if self.bands:
            table = np.array([to_rgb(colour) for colour in self.steps])
            return np.asarray(table[np.nan_to_num(self.places(values)).astype(int)])
        low, high = self.limits
        share = np.clip((values - low) / max(high - low, 1e-300), 0.0, 1.0)
        return np.asarray(colour_map()(np.nan_to_num(share))[:, :3])

    @property
    def marks(self) -> tuple[list[float], list[str]]:
        """The borders of bands on the colour bar, and their labels."""
        return [k + 0.5 for k in range(len(self.bands))], [number(value) for value in self.bands]

    def mappable(self) -> Any:
        """Return a mappable for a colour bar of matplotlib: values, or bands by number."""
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize

        if not self.bands:
            return ScalarMappable(Normalize(*self.limits), colour_map())
        count = len(self.bands) + 1
        norm = BoundaryNorm(np.arange(count + 1.0) - 0.5, count)
        return ScalarMappable(norm, ListedColormap(self.steps))

    def marker(self, values: FloatArray, label: str) -> dict[str, Any]:
        """Return plotly's marker options for `values`, with a colour bar titled `label`."""
        bar: dict[str, Any] = {
            "title": {"text": label, "side": "right"},
            "thickness": 12,
            "outlinewidth": 0,
        }
        if not self.bands:
            scale = [[k / (len(SCALE) - 1), colour] for k, colour in enumerate(SCALE)]
            low, high = self.limits
        else:
            count = len(self.bands) + 1
            scale = [
                [(k + end) / count, colour] for k, colour in enumerate(self.steps) for end in (0, 1)
            ]
            low, high = -0.5, count - 0.5
            bar["tickvals"], bar["ticktext"] = self.marks
        return {
            "color": self.places(values),
            "cmin": low,
            "cmax": high,
            "colorscale": scale,
            "colorbar": bar,
            "line": {"color": PAPER, "width": 1},
        }

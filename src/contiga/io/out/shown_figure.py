"""A figure of matplotlib that a notebook shows."""

from __future__ import annotations

from io import BytesIO

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure without a window, which a notebook shows whether or not pyplot is loaded."""

    def png(self, dpi: int = 110) -> bytes:
        """Return the figure as PNG, with `dpi` pixels per inch."""
        picture = BytesIO()
        self.savefig(picture, dpi=dpi, format="png")
        return picture.getvalue()

    def _repr_png_(self) -> bytes:
        return self.png()

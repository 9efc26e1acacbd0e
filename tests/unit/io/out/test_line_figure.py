"""Panels of lines: where their legends are."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.io.out.line_figure import Line, Panel, draw_panels


@pytest.mark.parametrize(("count", "beside"), [(4, False), (9, True)])
def test_the_legend_of_many_lines_is_beside_the_axes(count: int, beside: bool) -> None:
    across = np.linspace(0.0, 1.0, 5)
    lines = tuple(Line(f"run {k}", across, k * across) for k in range(count))
    figure = draw_panels([Panel("x", "y", lines)], "")
    figure.draw_without_rendering()
    (axes,) = figure.axes
    legend = axes.get_legend().get_window_extent()
    assert (legend.x0 >= axes.get_window_extent().x1) == beside
    assert legend.x1 <= figure.bbox.x1

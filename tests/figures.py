"""Figures as objects of plotly, which refuse whatever its schema does not know."""

from __future__ import annotations

import json
import re
from typing import Any

import plotly.graph_objects as go

from contiga.report.figure import Figure


def checked(figure: Figure | None) -> Any:
    """A figure that has been found to be as the schema wants it."""
    assert figure is not None
    return go.Figure(figure.data, figure.layout)


def figures_of(page: str) -> dict[str, Any]:
    """All figures that a page draws as it is opened, by their id, found to be right."""
    read, figures = json.JSONDecoder().raw_decode, {}
    for call in re.finditer(r'<script>Plotly\.newPlot\("([\w-]+)",', page):
        data, end = read(page, call.end())
        layout, _ = read(page, end + 1)
        figures[call[1]] = go.Figure(data, layout)
    return figures

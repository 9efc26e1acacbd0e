"""Colours of reports, figures of results and pages."""

from __future__ import annotations

INK, MUTED, GRID, PAPER = "#21262d", "#6a737d", "#e8eaed", "#ffffff"
"""Colours of text and axes, of secondary text, of grid lines, and of the background."""
LINES = ("#1f5f8b", "#c4473a", "#3f7f4f", "#8a5a9e", "#b07d1e", "#4b5563")
"""Colours of curves, in turn."""

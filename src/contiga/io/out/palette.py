"""Colours of all that is drawn: reports, figures of results, pages."""

from __future__ import annotations

INK, MUTED, GRID, PAPER = "#21262d", "#6a737d", "#e8eaed", "#ffffff"
"""Of text and axes, of what stands back, of the lines behind a plot, and of what is behind all."""
LINES = ("#1f5f8b", "#c4473a", "#3f7f4f", "#8a5a9e", "#b07d1e", "#4b5563")
"""Of curves, in turn."""

"""Feet and first hits of points on exact geometry."""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)

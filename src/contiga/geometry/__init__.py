"""Exact geometry: splines, shapes, refinement, trims, bodies."""

"""Slaves: points with what they know of cells, facets, areas, thickness and mass."""

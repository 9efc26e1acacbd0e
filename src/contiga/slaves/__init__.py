"""Slaves: points with what they know of cells, facets, areas, thickness and mass.

Question: which points may touch, and what does each stand for? Answered by a `Slave`. Read `slave`,
`checks`, `cells` (kinds of cells and their faces), `elements`, `skin` (facets and tributary areas),
`sampling` (nodes or quadrature points), `selection`; `surfaces` and `strip` make slaves of splines.
"""

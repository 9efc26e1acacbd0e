"""Slaves: points with their cells, facets, areas, thickness and mass.

Question: which points may touch, and which area does each represent? A `Slave` has the answer. Read
`slave`, `checks`, `cells` (kinds of cells and their faces), `elements`, `skin` (facets and
tributary areas), `sampling` (nodes or quadrature points), `selection`; `surfaces` and `strip` make
slaves of splines.
"""

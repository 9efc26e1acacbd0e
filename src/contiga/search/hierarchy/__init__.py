"""The tables of a body that every search goes down: boxes, leaves, curves and plates.

Question: what of a body may a search leave out? Asked with a set of Bézier elements
(`contiga.elements`); answered by `Tables`, whose fields `table_types` says. Read `tree_nb` (the
binary hierarchy), `hierarchy_nb` and `curve_leaves_nb` (its leaves), `build`, then `plates_nb`
and `closest_cell_nb`: bounds that leave a leaf, or a cell of it, out; and `forms` and `form_nb`:
planes, cylinders, cones, spheres and tori, whose closest points are formulas.
"""

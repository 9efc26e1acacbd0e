"""The tables of a body that every search traverses: boxes, leaves, curves and plates.

Question: which parts of a body can a search skip? The input is a set of Bézier elements
(`contiga.elements`), the result is `Tables`, described in `table_types`. Read `tree_nb` (the
binary hierarchy), `hierarchy_nb` and `curve_leaves_nb` (its leaves), `build`, then `plates_nb`
and `closest_cell_nb`: bounds that exclude a leaf, or a cell of it; and `forms` and `form_nb`:
planes, cylinders, cones, spheres and tori, whose closest points are formulas.
"""

"""Kernels, in reading order: splines, trims and the mesher. Each stands on those before it.

- basis_nb: B-spline basis functions, their derivatives, and the maps between knot vectors
- evaluate_nb: points, derivatives and normals of NURBS curves and surfaces at many parameters
- net_nb: how places on a surface move with its control points, and what forces at places do on
  these
- quadrature_nb: adaptive Gauss quadrature of area and length over Bézier elements
- trim_nb: kernels of the trim tables: monotone pieces, the cell grid, the exact in/out test
- trim_build_nb: kernels that build the trim tables: splitting into monotone pieces and filling
  the cell grid
- trim_area_nb: kernels for areas and moments of trimmed patches: Green's theorem along the monotone
  pieces
- edge_gap_nb: how far a face's own image of an edge, its p-curve on its surface, is from the
  edge's curve
- triangulation_nb: a triangulation in the plane that grows: exact turns, insertion, flips, walks
- border_nb: triangles between polygons that may have holes: constrained Delaunay, then the
  outside dropped
- ears_nb: triangles between polygons that cross themselves or each other: closed, if not
  beautiful
- chord_nb: proof that two triangles stay within a distance of the piece of surface above them
- shape_nb: what a surface asks of triangles around a place: its bend, and the metric they should
  be even in
- refine_nb: vertices put into the triangles of a face until none misses the surface by too much
- height_nb: proof that the surface over a triangle stays within a distance of the triangle's
  plane
- check_nb: triangles of a face held against the surface, and cut where it is farther than allowed
"""

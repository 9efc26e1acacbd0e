"""Kernels, in reading order: splines, trims and the mesher. Each stands on those before it.

- basis_nb: B-spline basis functions, their derivatives, and the maps between knot vectors
- evaluate_nb: points, derivatives and normals of NURBS curves and surfaces at many parameters
- net_nb: move places on a surface along with its control points, and spread forces at places to
  these
- quadrature_nb: adaptive Gauss quadrature of area and length over Bézier elements
- trim_nb: kernels of the trim tables: monotone pieces, the cell grid, the exact in/out test
- trim_build_nb: kernels that build the trim tables: splitting into monotone pieces and filling
  the cell grid
- trim_area_nb: kernels for areas and moments of trimmed patches: Green's theorem along the monotone
  pieces
- edge_gap_nb: how far a face's p-curve on its surface is from the edge's curve
- triangulation_nb: a triangulation in the plane that grows: exact orientation, insertion, flips,
  walks
- border_nb: triangulate between polygons that may have holes: constrained Delaunay, the outside
  removed
- ears_nb: triangles between polygons that cross themselves or each other: closed, of any shape
- chord_nb: proof that two triangles stay within a distance of the piece of surface above them
- shape_nb: the curvature of a surface at a point, and the metric for triangles around it
- refine_nb: insert vertices in the triangles of a face until none misses the surface by too much
- height_nb: proof that the surface over a triangle stays within a distance of the triangle's
  plane
- check_nb: check triangles of a face against the surface, and split those farther from it than the
  sag
"""

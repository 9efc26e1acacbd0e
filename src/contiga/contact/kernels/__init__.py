"""Kernels, in reading order: contact. Each stands on those before it.

- status_nb: what becomes of points, as the numbers that kernels write
- place_nb: what is known of points after they have moved, and which have to be looked at
- bulging_nb: which points may come to the surface on paths that bulge
- relative_nb: how fast points move against the body
- carrying_nb: what is known of the points in contact before forces
- settle_nb: points that sides, feet, touching balls and closest points tell enough of, settled a
  chunk at a time in one call
- way_nb: which wall pushes a point at the end of its way, where these do not tell
- sums_nb: sums in one order, as NumPy takes them
- tangent_nb: derivatives of the forces of points
- totals_nb: world forces, and sums over the points that carry them: wrench and energies
"""

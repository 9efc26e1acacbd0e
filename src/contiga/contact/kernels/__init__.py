"""Kernels, in reading order: contact. Each stands on those before it.

- status_nb: what becomes of points, as the numbers that kernels write
- place_nb: what is known of points after they have moved, and which have to be looked at
- bulging_nb: which points may come to the surface on paths that bulge
- relative_nb: how fast points move against the body
- carrying_nb: what is known of the points in contact before forces
- settle_nb: points of a closed body whose sides and feet tell what becomes of them: settled in
  single passes
- usual_nb: the usual points of a closed body: all of these passes in one call
- judge_nb: points whose feet do not tell, where their closest points do
- deep_nb: points deeper than balls at their feet tell: all of these passes in one call
- sums_nb: sums in one order, as NumPy takes them
- totals_nb: world forces, and sums over the points that carry them: wrench and energies
"""

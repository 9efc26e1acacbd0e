"""Kernels, in reading order: contact. Each stands on those before it.

- status_nb: numbers of statuses
- place_nb: safe distances of moved points, and the list of points to examine
- bulging_nb: points that may reach the surface on curved paths
- relative_nb: velocities relative to the body
- carrying_nb: depths, normals, paths and rates of the points in contact
- settle_nb: points decided by sides, feet, touching balls and closest points, a chunk per call
- deep_path_nb: the wall that pushes a point at the end of its path, for the remaining points
- sums_nb: sums in a fixed order, as in NumPy
- tangent_nb: derivatives of the forces of points
- totals_nb: world forces, and sums over the points that carry them: wrench and energies
"""

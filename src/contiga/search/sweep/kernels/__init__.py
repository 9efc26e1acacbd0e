"""Kernels of path crossings, in reading order: each uses those before it.

In all of them `h` (4, 6) is work: it holds the point and derivatives of the place that was
evaluated last.

- flat_cell_nb: crossing of a cell that is a point, or flat along the path, by the path's ends
- crossing_nb: crossings of a straight path with one leaf, cell by cell, with tolerances that are
  lengths
- piece_lists_nb: pieces of a surface near every voxel of a grid, and whether a short path is clear
  of all of them
- hit_nb: crossings of swept points: the segments p0 → p1 against the exact surface
- moving_nb: crossings of swept points with a surface whose control points move in the same time
"""

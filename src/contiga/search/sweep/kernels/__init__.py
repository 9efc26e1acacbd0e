"""Kernels, in reading order: first hits of paths. Each stands on those before it.

- flat_cell_nb: where a path crosses a cell that is a point, or flat along the path: its ends tell
- crossing_nb: where a straight path crosses one leaf, cell by cell, with tolerances that are
  lengths
- piece_lists_nb: pieces of a surface near every voxel of a grid: whether a short path is clear of
  all of them
- hit_nb: crossings of swept points: the segments p0 → p1 against the exact surface
- moving_nb: crossings of swept points with a surface whose control points move in the same time
"""

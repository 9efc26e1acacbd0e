"""Kernels of sides, in reading order: each uses those before it.

- side_pieces_nb: pieces of a surface, small and flat enough to decide which cells of a grid they
  meet
- side_grid_nb: which cells of a grid contain surface, and which of the others are connected
- side_nb: queries of a grid of known sides: the side of a point, and whether a path is clear of the
  surface
"""

"""Kernels, in reading order: which side a point is on. Each stands on those before it.

- side_pieces_nb: pieces of a surface, small and flat enough to tell which cells of a grid they
  meet
- side_grid_nb: which cells of a grid hold surface, and which of the others are joined
- side_nb: looking up a grid of known sides: the side of a point, and whether a way is clear of
  surface
"""

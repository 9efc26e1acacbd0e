"""Kernels, in reading order: balls that touch a body. Each stands on those before it.

- ball_plane_nb: touching balls: how large a ball may touch a surface from inside or outside and
  hold no more
- ball_cell_nb: cells of elements with rigorous bounds of how their surface runs, turns and bends
- ball_block_nb: blocks of cells over which a patch is smooth: how near its own points come to
  touching balls
- ball_bound_nb: the corner values of cells: what all other cells of the body leave of their
  touching balls
- ball_nb: radii of touching balls at feet, looked up in the cells of the elements
"""

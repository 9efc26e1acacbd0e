"""Kernels of touching balls, in reading order: each uses those before it.

- ball_plane_nb: how large a ball may touch a surface from inside or outside and contain no other
  point of it
- ball_cell_nb: cells of elements with rigorous bounds of derivatives, normals and curvatures
- ball_block_nb: blocks of cells over which a patch is smooth: their own bound of touching balls
- ball_bound_nb: the corner values of cells: the bound of their touching balls by all other cells
- ball_nb: radii of touching balls at feet, looked up in the cells of the elements
"""

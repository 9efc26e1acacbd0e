"""Kernels, in reading order: derivatives of feet. Each stands on those before it.

- bending_nb: the second fundamental form at a place of a surface, at its poles too
- slopes_nb: derivatives of depth and normal at feet on faces, edges and vertices
"""

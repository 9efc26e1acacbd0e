"""Kernels of derivatives of feet, in reading order: each depends on the ones before it only.

- bending_nb: the second fundamental form at a place of a surface, also at its poles
- slopes_nb: derivatives of depth and normal at feet on faces, edges and vertices
"""

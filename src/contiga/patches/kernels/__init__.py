"""Kernels of patches.

- point_map_nb: points of splines, x = N q, and Nᵀ f
"""

"""Kernels, in reading order: parts of a surface that may cross. Each stands on those before it.

- near_leaves_nb: pairs of leaves of faces that may come nearer than a distance
- common_point_nb: Newton's method from places on two leaves to a point that both pass through
"""

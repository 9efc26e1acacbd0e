"""Kernels of surfaces that cross, in reading order: each depends on the ones before it only.

- near_leaves_nb: pairs of leaves of faces that may come nearer than a distance
- common_point_nb: Newton's method from places on two leaves to a point that both pass through
"""

"""Kernels of Bézier elements, in reading order: each depends on the ones before it only.

- bounds_nb: rigorous bounds of an element's derivatives over a box, from Bernstein coefficients
- element_nb: evaluation of one Bézier element and its derivatives to second order
- sides_nb: points and normals along the sides of elements
"""

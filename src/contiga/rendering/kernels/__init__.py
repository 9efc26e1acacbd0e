"""Kernels of shaded pictures, in reading order. Each uses the kernels before it.

- raster_nb: a z-buffer: triangles, balls and lines drawn into arrays of pixels
- shading_groups_nb: corners of facets that share a normal
- shading_nb: light on the pixels of a z-buffer, and a veil over them
"""

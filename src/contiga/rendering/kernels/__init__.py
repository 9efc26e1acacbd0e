"""Kernels, in reading order: shaded pictures. Each stands on those before it.

- raster_nb: a z-buffer in plain loops: triangles, balls and lines drawn into arrays of pixels
- shading_groups_nb: corners of facets that share a normal
- shading_nb: light on its pixels, and a veil over them
"""

"""Kernels, in reading order: the pictures of a report. Each stands on those before it.

- raster_nb: a z-buffer in plain loops: triangles, balls and lines drawn into arrays of pixels
"""

"""Kernels, in reading order: contact. Each stands on those before it.

- place_nb: what is known of points after they have moved, and which have to be looked at
"""

"""Vectors of three numbers in kernels, as tuples."""

from __future__ import annotations

from contiga.jit import inner


@inner(error_model="numpy")
def dot(a, b):
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner(error_model="numpy")
def minus(a, b):
    """Return the difference a − b of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inner(error_model="numpy")
def cross(a, b):
    """Return a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inner(error_model="numpy")
def column(h, k):
    """Return column k of a table of three rows."""
    return h[0, k], h[1, k], h[2, k]

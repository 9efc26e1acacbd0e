"""Feet, first hits and sides of points on exact geometry.

Rooms, from the bottom: `hierarchy` (tables), `balls` (that touch the body), `closest` (points),
`sides`, `sweep` (first hits), `slopes` (derivatives of feet), `certify`, `track` (feet from step to
step), `borders` (whether a body is closed). Above them `tables` builds the tables that all of them
read, and `exact_surface` is the interface for contact.
"""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)

"""Every status, side, kind and state as the number that kernels compare, each defined once.

Those that users see are the enumerations of `contiga.statuses`; here they are plain numbers, which
compiled code takes for constants.
"""

from __future__ import annotations

from contiga.statuses import Feature, Status

# Outcome of a foot or a hit: `Status`.
OK = int(Status.OK)
AT_BORDER = int(Status.BORDER)
TRIMMED = int(Status.TRIMMED)
MAX_ITERATIONS = int(Status.MAX_ITERATIONS)
BRANCH_EVENT = int(Status.BRANCH_EVENT)
NOT_FINITE = int(Status.NOT_FINITE)
NO_HIT = int(Status.NO_HIT)
AT_START = int(Status.AT_START)
BUDGET = int(Status.BUDGET)

# What a foot lies on: `Feature`.
FACE = int(Feature.FACE)
EDGE = int(Feature.EDGE)
VERTEX = int(Feature.VERTEX)

# Side of a Bézier element: what continues the surface across it.
SMOOTH = 0
"""Another element, with the same tangent plane."""
CREASE = 1
"""Another element, with a kink."""
BORDER = 2
"""Nothing: the surface ends."""
POLE = 3
"""The whole side is one point."""
SHARED = 4
"""A face whose elements do not line up with this one's."""

# State of a part of a patch against its trimming loops.
OUT, IN, CUT = 0, 1, 2

# Form an element is evaluated in.
GENERAL, CUBIC, RATIONAL_CUBIC = 0, 1, 2

# Shape of an element that has formulas for its closest points.
NO_FORM, PLANE, TURNED_LINE, TURNED_ARC = 0, 1, 2, 3

# What the stages of tracking are to do with a row.
DONE = 0
"""Nothing; or, where its foot is not proved, to try that."""
TO_WALK = 1
"""Its foot left the lanes: a careful walk continues it."""
TO_SEARCH = 2
"""It has no foot to start from: its closest point is searched for."""
HAS_ENDED = 3
"""The walk has found no minimum: its closest point is searched for, and it is a BRANCH_EVENT."""

# Crossings a search looks for.
ENTRIES, EITHER = 0, 1

NO_TRIANGLE = -1
"""Across an edge of a triangle: the surface ends."""

"""Numbers of all statuses, sides, kinds and states that kernels compare, each defined once.

The public ones are the enumerations of `contiga.statuses`; here they are plain numbers, which are
constants for compiled code.
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

# Feature on which a foot lies: `Feature`.
FACE = int(Feature.FACE)
EDGE = int(Feature.EDGE)
VERTEX = int(Feature.VERTEX)

# Side of a Bézier element: the continuation of the surface across it.
SMOOTH = 0
"""Another element, with the same tangent plane."""
CREASE = 1
"""Another element, with a kink."""
BORDER = 2
"""None: the surface ends."""
POLE = 3
"""None: the side is one point."""
SHARED = 4
"""A face whose elements do not match this one's."""

# State of a part of a patch against its trimming loops.
OUT, IN, CUT = 0, 1, 2

# Form an element is evaluated in.
GENERAL, CUBIC, RATIONAL_CUBIC = 0, 1, 2

# Shape of an element that has formulas for its closest points.
NO_FORM, PLANE, TURNED_LINE, TURNED_ARC = 0, 1, 2, 3

# Next task of the stages of tracking for a row.
DONE = 0
"""Row finished; if its foot is not certified, certification is still pending."""
TO_WALK = 1
"""Its foot left the lanes: a careful walk continues it."""
TO_SEARCH = 2
"""It has no foot to start from: search its closest point."""
HAS_ENDED = 3
"""The walk has found no minimum: search its closest point, and mark it as a BRANCH_EVENT."""

# Kind of crossings of a search.
ENTRIES, EITHER = 0, 1

NO_TRIANGLE = -1
"""Across an edge of a triangle: the surface ends."""

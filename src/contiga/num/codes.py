"""Every status, side, kind and state as the number that kernels compare, each defined once.

Those that users see are the enumerations of `contiga.records`; here they are plain numbers, which
compiled code takes for constants.
"""

from __future__ import annotations

from contiga.records import Feature, Status

# Outcome of a foot or a hit: `Status`.
OK = int(Status.OK)
FREE_BORDER = int(Status.BORDER)
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

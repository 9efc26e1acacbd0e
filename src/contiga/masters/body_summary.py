"""What a body consists of, in numbers and words."""

from __future__ import annotations

from collections import Counter
from typing import Any

from contiga.masters.body import Body


def body_summary(body: Body) -> dict[str, Any]:
    """Counts and sizes of `body`, for `contiga info` and reports.

    Returns
    -------
    dict
        "name", "unit" (None if unknown), "patches", "degrees" (how many patches of each
        "p × q"), "rational", "trimmed", "loops", "shared_edges", "free_edges" (used by one face
        only; both are 0 where nothing is known about edges), "bounds" (low and high corner),
        "size" (diagonal) and "area", in the body's unit.
    """
    degrees = Counter("{} × {}".format(*patch.degrees) for patch in body.patches)
    shared = sum(len(edge.uses) > 1 for edge in body.edges)
    return {
        "name": body.name,
        "unit": body.unit,
        "patches": len(body.patches),
        "degrees": dict(degrees.most_common()),
        "rational": sum(patch.is_rational for patch in body.patches),
        "trimmed": sum(loops is not None for loops in body.trims),
        "loops": sum(len(loops) for loops in body.trims if loops is not None),
        "shared_edges": shared,
        "free_edges": len(body.edges) - shared,
        "bounds": body.bounds().tolist(),
        "size": body.size,
        "area": body.area(),
    }

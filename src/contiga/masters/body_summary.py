"""Describe a body in numbers and words."""

from __future__ import annotations

from collections import Counter
from typing import Any

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.geometry.surface import NurbsSurface
from contiga.masters.body import Body


def warm_up() -> None:
    """Load the kernels that measure bodies, by measuring a small body.

    `io.worker` calls it while another process loads a reader and reads the file.
    """
    lines = [NurbsCurve(1, [0, 0, 1, 1], ends) for ends in ([[0, 0], [1, 0]], [[1, 0], [0, 1]])]
    lines.append(NurbsCurve(1, [0, 0, 1, 1], [[0, 1], [0, 0]]))
    corners = [[[-1, -1, 0], [-1, 1, 0]], [[1, -1, 0], [1, 1, 0]]]
    patch = NurbsSurface((1, 1), ([-1, -1, 1, 1], [-1, -1, 1, 1]), corners)
    rim = NurbsCurve(1, [0, 0, 1, 1], [[0, 0, 0], [1, 0, 0]])
    body = Body([patch], trims=[[lines]], edges=[BodyEdge(rim, 0.0, (EdgeUse(0, 0, 0, False),))])
    body_summary(body)
    body.condition_rows()
    body.volume()


def body_summary(body: Body) -> dict[str, Any]:
    """Return counts and sizes of `body`, for `contiga info` and reports.

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

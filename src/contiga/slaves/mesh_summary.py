"""Describe a mesh in numbers and words."""

from __future__ import annotations

from typing import Any

from contiga.slaves.skin import tributary_area
from contiga.slaves.slave import Slave

_SECOND_ORDER = "facets are split through mid-side nodes, which take part as corners do"


def _has_middles(slave: Slave) -> bool:
    return any(kind[-1].isdigit() for kind in slave.cells)


def _whole_area(slave: Slave) -> float | None:
    """Return the area of the facets, or the sum of what the points were given; None if neither."""
    if slave.facets is not None:
        return float(tributary_area(slave.points, slave.facets, slave.quads).sum())
    return None if slave.area is None else float(slave.area.sum())


def mesh_summary(slave: Slave) -> dict[str, Any]:
    """Describe a mesh in plain numbers and strings, ready to print or dump.

    Returns
    -------
    dict with name, nodes, active_nodes, facets, cells (count by kind), second_order (what is done
    with mid-side nodes, None where there are none), area (of the facets, or
    the sum of what the points were given; None if neither), thickness (lowest and highest over
    the active nodes, or None), mass (total or None), bounds (of the active nodes), parts (label,
    cells, nodes), unit
    """
    active = slave.active
    thickness = None
    if slave.thickness is not None and active.any():
        values = slave.thickness[active]
        thickness = [float(values.min()), float(values.max())]
    return {
        "name": slave.name,
        "nodes": len(slave),
        "active_nodes": int(active.sum()),
        "facets": 0 if slave.facets is None else len(slave.facets),
        "cells": dict(slave.cells),
        "second_order": _SECOND_ORDER if _has_middles(slave) else None,
        "area": _whole_area(slave),
        "thickness": thickness,
        "mass": None if slave.mass is None else float(slave.mass.sum()),
        "bounds": slave.bounds().tolist(),
        "parts": [
            {"label": part.label, "cells": part.n_cells, "nodes": part.n_nodes}
            for part in slave.parts
        ],
        "unit": slave.unit,
    }

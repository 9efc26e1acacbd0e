"""Describe a mesh in numbers and words."""

from __future__ import annotations

from typing import Any

from contiga.slaves.skin import tributary_area
from contiga.slaves.slave import Slave

_SECOND_ORDER = "facets are split through mid-side nodes, which take part as corners do"


def mesh_summary(slave: Slave) -> dict[str, Any]:
    """Return a description of a slave in plain numbers and strings, ready to print or dump.

    Returns
    -------
    dict with name, nodes, active_nodes, facets, cells (count by kind), second_order (use of
    mid-side nodes, None without them), area (of the facets, or the sum over the points; None if
    neither is known), thickness (lowest and highest over the active nodes, or None), mass (total or
    None), bounds (of the active nodes), parts (label, cells, nodes), unit
    """
    active = slave.active
    area = None if slave.area is None else float(slave.area.sum())
    if slave.facets is not None:
        area = float(tributary_area(slave.points, slave.facets, slave.quads).sum())
    has_mid_nodes = any(kind[-1].isdigit() for kind in slave.cells)
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
        "second_order": _SECOND_ORDER if has_mid_nodes else None,
        "area": area,
        "thickness": thickness,
        "mass": None if slave.mass is None else float(slave.mass.sum()),
        "bounds": slave.bounds().tolist(),
        "parts": [
            {"label": part.label, "cells": part.n_cells, "nodes": part.n_nodes}
            for part in slave.parts
        ],
        "unit": slave.unit,
    }

"""Area and clusters of 100,000 nodes in contact beside the projection of the same nodes."""

from __future__ import annotations

from itertools import repeat

import numpy as np

import contiga as cg
from benchmarks.scene import OFFSET, STEP, surface
from benchmarks.timing import median_seconds
from contiga.area.base import AreaInput, Rest
from contiga.area.regions import regions, structure_of

SIDE = 317  # 317² = 100,489 nodes
REPEATS = 6


def run() -> list[str]:
    """The lines of the table."""
    patch = surface()
    body = cg.Body(patch)
    grid = np.linspace(0.05, 0.95, SIDE)
    uv = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)
    nodes = patch.evaluate(uv) - 0.5 * OFFSET * patch.normal(uv)
    i = np.arange(SIDE * SIDE, dtype=np.int32).reshape(SIDE, SIDE)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    feet = body.project(nodes)
    moved = nodes + STEP  # a step on, as in a run
    rows = np.arange(len(nodes), dtype=np.int32)
    rest = Rest(nodes, facets, None)
    inp = AreaInput(body, rows, nodes, feet, None, "slave", cg.FacetArea().prepare(rest))
    cloud = structure_of(Rest(nodes, None, None))
    work = {
        "projection, global": lambda _: body.project(nodes),
        "projection, tracked": lambda _: body.project(moved, start=feet, mode="track"),
        "FacetArea with clusters, on the slave": lambda _: cg.FacetArea().measure(inp),
        "FacetArea with clusters, on the master": lambda _: cg.FacetArea("master").measure(inp),
        'clusters "auto", cloud': lambda _: regions(cloud, rows, nodes),
    }
    times = {name: median_seconds(f, repeat(None, REPEATS)) for name, f in work.items()}
    whole, tracked = times["projection, global"], times["projection, tracked"]
    return [
        f"{name:40s} {1e3 * t:8.1f} ms  {t / whole:6.2f} of global  {t / tracked:6.2f} of tracked"
        for name, t in times.items()
    ]

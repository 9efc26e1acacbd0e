"""Area and clusters of 100,000 nodes in contact beside the projection of the same nodes.

The projection meant is the tracked one, what a step of a run costs; the global one (a cold start)
is printed too. The mesh is larger than its two regions of contact, so that facets are cut.
"""

from __future__ import annotations

from itertools import repeat
from statistics import median

import numpy as np

import contiga as cg
from benchmarks.scene import OFFSET, STEP, surface
from benchmarks.timing import median_seconds
from contiga.area.cluster import clusters_of
from contiga.area.method import AreaInput, Rest
from contiga.area.regions import regions, structure_of
from contiga.records import rows_of

SIDE = 340  # 340² nodes, of which 100,208 touch
REPEATS = 9
FEW = 10_000  # DBSCAN and k-means are timed on this many of the feet


def scene() -> tuple[cg.Body, np.ndarray, np.ndarray]:
    """A wavy body, and nodes and facets that touch it in two regions."""
    patch = surface()
    grid = np.linspace(0.03, 0.97, SIDE)
    uv = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)
    x, y = 2.0 * uv.T - 1.0
    # Negative but for the border and a strip in the middle.
    level = np.maximum(np.maximum(abs(x), abs(y)) - 0.893, 0.03 - abs(x + 0.1 * y))
    nodes = patch.evaluate(uv) + OFFSET * np.clip(20.0 * level, -0.5, 0.5)[:, None] * patch.normal(
        uv
    )
    i = np.arange(SIDE * SIDE, dtype=np.int32).reshape(SIDE, SIDE)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return cg.Body(patch), nodes, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def run() -> list[str]:
    """The lines of the table."""
    body, nodes, facets = scene()
    every = body.project(nodes)
    rows = np.flatnonzero(every.gap < 0.0).astype(np.int32)
    feet, inside = rows_of(every, rows), nodes[rows]
    moved = inside + STEP  # a step on, as in a run
    rest = Rest(nodes, facets, None)
    inp = AreaInput(body, rows, nodes, feet, None, "slave", cg.FacetArea().prepare(rest))
    bare = Rest(nodes, None, None)
    cloud = inp._replace(prepared=cg.CloudArea().prepare(bare))
    mesh, graph = structure_of(rest), structure_of(bare)
    few = feet.uv[np.random.default_rng(0).permutation(len(rows))[:FEW]]
    work = {
        "projection, tracked": lambda _: body.project(moved, start=feet, mode="track"),
        "projection, global": lambda _: body.project(inside),
        "FacetArea with clusters, on the slave": lambda _: cg.FacetArea().measure(inp),
        "FacetArea with clusters, on the master": lambda _: cg.FacetArea("master").measure(inp),
        "CloudArea with clusters, on the slave": lambda _: cg.CloudArea().measure(cloud),
        'clusters "auto", facets': lambda _: regions(mesh, rows, nodes),
        'clusters "auto", cloud': lambda _: regions(graph, rows, nodes),
        f"k-means, {FEW} feet": lambda _: clusters_of(few, "kmeans", k=2),
        f"DBSCAN, {FEW} feet": lambda _: clusters_of(few, "dbscan", eps=0.02, min_points=4),
    }
    # In turns: what else the machine does falls on all of them alike.
    turns = [
        {name: median_seconds(f, repeat(None, 2)) for name, f in work.items()}
        for _ in range(REPEATS)
    ]
    times = {name: median(turn[name] for turn in turns) for name in work}
    tracked = times["projection, tracked"]
    found = cg.FacetArea().measure(inp)
    return [f"{len(rows)} nodes in contact in {found.clusters.max() + 1} regions"] + [
        f"{name:40s} {1e3 * t:8.1f} ms  {t / tracked:8.2f} of the tracked projection"
        for name, t in times.items()
    ]

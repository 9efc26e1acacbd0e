"""Solids that touch or overlap, in one file: shaken through clouds as the union that they are.

Closed forms of the pieces; of their union, the least of them. A closed piece stands a hair larger
than it is (`SEAM` of the size): two that touch have no seam between them, where the least of two
exact forms is zero.
"""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
from tests.stress import pieces
from tests.stress.pieces import Piece
from tests.stress.solids import Solid, written

import contiga as cg
from contiga.errors import ContigaWarning

SEAM = 1e-10
"""Share of the size by which pieces are larger in closed form: a twentieth of what is judged."""


def _tiles() -> list[Piece]:
    """A floor of four by three tiles, side by side."""
    return [
        pieces.box((10 * i, 8 * j, 0), (10 * i + 10, 8 * j + 8, 3))
        for i in range(4)
        for j in range(3)
    ]


def _lapped_tiles() -> list[Piece]:
    """As before, each half a length into the next."""
    return [
        pieces.box((10 * i, 8 * j, 0), (10 * i + 10.5, 8 * j + 8.5, 3))
        for i in range(4)
        for j in range(3)
    ]


def _bricks() -> list[Piece]:
    """A wall in running bond: every brick meets four others, and parts of them."""
    return [
        pieces.box((10 * i + 5 * (j % 2), 0, 4 * j), (10 * i + 10 + 5 * (j % 2), 6, 4 * j + 4))
        for i in range(3)
        for j in range(3)
    ]


def _pin() -> list[Piece]:
    """A pin that stands out of a hole of its own size."""
    plate = pieces.box((-20, -20, 0), (20, 20, 8))
    return [
        pieces.cut(plate, pieces.rod(2, 6.0, (0, 0, -1), 10.0)),
        pieces.rod(2, 6.0, (0, 0, 0), 14.0),
    ]


def _bolt() -> list[Piece]:
    """A bolt with a head, cast in: the shank overlaps the block, the head stands on it."""
    return [
        pieces.box((-20, -15, -12), (20, 15, 0)),
        pieces.rod(2, 4.0, (3, 2, -9), 11.0),
        pieces.rod(2, 9.0, (3, 2, 0), 5.0),
    ]


def _within() -> list[Piece]:
    """A box in another one, and one that fills a cavity."""
    hollow = pieces.cut(pieces.box((0, 0, 0), (30, 20, 20)), pieces.box((5, 5, 5), (15, 15, 15)))
    return [hollow, pieces.box((5, 5, 5), (15, 15, 15)), pieces.box((20, 5, 5), (25, 15, 15))]


def _edge_to_edge() -> list[Piece]:
    """Two boxes that have an edge in common, on a third that makes one of them."""
    return [
        pieces.box((0, 0, 0), (10, 10, 10)),
        pieces.box((10, 10, 0), (20, 20, 10)),
        pieces.box((-5, -5, -6), (25, 25, 0)),
    ]


def _heap(seed: int) -> list[Piece]:
    """Ten boxes and cylinders at random places, so close that they overlap."""
    rng = np.random.default_rng(seed)
    heap: list[Piece] = []
    for k in range(10):
        at = rng.uniform(-15.0, 15.0, 3)
        if k % 2:
            heap.append(pieces.rod(int(rng.integers(3)), rng.uniform(3, 9), at, rng.uniform(8, 25)))
        else:
            heap.append(pieces.box(at, at + rng.uniform(6, 22, 3)))
    return heap


HEAPS = 4
RECIPES = {
    "tiles": _tiles,
    "tiles that overlap": _lapped_tiles,
    "bricks": _bricks,
    "pin in its hole": _pin,
    "bolt cast in": _bolt,
    "boxes within": _within,
    "edge to edge": _edge_to_edge,
    **{f"heap {k}": lambda k=k: _heap(k) for k in range(HEAPS)},
}


@cache
def solid(name: str) -> Solid:
    """A union of `RECIPES`, read from a STEP file that has its pieces."""
    made = pieces.together(*RECIPES[name]())
    path = written(name, made.shape)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", ContigaWarning)
        body = cg.read_cad(path)
    assert len(told) == 1, [str(each.message) for each in told]
    assert "made one" in str(told[0].message)
    assert body.closed
    hair = SEAM * body.size
    return Solid(f"union, {name}", body, None, lambda p: made.field(p) - hair)

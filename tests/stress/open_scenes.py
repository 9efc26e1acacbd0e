"""Shells to attack the rule for open bodies with: creases, borders, folds and stacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from tests.stress.shells import Ball, Cylinder, Disc, Face, Point, Polygon, Shell

import contiga as cg

HALF = 0.5 * np.pi


class Scene(NamedTuple):
    """A shell about as large as one, and the same as a master."""

    name: str
    shell: Shell
    master: cg.Body | cg.TriMesh
    low: np.ndarray
    """Corner of its box."""
    high: np.ndarray


def profile(*points: Point, ends: tuple[float, float] = (0.0, 2.0)) -> list[Face]:
    """Walls over a polyline (x, y), extended along z; they face to its right."""
    low, high = ends
    return [Polygon([(*a, low), (*b, low), (*b, high), (*a, high)]) for a, b in pairwise(points)]


def block(low: Point, high: Point, without: str = "") -> list[Face]:
    """The faces of a box less those named: x, y, z for the lower ones, X, Y, Z for the upper."""
    (a, b, c), (d, e, f) = low, high
    faces = {
        "x": [(a, b, c), (a, b, f), (a, e, f), (a, e, c)],
        "X": [(d, b, c), (d, e, c), (d, e, f), (d, b, f)],
        "y": [(a, b, c), (d, b, c), (d, b, f), (a, b, f)],
        "Y": [(a, e, c), (a, e, f), (d, e, f), (d, e, c)],
        "z": [(a, b, c), (a, e, c), (d, e, c), (d, b, c)],
        "Z": [(a, b, f), (d, b, f), (d, e, f), (a, e, f)],
    }
    return [Polygon(corners) for name, corners in faces.items() if name not in without]


def turned_over(faces: Sequence[Face]) -> list[Face]:
    """Polygons that face the other way."""
    return [Polygon(face.corners[::-1]) for face in faces if isinstance(face, Polygon)]


def plate(z: float, x: tuple[float, float] = (0.0, 2.0), y: tuple[float, float] = (0.0, 2.0),
          up: bool = True, hole: tuple[Point, float] | None = None) -> list[Face]:  # fmt: skip
    """A rectangle at height z."""
    (a, b), (c, d) = x, y
    corners = [(a, c, z), (b, c, z), (b, d, z), (a, d, z)]
    return [Polygon(corners if up else corners[::-1], hole)]


def roof(angle: float, ends: tuple[float, float] = (0.0, 2.0)) -> list[Face]:
    """Two walls that meet at x = 0 under `angle` behind them, degrees; they face up, along y."""
    s, c = np.sin(np.deg2rad(0.5 * angle)), np.cos(np.deg2rad(0.5 * angle))
    return profile((s, -c), (0.0, 0.0), (-s, -c), ends=ends)


def gutter(angle: float) -> list[Face]:
    """As a roof whose inside is the free side."""
    return turned_over(roof(angle))


def hills(n: int, seed: int, high: float) -> list[Face]:
    """Triangles over a grid of random heights, facing up."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 2.0, n + 1)
    z = high * rng.normal(size=(n + 1, n + 1))
    p = np.stack([*np.meshgrid(x, x, indexing="ij"), z], axis=-1)
    faces: list[Face] = []
    for i in range(n):
        for j in range(n):
            a, b, c, d = p[i, j], p[i + 1, j], p[i + 1, j + 1], p[i, j + 1]
            faces += [Polygon([a, b, c]), Polygon([a, c, d])]
    return faces


def tent(high: float) -> list[Face]:
    """Four triangles that rise to a point."""
    ring = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)
    apex = np.array([0.1, -0.15, high])
    return [Polygon([ring[k - 1], ring[k], apex]) for k in range(4)]


def facetted_ball(around: int, up: int, lowest: float) -> list[Face]:
    """Triangles with corners on a sphere of radius 1, from the latitude `lowest` up."""
    rings = np.linspace(lowest, HALF, up + 1)[:-1]
    turns = 2.0 * np.pi * np.arange(around) / around
    p = np.array(
        [[(np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)) for a in turns] for b in rings]
    )
    faces: list[Face] = []
    for k in range(around):
        for low, high in pairwise(p):
            faces += [
                Polygon([low[k - 1], low[k], high[k]]),
                Polygon([low[k - 1], high[k], high[k - 1]]),
            ]
        faces.append(Polygon([p[-1, k - 1], p[-1, k], (0.0, 0.0, 1.0)]))
    return faces


def round_fold(gap: float) -> list[Face]:
    """A sheet over itself: out along y = 0, round, and back at y = −gap; it faces outward."""
    upper = Polygon([(1.5, 0, 0), (0, 0, 0), (0, 0, 2), (1.5, 0, 2)])
    lower = Polygon([(0, -gap, 0), (1.5, -gap, 0), (1.5, -gap, 2), (0, -gap, 2)])
    bend = Cylinder((1.5, -0.5 * gap), 0.5 * gap, (-HALF, HALF), (0.0, 2.0))
    return [upper, bend, lower]


# Corners: out along y = 0, back below it and out again below that: the first and the last face up.
Z_FOLD = [(2.0, 0.0), (0.0, 0.0), (1.8, -0.5), (0.0, -0.9)]
U_FOLD = [(0.0, -0.6), (2.0, -0.6), (2.0, 0.0), (0.0, 0.0)]

PATCHES: dict[str, Callable[[], list[Face]]] = {
    "plate": lambda: plate(0.0),
    "plate with a hole": lambda: plate(0.0, hole=((0.9, 1.1, 0.0), 0.45)),
    "stack": lambda: [*plate(0.0), *plate(-0.3, (0.5, 2.5), (-0.3, 1.6))],
    "stack of three": lambda: [*plate(0.0), *plate(-0.2), *plate(-0.7, (0.5, 2.5))],
    "leaning stack": lambda: [*plate(0.0), *profile((2.0, -0.7), (-0.2, -0.2))],
    "plate with two sides": lambda: [*plate(0.0), *plate(-0.4, up=False)],
    "slot": lambda: [*plate(0.0), *plate(0.4, up=False)],
    "roof 90": lambda: roof(90.0),
    "roof 60": lambda: roof(60.0),
    "roof 130": lambda: roof(130.0),
    "gutter 90": lambda: gutter(90.0),
    "gutter 60": lambda: gutter(60.0),
    "gutter 130": lambda: gutter(130.0),
    "knife": lambda: roof(14.0),
    "block without its top": lambda: block((0, 0, 0), (2, 1.4, 0.8), "Z"),
    "block without its bottom": lambda: block((0, 0, 0), (2, 1.4, 0.8), "z"),
    "tube with corners": lambda: block((0, 0, 0), (2, 1.4, 0.8), "xX"),
    "corner": lambda: block((0, 0, 0), (2, 1.4, 0.8), "xyz"),
    "room": lambda: turned_over(block((0, 0, 0), (2, 1.4, 0.8), "Z")),
    "inner corner": lambda: turned_over(block((0, 0, 0), (2, 1.4, 0.8), "xyz")),
    "U fold": lambda: profile(*U_FOLD),
    "U fold from within": lambda: turned_over(profile(*U_FOLD)),
    "Z fold": lambda: profile(*Z_FOLD[::-1]),
    "Z fold turned over": lambda: profile(*Z_FOLD),
    "steps": lambda: profile((2, -1), (1.4, -1), (1.4, -0.5), (0.8, -0.5), (0.8, 0), (0, 0)),
    "zigzag": lambda: profile((2, 0), (1.5, 0.4), (1, -0.1), (0.5, 0.5), (0, 0)),
    "round fold": lambda: round_fold(0.5),
    "sphere without its cap": lambda: [Ball((0, 0, 0), 1.0, (-1.0, HALF))],
    "hemisphere": lambda: [Ball((0, 0, 0), 1.0, (0.0, HALF))],
    "bowl": lambda: [Ball((0, 0, 0), 1.0, (-HALF, 0.2), bulges=False)],
    "two spheres": lambda: [
        Ball((0, 0, 0), 1.0, (-1.0, HALF)), Ball((0.1, 0, 0), 0.7, (-1.0, HALF)),
    ],
    "pipe": lambda: [Cylinder((0, 0), 0.8, ends=(0.0, 2.0))],
    "bore": lambda: [Cylinder((0, 0), 0.8, ends=(0.0, 2.0), bulges=False)],
    "half pipe": lambda: [Cylinder((0, 0), 0.8, (0.3, 3.0), (0.0, 2.0))],
    "lidded pipe": lambda: [Cylinder((0, 0), 0.8, ends=(0.0, 1.0)), Disc((0, 0, 1.0), 0.8)],
    "cup": lambda: [Cylinder((0, 0), 0.8, ends=(0.0, 1.0), bulges=False), Disc((0, 0, 0.0), 0.8)],
    "pipe in a pipe": lambda: [
        Cylinder((0, 0), 0.8, ends=(0.0, 2.0)), Cylinder((0, 0), 0.5, ends=(0.3, 1.7)),
    ],
    "two plates apart": lambda: [*plate(0.0, (0.0, 0.9)), *plate(0.0, (1.1, 2.0))],
    "plate in strips": lambda: [f for k in range(4) for f in plate(0.0, (0.5 * k, 0.5 * k + 0.5))],
}  # fmt: skip

MESHES: dict[str, Callable[[], list[Face]]] = {
    f"{name}, mesh": PATCHES[name]
    for name in (
        "plate", "stack", "plate with two sides", "roof 90", "gutter 60", "knife",
        "block without its top", "block without its bottom", "room", "corner", "inner corner",
        "U fold", "Z fold", "steps", "zigzag", "leaning stack",
    )
} | {
    "hills, mesh": lambda: hills(4, 1, 0.15),
    "steep hills, mesh": lambda: hills(4, 2, 0.5),
    "tent, mesh": lambda: tent(0.8),
    "funnel, mesh": lambda: turned_over(tent(0.8)),
    "facetted dome, mesh": lambda: facetted_ball(10, 4, -0.6),
    "two layers of hills, mesh": lambda: [
        *hills(3, 3, 0.1),
        *(Polygon(f.corners - [0.2, 0.1, 0.5]) for f in hills(3, 4, 0.1)),
    ],
}  # fmt: skip

CLOSED: dict[str, Callable[[], list[Face]]] = {
    "block": lambda: block((0, 0, 0), (2, 1.4, 0.8)),
    "thin block": lambda: block((0, 0, 0), (2, 1.4, 0.1)),
    "sphere": lambda: [Ball((0, 0, 0), 1.0)],
    "drum": lambda: [
        Cylinder((0, 0), 0.8, ends=(0.0, 1.0)),
        Disc((0, 0, 1.0), 0.8), Disc((0, 0, 0), 0.8, up=False),
    ],
    "two blocks": lambda: [
        *block((0, 0, 0), (2, 1.4, 0.5)), *block((0.3, -0.2, -0.6), (2.2, 1.2, -0.2)),
    ],
    "block, mesh": lambda: block((0, 0, 0), (2, 1.4, 0.8)),
    "facetted ball, mesh": lambda: [
        *facetted_ball(8, 4, -0.5), *(
            Polygon([(0, 0, -1.0), *sides]) for sides in _lower_ring(8, -0.5)
        ),
    ],
}  # fmt: skip


def _lower_ring(around: int, latitude: float) -> list[list[Point]]:
    turns = 2.0 * np.pi * np.arange(around) / around
    ring = [
        (np.cos(latitude) * np.cos(a), np.cos(latitude) * np.sin(a), np.sin(latitude))
        for a in turns
    ]
    return [[ring[k], ring[k - 1]] for k in range(around)]


ALL = PATCHES | MESHES | CLOSED


@cache
def scene(name: str) -> Scene:
    """One by name."""
    shell = Shell(ALL[name]())
    master = shell.mesh(name) if name.endswith("mesh") else shell.body(name)
    low, high = np.asarray(master.bounds())
    return Scene(name, shell, master, low, high)

"""Small keyword decks: a rigid sphere of shells above a pad of solids."""

from __future__ import annotations

from itertools import chain
from pathlib import Path

import numpy as np

from contiga.case.convert import convert
from contiga.case.schema import Case, load_case

UNITS = ("mm", "kg", "ms")

RADIUS, THICKNESS, DENSITY = 20.0, 2.0, 7.8e-6
"""mm, kg"""


def sphere(n: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a sphere about (0, 0, 20.5), closed."""
    polar, around = np.linspace(0.0, np.pi, n + 1)[1:-1], np.arange(2 * n) * np.pi / n
    ring = [
        [np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)] for p in polar for a in around
    ]
    points = RADIUS * np.array([*ring, [0, 0, 1], [0, 0, -1]]) + [0.0, 0.0, RADIUS + 0.5]
    top, bottom, m = len(ring), len(ring) + 1, 2 * n
    faces = []
    for j in range(m):
        k = (j + 1) % m
        faces.append([top, j, k])
        faces.append([bottom, (n - 2) * m + k, (n - 2) * m + j])
        for i in range(n - 2):
            a, b = i * m + j, i * m + k
            faces += [[a, a + m, b], [b, a + m, b + m]]
    return points, np.array(faces)


def pad(n: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Points and hexahedra of a pad 30 × 30 × 10 under z = 0, one through its thickness."""
    x = np.linspace(-15.0, 15.0, n + 1)
    layer = np.array([[a, b] for b in x for a in x])
    points = np.vstack([np.c_[layer, np.full(len(layer), z)] for z in (-10.0, 0.0)])
    cells = []
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i
            low = [a, a + 1, a + n + 2, a + n + 1]
            cells.append([*low, *(k + len(layer) for k in low)])
    return points, np.array(cells)


def card(*values: object) -> str:
    """Fields of ten columns."""
    return "".join(f"{value!s:>10}" for value in values)


def mesh() -> list[str]:
    """Nodes and elements: part 1 the sphere, part 2 the pad."""
    ball, faces = sphere()
    foam, cells = pad()
    lines = ["*NODE"]
    for k, p in enumerate(np.vstack([ball, foam]), start=1):
        lines.append(f"{k:8d}" + "".join(f"{x:16.8f}" for x in p))
    lines.append("*ELEMENT_SHELL")
    for k, (a, b, c) in enumerate(faces + 1, start=1):
        lines.append("".join(f"{v:8d}" for v in (k, 1, a, b, c, c)))
    lines.append("*ELEMENT_SOLID")
    for k, nodes in enumerate(cells + 1 + len(ball), start=10001):
        lines.append("".join(f"{v:8d}" for v in (k, 2, *nodes)))
    return lines


def box(first: int, element: int, part: int, low: float, high: float) -> list[str]:
    """Eight nodes and one solid, 20 × 20 across."""
    points = [(x, y, z) for z in (low, high) for y in (-10, 10) for x in (-10, 10)]
    nodes = [
        f"{first + k:8d}" + "".join(f"{v:16.4f}" for v in p) for k, p in enumerate(points)
    ]  # fmt: skip
    corners = "".join(f"{first + k:8d}" for k in (0, 1, 3, 2, 4, 5, 7, 6))
    return ["*NODE", *nodes, "*ELEMENT_SOLID", f"{element:8d}{part:8d}{corners}"]


PARTS = [
    "*PART", "head form", card(1, 11, 21), "*PART", "$ its title", "foam pad", card(2, 12, 22),
    "*SECTION_SHELL", card(11, 2), card(THICKNESS, THICKNESS, THICKNESS, THICKNESS),
    "*SECTION_SOLID", card(12, 1),
]  # fmt: skip
RIGID = ["*MAT_RIGID", card(21, DENSITY, 210.0, 0.3), card(1, 0, 7), ""]
FOAM = ["*MAT_LOW_DENSITY_FOAM_TITLE", "some foam", card(22, 1e-7, 0.003, 5)]
CONTACT = [
    "*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_ID", card(1) + "pad and head",
    card(2, 1, 3, 3), card(0.4, 0.3, 0.01), "",
]  # fmt: skip
FLIGHT = ["*INITIAL_VELOCITY_GENERATION", card(1, 2, 0.0, 0.0, 0.0, -2.0), ""]
END = ["*CONTROL_TERMINATION", card(4.0)]


def deck(*pieces: list[str], parts: list[str] = PARTS) -> str:
    """The text of a deck with its mesh and parts."""
    head = ["*KEYWORD", "*TITLE", "Head onto foam"]
    lines = [*head, *mesh(), *parts, *chain.from_iterable(pieces), "*END"]
    return "\n".join(lines) + "\n"


FULL = deck(RIGID, FOAM, CONTACT, FLIGHT, END)


def converted(folder: Path, text: str) -> tuple[Case, str]:
    """The case of a deck, and its text."""
    (folder / "deck.k").write_text(text, encoding="utf-8")
    result = convert(folder / "deck.k", UNITS, folder)
    (folder / "case.toml").write_text(result.text, encoding="utf-8")
    return load_case(folder / "case.toml"), result.text

"""Errors of the area methods at equal point count, and what they do to the stress model's force.

Root mean squares over four places of the mesh, relative; the scenes have closed forms.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import contiga as cg

CELLS = 64  # along each side of the slave: 65² nodes
SHIFTS = ((0.0123, 0.0077), (-0.0031, 0.0164), (0.0049, -0.0098), (-0.0142, -0.0057))
WINKLER = 3.0, 0.5  # stiffness k and thickness t of the foundation, σ = k λ/t


class Scene(NamedTuple):
    """A master, a slave over a square, and the true area on the master."""

    name: str
    body: cg.Body
    place: Callable[[np.ndarray], np.ndarray]
    half: float
    area: float


METHODS = {
    "facets": cg.FacetArea("master"),
    "cloud, at rest": cg.CloudArea("master"),
    "cloud, by feet": cg.CloudArea("master", by="feet"),
    "hulls, exact": cg.HullArea("auto", "exact"),
    "hulls, linear": cg.HullArea("auto", "linear"),
    "hulls, k-means 2": cg.HullArea(2, "linear"),
    "constant": cg.NodalArea(),
}


def flat(z: float) -> Callable[[np.ndarray], np.ndarray]:
    """A level sheet."""
    return lambda xy: np.column_stack([xy, np.full(len(xy), z)])


def ball_below(radius: float, z: float) -> Callable[[np.ndarray], np.ndarray]:
    """The lower side of a ball about (0, 0, z)."""
    return lambda xy: np.column_stack([xy, z - np.sqrt(radius**2 - np.square(xy).sum(axis=1))])


def scenes() -> list[Scene]:
    """Closed forms of contact areas on masters."""
    plate = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    hollow = cg.Body([cg.shapes.sphere(radius=1.0)]).flipped()
    z = (0.8**2 - 1.0 - 0.22**2) / 0.44
    two = cg.Body([cg.shapes.sphere(radius=0.5, centre=[x, 0, 0]) for x in (-0.6, 0.6)])
    ring = cg.Body([cg.shapes.torus(major=1.0, minor=0.4)])
    tube = 4 * np.pi * 0.4 * np.arccos(0.75)
    return [
        Scene("ball in a plane", plate, ball_below(1.0, 0.8), 0.66, 0.36 * np.pi),
        Scene("ball in a hollow ball", hollow, ball_below(0.8, -0.22), 0.5, 2 * np.pi * (1 + z)),
        Scene("two balls", two, flat(0.35), 0.99, 0.3 * np.pi),
        Scene("torus", ring, flat(0.3), 1.6, tube),
    ]


def mesh(scene: Scene, shift: tuple[float, float]) -> cg.Slave:
    """The slave of a scene."""
    x = np.linspace(-scene.half, scene.half, CELLS + 1)
    xy = np.stack(np.meshgrid(x + shift[0], x + shift[1], indexing="ij"), -1).reshape(-1, 2)
    i = np.arange(len(xy)).reshape(CELLS + 1, CELLS + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return cg.Slave(scene.place(xy), facets)


def touch(scene: Scene, slave: cg.Slave, area: object, law: object) -> cg.State:
    """The contact of a scene, on the master's side."""
    contact = cg.Contact(
        scene.body, slave, law=law, area=area, search="penetration", contact_type="master"
    )
    return contact.start(slave.points)


def error(scene: Scene, area: object, exact: float, force: bool) -> float:
    """Relative error of the area, or of the force along z, root mean square over the shifts."""
    law = cg.StressLaw(WINKLER[0], thickness=WINKLER[1]) if force else cg.PenaltyLaw(1.0)
    states = [touch(scene, mesh(scene, shift), area, law) for shift in SHIFTS]
    found = [state.total_force[2] if force else state.total_area for state in states]
    return float(np.sqrt(np.mean((np.array(found) / exact - 1.0) ** 2)))


def run() -> list[str]:
    """The lines of the table."""
    every = scenes()
    heads = [scene.name for scene in every] + ["Winkler force"]
    lines = [f"{'error of':18s}" + "".join(f"{head:>23s}" for head in heads)]
    volume = np.pi * 0.2**2 * (1.0 - 0.2 / 3.0)
    for name, area in METHODS.items():
        found = [error(scene, area, scene.area, False) for scene in every]
        found.append(error(every[0], area, WINKLER[0] / WINKLER[1] * volume, True))
        lines.append(f"{name:18s}" + "".join(f"{100 * e:21.4f} %" for e in found))
    return lines

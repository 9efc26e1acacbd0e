"""Errors of the area methods at equal point count, and what they do to the stress model's force.

Root mean squares over four places of the mesh, relative; the scenes have closed forms, the saddle
an adaptive quadrature. The order is that of the facets, over four refinements.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import contiga as cg

CELLS = 64  # along each side of the slave: 65² nodes
REFINED = (20, 34, 57, 95, 160)
SHIFTS = ((0.12, 0.43), (0.37, 0.81), (0.62, 0.18), (0.87, 0.56))  # of a cell
WINKLER = 3.0, 0.5  # stiffness k and thickness t of the foundation, σ = k λ/t

Place = Callable[[np.ndarray], np.ndarray]


class Scene(NamedTuple):
    """A master, a slave over a rectangle, and the truth on one of them."""

    name: str
    body: cg.Body
    place: Place
    """From (n, 2) to the points of the slave."""
    half: tuple[float, float]
    """Half the sides of the rectangle."""
    exact: float
    force: bool = False
    """Whether the truth is the force along z, not the area."""
    side: str = "master"


METHODS = {
    "facets": cg.FacetArea("master"),
    "cloud, rest": cg.CloudArea("master"),
    "cloud, feet": cg.CloudArea("master", by="feet"),
    "hull, exact": cg.HullArea("auto", mapping="exact"),
    "hull, linear": cg.HullArea("auto", mapping="linear"),
    "k-means 2": cg.HullArea(2, mapping="linear"),
    "constant": cg.NodalArea(),
}


def lifted(height: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Place:
    """The graph of a height over (x, y)."""
    return lambda xy: np.column_stack([xy, np.broadcast_to(height(*xy.T), len(xy))])


def ball_below(radius: float, z: float) -> Place:
    """The lower side of a ball about (0, 0, z)."""
    return lifted(lambda x, y: z - np.sqrt(radius**2 - x * x - y * y))


def on_a_plate() -> list[Scene]:
    """Rectangle, disc, two discs, annulus: areas in a plane."""
    plate = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    # The last step of Table 5.1: radius 0.2, axis 0.16 above the plate, 1 long; 0.24 wide.
    tube = lifted(lambda x, y: 0.16 - np.sqrt(0.04 - x * x))
    bowls = lifted(lambda x, y: 0.5 * (np.abs(x) - 0.6) ** 2 + 0.5 * y * y - 0.08)
    bead = lifted(lambda x, y: (np.hypot(x, y) - 1.0) ** 2 - 0.09)
    volume = np.pi * 0.2**2 * (1.0 - 0.2 / 3.0)
    return [
        Scene("cylinder on a plate", plate, tube, (0.17, 0.5), 0.24),
        Scene("ball in a plane", plate, ball_below(1.0, 0.8), (0.66, 0.66), 0.36 * np.pi),
        Scene("two discs", plate, bowls, (1.1, 0.6), 2 * 0.16 * np.pi),
        Scene("annulus", plate, bead, (1.4, 1.4), np.pi * (1.3**2 - 0.7**2)),
        Scene(
            "Winkler force", plate, ball_below(1.0, 0.8), (0.66, 0.66),
            WINKLER[0] / WINKLER[1] * volume, force=True,
        ),
    ]  # fmt: skip


def on_curved_masters() -> list[Scene]:
    """Caps, a trough that ends before its cylinder, the ring of a torus, a saddle."""
    hollow = cg.Body([cg.shapes.sphere(radius=1.0)]).flipped()
    rim = (0.8**2 - 1.0 - 0.22**2) / 0.44
    two = cg.Body([cg.shapes.sphere(radius=0.5, centre=[x, 0, 0]) for x in (-0.6, 0.6)])
    trough = cg.Body([cg.shapes.cylinder(radius=1.0, height=1.1, axis="x")]).flipped()
    side = (0.7**2 - 1.0 - 0.4**2) / 0.8
    round_rod = lifted(lambda x, y: -0.4 - np.sqrt(0.49 - y * y))
    torus = cg.Body([cg.shapes.torus(major=1.0, minor=0.4)])
    saddle = cg.Body([cg.shapes.saddle(width=2.0, length=2.0, height=0.25)])
    return [
        Scene("ball in a hollow ball", hollow, ball_below(0.8, -0.22), (0.5, 0.5),
              2 * np.pi * (1 + rim)),
        Scene("caps of two balls", two, lifted(lambda x, y: 0.35), (0.99, 0.99), 0.3 * np.pi),
        Scene("cylinder in a trough", trough, round_rod, (0.8, 0.6),
              2.0 * np.arccos(-side) * 1.1),
        Scene("ring of a torus", torus, lifted(lambda x, y: 0.3), (1.6, 1.6),
              4 * np.pi * 0.4 * np.arccos(0.75)),
        Scene("saddle", saddle, lifted(lambda x, y: 0.08), (1.1, 1.1), saddle_area(0.08)),
    ]  # fmt: skip


def saddle_area(level: float) -> float:
    """Area of z = (x² − y²)/4 over [−1, 1]² above a level."""
    from scipy.integrate import quad

    def strip(y: float) -> float:
        start = np.sqrt(4 * level + y * y)
        return quad(lambda x: np.sqrt(1 + 0.25 * (x * x + y * y)), start, 1.0)[0]

    end = np.sqrt(1 - 4 * level)
    return 2.0 * quad(strip, -end, end, epsabs=1e-13, epsrel=1e-13)[0]


def scenes() -> list[Scene]:
    """All of them."""
    return on_a_plate() + on_curved_masters()


def mesh(scene: Scene, shift: tuple[float, float], cells: int) -> cg.Slave:
    """The slave of a scene."""
    x, y = (
        h * (np.linspace(-1.0, 1.0, cells + 1) + 2.0 * (s - 0.5) / cells)
        for h, s in zip(scene.half, shift, strict=True)
    )
    xy = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
    i = np.arange(len(xy)).reshape(cells + 1, cells + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return cg.Slave(scene.place(xy), facets)


def touch(scene: Scene, slave: cg.Slave, area: object) -> cg.State:
    """The contact of a scene."""
    law = cg.StressLaw(WINKLER[0], thickness=WINKLER[1]) if scene.force else cg.PenaltyLaw(1.0)
    contact = cg.Contact(
        scene.body,
        slave,
        law=law,
        area=area,
        weights="area",
        search="penetration",
        contact_type=scene.side,
    )
    return contact.start(slave.points)


def error(scene: Scene, area: object, cells: int = CELLS) -> float:
    """Relative error, root mean square over the shifts."""
    states = [touch(scene, mesh(scene, shift, cells), area) for shift in SHIFTS]
    found = [state.total_force[2] if scene.force else state.total_area for state in states]
    return float(np.sqrt(np.mean((np.array(found) / scene.exact - 1.0) ** 2)))


def order(scene: Scene, area: object) -> float:
    """Slope of log error over log size, least squares."""
    errors = [error(scene, area, cells) for cells in REFINED]
    return float(-np.polyfit(np.log(REFINED), np.log(errors), 1)[0])


def run() -> list[str]:
    """The lines of the table."""
    lines = [f"{'error of':24s}" + "".join(f"{name:>14s}" for name in [*METHODS, "order, facets"])]
    for scene in scenes():
        found = [error(scene, area) for area in METHODS.values()]
        cells = "".join(f"{100 * e:12.3f} %" for e in found)
        lines.append(f"{scene.name:24s}{cells}{order(scene, METHODS['facets']):14.2f}")
    return lines

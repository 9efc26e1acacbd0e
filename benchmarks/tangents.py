"""The derivatives of the forces on a hundred thousand nodes, beside the step that makes them."""

from __future__ import annotations

from collections.abc import Iterator
from time import process_time
from typing import Any

import numpy as np

import contiga as cg
from benchmarks.sizes import Sizes
from benchmarks.stepping import ball
from benchmarks.table import Row
from benchmarks.timing import in_turns, on_threads

NODES = Row("tangent over its step, sphere", "×", 1.5, None)
SPLINES = Row("tangent over its step, splines", "×", 1.5, None)
GRIPPED = Row("tangent over its step, friction", "×", 1.5, None)
BETWEEN = Row("tangent over its step, three points a facet", "×", 1.5, None)


class Pressed:
    """A sheet around a body, all of which is in contact after a step."""

    def __init__(self, body: cg.Body, patch: cg.NurbsSurface, nodes: int, **options: Any) -> None:
        side = int(np.sqrt(nodes))
        (u0, u1), (v0, v1) = patch.domain
        # Off poles and seams, along which a sheet would meet itself.
        u, v = (
            np.linspace(a + 0.1 * (b - a), b - 0.1 * (b - a), side) for a, b in ((u0, u1), (v0, v1))
        )
        places = np.stack([axis.ravel() for axis in np.meshgrid(u, v, indexing="ij")], axis=1)
        points, normals = patch.evaluate(places), patch.normal(places)
        row = np.arange(side * side).reshape(side, side)
        corners = row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]
        quads = np.stack(corners, axis=-1).reshape(-1, 4)
        law = cg.StressLaw([[0.0, 0.0], [0.05, 0.3], [0.5, 0.7]], 0.1 * body.size)
        self.contact = cg.Contact(body, cg.Slave(points, quads), law=law, **options)
        self.before = points + 1e-3 * body.size * normals
        self.points = points - 1e-3 * body.size * normals
        self.state = self.contact.step(self.contact.start(self.before), self.points, dt=1.0)
        self.way = 1e-5 * body.size
        self.trial = self.state

    def step(self, k: int) -> None:
        """Make the state of iterate k."""
        self.trial = self.contact.step(self.state, self.points + k * self.way, dt=1.0)

    def tangent(self, _: int) -> None:
        """Make its tangent."""
        self.contact.tangent(self.trial)


def _compared(row: Row, pressed: Pressed, size: Sizes) -> Row:
    with on_threads(1):
        works = {"step": pressed.step, "tangent": pressed.tangent}
        seconds = in_turns(works, size.rounds, process_time)
    n = pressed.trial.n_contact
    each = {name: 1e9 * t / max(n, 1) for name, t in seconds.items()}
    note = f"{each['tangent']:.0f} and {each['step']:.0f} ns a node"
    value = seconds["tangent"] / seconds["step"]
    return row._replace(value=value, note=note, detail={"seconds": seconds})


def rows(size: Sizes) -> Iterator[Row]:
    """On nodes of a sheet that is pressed into a sphere and into splines, and between them."""
    nodes, sphere = size.points // 10, ball()
    bumpy = cg.Body([cg.shapes.bumpy_plate()])
    plain: dict[str, Any] = {"area": cg.NodalArea(1.0)}
    gripped = plain | {"friction": cg.Coulomb(0.3)}
    yield _compared(NODES, Pressed(sphere, sphere.patches[0], nodes, **plain), size)
    yield _compared(SPLINES, Pressed(bumpy, bumpy.patches[0], nodes, **plain), size)
    yield _compared(GRIPPED, Pressed(sphere, sphere.patches[0], nodes, **gripped), size)
    between = Pressed(sphere, sphere.patches[0], nodes // 6, quadrature=3)
    yield _compared(BETWEEN, between, size)

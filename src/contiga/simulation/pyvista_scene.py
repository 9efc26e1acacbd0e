"""Turn a state of a simulation into a `pyvista.MultiBlock`: a block for each body and slave."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contiga.extras import require
from contiga.rigid.frames import to_world
from contiga.simulation.fields import DRAWING_TOL, DrawnShape
from contiga.simulation.model import Model
from contiga.simulation.system_state import SystemState
from contiga.triangles.pyvista_mesh import pyvista_mesh

if TYPE_CHECKING:
    import pyvista

    from contiga.io.out.vtkhdf import FieldSeries


def scene_of_state(purpose: str, model: Model, state: SystemState) -> pyvista.MultiBlock:
    """Return bodies in their poses, and slaves with "penetration" (n,) and "force" (n, 3).

    At a node of several contacts they are the deepest penetration and the sum of the forces.

    Raises
    ------
    MissingPackageError
        pyvista is not installed.
    """
    require(purpose, "pyvista")
    import pyvista

    blocks = pyvista.MultiBlock()
    for name, part in model.bodies.items():
        mesh = part.body.tessellate(DRAWING_TOL * part.body.size)
        shape = model.shapes.points(name, state.time, state.slaves)
        placed = mesh.vertices if shape is None else DrawnShape(part.body, mesh).at(shape)
        points = to_world(state.bodies[name].pose, placed)
        blocks[name] = pyvista_mesh(purpose, points, mesh.triangles)
    for name, slave in model.slaves.items():
        points = state.slaves[name].points
        penetration, force = np.zeros(len(points)), np.zeros((len(points), 3))
        for contact in model.contacts:
            if contact.slave == name:
                touched = state.contacts[contact.name]
                np.maximum(penetration, touched.penetration[: len(points)], out=penetration)
                force += touched.force
        data = {"penetration": penetration, "force": force}
        blocks[name] = pyvista_mesh(purpose, points, slave.slave.facets, data)
    return blocks


def scene_of_fields(purpose: str, series: FieldSeries, step: int) -> pyvista.MultiBlock:
    """Return the parts of a recorded step, each with the fields of its points.

    Raises
    ------
    MissingPackageError
        pyvista is not installed.
    """
    require(purpose, "pyvista")
    import pyvista

    points = series.points(step)
    fields: dict[str, Any] = {name: series.data(step, name) for name in series.names}
    blocks = pyvista.MultiBlock()
    for part in series.parts:
        rows = series.rows(part.name)
        data = {name: values[rows] for name, values in fields.items()}
        blocks[part.name] = pyvista_mesh(purpose, points[rows], part.triangles, data)
    return blocks

"""Write fields of a run for ParaView, with all bodies and slaves in one data set.

The outlines of contact regions are a second file, if an area method has them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contiga.errors import InputError
from contiga.geometry.net import NetMotion, net_of
from contiga.io.out.outlines import Loops, OutlinesWriter
from contiga.io.out.vtkhdf import FieldsWriter, Part
from contiga.io.units import derived_units
from contiga.masters.protocol import Master
from contiga.masters.sampling import least_size, refined
from contiga.matter.element_fields import FIELDS, TENSORS, at_facets, at_nodes
from contiga.records import FloatArray, IndexArray, SurfacePlaces
from contiga.rigid.frames import to_world
from contiga.simulation.model import Model
from contiga.simulation.system_state import SystemState
from contiga.slaves.slave import Slave, own_nodes
from contiga.triangles.trimesh import TriMesh

# Largest departure of the drawn triangles from a body, relative to its size.
DRAWING_TOL = 2e-3
MAX_TRIANGLES = 1_000_000
"""Largest number of triangles of a body in fields with a given size."""
_BYTES_PER_POINT = 200
"""Bytes of a point with its fields, and of the outlines per point."""


class Fields:
    """Writes the fields and outlines of a run, step by step.

    Raises `InputError` if the output's `size` needs more than `MAX_TRIANGLES` for a body.

    Parameters
    ----------
    model : the model that is run
    path, outlines : the two files
    written : number of steps in existing files, which are kept; None starts new files
    """

    def __init__(
        self, model: Model, path: Path, outlines: Path, written: int | None = None
    ) -> None:
        self._model = model
        self._element_fields = model.output.fields if model.mechanism.deforms else ()
        self._cells = bool(self._element_fields) and model.output.cells
        self._meshes: dict[str, TriMesh] = {
            name: _body_mesh(name, part.body, model.output.size)
            for name, part in model.bodies.items()
        }
        self._shapes = {
            name: DrawnShape(model.bodies[name].body, self._meshes[name])
            for name in model.shapes.of
        }
        self._node_rows = {name: own_nodes(part.slave) for name, part in model.slaves.items()}
        parts = [
            Part(name, "body", len(mesh.vertices), mesh.triangles)
            for name, mesh in self._meshes.items()
        ] + [
            _slave_part(name, part.slave, self._node_rows[name])
            for name, part in model.slaves.items()
        ]
        self._part = np.repeat(np.arange(len(parts), dtype=np.int32), [p.n_points for p in parts])
        outlined = has_outlines(model)
        if written is None:
            units: dict[str, str] = {}
            if all(model.units):
                derived = derived_units(*model.units)
                units = {
                    **dict.fromkeys(("Points", "penetration", "gap"), model.units[0]),
                    "force": derived["force"],
                    "area": derived["area"],
                    **dict.fromkeys(("pressure", "stress", "von_mises"), derived["stress"]),
                    "energy_density": f"{derived['energy']}/{model.units[0]}³",
                }
            self._writer = FieldsWriter(path, parts, units)
            self._outlines = OutlinesWriter(outlines) if outlined else None
        else:
            self._writer = FieldsWriter.reopen(path, written)
            self._outlines = OutlinesWriter.reopen(outlines, written) if outlined else None

    @property
    def n_bytes(self) -> int:
        """Largest number of bytes of a step, before compression."""
        columns = sum(6 if field in TENSORS else 1 for field in self._element_fields)
        of_cells = self._writer.n_cells if self._cells else 0
        return (_BYTES_PER_POINT + 8 * columns) * len(self._part) + 8 * columns * of_cells

    def append(self, state: SystemState) -> None:
        """Write the points and fields of one step, and its outlines if the run has them.

        At a node of several contacts forces add up; the other fields are those of the last contact
        in the model that it touches. Off contact penetration, normal, area and pressure are 0, the
        gap is NaN and the cluster −1. Points of bodies, and inactive nodes off contact, have the
        status −1.
        """
        bodies = []
        for name, mesh in self._meshes.items():
            shape = self._model.shapes.points(name, state.time, state.slaves)
            vertices = mesh.vertices if shape is None else self._shapes[name].at(shape)
            bodies.append(to_world(state.bodies[name].pose, vertices))
        first = sum(len(b) for b in bodies)
        slaves = [state.slaves[name].points[self._node_rows[name]] for name in self._model.slaves]
        points = np.concatenate(bodies + slaves)
        k = len(points)
        data: dict[str, NDArray[np.generic]] = {
            "part": self._part,
            "contact_status": np.where(np.arange(k) < first, -1, 0).astype(np.int32),
            "penetration": np.zeros(k),
            "gap": np.full(k, np.nan),
            "normal": np.zeros((k, 3)),
            "force": np.zeros((k, 3)),
            "area": np.zeros(k),
            "pressure": np.zeros(k),
            "cluster": np.full(k, -1, np.int32),
        }
        for field in self._element_fields:
            data[field] = np.full((k, 6) if field in TENSORS else k, np.nan)
        cells: list[dict[str, FloatArray]] = []
        for name, slave in self._model.slaves.items():
            node_rows = self._node_rows[name]
            n = len(node_rows)
            data["contact_status"][first : first + n][~slave.slave.active[node_rows]] = -1
            element_values = self._model.mechanism.nodes[name].inside(state.slaves[name])
            if element_values:
                means = at_nodes(element_values, len(slave.slave))
                for field in self._element_fields:
                    data[field][first : first + n] = FIELDS[field](means)[node_rows]
            if self._cells and slave.slave.facets is not None:
                facet_values = at_facets(element_values, slave.slave.facets)
                cells.append({field: FIELDS[field](facet_values) for field in self._element_fields})
            for part in self._model.contacts:
                if part.slave == name:
                    # Write over the fields of other contacts of the same slave.
                    rows, contact = slice(first, first + n), state.contacts[part.name]
                    is_touching: NDArray[np.bool_] = contact.in_contact[node_rows]
                    status = data["contact_status"][rows]
                    is_shown = is_touching | (status == 0)
                    status[is_shown] = contact.status[node_rows][is_shown]
                    contact_fields: dict[str, NDArray[np.generic]] = {
                        "penetration": contact.penetration,
                        "gap": -contact.penetration,
                        "normal": contact.normal,
                        "area": contact.area,
                        "pressure": contact.pressure,
                        "cluster": contact.clusters,
                    }
                    for field, values in contact_fields.items():
                        data[field][rows][is_touching] = values[node_rows][is_touching]
                    total = data["force"][rows]
                    total += contact.force[node_rows]  # type: ignore[misc]  # float arrays, both
            first += n
        # Outlines first: a stop between the two leaves one step too many, which resuming drops.
        if self._outlines is not None:
            lines, counts = [np.zeros((0, 3))], [np.zeros(0, np.int64)]
            clusters, contacts = [np.zeros(0, np.int32)], [np.zeros(0, np.int32)]
            for k, part in enumerate(self._model.contacts):
                outlines = part.contact.outlines(state.contacts[part.name])
                if outlines is not None:
                    lines.append(outlines.points)
                    counts.append(np.diff(outlines.first))
                    clusters.append(outlines.clusters)
                    contacts.append(np.full(len(outlines.clusters), k, np.int32))
            begin = np.concatenate(([0], np.cumsum(np.concatenate(counts)))).astype(np.int64)
            of_lines = np.concatenate(clusters), np.concatenate(contacts)
            self._outlines.append(state.time, Loops(np.concatenate(lines), begin, *of_lines))
        stacked = {}
        if self._cells:  # rows: points of clouds, triangles of bodies, facets of slaves
            n_before = self._writer.n_cells - sum(len(next(iter(each.values()))) for each in cells)
            for field in self._element_fields:
                nan_rows = np.full((n_before, 6) if field in TENSORS else n_before, np.nan)
                stacked[field] = np.concatenate([nan_rows, *(each[field] for each in cells)])
        self._writer.append(state.time, points, data, stacked)

    def flush(self) -> None:
        """Write the appended steps to the disk."""
        self._writer.flush()

    def close(self) -> None:
        """Close both files."""
        try:
            if self._outlines is not None:
                self._outlines.close()
        finally:
            self._writer.close()


class DrawnShape:
    """The vertices of a drawn body that changes its shape."""

    def __init__(self, body: Master, mesh: TriMesh) -> None:
        assert body.faces is not None
        feet = body.project(mesh.vertices)
        self._body = body.faces
        self._feet, self._rest = SurfacePlaces(feet.patch, feet.uv), feet.point

    def at(self, points: FloatArray) -> FloatArray:
        """Return vertices (n, 3), body axes, for control points (m, 3)."""
        rest = net_of(self._body).points
        change = NetMotion(self._body, rest, points - rest)
        return self._rest + change.carry(self._feet, self._rest)


def _slave_part(name: str, slave: Slave, node_rows: IndexArray) -> Part:
    facets = slave.facets
    if facets is not None:
        new_index = np.zeros(len(slave), facets.dtype)
        new_index[node_rows] = np.arange(len(node_rows))
        facets = new_index[facets]
    return Part(name, "slave", len(node_rows), facets)


def _body_mesh(name: str, body: Master, size: float | None) -> TriMesh:
    """Return the triangles that draw a body; of exact geometry with sides up to `size`, if given.

    Raises `InputError` for a size that takes more than `MAX_TRIANGLES` triangles.
    """
    mesh = body.tessellate(DRAWING_TOL * body.size)
    if size is None or body.faces is None:
        return mesh
    min_size = least_size(mesh, MAX_TRIANGLES)
    if size < min_size:
        raise InputError(
            f"would draw {name} by more than {MAX_TRIANGLES:,} triangles in every set of fields",
            where="output.size",
            found=size,
            allowed=f"{min_size:.3g} or more",
        )
    return refined(body, mesh, size)


def has_outlines(model: Model) -> bool:
    """Return whether any contact has outlines of its regions."""
    return any(part.contact.has_outlines for part in model.contacts)

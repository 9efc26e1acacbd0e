"""Descriptions of a case in words."""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import length, product
from contiga.case.contact_spec import QUADRATURE, ContactSpec
from contiga.case.schema import Case
from contiga.dynamics.stepping import EqualSteps
from contiga.masters.protocol import Master
from contiga.placement.sample import extent_at
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Quantities
from contiga.simulation.simulation import Simulation
from contiga.simulation.step import place
from contiga.slaves.slave import box_of

_TRIANGLE_TOL = 0.02
"""Tolerance of the triangles that determine the direction a body faces, over its size."""
_MIN_FACING_SHARE = 0.05
"""Smallest mean of the unit normals of a body that faces one direction."""
_DEFAULT_AREA = "facets cut where contact ends, else tributary"
_WEIGHTS = {
    "rest": "areas of the slave at rest",
    "area": "contact areas as measured: forces make and lose energy",
}


def describe(case: Case) -> list[tuple[str, str]]:
    """Return rows (subject, description) of a case for a person to read before a run.

    Nothing is built and no mesh is read.
    """
    from contiga.io.units import derived_units

    units = case.units
    derived = derived_units(units.length, units.mass, units.time)
    steps = case.time.stepping()
    times = f"{steps.start:g} to {steps.end:g} {units.time}"
    if isinstance(steps, EqualSteps):
        times += f" in {steps.count} steps of {steps.step:g}"
    else:
        times += f" in automatic steps of at most {steps.most:g}"
    rows = [
        ("title", case.title),
        ("units", f"{units.length}, {units.mass}, {units.time}"),
        ("derived units", f"force {derived['force']}, stress {derived['stress']}"),
        ("time", times),
    ]
    if any(case.world.gravity):
        rows.append(("gravity", f"{case.world.gravity} {units.length}/{units.time}²"))
    if case.settle is not None:
        rows.append(("settles", case.settle.describe()))
    for body in case.body:
        rows.append((f"body {body.name}", _with_placement(body.geometry.describe(), body.geometry)))
        if body.mass is not None:
            rows.append(("  mass", body.mass.describe()))
        if body.layer is not None:
            rows.append(("  layer", body.layers()))
        rows.append(("  motion", body.motion.describe()))
    for slave in case.slave:
        rows.append((f"slave {slave.name}", _with_placement(slave.describe_source(), slave.source)))
        rows.append(("  motion", slave.motion.describe()))
        nodal = [f"{k} {v:g}" for k in ("thickness", "area", "mass") if (v := getattr(slave, k))]
        if nodal:
            rows.append(("  every node", ", ".join(nodal)))
    for belt in case.belt:
        rows.append((f"belt {belt.name}", belt.describe()))
        rows += [(f"  {end}", webbing.describe()) for end, webbing in belt.webbing.items()]
    deforming = {
        slave.name
        for slave in case.slave
        if slave.motion.kind == "deform" and (slave.points or slave.mesh)
    }
    deforming |= {belt.name for belt in case.belt}
    for contact in case.contact:
        rows += _contact(contact, case.sides(contact).type, contact.slave in deforming)
    for k, load in enumerate(case.load):
        rows.append((f"load {k}", load.describe()))
    for spring in case.spring:
        rows.append((f"spring {spring.name or '-'.join(spring.between)}", spring.describe()))
    for ring in case.slip_ring:
        rows.append((f"slip ring {ring.instance.name}", ring.describe()))
    for joint in case.joint:
        rows.append((f"joint {joint.instance.name}", joint.describe()))
    for chamber in case.gas:
        rows.append((f"gas {chamber.name}", chamber.describe()))
    for sensor in case.sensor:
        rows.append((f"sensor {sensor.name}", sensor.describe()))
    rows += [("plot", plot.describe()) for plot in case.plot]
    rows += [(f"test {curve.name}", curve.describe()) for curve in case.reference]
    output = case.output
    kinds = [*output.formats, *(["report"] if output.report else [])]
    interval = f"{output.every} steps" if output.interval is None else f"{output.interval:g}"
    rows.append(("output", f"{', '.join(kinds) or 'none'}; fields every {interval}"))
    return rows


def placed_parts(simulation: Simulation) -> list[tuple[str, str]]:
    """Return rows (part, size and place at the start) of a built case.

    Of slaves the box of the active points counts; of open bodies the free side is described.
    """
    quantities = Quantities(simulation.units)
    start = place(simulation, None, simulation.stepping.start)
    rows = []
    for name, (body, _) in simulation.bodies.items():
        pose = start.bodies[name].pose
        free_side = "" if body.closed else f"; {_free_side(body, pose)}"
        rows.append((f"body {name}", _box(quantities, extent_at(body, pose)) + free_side))
    for name, (slave, _) in simulation.slaves.items():
        count = int(slave.active.sum())
        active = "" if count == len(slave) else f", {count} of {len(slave)} points active"
        box = box_of(start.slaves[name].points, slave.active)
        rows.append((f"slave {name}", _box(quantities, box) + active))
    return rows


def _box(quantities: Quantities, bounds: FloatArray) -> str:
    """Return the size and the corners of a box in words."""
    size = " × ".join(f"{x:.4g}" for x in np.ptp(bounds, axis=0))
    unit = quantities.unit("length") if quantities.known else ""
    low, high = (", ".join(f"{x:.6g}" for x in corner) for corner in bounds)
    return f"{size} {unit}, from [{low}] to [{high}]"


def _free_side(body: Master, pose: FloatArray) -> str:
    """Return the mean direction that an open body faces at `pose`, world axes, in words.

    If the mean of its unit normals, weighted by area, is shorter than 0.05, none is named.
    """
    mesh = body.tessellate(_TRIANGLE_TOL * body.size)
    p = mesh.vertices[mesh.triangles]
    vectors = 0.5 * np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    area = np.sqrt(np.square(vectors).sum(axis=1)).sum()
    normal = product(pose[:3, :3], vectors.sum(axis=0))
    if not length(normal) > _MIN_FACING_SHARE * area:
        return "open, its free sides face all ways"
    direction = ", ".join(f"{x:.2g}" for x in normal / length(normal))
    return f"open, its free side faces [{direction}]"


def description(case: Case) -> str:
    """Return `describe` as plain text in two columns."""
    rows = describe(case)
    width = max(len(subject) for subject, _ in rows)
    return "\n".join(f"{subject:<{width}}  {text}" for subject, text in rows)


def _with_placement(text: str, spec: object) -> str:
    """Return a description of a source, followed by its transforms, flip, alignment and place."""
    steps = len(getattr(spec, "transform", [])) + len(getattr(spec, "then", []))
    moved = f", placed by {steps} transforms" if steps else ""
    flipped = ", flipped" if getattr(spec, "flip", False) else ""
    texts = [entry.describe() for key in ("align", "place") if (entry := getattr(spec, key, None))]
    return ", ".join([text + moved + flipped, *texts])


def _contact(contact: ContactSpec, kind: str, deforms: bool) -> list[tuple[str, str]]:
    """Return the rows (subject, description) of a contact.

    `kind` is its type, which tells the side that deforms; `deforms` tells whether its slave is a
    mesh that deforms.
    """
    laws = [] if contact.law is None else [("  law", contact.law.describe())]
    if contact.master_law is not None:
        laws.append(("  master law", contact.master_law.describe()))
    if contact.friction is not None:
        laws.append(("  friction", contact.friction.describe()))
    area = _DEFAULT_AREA if contact.area is None else contact.area.describe()
    if contact.quadrature is None:
        points = f", at {QUADRATURE} points a facet where it can have them" if deforms else ""
    else:
        is_nodal = contact.quadrature == "nodes"
        points = "" if is_nodal else f", at {contact.quadrature} points a facet"
    if contact.shell_thickness:
        points += ", from half the thickness of the shell on"
    return [
        (f"contact {contact.title}", f"{contact.slave} against {contact.master}"),
        ("  search", f"{contact.search}, type {kind}, foot {contact.foot}"),
        ("  at an edge", f"{contact.on_edge}; after tunnelling: {contact.through}"),
        *laws,
        ("  weights", _WEIGHTS[contact.weights] + points),
        ("  area", area),
    ]

"""Scenes that need, one after the other, the kernels that runs need; nobody wants their results."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from tests import nothing_compiled
from tests.blocks import block
from tests.kernels.scenes import cloud, plate, puck, sheet

import contiga as cg
from contiga.contact.foot_rows import blank
from contiga.errors import MissingPackageError
from contiga.extras import require
from contiga.gas import Chamber, IdealGas, Inflator, Surroundings
from contiga.matter.iga import Symmetry, assemble_shell
from contiga.records import FloatArray, IntArray
from contiga.report import write_report
from contiga.search.balls.radii import balls_of
from contiga.search.sweep.piece_lists import MIN_PATHS
from contiga.search.tables import tables_of

ALL = (
    *("run", "flight", "meshes", "balls", "followed", "paths", "sides", "closest", "rubbed"),
    *(
        "deep",
        "readme",
        "crowds",
        "areas",
        "pressed",
        "simulations",
        "files",
        "triangles",
        "shapes",
    ),
    "deformed",
    "reshaped",
    "derivatives",
    "gas",
    "joined",
)
"""In the order in which runs come to what they need."""
MANY = 300
"""Points of a search: threads and lanes take no fewer."""
CROWD = 5000
"""Points that are put in order first."""
FOAM = cg.StressLaw([[0.0, 0.0], [0.3, 2.0]], unloading=0.1, hysteresis_slope=8.0, damping=0.1)


def run() -> None:
    """A puck falls on a sheet, with friction, and with files and report, if what writes them is."""
    simulation = _fall(0.005, end=0.05)
    if not _is_there("output", "h5py"):
        simulation.run()
        return
    with TemporaryDirectory() as folder:
        simulation.run(Path(folder) / "out")
        if _is_there("a report", "plotly", "matplotlib"):
            write_report(Path(folder) / "out")


def meshes() -> None:
    """Triangles of whole patches, and of what trims leave of them."""
    for face in (cg.shapes.sphere(), cg.shapes.bumpy_plate()):
        face.tessellate(0.05, method="net")
        face.tessellate(0.02)
    for body in (plate(), puck()):
        body.tessellate(0.02)


def shapes() -> None:
    """Curves and patches that are measured and refined."""
    arc = cg.shapes.arc()
    arc.length()
    arc.elevate(1)
    face = cg.shapes.sphere()
    face.elevate(1, 1)
    face.insert_knots(u=[0.4], v=[0.4])
    face.area()


def flight() -> None:
    """A free body, an elastic spring and one with hysteresis, with nothing to touch."""
    motion = cg.motion.Free(2.0, inertia=np.diag([1.0, 2.0, 3.0]), spin=(0.0, 6.0, 0.0))
    at = [[0.0, 0.0, 0.0], [0.0, 0.0, 3.0]]
    spring = cg.Spring(("body", "ground"), at=at, curve=5.0)
    webbing = {"curve": 1.0, "unloading": 0.1, "hysteresis_slope": 8.0}
    belt = cg.Spring(("body", "ground"), at=at, name="belt", **webbing)  # type: ignore[arg-type]
    cg.Simulation(
        bodies={"body": (cg.Body(cg.shapes.sphere()), motion)},
        slaves={},
        contacts=[],
        end=0.1,
        step="auto",
        gravity=(0.0, 0.0, -1.0),
        springs=[spring, belt],
    ).run()


def balls() -> None:
    """Balls that touch a body at its feet and fit in it, and closest points proved by them."""
    for body in (puck(), plate()):
        balls_of(tables_of(body))
        body.project(_points())


def deep() -> None:
    """Points that go through the middle of a body, of which the nearest wall does not hold them."""
    for body in (puck(), puck().tessellate(0.02)):
        low, high = body.bounds()
        points = 0.5 * (low + high) + (high - low) * np.array([[0.0, 0.0, 0.55]])
        contact = cg.Contact(body, cg.Slave(points, area=[1.0]), law=cg.PenaltyLaw(1.0))
        state = contact.start(points)
        for share in (0.1, 0.3, 0.6, 0.7):
            state = contact.step(state, points - [0.0, 0.0, share * (high[2] - low[2])])


def followed() -> None:
    """Feet that go on over trims, creases and borders."""
    for body in (puck(), plate()):
        patch, uv, before = _feet(body)
        out = blank(len(patch))
        for way in (0.01, 0.8):
            now = before + way * np.array([0.6, 0.3, -0.1])
            body.surface.track(now, patch, uv, out, before)
            body.surface.track(now, patch, uv, out)


def sides() -> None:
    """What lies inside a closed body, and how much it weighs."""
    puck().contains(_points())
    puck().mass_properties(1.0)
    puck().area()


def paths() -> None:
    """Where points go in."""
    points = _points()
    for body in (puck(), plate()):
        body.first_hit(points, 0.2 * points)
        # So many that pieces are listed for them.
        many = np.resize(points, (MIN_PATHS, 3))
        body.first_hit(many, 1.001 * many)


def closest() -> None:
    """Feet of points anywhere."""
    points = _points()
    for body in (puck(), plate()):
        feet = body.project(points)
        body.project(points + 0.01, start=feet, mode="track")


def crowds() -> None:
    """Many points in no order, over a patch of many pieces and over many triangles."""
    body = cg.Body([cg.shapes.bumpy_plate(waves=3)])
    patch, uv, points = _feet(body, CROWD)
    body.surface.track(points, patch, uv, blank(CROWD), points - 0.001)
    mesh = body.tessellate(0.01)
    mesh.project(points)


def pressed() -> None:
    """Sheets with facets on closed and open bodies, by every choice of the search."""
    choices: list[dict[str, str | int]] = [
        {},
        {"through": "hold"},
        {"search": "penetration"},
        {"on_edge": "hold", "quadrature": 3},
        {"weights": "area"},
        {"contact_type": "master"},
    ]
    for body in (puck(), plate()):
        for options in choices:
            _press(body, sheet(), area=cg.FacetArea(), **options)


def areas() -> None:
    """Areas of facets, clouds and hulls, on either side, and their outlines."""
    on_facets: list[cg.AreaMethod] = [cg.FacetArea("master"), cg.CloudArea(by="feet")]
    for area in (*on_facets, cg.CloudArea("master")):
        _press(puck(), sheet(), area=area)
    on_points: list[cg.AreaMethod] = [cg.HullArea(), cg.HullArea(mapping="exact"), cg.CloudArea()]
    for area in on_points:
        _press(plate(), cloud(), area=area)


def readme() -> None:
    """Its ten lines, with a law of the force."""
    nothing_compiled.pressed()


def rubbed() -> None:
    """Friction of both kinds."""
    for friction in (cg.Coulomb(0.4), cg.ViscousFriction(0.4, 0.1)):
        _press(puck(), sheet(), friction=friction)


def derivatives() -> None:
    """Of forces on exact bodies and triangles, with friction, between nodes, and off shells."""
    choices: list[dict[str, object]] = [
        {"friction": cg.Coulomb(0.4)},
        {"friction": cg.ViscousFriction(0.4, 0.1)},
        {"quadrature": 3},
        {"shell_thickness": 0.1},
    ]
    for master in (puck(), plate(), puck().tessellate(0.01)):
        for options in choices:
            slave = sheet()
            contact = cg.Contact(master, slave, law=FOAM, **options)  # type: ignore[arg-type]
            state = contact.start(slave.points - np.array([0.0, 0.0, 0.8]))
            state = contact.step(state, slave.points - np.array([0.0, 0.0, 0.4]), dt=0.1)
            contact.linearise(state)


def triangles() -> None:
    """A mesh as the rigid body."""
    points = _points()
    for body in (puck(), plate()):
        mesh = body.tessellate(0.01)
        mesh.project(points + 0.01, start=mesh.project(points), mode="track")
        mesh.first_hit(points, 0.2 * points)
        for options in ({}, {"search": "penetration"}, {"through": "hold"}):
            _press(mesh, sheet(), area=cg.FacetArea(), **options)
    puck().tessellate(0.01).contains(points)


def simulations() -> None:
    """Steps that are as long as may be, and nodes that are free."""
    _fall("auto", end=0.01).run()
    slave = sheet(height=-0.6)
    cg.Simulation(
        bodies={"puck": puck()},
        slaves={"sheet": (slave, cg.motion.Free(velocity=(0.0, 0.0, 2.0)))},
        contacts=[cg.Contact(puck(), slave, law=FOAM, quadrature=3)],
        end=0.1,
        step=0.02,
    ).run()


def gas() -> None:
    """A ball of cloth that gas blows up."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)]).tessellate(0.1)
    air = Surroundings(1.0, 293.0, IdealGas(1.4, 1e-3))
    elastic = cg.materials.Elastic(young=10.0, poisson=0.3)
    cloth = cg.motion.Deforming(material=elastic, density=1.0, thickness=0.1)
    cg.Simulation(
        bodies={},
        slaves={"ball": (cg.Slave(ball.vertices, ball.triangles), cloth)},
        contacts=[],
        gas=[Chamber("ball", air, inflators=[Inflator(1.0, 300.0)])],
        end=3e-3,
        step=1e-3,
    ).run()


def joined() -> None:
    """Two links that joints move together at the start, one with a law, swing."""
    bodies = {}
    for name, x in (("upper", 0.5), ("lower", 1.6)):
        motion = cg.motion.Free(1.0, inertia=np.eye(3), centre=(x, 0.0, 0.0))
        bodies[name] = cg.Body([cg.shapes.sphere(radius=0.3, centre=(x, 0.0, 0.0))]), motion
    pin = cg.Joint(
        "revolute", "ground", "upper", at=[0, 0, 0], axis=[0, 1, 0], angle=cg.JointLaw(1.0)
    )
    eye = cg.Joint("spherical", "upper", "lower", at=[[1.0, 0.0, 0.0], [1.1, 0.0, 0.0]])
    cg.Simulation(
        bodies=bodies,
        slaves={},
        contacts=[],
        joints=[pin, eye],
        gravity=(0.0, 0.0, -9.81),
        end=0.02,
        step=0.01,
    ).run()


def files() -> None:
    """A body as STEP, read again, where there is what reads it."""
    if not _is_there("reading CAD", "OCP"):
        return
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    box = BRepPrimAPI_MakeBox(2.0, 2.0, 1.0).Shape()
    fillet = BRepFilletAPI_MakeFillet(box)
    fillet.Add(0.2, TopoDS.Edge(TopExp_Explorer(box, TopAbs_EDGE).Current()))
    writer = STEPControl_Writer()
    writer.Transfer(fillet.Shape(), STEPControl_AsIs)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "box.step"
        writer.Write(str(path))
        body = cg.read_cad(path)
    body.contains(_points())
    body.tessellate(0.05)


def deformed() -> None:
    """Matter of all elements and materials, pressed together."""
    corners = np.array([[i >> 0 & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)], float)
    brick, cut = [[0, 1, 3, 2, 4, 5, 7, 6]], [[0, 1, 2, 4], [3, 2, 1, 7]]
    elastic, rubber = cg.materials.Elastic(young=1.0, poisson=0.3), {"young": 1.0, "poisson": 0.3}
    foam = cg.materials.Foam(loading=[[0.0, 0.0], [0.9, 3.0]], tension=3.0)
    woven = cg.materials.Fabric(warp=3.0, weft=2.0, shear=0.4, direction=[1.0, 0.0, 0.0])
    solids = (elastic, cg.materials.NeoHooke(**rubber), foam)
    averaged = cg.materials.NeoHooke(**rubber, volume="nodes")
    slack = cg.materials.Elastic(young=1.0, compression=False)
    belt = cg.materials.Belt(loading=0.3)
    flat, line = {"thickness": 0.1}, {"section": 0.1}
    for kind, elements, made_of, more in (
        *(("hex8", brick, of, {"bulk_viscosity": (0.06, 1.5)}) for of in solids),
        *(("tet4", cut, of, {"bulk_viscosity": (0.06, 1.5)}) for of in (*solids, averaged)),
        *(("tri3", [[0, 1, 2], [3, 2, 1]], of, flat) for of in (elastic, slack, solids[1], woven)),
        *(("bar2", [[0, 1]], of, line) for of in (elastic, slack, belt)),
    ):
        rows = np.array(elements)
        own, at = np.unique(rows, return_inverse=True)
        part = cg.matter.Part(
            kind=kind, elements=at.reshape(rows.shape), material=made_of, density=1.0, **more
        )
        matter = cg.matter.assemble(corners[own], [part])
        pressed = matter.forces(matter.start(), 0.98 * corners[own], corners[own], 1e-3)
        matter.stiffness(pressed.state)
    _splines()
    _soft()


def reshaped() -> None:
    """Control points of a body that move, with friction, a thickness and neither."""
    slave = sheet()
    for body in (cg.Body([cg.shapes.bumpy_plate(waves=3)]), cg.Body([cg.shapes.sphere()])):
        control = body.net.points
        for friction in (None, cg.Coulomb(0.4)):
            contact = cg.Contact(body, slave, law=FOAM, friction=friction, shell_thickness=0.2)
            top = body.bounds()[1, 2]
            far, near = (slave.points + np.array([0.0, 0.0, top + z]) for z in (0.2, 0.08))
            state = contact.start(far, control_points=control)
            for scale in (1.01, 1.02):
                state = contact.step(state, near, control_points=scale * control, dt=0.1)
            contact.linearise(state)
        thin = cg.Contact(body, slave, law=FOAM)
        state = thin.start(far, control_points=control)
        for depth in (0.05, 0.06):
            points = slave.points + np.array([0.0, 0.0, top - depth])
            state = thin.step(state, points, control_points=1.01 * control, dt=0.1)


def _splines() -> None:
    """Shells of two patches that share an edge, and of one at a plane of symmetry."""
    leaves = [cg.shapes.plane(width=1.0, length=1.0, centre=(x, 0.0, 0.0)) for x in (0.0, 1.0)]
    elastic = cg.materials.Elastic(young=1.0, poisson=0.3)
    bent = [leaf.k_refined((1, 1), [0.5], [0.5]) for leaf in leaves]
    plane = Symmetry("u0", np.array([1.0, 0.0, 0.0]))
    for contact, leaves, symmetry in (("nodes", bent, ()), ("gauss", bent[:1], [plane])):
        shell = assemble_shell(
            leaves,
            material=elastic,
            density=1.0,
            thickness=0.1,
            contact=contact,
            symmetry=symmetry,
        )
        state = shell.start()
        shell.spread(shell.points(1.01 * state.points))
        pressed = shell.forces(state, 1.01 * state.points, state.points, 1e-3)
        shell.stiffness(pressed.state)
        shell.tangent(pressed.state)


def _soft() -> None:
    """A block of foam falls on a plate: nodes that are stepped, and put right after a step."""
    slave = block((3, 3, 2), (0.4, 0.4, 0.2), (-0.2, -0.2, 0.51), kind="hexahedron")
    soft = cg.motion.Deforming(
        material=cg.materials.Foam(loading=[[0.0, 0.0], [0.9, 3.0]], tension=3.0),
        density=1.0,
        velocity=(0.0, 0.0, -1.0),
        damping=0.1,
    )
    cg.Simulation(
        bodies={"puck": puck()},
        slaves={"block": (slave, soft)},
        contacts=[cg.Contact(puck(), slave, law=cg.PenaltyLaw(10.0))],
        end=0.05,
        step="auto",
        gravity=(0.0, 0.0, -1.0),
    ).run()


def _points() -> FloatArray:
    """(MANY, 3) in and around the bodies."""
    return np.random.default_rng(0).uniform(-1.3, 1.3, (MANY, 3))


def _feet(body: cg.Body, n: int = MANY) -> tuple[IntArray, FloatArray, FloatArray]:
    """Patch (n,) and parameters (n, 2) all over a body, and points (n, 3) a little above."""
    uv = np.random.default_rng(0).uniform(0.02, 0.98, (n, 2))
    patch = np.arange(n, dtype=np.int32) % len(body.patches)
    points = np.empty((n, 3))
    for k, face in enumerate(body.patches):
        own = patch == k
        if body.trims[k] is not None:  # near the rim of what is left of it
            uv[own] = 0.5 + 0.3 * (uv[own] - 0.5)
        points[own] = face.evaluate(uv[own]) + 0.05 * face.normal(uv[own])
    return patch, uv, points


def _press(body: cg.Master, slave: cg.Slave, **options: object) -> None:
    """A sheet goes up and down through what is above it, and a little to the side."""
    contact = cg.Contact(body, slave, law=FOAM, **options)  # type: ignore[arg-type]
    heights = (-0.8, -0.45, -0.4, -0.35, 0.8, -0.8)
    state = contact.start(slave.points + np.array([0.0, 0.0, heights[0]]))
    for k, height in enumerate(heights[1:]):
        state = contact.step(state, slave.points + np.array([0.01 * k, 0.0, height]), dt=0.1)
        contact.areas(state)
        contact.outlines(state)
        contact.pressure(state)


def _fall(step: float | str, end: float) -> cg.Simulation:
    """A puck falls on a sheet."""
    slave = sheet(height=-0.505)
    motion = cg.motion.Free(puck().mass_properties(0.1), velocity=(0.1, 0.0, -2.0))
    contact = cg.Contact(puck(), slave, law=FOAM, area=cg.FacetArea(), friction=cg.Coulomb(0.4))
    return cg.Simulation(
        bodies={"puck": (puck(), motion)},
        slaves={"sheet": slave},
        contacts={"contact": contact},
        end=end,
        step=step,
        gravity=(0.0, 0.0, -1.0),
        sensors=[cg.Sensor("head", "puck")],
        title="puck on a sheet",
        units=("mm", "g", "ms"),
    )


def _is_there(purpose: str, *modules: str) -> bool:
    """Whether what an exercise needs is installed."""
    with suppress(MissingPackageError):
        require(purpose, *modules)
        return True
    return False

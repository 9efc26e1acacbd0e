"""Vibrating shells of splines, bodies that change their shape, and contact between shells."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import eigh

import contiga as cg
from contiga.matter.iga import Shell, assemble_shell
from contiga_validation.closed_forms.case import Answer, Cases, order_of, relative, zero
from contiga_validation.closed_forms.matter import carried_along
from contiga_validation.closed_forms.pictures import comparison, errors_over
from contiga_validation.closed_forms.scenes import run_of
from contiga_validation.closed_forms.shells import (
    GROUP,
    disc,
    free_dofs,
    in_elements,
    octant,
    plate,
    refined,
    rim,
)
from contiga_validation.closed_forms.vibrations import BEAM, DRUM, cantilever_mode
from contiga_validation.engine.arrays import FloatArray, IntArray

CASES = Cases(GROUP)


def _slowest(shell: Shell, free: IntArray, q: FloatArray) -> tuple[float, FloatArray]:
    """Return the first circular frequency of a shell with control points `q`, and its mode (m, 3).

    `free` numbers the degrees of freedom that are not held; masses are lumped.
    """
    state = shell.start()._replace(points=q)
    stiffness = shell.tangent(state)[free][:, free].toarray()
    masses = np.diag(shell.mass[free // 3])
    (square,), mode = eigh(stiffness, masses, subset_by_index=[0, 0])
    displacements = np.zeros(q.size)
    displacements[free] = mode[:, 0]
    return math.sqrt(square), displacements.reshape(q.shape)


YOUNG, DENSITY, THICKNESS, LENGTH = 3.0, 2.0, 0.1, 10.0


def _strip(count: int) -> tuple[Shell, float, FloatArray]:
    """Return a cantilever of `count` elements of degree 2, its first frequency and mode (m, 3)."""
    shell = assemble_shell(
        [plate(2, (count, 1), (LENGTH, 1.0))],
        material=cg.materials.Elastic(young=YOUNG),
        density=DENSITY,
        thickness=THICKNESS,
    )
    free = free_dofs(shell, (shell.net.edge("u0", rows=2), "xyz"))
    return shell, *_slowest(shell, free, shell.nodes)


@CASES.add(
    "shell-swing",
    "A cantilever of splines swings",
    "ω = 1.8751² √(E I/(ρ A L⁴))",
    "One row of up to 40 elements of degree 2, ν = 0; the smallest eigenvalue of its stiffness "
    "and lumped masses, which are of second order.",
)
def _swing() -> Answer:
    exact = BEAM**2 * math.sqrt(YOUNG * THICKNESS**2 / 12.0 / DENSITY / LENGTH**4)
    order, frequencies = in_elements("frequency", lambda n: _strip(n)[1], exact, (10, 20, 40), 1.9)
    checks = (
        relative("frequency, 40 elements", frequencies[40], exact, 2e-3),
        relative("from 20 and 40", (4.0 * frequencies[40] - frequencies[20]) / 3.0, exact),
    )
    shell, _, displacements = _strip(40)
    nodes, deflection = shell.points(shell.nodes), shell.points(displacements)[:, 2]
    row = np.flatnonzero(nodes[:, 1] == 0.0)
    row = row[np.argsort(nodes[row, 0])]
    x = np.linspace(0.0, 1.0, 200)
    shape = deflection[row] / deflection[row[-1]]
    draw = comparison(
        ("x/L", "way over that of the end"),
        [("formula", x, cantilever_mode(x))],
        [("40 elements", nodes[row, 0] / LENGTH, shape)],
    )
    return Answer(checks, draw, order)


STRAIN, POISSON = 1e-3, 0.3
"""Uniform strain of the drum, and Poisson's ratio."""


def _drum_of(count: int) -> float:
    """Return the first frequency of a stretched drum of radius 1, of `count` × `count` elements."""
    shell = assemble_shell(
        [disc(2, count)],
        material=cg.materials.Elastic(young=YOUNG, poisson=POISSON),
        density=DENSITY,
        thickness=THICKNESS,
        bending=0.0,
    )
    across = free_dofs(
        shell, (rim(shell), "xyz"), (np.arange(len(shell.nodes), dtype=np.int32), "xy")
    )
    return _slowest(shell, across, shell.nodes * math.sqrt(1.0 + 2.0 * STRAIN))[0]


@CASES.add(
    "shell-drum",
    "A drum of splines swings",
    "ω = 2.404826/a √(N/(ρ t))",
    "A disc of one patch of degree 2 without bending, up to 32 × 32 elements, stretched by a "
    "thousandth and held at its border; lumped masses are of second order. Coarser nets have "
    "slower checkerboards, which the surface does not see.",
)
def _drum() -> Answer:
    exact = DRUM * math.sqrt(YOUNG * STRAIN / (1.0 - POISSON) / DENSITY)
    order, frequencies = in_elements("frequency", _drum_of, exact, (8, 16, 32), 1.9)
    checks = (
        relative("frequency, 32 × 32", frequencies[32], exact, 3e-3),
        relative(
            "from 16 × 16 and 32 × 32", (4.0 * frequencies[32] - frequencies[16]) / 3.0, exact, 5e-4
        ),
    )
    counts = np.array(list(frequencies), np.float64)
    draw = comparison(
        ("elements a side", "frequency over the formula's"),
        [("formula", np.array([0.0, 35.0]), np.ones(2))],
        [("degree 2", counts, np.array(list(frequencies.values())) / exact)],
    )
    return Answer(checks, draw, order)


RADIUS, GROWTH, HALF, STIFF, MASS, BREATH = 1.0, 0.2, 0.05, 50.0, 2.0, 2.0
"""Breathing sphere: radius, growth of the radius, half thickness; spring and mass of each point on
it; circular frequency."""


def _breathing(step: float) -> cg.Result:
    """Run 24 masses on springs on a sphere whose control points grow by a table."""
    ball = cg.Body([cg.shapes.sphere(radius=RADIUS)])
    end = math.pi / BREATH
    times = np.linspace(0.0, end, 81)
    radii = RADIUS + 0.5 * GROWTH * (1.0 - np.cos(BREATH * times))
    breath = cg.motion.ControlPoints(times, radii[:, None, None] / RADIUS * ball.net.points)
    directions = np.random.default_rng(1).normal(size=(24, 3))
    directions /= np.sqrt((directions**2).sum(axis=1))[:, None]
    cloud = cg.Slave((RADIUS + HALF) * directions, area=np.ones(24))
    contact = cg.Contact(ball, cloud, law=cg.PenaltyLaw(STIFF), shell_thickness=2.0 * HALF)
    return run_of(
        bodies={"ball": (ball, breath)},
        slaves={"cloud": (cloud, cg.motion.Free(MASS))},
        contacts=[contact],
        end=0.9 * 2.0 * math.pi / (BREATH + math.sqrt(STIFF / MASS)),
        step=step,
        sensors=[cg.NodeSensor("node", "cloud", at=cloud.points[0])],
    )


def _breath(t: FloatArray) -> FloatArray:
    """Return the radial displacement of a mass from rest: ÿ = Ω² (r − y), r = G (1 − cos ω t)/2."""
    w, W = BREATH, math.sqrt(STIFF / MASS)
    share = 1.0 / (W**2 - w**2)
    shape = 1.0 - share * (W**2 * np.cos(w * t) - w**2 * np.cos(W * t))
    return np.asarray(0.5 * GROWTH * shape)


@CASES.add(
    "deform-breathing",
    "A sphere that breathes pushes masses",
    "ÿ = Ω² (r − y), r = G (1 − cos ω t)/2: y = G/2 (1 − (Ω² cos ω t − ω² cos Ω t)/(Ω² − ω²))",
    "The control points of an exact sphere grow by a table of 81 rows; 24 masses lie on it, each "
    "by a spring from half its thickness on, until just before they fly off.",
)
def _sphere() -> Answer:
    runs = {step: _breathing(step) for step in (0.02, 0.01, 0.005)}

    def error(step: float) -> float:
        history = runs[step].history
        radius = np.sqrt(sum(history[f"node.{axis}"] ** 2 for axis in "xyz"))
        return float(np.abs(radius - _breath(history["time"])).max() / GROWTH)

    order = order_of("largest error of the way, by how far it grows", 0.02, error)
    fine = runs[0.005].history
    points = runs[0.005].state.slaves["cloud"].points
    radii = np.sqrt((points**2).sum(axis=1))
    energy = float(np.abs(fine["energy.error"]).max() / fine["energy.external"].max())
    checks = (
        zero("largest error of the way", error(0.005), 2e-4),
        zero("how much the masses differ", float(np.ptp(radii)) / GROWTH, 1e-9),
        zero("energy balance error, by the work done", energy, 1e-3),
    )
    t = np.linspace(0.0, fine["time"][-1], 200)
    radius = np.sqrt(sum(fine[f"node.{axis}"] ** 2 for axis in "xyz"))
    sphere = 0.5 * GROWTH * (1.0 - np.cos(BREATH * t))
    draw = comparison(
        ("t", "way"),
        [("formula", t, _breath(t)), ("sphere", t, sphere)],
        [("masses", fine["time"], radius)],
    )
    return Answer(checks, draw, order)


@CASES.add(
    "deform-turning",
    "A torus that is deformed so that it turns",
    "F constant, and as of the torus that turns",
    "Control points turn about the axis of a torus, in sixteen steps, among 400 points at rest "
    "around it; the same torus turned as a rigid body beside it.",
)
def _torus() -> Answer:
    torus = cg.Body([cg.shapes.torus(major=1.0, minor=0.3)])
    u, v = 2.0 * math.pi * np.random.default_rng(2).random((2, 400))
    out = 1.0 + 0.32 * np.cos(v)
    points = np.stack([out * np.cos(u), out * np.sin(u), 0.32 * np.sin(v)], axis=1)
    contact = cg.Contact(
        torus,
        cg.Slave(points, area=np.ones(len(points))),
        law=cg.PenaltyLaw(1.0),
        shell_thickness=0.1,
        search="penetration",
    )
    rest = torus.net.points
    shaped, rigid = contact.start(points, control_points=rest), contact.start(points)
    angles = np.linspace(0.0, 2.0 * math.pi, 17)[1:]
    forces, differences = [shaped.normal_force], []
    for angle in angles:
        pose = cg.motion.pose.rotation("z", angle)
        shaped = contact.step(shaped, points, control_points=rest @ pose[:3, :3].T)
        rigid = contact.step(rigid, points, pose)
        forces.append(shaped.normal_force)
        differences.append(np.abs(shaped.force - rigid.force).max())
    size, every = 400 * 0.03, np.array(forces)
    turn = np.cross(rest @ pose[:3, :3].T, shaped.control_force)
    turn = turn.sum(axis=0) + np.cross(points, shaped.force).sum(axis=0)
    pull = shaped.control_force.sum(axis=0) + shaped.force.sum(axis=0)
    checks = (
        zero("change of the forces, by their size", np.ptp(every, axis=0).max() / 0.03, 1e-12),
        zero("difference from the rigid torus", max(differences) / 0.03, 1e-11),
        relative("sum of forces", every[-1].sum(), size, 1e-12),
        zero(
            "force and moment of points and control points together, by that sum",
            max(np.abs(pull).max(), np.abs(turn).max()) / size,
            1e-12,
        ),
    )
    draw = errors_over(
        ("angle", "difference from the rigid torus"),
        [("largest of 400 forces", angles, np.array(differences) / 0.03)],
    )
    return Answer(checks, draw)


def _carried(along: float) -> dict[str, FloatArray]:
    """Return the history of 25 masses falling on a free plate, whose surface is their master.

    All start with the speed `along` along x.
    """
    flat = refined(cg.shapes.plane(width=100.0, length=100.0), 2, (4, 4))
    line = np.linspace(-14.0, 14.0, 5)
    places = np.stack([*np.meshgrid(line, line), np.full((5, 5), 0.7)], axis=-1).reshape(-1, 3)
    dust = cg.Slave(places, area=np.full(25, 10.0))
    plate_moves = cg.motion.Deforming(
        material=cg.materials.Elastic(young=2000.0, poisson=0.3),
        density=1e-3,
        thickness=1.0,
        velocity=[along, 0.0, 0.0],
    )
    body = cg.Body([flat])
    return run_of(
        bodies={"upper side": (body, cg.motion.ControlPointsOf("plate"))},
        slaves={
            "plate": (cg.Slave(surfaces=[flat]), plate_moves),
            "dust": (dust, cg.motion.Free(1.2, velocity=[along, 0.0, -2.0])),
        },
        contacts=[cg.Contact(body, dust, law=cg.PenaltyLaw(20.0), shell_thickness=1.0)],
        end=1.0,
        step=0.004,
    ).history


@CASES.add(
    "deform-carried",
    "Masses on a shell that is their master, carried along",
    "F(t), U(t) as at rest",
    "25 masses fall on a free plate of splines, whose control points are the master's; then all "
    "of it at 64 a time along x, 32 times as fast as they meet.",
)
def _along() -> Answer:
    still, carried = _carried(0.0), _carried(64.0)
    sizes = {"force": still["force"].max(), "energy.strain": still["energy.total"][0]}
    return carried_along(still, carried, sizes)


FIRM, TOUCH, GAP = 3.0, 0.06, 0.05
"""Two shells: contact stiffness, distance at which contact begins, and their distance."""


def _sheet(radius: float, count: int, *, inward: bool) -> tuple[Shell, cg.Body]:
    """Return an eighth of a sphere of `radius`, as shell and as body, with normals out or `inward`.

    It has three patches of `count` × `count` elements of degree 4.
    """
    patches = [refined(patch, 4, (count, count)) for patch in octant(radius)]
    patches = [patch.flipped() for patch in patches] if inward else patches
    shell = assemble_shell(
        patches, material=cg.materials.Elastic(young=1.0), density=1.0, thickness=0.01
    )
    return shell, cg.Body(patches)


@CASES.add(
    "shell-two-sided",
    "Two curved shells press on each other",
    "p = k λ/2 (1 + R²/r²),  F_I = p ∫ N_I n dA,  Σ F = 0,  Σ P × F = 0",
    "Spheres of radius 1 and 1.05 of other elements, 4 × 4 and 6 × 6 of degree 4 on each of three "
    "patches, are each master and slave of the other with half of the law: all their control "
    "points have what an even pressure gives them, but for the rules of quadrature.",
)
def _both() -> Answer:
    radii = 1.0, 1.0 + GAP
    sides = _sheet(radii[0], 4, inward=False), _sheet(radii[1], 6, inward=True)
    forces = [np.zeros_like(shell.nodes) for shell, _ in sides]
    for i, (shell, _) in enumerate(sides):
        master, body = sides[1 - i]
        slave = cg.Slave.of(shell)
        contact = cg.Contact(
            body,
            slave,
            law=cg.PenaltyLaw(0.5 * FIRM, per_area=True),
            shell_thickness=2.0 * TOUCH,
            on_edge="hold",
            search="penetration",
        )
        state = contact.start(slave.points, control_points=master.nodes)
        forces[i] += shell.spread(state.force)
        forces[1 - i] += state.control_force
    size, checks, errors = sum(np.abs(force).sum() for force in forces), [], []
    for i, (shell, _) in enumerate(sides):
        ratio = (radii[1 - i] / radii[i]) ** 2
        even = 0.5 * FIRM * (TOUCH - GAP) * (1.0 + ratio) * shell.pressure(shell.nodes)
        errors_of_force = np.sqrt(
            ((forces[i] + even) ** 2).sum(axis=1) / (even**2).sum(axis=1).max()
        )
        errors.append(errors_of_force)
        checks.append(
            zero(f"largest error of a force, radius {radii[i]:g}", errors_of_force.max(), 2e-5)
        )
    moment = sum(
        np.cross(shell.nodes, force).sum(axis=0)
        for (shell, _), force in zip(sides, forces, strict=True)
    )
    checks += [
        zero("sum of all forces", np.abs(sum(f.sum(axis=0) for f in forces)).max() / size, 1e-14),
        zero("sum of all moments", np.abs(moment).max() / size, 1e-14),
    ]
    draw = errors_over(
        ("control point", "error of its force"),
        [
            (f"radius {radius:g}", np.linspace(0.0, 1.0, len(errors_of_force)), errors_of_force)
            for radius, errors_of_force in zip(radii, errors, strict=True)
        ],
    )
    return Answer(tuple(checks), draw)

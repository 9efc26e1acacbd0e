"""Strings and belts over exact bodies: shortest paths, and the capstan."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad

import contiga as cg
from contiga_validation.closed_forms.case import Answer, Cases, order_of, relative
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Strings and belts")

MU = 0.3
STIFFNESS, DENSITY = 3000.0, 0.01
"""Modulus times section, and mass per length, of the belt, whose loose end is pulled by 1."""
START_TENSION = 3.0
"""Its tension at the start: more than that of the capstan anywhere, so that all of it slides."""
DEPTH = 2e-5
"""Penetration of a node with the tension `START_TENSION` into the drum of radius 1, length."""
STRAIGHT_LENGTH = 0.25 * math.pi
"""Length of the straight ends: multiples of a bar, so that the belt lifts off at a node."""


def _string(exact: float, body: cg.Body, ends: FloatArray, over: list[float]) -> Answer:
    """Compare the length of a string of 200 chords with the `exact` one, and find its order.

    The string goes from one of the `ends` (2, 3) to the other, on the side of the point `over`.
    """

    def path(points: int) -> cg.Path:
        return cg.route(body, ends[0], ends[1], via=[over], points=points)

    def error(chord: float) -> float:
        return abs(path(round(exact / chord)).length - exact)

    string = path(200)
    checks = (relative("length", string.length, exact),)
    draw = comparison(("x", "z"), [], [("200 chords", string.points[:, 0], string.points[:, 2])])
    return Answer(checks, draw, order_of("length, by that of a chord", exact / 100.0, error))


@CASES.add(
    "string-sphere",
    "String over a sphere",
    "2 √(d² − r²) + 2 r asin(r/d), d = 2 r",
    "Two tangents and a part of a great circle.",
)
def _sphere() -> Answer:
    body = cg.Body([cg.shapes.sphere(radius=1.0)])
    ends = np.array([[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    return _string(2.0 * math.sqrt(3.0) + math.pi / 3.0, body, ends, [0.0, 0.0, 1.5])


@CASES.add(
    "string-torus",
    "String over the tube of a torus",
    "2 √(d² − r²) + r (π + 2 atan(1.2/R) − 2 acos(r/d)), d² = R² + 1.2²",
    "From below, through the hole and over the tube, in a plane of symmetry; R = 3, r = 1.",
)
def _torus() -> Answer:
    body = cg.Body(cg.shapes.torus(major=3.0, minor=1.0))
    away = math.hypot(3.0, 1.2)
    angle = math.pi + 2.0 * math.atan2(1.2, 3.0) - 2.0 * math.acos(1.0 / away)
    ends = np.array([[0.0, 0.0, -1.2], [6.0, 0.0, -1.2]])
    return _string(2.0 * math.sqrt(away**2 - 1.0) + angle, body, ends, [3.0, 0.0, 1.5])


@CASES.add(
    "string-ellipse",
    "String over an elliptic profile",
    "2 |x_d − x(t)| + ∫ √(a² sin² + b² cos²), cos t = a/d, by quadrature",
    "A cylinder over the ellipse a = 2, b = 1; both ends at d = 3 on its long axis.",
)
def _ellipse() -> Answer:
    a, b, d = 2.0, 1.0, 3.0
    body = cg.Body.from_profile(cg.shapes.ellipse(axes=(a, b)), depth=4.0).rotated("x", 90.0)
    t = math.acos(a / d)
    straight = math.hypot(d - a * math.cos(t), b * math.sin(t))
    arc, _ = quad(lambda s: math.hypot(a * math.sin(s), b * math.cos(s)), t, math.pi - t)
    ends = np.array([[-d, 0.0, 0.0], [d, 0.0, 0.0]])
    return _string(2.0 * straight + arc, body, ends, [0.0, 0.0, 2.0])


def tensions(segments: int, kind: str) -> FloatArray:
    """Return the tensions (2,) at the loose and the held end of a belt over half a drum, at rest.

    The belt starts with the tension `START_TENSION`. The pull at its loose end falls slowly to 1,
    so that it creeps to the held end and sticks nowhere. `kind` is that of `cg.Belt`.
    """
    drum = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0, axis="y")])
    path = cg.route(
        drum, [-1.0, 0.0, -STRAIGHT_LENGTH], [1.0, 0.0, -STRAIGHT_LENGTH], via=[[0.0, 0.0, 1.2]]
    )
    width, thickness, strain = 0.2, 0.05, START_TENSION / STIFFNESS
    section = width * thickness
    belt = cg.Belt(
        path=path,
        material=cg.materials.Elastic(young=STIFFNESS / section),
        density=DENSITY / section,
        width=width,
        thickness=thickness,
        kind=kind,
        segments=segments,
        across=1,
        shortening=strain / (1.0 + strain),
        anchors=("free", "ground"),
    )
    loose, held = belt.ends
    speed = math.sqrt(STIFFNESS / DENSITY)
    duration = 60.0 * path.length / speed
    pull = [
        [0.0, 0.0, 0.0, -START_TENSION],
        [0.1 * duration, 0.0, 0.0, -START_TENSION],
        [0.6 * duration, 0.0, 0.0, -1.0],
    ]
    pull.append([duration, 0.0, 0.0, -1.0])
    motion = cg.motion.Deforming(
        material=belt.material,
        density=belt.density,
        section=section if kind == "bars" else None,
        thickness=None if kind == "bars" else thickness,
        bending=0.0,
        rest=belt.motion.rest,
        # The slowest wave along the belt dies out without swinging.
        damping=math.pi * speed / path.length,
        fixed=[
            {"nodes": held},
            {"nodes": loose, "hold": ["x"]},
            {"nodes": np.arange(len(belt.slave)), "hold": ["y"]},
        ],
        loads=cg.motion.NodalForce(pull, on={"nodes": loose}, smooth=True),
    )
    stiff = START_TENSION / width / DEPTH
    damping = 2.0 * math.sqrt(stiff * DENSITY / width)
    law = cg.PenaltyLaw(stiff, damping=damping, per_area=True)
    friction = cg.Coulomb(MU, stiffness=stiff, per_area=True)
    press = cg.Contact(drum, belt.slave, law=law, friction=friction, quadrature="nodes")
    state = (
        cg.Simulation(
            bodies={"drum": drum},
            slaves={"belt": (belt.slave, motion)},
            contacts=[press],
            end=duration,
            step="auto",
        )
        .run()
        .state
    )
    force = state.slaves["belt"].matter["force"]
    if (surfaces := belt.slave.surfaces) is not None:  # its forces are on control points
        loose, held = surfaces.net.edge("u0"), surfaces.net.edge("u1")
    return np.array([np.linalg.norm(force[rows].sum(axis=0)) for rows in (loose, held)])


@CASES.add(
    "belt-capstan",
    "Belt that slides over a drum",
    "T₂/T₁ = e^{μ π}",
    "μ = 0.3, half a turn. The belt is laid as bars, a ribbon of triangles and splines; the "
    "order is that of bars.",
)
def _capstan() -> Answer:
    exact = math.exp(MU * math.pi)

    def ratio(segments: int, kind: str) -> float:
        loose, held = tensions(segments, kind)
        return float(held / loose)

    def error(bar: float) -> float:
        return abs(ratio(round(1.5 * math.pi / bar), "bars") / exact - 1.0)

    fine = 156
    checks = (
        relative(f"{fine} bars", ratio(fine, "bars"), exact),
        relative(f"{fine} × 2 triangles", ratio(fine, "ribbon"), exact),
        relative(f"{fine // 2} patches of degree 2", ratio(fine // 2, "membrane"), exact),
    )
    angle = np.linspace(0.0, math.pi, 100)
    draw = comparison(("angle", "T/T₁"), [("formula", angle, np.exp(MU * angle))], [])
    return Answer(checks, draw, order_of("ratio, by the length of a bar", math.pi / 12, error))


WIDTH, THICKNESS = 0.2, 0.05
END_DISPLACEMENT = 4e-3
"""Displacement of the held end of a belt of splines, length: just enough for all of it to slide."""


def _ribbon(elements: int) -> cg.NurbsSurface:
    """Return one patch of degree 2 along the belt's path, which meets it at the Greville points."""
    knots = np.concatenate([np.zeros(2), np.linspace(0.0, 1.0, elements + 1), np.ones(2)])
    at = cg.knots.greville(knots, 2)
    arc_length = (2.0 * STRAIGHT_LENGTH + math.pi) * at - STRAIGHT_LENGTH
    angle = np.clip(arc_length, 0.0, math.pi)
    height = np.sin(angle) + np.minimum(arc_length, 0.0) + np.minimum(math.pi - arc_length, 0.0)
    sites = np.stack([-np.cos(angle), height], axis=1)
    points = np.zeros((len(at), 2, 3))
    points[:, :, [0, 2]] = np.linalg.solve(cg.knots.basis(knots, 2, at)[:, 0], sites)[:, None]
    points[:, :, 1] = [-0.5 * WIDTH, 0.5 * WIDTH]
    return cg.NurbsSurface((2, 1), (knots, [0.0, 0.0, 1.0, 1.0]), points).elevate(0, 1)


def _pulls(elements: int) -> FloatArray:
    """Run a belt of splines until all of it has slid; return the tensions (2,) at both ends.

    The loose end comes first, which is pulled by 1. The other end is displaced by
    `END_DISPLACEMENT`.
    """
    belt, length = cg.Slave(surfaces=[_ribbon(elements)]), 2.0 * STRAIGHT_LENGTH + math.pi
    speed, section = math.sqrt(STIFFNESS / DENSITY), WIDTH * THICKNESS
    duration = 60.0 * length / speed
    travel = [
        [0.0, 0.0],
        [0.3 * duration, 0.0],
        [0.8 * duration, -END_DISPLACEMENT],
        [duration, -END_DISPLACEMENT],
    ]
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=STIFFNESS / section),
        density=DENSITY / section,
        thickness=THICKNESS,
        bending=0.0,
        damping=math.pi * speed / length,
        fixed=[
            {"edge": "u0", "hold": ["x"]},
            {"edge": "u1", "hold": ["x"]},
            {"nodes": np.arange(len(belt)), "hold": ["y"]},
        ],
        driven={
            "edge": "u1",
            "hold": ["z"],
            "motion": cg.motion.Translate([[t, 0.0, 0.0, z] for t, z in travel]),
        },
        loads=cg.motion.NodalForce(
            [[0.0, 0.0, 0.0, 0.0], [0.2 * duration, 0.0, 0.0, -1.0], [duration, 0.0, 0.0, -1.0]],
            on={"edge": "u0"},
            smooth=True,
        ),
    )
    drum = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0, axis="y")])
    stiff = START_TENSION / (WIDTH * DEPTH)
    friction = cg.Coulomb(MU, stiffness=stiff * WIDTH * length / len(belt))
    press = cg.Contact(
        drum,
        belt,
        law=cg.PenaltyLaw(stiff, per_area=True),
        friction=friction,
        search="penetration",
    )
    run = cg.Simulation(
        bodies={"drum": drum},
        slaves={"belt": (belt, motion)},
        contacts=[press],
        end=duration,
        step="auto",
    ).run()
    force = run.state.slaves["belt"].matter["force"]
    assert belt.surfaces is not None
    ends = (belt.surfaces.net.edge(name) for name in ("u0", "u1"))
    return np.array([np.linalg.norm(force[rows].sum(axis=0)) for rows in ends])


@CASES.add(
    "belt-capstan-splines",
    "Belt of splines that slides over a drum",
    "T₂/T₁ = e^{μ π}",
    "μ = 0.3, half a turn, 24 elements of degree 2 without bending. One end is pulled by 1, the "
    "other along until all of it has slid. Lines of the patch are where it lifts off at the start, "
    "and slide away from there: that is most of the error.",
)
def _capstan_of_splines() -> Answer:
    loose, held = _pulls(24)
    checks = (
        relative("pull on the loose end", loose, 1.0),
        relative("24 elements", held / loose, math.exp(MU * math.pi), 1e-3),
    )
    angle = np.linspace(0.0, math.pi, 100)
    ends = np.array([0.0, math.pi])
    draw = comparison(
        ("angle", "T/T₁"),
        [("formula", angle, np.exp(MU * angle))],
        [("ends", ends, np.array([loose, held]) / loose)],
    )
    return Answer(checks, draw)


LOOSE_TENSION, SPEED = 1.0, 7.0
"""Tension at the loose end of the running belt, and the speed of the belt without stretch."""
FED_LENGTH, TAKEN_LENGTH = 2.5, 0.5
"""Lengths of its straight ends before and behind the drum."""
RUN_LENGTH = 2.0
"""Length by which it runs."""


class Running(NamedTuple):
    """Forces of a belt that runs over a drum, means over the run."""

    ratio: float
    """(T₂ − ṁ v₂)/(T₁ − ṁ v₁), with ṁ v = ρ v² of the stretched belt."""
    push: float
    """Force on the drum over T₁ + T₂ − ṁ (v₁ + v₂), tensions by the closed form."""


def _running(bars: int) -> Running:
    """Run a belt, with `bars` bars in its half turn over a drum, from its steady state.

    Means over the run are weighted by 1 − cos, which suppresses vibrations of the belt.
    """
    bar = math.pi / bars
    arc_length = bar * np.arange(round((FED_LENGTH + math.pi + TAKEN_LENGTH) / bar) + 1)
    fed_length = bar * round(FED_LENGTH / bar)
    angle = np.clip(arc_length - fed_length, 0.0, math.pi)
    # The flow of mass is the same everywhere: v grows with the stretch, T − ṁ v as on a drum.
    flow = DENSITY * SPEED / (1.0 + LOOSE_TENSION / STIFFNESS)
    moving = flow**2 / DENSITY
    pressing = (LOOSE_TENSION - flow * SPEED) * np.exp(MU * angle)
    tension = (pressing + moving) / (1.0 - moving / STIFFNESS)
    speed = flow / DENSITY * (1.0 + tension / STIFFNESS)
    stiff = START_TENSION / WIDTH / DEPTH
    wraps = (arc_length > fed_length - 0.5 * bar) & (arc_length < fed_length + math.pi + 0.5 * bar)
    radius = np.where(wraps, 1.0 - pressing / (stiff * WIDTH), 1.0)
    height = np.minimum(arc_length - fed_length, 0.0) - np.maximum(
        arc_length - fed_length - math.pi, 0.0
    )
    zeros = np.zeros(len(arc_length))
    x, z = -radius * np.cos(angle), radius * np.sin(angle) + height
    points = np.stack([x, zeros, z], axis=1)
    tangent = np.stack([np.sin(angle), zeros, np.cos(angle)], axis=1)
    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
    stretch = 1.0 + 0.5 * (tension[1:] + tension[:-1]) / STIFFNESS
    rest_points = np.stack([np.append(0.0, np.cumsum(chord / stretch)), zeros, zeros], axis=1)
    node, last = np.arange(len(arc_length)), len(arc_length) - 1
    area = WIDTH * bar * np.where((node == 0) | (node == last), 0.5, 1.0)
    belt = cg.Slave(points, elements={"line": np.stack([node[:-1], node[1:]], axis=1)}, area=area)
    end, section = RUN_LENGTH / SPEED, WIDTH * THICKNESS
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=STIFFNESS / section),
        density=DENSITY / section,
        section=section,
        rest=rest_points,
        velocity=speed[:, None] * tangent,
        fixed=[{"nodes": [0, last], "hold": ["x"]}, {"nodes": node, "hold": ["y"]}],
        driven={
            "nodes": [last],
            "hold": ["z"],
            "motion": cg.motion.Translate(
                [[0.0, 0.0, 0.0, 0.0], [end, 0.0, 0.0, -speed[-1] * end]]
            ),
        },
        loads=cg.motion.NodalForce(
            [[0.0, 0.0, 0.0, -LOOSE_TENSION], [end, 0.0, 0.0, -LOOSE_TENSION]], on={"nodes": [0]}
        ),
    )
    drum = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0, axis="y")])
    law = cg.PenaltyLaw(stiff, damping=2.0 * math.sqrt(stiff * DENSITY / WIDTH), per_area=True)
    friction = cg.Coulomb(MU, stiffness=stiff, per_area=True)
    press = cg.Contact(drum, belt, law=law, friction=friction, search="penetration")
    history = (
        cg.Simulation(
            bodies={"drum": drum},
            slaves={"belt": (belt, motion)},
            contacts=[press],
            end=end,
            step="auto",
        )
        .run()
        .history
    )
    # Means with the weight 1 − cos 2πt, which belts that swing do not disturb: of the work that
    # comes in, by parts.
    t = np.linspace(0.0, end, 20_001)
    work, push = (
        np.interp(t, history["time"], history[name]) for name in ("energy.external", "force_z")
    )
    turn = 2.0 * math.pi * t / end
    power = -np.trapezoid(2.0 * math.pi / end * np.sin(turn) * work, t) / end
    pull = (power + LOOSE_TENSION * speed[0]) / speed[-1]
    resultant = LOOSE_TENSION + tension[-1] - flow * (speed[0] + speed[-1])
    return Running(
        float((pull - flow * speed[-1]) / (LOOSE_TENSION - flow * speed[0])),
        float(np.trapezoid((1.0 - np.cos(turn)) * np.abs(push), t) / end / resultant),
    )


@CASES.add(
    "belt-running",
    "Belt that runs over a drum",
    "(T₂ − ρ v²)/(T₁ − ρ v²) = e^{μ π}",
    "μ = 0.3, half a turn, ρ v² = 0.49 T₁: bars that move along themselves press on the drum by "
    "(T − ρ v²)/R. They begin in the steady state; pulls are means over two radii of their way.",
)
def _runs() -> Answer:
    exact = math.exp(MU * math.pi)
    runs = {bars: _running(bars) for bars in (12, 24, 48)}

    def error(bar: float) -> float:
        return abs(runs[round(math.pi / bar)].ratio / exact - 1.0)

    checks = (
        relative("48 bars", runs[48].ratio, exact, 1e-3),
        relative("force on the drum over T₁ + T₂ − 2 ρ v²", runs[48].push, 1.0, 1e-3),
    )
    angle = np.linspace(0.0, math.pi, 100)
    moving = DENSITY * SPEED**2
    draw = comparison(
        ("angle", "T/T₁"),
        [
            ("ρ v² = 0.49 T₁", angle, moving + (1.0 - moving) * np.exp(MU * angle)),
            ("at rest", angle, np.exp(MU * angle)),
        ],
        [
            (
                "48 bars",
                np.array([0.0, math.pi]),
                np.array([1.0, moving + (1.0 - moving) * runs[48].ratio]),
            )
        ],
    )
    return Answer(checks, draw, order_of("ratio, by the length of a bar", math.pi / 12, error))

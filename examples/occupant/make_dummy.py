"""Write the dummy of the occupant as tables of a case: fifteen bodies, fourteen joints, sensors.

    python make_dummy.py dummy.toml

Lengths are in mm, masses in g, times in ms, so that moments are in N·mm. The dummy sits with its
H-point, the middle between its hips, in the origin, and faces +x; z is up and +y is its left.

Masses are those of the segments of the Hybrid III 50th percentile male, the dummy of 49 CFR 572,
subpart E: 77.7 kg in all; 0.7 kg of the upper torso is that of the sternum here. Shapes, places of
joints and their laws are round numbers of about its size and strength: this is the model of no
dummy that is sold. The spring and the damper of the chest are set by the impactor of § 572.34.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

RECLINE = 20.0
"""Angle of the torso from the vertical, backwards, degrees."""
HIP, KNEE, ANKLE = np.array([[0.0, 85.0, 0.0], [395.0, 100.0, 85.0], [640.0, 100.0, -225.0]])
SOLE = np.radians(50.0)
"""Slope of the soles of the feet."""
GRIP = np.array([305.0, 190.0, 300.0])
"""Place of the left hand, at the rim of the wheel."""
UPPER_ARM, FOREARM = 265.0, 300.0
"""Lengths from shoulder to elbow, and from there to the middle of the hand."""
CHEST = [
    (105, 115, -95, 30),
    (200, 150, -125, 45),
    (330, 165, -130, 45),
    (430, 145, -115, 25),
    (465, 85, -70, 15),
]
"""Sections of the chest behind the sternum: height over the H-point, half width, back, front, in
the axes of the torso."""
PELVIS = [
    (-100, 130, -95, 75),
    (-40, 190, -130, 110),
    (60, 185, -125, 125),
    (150, 150, -110, 105),
    (190, 115, -85, 65),
]
"""Sections of pelvis and abdomen."""
HEAD = """# The dummy of the occupant: fifteen bodies, fourteen joints and its sensors, written by
# make_dummy.py, which says where its numbers come from. Lengths in mm, masses in g, times in ms.
# It sits with its H-point in the origin and faces +x.
"""


def torso(x: float, y: float, z: float) -> np.ndarray:
    """Place (3,) in the world of a point in the axes of the torso: x to its front, y to its left,
    z from the H-point to the neck."""
    angle = np.radians(RECLINE)
    return np.array(
        [np.cos(angle) * x - np.sin(angle) * z, y, np.sin(angle) * x + np.cos(angle) * z]
    )


def text(values: np.ndarray | Sequence[float] | float, digits: int = 3) -> str:
    """Numbers of any shape in TOML, rounded to `digits` behind the point."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0:
        return repr(round(float(array), digits) + 0.0)
    return "[" + ", ".join(text(part, digits) for part in array) + "]"


def rows(values: np.ndarray, digits: int = 3) -> str:
    """An array in TOML, one row a line."""
    return "[\n" + "".join(f"  {text(row, digits)},\n" for row in values) + "]"


def ellipsoid(axes: Sequence[float], centre: np.ndarray, lean: float = 0.0) -> str:
    """Geometry of an ellipsoid whose half axes are turned about y by `lean`, degrees."""
    turn = f'{{ rotate = {{ axis = "y", degrees = {lean}, centre = {text(centre)} }} }}'
    transform = f"transform = [{turn}]\n" if lean else ""
    return (
        f'[body.geometry]\nshape = "ellipsoid"\naxes = {text(axes)}\n'
        f"centre = {text(centre)}\n{transform}"
    )


def capsule(start: np.ndarray, end: np.ndarray, first: float, last: float) -> str:
    """Geometry of the hull of two balls of radii `first` and `last`: two arcs, and the line that
    touches both, revolved."""
    length = float(np.linalg.norm(end - start))
    lean = float(np.arcsin((first - last) / length))
    points: list[tuple[float, float, float]] = []
    weights: list[float] = []
    for height, radius, low, high in (
        (0.0, first, -0.5 * np.pi, lean),
        (length, last, lean, 0.5 * np.pi),
    ):
        shrink = float(np.cos(0.5 * (high - low)))
        for angle, reach in ((low, radius), (0.5 * (low + high), radius / shrink), (high, radius)):
            points.append((reach * np.cos(angle), 0.0, height + reach * np.sin(angle)))
        weights += [1.0, shrink, 1.0]
    points.insert(3, tuple(np.mean(points[2:4], axis=0)))
    weights.insert(3, 1.0)
    x, y, z = (end - start) / length
    turn = f"axis = {text([-y, x, 0.0], 9)}, degrees = {text(np.degrees(np.arccos(z)), 6)}"
    return (
        f'[body.geometry]\nshape = "revolved"\n'
        f"transform = [{{ rotate = {{ {turn} }} }}, {{ translate = {text(start)} }}]\n"
        f"[body.geometry.curve.nurbs]\ndegree = 2\nknots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 3]\n"
        f"weights = {text(weights, 9)}\ncontrol_points = {rows(np.array(points), 6)}\n"
    )


def loft(sections: Iterable[tuple[float, float, float, float]]) -> str:
    """Geometry of a surface of degree 2 over ellipses, whose first and last section are closed by
    flat caps."""
    corner = 0.5**0.5
    circle = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    around = np.array([1.0, corner] * 4 + [1.0])
    ellipses = [
        [torso(0.5 * (back + front) + 0.5 * (front - back) * x, width * y, z) for x, y in circle]
        for z, width, back, front in sections
    ]
    poles = [[np.mean(e[:-1:2], axis=0)] * len(circle) for e in (ellipses[0], ellipses[-1])]
    net = np.swapaxes(np.array([poles[0], *ellipses, poles[1]]), 0, 1)
    spans = net.shape[1] - 2
    knots = [0, 0, *range(spans + 1), spans, spans]
    weights = np.tile(around[:, None], net.shape[1])
    return (
        f"[body.geometry.nurbs]\ndegrees = [2, 2]\n"
        f"knots = [[0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], {knots}]\n"
        f"weights = {rows(weights, 9)}\ncontrol_points = {rows(net)}\n"
    )


def body(name: str, mass: float, geometry: str) -> str:
    """A free body of `mass`, g, spread evenly in its shape."""
    return (
        f'\n[[body]]\nname = "{name}"\nmass = {{ total = {mass:.1f} }}\n'
        f'motion = {{ kind = "free" }}\n{geometry}'
    )


def joint(
    name: str, kind: str, between: tuple[str, str], at: np.ndarray, axis: np.ndarray, **laws: str
) -> str:
    """A joint with the `laws` of its coordinates."""
    said = "".join(f"{coordinate} = {{ {law} }}\n" for coordinate, law in laws.items())
    return (
        f'\n[[joint]]\nname = "{name}"\nkind = "{kind}"\n'
        f'between = ["{between[0]}", "{between[1]}"]\nat = {text(at)}\n'
        f"axis = {text(axis, 9)}\n{said}"
    )


def unit(vector: np.ndarray) -> np.ndarray:
    """`vector` (3,) over its length."""
    return vector / np.linalg.norm(vector)


def elbow_of(shoulder: np.ndarray, hand: np.ndarray, side: np.ndarray) -> np.ndarray:
    """Place of the elbow, below and outside of the line from shoulder to hand."""
    along, reach = unit(hand - shoulder), float(np.linalg.norm(hand - shoulder))
    share = (reach**2 + UPPER_ARM**2 - FOREARM**2) / (2.0 * reach)
    below = side * [0.0, 0.5, 0.0] - [0.0, 0.0, 1.0]
    below = unit(below - (below @ along) * along)
    return shoulder + share * along + np.sqrt(UPPER_ARM**2 - share**2) * below


def trunk() -> str:
    """Head, neck, chest, sternum and pelvis, from the top down, and their joints."""
    base, condyle, lumbar = torso(-15, 0, 455), np.array([-160.0, 0.0, 550.0]), torso(-40, 0, 120)
    front, up, left = torso(1, 0, 0), torso(0, 0, 1), np.array([0.0, 1.0, 0.0])
    return "".join(
        [
            body("head", 4540, ellipsoid([99, 77, 112], condyle + np.array([17.8, 0.0, 50.8]))),
            body("neck", 1540, capsule(base, condyle, 52, 48)),
            body("chest", 16490, loft(CHEST)),
            body("sternum", 700, ellipsoid([67, 130, 150], torso(48, 0, 290), -RECLINE)),
            body("pelvis", 23040, loft(PELVIS)),
            joint(
                "nod",
                "revolute",
                ("neck", "head"),
                condyle,
                left,
                angle="curve = 4.0e4, damping = 4.0e5, stops = [-0.6, 0.6], stop_curve = 4.0e5",
            ),
            joint(
                "neck base",
                "spherical",
                ("chest", "neck"),
                base,
                unit(condyle - base),
                cone="curve = [[0, 0], [0.6, 9.0e4], [1.2, 2.7e5]], damping = 1.5e6",
                twist="curve = 8.0e4, damping = 2.0e5",
            ),
            joint(
                "ribs",
                "translational",
                ("chest", "sternum"),
                torso(48, 0, 290),
                -front,
                travel="curve = [[-20, -1100], [0, 0], [40, 2200], [60, 4200], [100, 1.0e4]], "
                "damping = 520.0",
            ),
            joint(
                "lumbar",
                "spherical",
                ("pelvis", "chest"),
                lumbar,
                up,
                cone="curve = [[0, 0], [0.6, 1.8e5], [1.2, 6.0e5]], damping = 1.0e7",
                twist="curve = 2.0e5, damping = 2.0e6",
            ),
        ]
    )


def limbs(side: str) -> str:
    """Arm and leg of the `"left"` or the `"right"`, and their joints."""
    mirror = np.array([1.0, 1.0 if side == "left" else -1.0, 1.0])
    left = np.array([0.0, 1.0, 0.0])
    shoulder, hand, hip, knee, ankle = (
        mirror * point for point in (torso(-5, 188, 400), GRIP, HIP, KNEE, ANKLE)
    )
    elbow = elbow_of(shoulder, hand, mirror)
    upper, lower = unit(elbow - shoulder), unit(hand - elbow)
    thigh, shin = unit(knee - hip), unit(ankle - knee)
    along, down = np.array([[np.cos(SOLE), 0, np.sin(SOLE)], [np.sin(SOLE), 0, -np.cos(SOLE)]])
    heel, toes = ankle + 32 * down - 35 * along, ankle + 40 * down + 160 * along
    named = {part: f"{side} {part}" for part in ("upper arm", "forearm", "thigh", "shin", "foot")}
    return "".join(
        [
            body(named["upper arm"], 2000, capsule(shoulder, elbow, 46, 40)),
            body(named["forearm"], 2270, capsule(elbow, hand, 40, 33)),
            body(named["thigh"], 5990, capsule(hip, knee, 78, 58)),
            body(named["shin"], 4280, capsule(knee, ankle, 55, 40)),
            body(named["foot"], 1160, capsule(heel, toes, 40, 32)),
            joint(
                f"{side} shoulder",
                "spherical",
                ("chest", named["upper arm"]),
                shoulder,
                upper,
                cone="friction = 1.0e4, friction_slope = 5.0e5, damping = 1.0e5",
                twist="friction = 3.0e3, friction_slope = 2.0e5, damping = 1.0e4",
            ),
            joint(
                f"{side} elbow",
                "revolute",
                (named["upper arm"], named["forearm"]),
                elbow,
                unit(np.cross(upper, lower)),
                angle=f"start = {np.arccos(upper @ lower):.4f}, stops = [0.05, 2.4], "
                "stop_curve = 5.0e5, friction = 4.0e3, friction_slope = 3.0e5, damping = 5.0e4",
            ),
            joint(
                f"{side} hip",
                "spherical",
                ("pelvis", named["thigh"]),
                hip,
                thigh,
                cone="friction = 2.0e4, friction_slope = 1.0e6, damping = 5.0e5",
                twist="friction = 8.0e3, friction_slope = 5.0e5, damping = 5.0e4",
            ),
            joint(
                f"{side} knee",
                "revolute",
                (named["thigh"], named["shin"]),
                knee,
                left,
                angle=f"start = {np.arccos(thigh @ shin):.4f}, stops = [0.0, 2.4], "
                "stop_curve = 1.0e6, friction = 1.0e4, friction_slope = 1.0e6, damping = 1.0e5",
            ),
            joint(
                f"{side} ankle",
                "revolute",
                (named["shin"], named["foot"]),
                ankle,
                left,
                angle="stops = [-0.6, 0.6], stop_curve = 5.0e5, friction = 5.0e3, "
                "friction_slope = 5.0e5, damping = 5.0e4",
            ),
        ]
    )


def sensors() -> str:
    """Accelerations of head, chest and pelvis, and the compression of the chest, with the limits of
    FMVSS 208."""
    spine, front = text(torso(-100, 0, 290)), text(torso(115, 0, 290))
    return f"""
[[sensor]]
name = "head_cg"
body = "head"
filter = "CFC1000"
criteria = ["HIC15", "3ms"]
bands = {{ HIC15 = {{ limits = [700.0], names = ["within FMVSS 208", "above FMVSS 208"] }} }}

[[sensor]]
name = "chest_cg"
body = "chest"
filter = "CFC180"
criteria = ["chest3ms"]
bands = {{ chest3ms = {{ limits = [60.0], names = ["within FMVSS 208", "above FMVSS 208"] }} }}

[[sensor]]
name = "pelvis_cg"
body = "pelvis"
filter = "CFC180"

[[sensor]]
name = "thorax"
between = ["chest", "sternum"]
at = [{spine}, {front}]
measures = ["distance"]
criteria = ["VC"]
"""


def dummy() -> str:
    """The tables of the dummy."""
    return HEAD + trunk() + limbs("left") + limbs("right") + sensors()


if __name__ == "__main__":
    Path(sys.argv[1] if len(sys.argv) > 1 else "dummy.toml").write_text(dummy(), encoding="utf-8")

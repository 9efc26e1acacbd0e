"""Two right models, and what is swapped in them."""

from __future__ import annotations

import contiga as cg
from contiga.case.schema import parse_case

PRESSED = """\
[units]
length = "mm"
mass = "g"
time = "ms"
[time]
end = 10.0
step = 0.25
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 50.0, centre = [0, 0, 52] }
motion = { kind = "translate", table = [[0, 0, 0, 0], [5, 0, 0, -9], [10, 0, 0, 0]] }
[[slave]]
name = "pad"
points = { grid = { shape = "plane", width = 120.0, length = 120.0, nu = 25, nv = 25 } }
thickness = 20.0
motion = { kind = "fixed" }
[[contact]]
master = "ball"
slave = "pad"
law = { kind = "stress", elastic = [[0, 0], [0.1, 0.1], [0.6, 0.4], [0.9, 2.0]] }
"""
"""A ball pressed 7 mm into a pad of foam and drawn back."""

DROPPED = """\
[units]
length = "mm"
mass = "g"
time = "ms"
[time]
end = 20.0
step = "auto"
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 50.0, centre = [0, 0, 52] }
mass = { total = 1000.0, centre = [0, 0, 52], inertia = [1e6, 1e6, 1e6, 0, 0, 0] }
motion = { kind = "free", velocity = [0, 0, -3.0] }
[[slave]]
name = "pad"
points = { grid = { shape = "plane", width = 120.0, length = 120.0, nu = 25, nv = 25 } }
thickness = 40.0
motion = { kind = "fixed" }
[[contact]]
master = "ball"
slave = "pad"
law = { kind = "stress", elastic = [[0, 0], [0.1, 0.1], [0.6, 0.4], [0.9, 2.0]] }
[[sensor]]
name = "middle"
body = "ball"
at = [0, 0, 52]
"""
"""A ball of 1 kg that falls on a pad of foam at 3 m/s."""

TABLE = "[[0, 0, 0, 0], [5, 0, 0, -9], [10, 0, 0, 0]]"
CURVE = "[[0, 0], [0.1, 0.1], [0.6, 0.4], [0.9, 2.0]]"
GRID = '{ grid = { shape = "plane", width = 120.0, length = 120.0, nu = 25, nv = 25 } }'
SPHERE = '{ shape = "sphere", radius = 50.0, centre = [0, 0, 52] }'
PLANE = '{ shape = "plane", width = 200.0, length = 200.0, centre = [0, 0, 0] }'
MASS = "mass = { total = 1000.0, centre = [0, 0, 52], inertia = [1e6, 1e6, 1e6, 0, 0, 0] }"
BOX = "{ random = { box = [[-50, -50, 1], [50, 50, 1.001]], n = 500 } }"


SWAPPED = {
    "ball": SPHERE,
    "table": TABLE,
    "curve": CURVE,
    "grid": GRID,
    "mass": MASS,
    "thickness": "thickness = 20.0",
    "thick": "thickness = 40.0",
    "step": "step = 0.25",
    "auto": 'step = "auto"',
    "end": "end = 20.0",
    "law": f'law = {{ kind = "stress", elastic = {CURVE} }}',
    "units": 'mass = "g"',
    "velocity": "velocity = [0, 0, -3.0]",
    "sensor": "at = [0, 0, 52]\n",
    "fixed": 'motion = { kind = "fixed" }',
    "world": "[time]",
    "nodal": "thickness = 20.0\n",
    "last": '[[sensor]]\nname = "middle"\nbody = "ball"\n',
    "slave": "[[contact]]",
}
"""What is swapped, by the name of its piece."""


def case_of(base: str, swaps: dict[str, str]) -> cg.Simulation:
    text = base
    for piece, new in swaps.items():
        assert SWAPPED[piece] in text, piece
        text = text.replace(SWAPPED[piece], new, 1)
    return cg.build(parse_case(text))


def sphere(radius: float, z: float, more: str = "") -> str:
    return f'{{ shape = "sphere", radius = {radius}, centre = [0, 0, {z}]{more} }}'


def moved(z: float) -> str:
    return f"[[0, 0, 0, 0], [5, 0, 0, {z}], [10, 0, 0, 0]]"


def face(size: float, z: float, more: str = "") -> str:
    """A square face at `z` whose free side is above it."""
    return f'{{ shape = "plane", width = {size}, length = {size}, centre = [0, 0, {z}]{more} }}'


def on_joint(kind: str, at: str) -> str:
    """The sensor at the end of `DROPPED`, after a joint of the ball to the ground."""
    return (
        f'[[joint]]\nname = "{kind}"\nkind = "{kind}"\nbetween = ["ground", "ball"]\n'
        f'axis = [0, 1, 0]\nat = {at}\n[[sensor]]\nname = "middle"\nbody = "ball"\n'
    )


def on_spring(curve: float | str) -> str:
    """The sensor at the end of `DROPPED`, after a spring of 100 mm that the ball hangs on."""
    return (
        '[[spring]]\nbetween = ["ball", "ground"]\nat = [[0, 0, 52], [0, 0, 152]]\n'
        f'curve = {curve}\n[[sensor]]\nname = "middle"\nbody = "ball"\n'
    )

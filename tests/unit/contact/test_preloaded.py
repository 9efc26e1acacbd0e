"""The kernels loaded while CAD is read are those that its contact then calls."""

from __future__ import annotations

import subprocess
import sys

RUN = """
import numpy as np
import contiga as cg
from contiga.contact.preloaded import KERNELS
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edges import BodyEdge, EdgeUse

ends = [([0, 0], [1, 0]), ([1, 0], [0, 1]), ([0, 1], [0, 0])]
loop = [NurbsCurve(1, [0, 0, 1, 1], pair) for pair in ends]
rim = NurbsCurve(1, [0, 0, 1, 1], [[0, 0, 0], [1, 0, 0]])
edge = BodyEdge(rim, 0.0, (EdgeUse(0, 0, 0, False),))
plate = cg.Body([cg.shapes.plane(width=2, length=2)], trims=[[loop]], edges=[edge])
for body in (plate, cg.Body([cg.shapes.sphere(radius=1.0)])):
    points = cg.clouds.sample(cg.shapes.plane(width=2, length=2), 61, 61)
    contact = cg.Contact(body, cg.Slave(points), law=cg.PenaltyLaw(1.0), area=cg.NodalArea(1.0))
    poses = [cg.motion.pose.translation([0, 0, z]) for z in (1.1, 0.9, 0.8)]
    list(contact.dry_run((points, pose) for pose in poses))
    edges = body.edges
print(*(kernel.py_func.__name__ for kernel in KERNELS if not kernel.signatures))
"""


def test_every_kernel_that_is_loaded_ahead_is_called() -> None:
    done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []

"""Motion of bodies and nodes: prescribed, by the forces on them, or with another body.

Question: how does what moves get from one step to the next? Read `prescribed` and `pulses` (motions
that are given), `free` and `rigid_bodies` (bodies that move by forces), `nodes` (the base of what
moves the nodes of a slave), `deforming`, `deforming_parts` and `deforming_nodes` (what deforms),
`holding`; `joints` and `linkage`; `springs`, `loads`, `belt`, `gas` (what acts); `stepping` (times
of steps).

>>> dip = Translate([[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, -3.0]])
>>> dip.pose(1.0)[:3, 3].tolist()
[0.0, 0.0, -1.5]
"""

from __future__ import annotations

from contiga.dynamics.deforming import Deforming
from contiga.dynamics.free import Attached, Free
from contiga.dynamics.nodal_loads import NodalForce, Pressure
from contiga.dynamics.prescribed import (
    BodyMotion,
    Combine,
    Fixed,
    Moved,
    Poses,
    Rotate,
    SlaveMotion,
    Translate,
)
from contiga.dynamics.pulse_files import read_pulse
from contiga.dynamics.pulses import Accelerated, Velocity, check_covers
from contiga.dynamics.shapes import ControlPoints, ControlPointsOf
from contiga.rigid import pose
from contiga.rigid.twist import Twist

__all__ = [
    "Accelerated",
    "Attached",
    "BodyMotion",
    "Combine",
    "ControlPoints",
    "ControlPointsOf",
    "Deforming",
    "Fixed",
    "Free",
    "Moved",
    "NodalForce",
    "Poses",
    "Pressure",
    "Rotate",
    "SlaveMotion",
    "Translate",
    "Twist",
    "Velocity",
    "check_covers",
    "pose",
    "read_pulse",
]

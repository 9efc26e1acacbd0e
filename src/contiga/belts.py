"""Devices of belts: retractors, load limiters, pretensioners, slip rings.

>>> from contiga.belts import LoadLimiter, Retractor
>>> import contiga as cg
>>> belt = cg.Spring(
...     ("sled", "dummy"), at=[[0, 0, 0], [300, 0, 0]], curve=50.0,
...     retractor=Retractor(5.0, rate=1.5), limiter=LoadLimiter(4000.0),
... )
>>> belt.is_webbing
True
"""

from __future__ import annotations

from contiga.dynamics.belt import BeltEnd
from contiga.dynamics.belt_devices import (
    Devices,
    DeviceState,
    LoadLimiter,
    Moment,
    Pretensioner,
    Retractor,
)
from contiga.dynamics.slip_rings import SlipRing, SlipRingState

__all__ = [
    "BeltEnd",
    "DeviceState",
    "Devices",
    "LoadLimiter",
    "Moment",
    "Pretensioner",
    "Retractor",
    "SlipRing",
    "SlipRingState",
]

"""What moves, and how: prescribed motions of bodies and slaves."""

from __future__ import annotations

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
from contiga.num import pose
from contiga.num.twist import Twist

__all__ = [
    "BodyMotion",
    "Combine",
    "Fixed",
    "Moved",
    "Poses",
    "Rotate",
    "SlaveMotion",
    "Translate",
    "Twist",
    "pose",
]

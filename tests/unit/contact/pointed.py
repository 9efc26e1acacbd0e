"""A ball that comes to a point at its poles, about which no touching balls are known."""

from __future__ import annotations

import math

import contiga as cg


def pointed_ball() -> cg.Body:
    """An arc of radius one turned about the z axis, a hundredth beside its centre; two high."""
    short = 0.01
    angle = math.acos(short)
    half = cg.shapes.arc(start=-angle, end=angle, axis=(0.0, -1.0, 0.0), centre=(-short, 0.0, 0.0))
    return cg.Body([cg.shapes.revolved(half).scaled(1.0 / math.sin(angle))])

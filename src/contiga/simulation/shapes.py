"""Move the control points of bodies: by a table, or as a slave of splines deforms."""

from __future__ import annotations

from collections.abc import Mapping

from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.shapes import ControlPoints, ControlPointsOf
from contiga.records import FloatArray


class Motions:
    """Motions of the control points of bodies; those of other bodies stay."""

    def __init__(self, motions: Mapping[str, object]) -> None:
        kinds = ControlPoints | ControlPointsOf
        self.of = {name: one for name, one in motions.items() if isinstance(one, kinds)}

    def points(self, body: str, time: float, slaves: Mapping[str, SlaveState]) -> FloatArray | None:
        """Return the control points (m, 3) of a body at a time; None if it keeps its shape."""
        motion = self.of.get(body)
        if isinstance(motion, ControlPointsOf):
            return slaves[motion.slave].matter["q"]
        return None if motion is None else motion.control_points(time)

    def velocity(
        self, body: str, time: float, slaves: Mapping[str, SlaveState]
    ) -> FloatArray | None:
        """Return the velocities (m, 3) of the control points."""
        motion = self.of.get(body)
        if isinstance(motion, ControlPointsOf):
            return slaves[motion.slave].matter["q_velocity"]
        return None if motion is None else motion.control_velocity(time)

    def is_prescribed(self, body: str) -> bool:
        """Return whether a table moves the control points of a body, and does work by that."""
        return isinstance(self.of.get(body), ControlPoints)

    def slave_of(self, body: str) -> str | None:
        """Return the name of the slave whose degrees of freedom the control points are."""
        motion = self.of.get(body)
        return motion.slave if isinstance(motion, ControlPointsOf) else None

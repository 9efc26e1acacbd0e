"""Force, slope and energy of one spring over its elongation."""

from __future__ import annotations

from typing import NamedTuple

from contiga.curves.characteristic import Characteristic
from contiga.curves.curve_records import Response
from contiga.curves.hysteresis import Hysteresis

SLACK = Response(0.0, 0.0, 0.0, 0.0)
"""Response of a spring that carries nothing."""


class SpringLaw(NamedTuple):
    """The law of a spring by its curve.

    An elastic spring carries both signs. One with hysteresis carries tension only: below the
    elongation zero it is slack, and begins anew at zero force.
    """

    curve: Characteristic
    hysteresis: Hysteresis | None
    """None for an elastic spring."""

    def move(self, x_old: float, f_old: float, x: float) -> Response:
        """Return the response to a step from an elongation and its force to the elongation `x`."""
        if self.hysteresis is None:
            return self.curve.response(x)
        return self.hysteresis.step(x_old, f_old, x)

    def max_slope(self, x: float) -> float:
        """Return an upper bound of dF/dx, ≥ 0, for a step from `x`."""
        if self.hysteresis is None:
            return self.curve.max_slope_near(x)
        return self.hysteresis.slope

"""Gas in closed slaves: chambers of one pressure, inflators, vents, in the units of the case.

>>> from contiga.gas import Chamber, IdealGas, Surroundings, Vent
>>> air = Surroundings(pressure=101_325.0, temperature=293.15, gas=IdealGas(1.4, 287.05))
>>> Chamber("bag", air, vents=[Vent(1e-3, opens_at=2_000.0)]).name
'gas'
"""

from __future__ import annotations

from contiga.dynamics.gas import Chamber, GasState, Inflator, Surroundings, Vent
from contiga.dynamics.gases import IdealGas, Mixture, ThermallyPerfectGas

__all__ = [
    "Chamber",
    "GasState",
    "IdealGas",
    "Inflator",
    "Mixture",
    "Surroundings",
    "ThermallyPerfectGas",
    "Vent",
]

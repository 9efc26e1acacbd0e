"""Materials of slaves that deform, in the units of the case.

>>> from contiga.materials import NeoHooke
>>> NeoHooke(young=3.0, poisson=0.49)
NeoHooke(young=3.0, poisson=0.49, volume='element')
"""

from __future__ import annotations

from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.woven import Belt, Fabric

__all__ = ["Belt", "Elastic", "Fabric", "Foam", "NeoHooke"]

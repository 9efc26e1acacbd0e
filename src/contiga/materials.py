"""Materials of what deforms, in the units of the case.

>>> from contiga.materials import NeoHooke
>>> NeoHooke(young=3.0, poisson=0.49)
NeoHooke(young=3.0, poisson=0.49, volume='element')
"""

from __future__ import annotations

from contiga.matter.materials import Elastic, Foam, NeoHooke

__all__ = ["Elastic", "Foam", "NeoHooke"]

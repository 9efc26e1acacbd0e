"""Motions: prescribed, attached, free; the public names of `contiga.dynamics`.

>>> from contiga.motion import Translate, pose
>>> pose.translation([1.0, 0.0, 0.0])[:3, 3].tolist()
[1.0, 0.0, 0.0]
"""

from __future__ import annotations

from contiga.dynamics import *  # noqa: F403 (the same names under the public one)
from contiga.dynamics import __all__ as __all__

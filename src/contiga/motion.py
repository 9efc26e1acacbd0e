"""Motions: prescribed, attached, free; the public names of `contiga.dynamics`.

Names are loaded when first used: modules of deforming slaves take longer to load than a contact.

>>> from contiga.motion import Translate, pose
>>> pose.translation([1.0, 0.0, 0.0])[:3, 3].tolist()
[1.0, 0.0, 0.0]
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from contiga.rigid import pose as pose

if TYPE_CHECKING:
    from contiga.dynamics import *  # noqa: F403 (the same names under the public one)
    from contiga.dynamics import __all__ as __all__


def __getattr__(name: str) -> Any:
    if name == "__all__" or not name.startswith("__"):
        from contiga import dynamics

        if name in ("__all__", *dynamics.__all__):
            return getattr(dynamics, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    from contiga import dynamics

    return sorted(dynamics.__all__)

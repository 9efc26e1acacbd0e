"""contiga: contact between exact CAD surfaces and deformable meshes.

Names are loaded when first used, so that ``import contiga`` stays as cheap as numba's own import.
Which there are, and where, `__init__.pyi` says, to type checkers as well.
"""

from __future__ import annotations

import pathlib
import re
from importlib import import_module
from typing import Any

from contiga.version import __version__

_LISTED = pathlib.Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_HOME = {name: home for home, name in re.findall(r"^from (\S+) import (\w+)", _LISTED, re.M)}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'contiga' has no attribute {name!r}")
    home = import_module(_HOME[name])
    value = vars(home).get(name) or import_module(f"{home.__name__}.{name}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)

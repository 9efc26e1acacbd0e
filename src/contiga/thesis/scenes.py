"""Where the case files of the thesis' scenes lie."""

from __future__ import annotations

from pathlib import Path

from contiga.errors import FileError

_PACKAGED = Path(__file__).with_name("scenes")
_IN_CHECKOUT = Path(__file__).parents[3] / "examples" / "thesis"


def scene(name: str) -> Path:
    """The case file of a scene, from the installed package or from the checkout.

    Raises
    ------
    FileError
        No such scene.
    """
    for folder in (_PACKAGED, _IN_CHECKOUT):
        path = folder / f"{name}.toml"
        if path.is_file():
            return path
    raise FileError("no such scene of the thesis", where=name)

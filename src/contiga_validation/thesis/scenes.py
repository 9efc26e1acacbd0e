"""Case files of the thesis' scenes."""

from __future__ import annotations

from pathlib import Path

from contiga.errors import FileError

CASES = Path(__file__).with_name("cases")


def scene(name: str) -> Path:
    """Return the case file of a scene.

    Raises
    ------
    FileError
        There is no such scene.
    """
    path = CASES / f"{name}.toml"
    if not path.is_file():
        raise FileError("no such scene of the thesis", where=name)
    return path

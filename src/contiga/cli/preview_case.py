"""The preview of a case: its path, checked early, and its output."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from contiga.extras import require

if TYPE_CHECKING:
    from contiga.simulation.simulation import Simulation


def preview_path(path: Path) -> Path:
    """Return `path` if a preview can be written to it; to be called before files are read.

    Raises
    ------
    FileError
        Neither a picture nor a page.
    MissingPackageError
        The package that draws it is not installed.
    """
    from contiga.previewing.preview import check_suffix

    check_suffix(path)
    require("a preview", "matplotlib" if path.suffix.lower() == ".png" else "plotly")
    return path


def write_preview(simulation: Simulation, path: Path) -> None:
    """Write the preview of a simulation and print its path."""
    from contiga.previewing.preview import preview

    preview(simulation).save(path)
    print(f"preview: {path}")

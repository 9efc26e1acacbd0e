"""``contiga export DIR``: signals of sensors in the format of crash laboratories."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Output folder of a run.")],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            metavar="DIR",
            help="Folder to put the test in; iso_mme in that of the run if left out.",
        ),
    ] = None,
    test: Annotated[
        str | None,
        typer.Option("--test", metavar="NAME", help="Name of the test; the folder's if left out."),
    ] = None,
) -> None:
    """Write the channels of sensors and springs of a run as ISO/TS 13499 (ISO-MME) files."""
    from contiga.simulation.stored_result import open_result

    result = open_result(folder)
    path, count = result.write_mme(out or folder / "iso_mme", test or folder.resolve().name)
    print(f"{path}: {count} channels")

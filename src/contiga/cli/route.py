"""``contiga route FILE``: shortest path over CAD between two points, or a case's belt paths."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import Annotated

import typer

from contiga.cli.options import load
from contiga.errors import FileError, InputError


def route(
    context: typer.Context,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="CAD file or mesh, or a case with belts.")
    ],
    start: Annotated[
        str | None, typer.Option("--from", metavar="X,Y,Z", help="Where the path starts.")
    ] = None,
    end: Annotated[
        str | None, typer.Option("--to", metavar="X,Y,Z", help="Where the path ends.")
    ] = None,
    via: Annotated[
        list[str] | None,
        typer.Option("--via", metavar="X,Y,Z", help="Which way round it goes. Repeatable."),
    ] = None,
    points: Annotated[
        int, typer.Option("--points", help="Chords along the path; sharp edges get more.")
    ] = 200,
    unit: Annotated[
        str | None, typer.Option("--unit", help="Length unit; the file's own if left out.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="x.png", help="Picture to write."),
    ] = None,
) -> None:
    """Lay a taut string over CAD, or the belts of a case: length, wrap angles, and a picture."""
    from contiga.previewing.routes import check_picture, draw_routes

    if out is not None:
        check_picture(out)
    if not file.exists():
        raise FileError("no such file", where=str(file))
    if file.suffix.lower() == ".toml":
        if start or end or via:
            raise InputError(
                "a case says itself where its belts run",
                where="--from",
                allowed="a CAD file or a mesh",
            )
        from contiga.case.build import belts_of

        belts = belts_of(load(file, None, context))
        if not belts:
            raise InputError("has no belts", where=str(file), allowed="a case with [[belt]] tables")
        paths = {name: belt.path for name, belt in belts.items()}
    else:
        from contiga.io.cad.formats import SUFFIXES
        from contiga.io.cad.read_cad import read_cad
        from contiga.io.mesh.read_master import read_master
        from contiga.routing.route import route as route_over

        ends = _point(start, "--from"), _point(end, "--to")
        is_cad = file.suffix.lower() in SUFFIXES
        body = read_cad(file, unit=unit) if is_cad else read_master(file, unit=unit)
        between = [_point(text, "--via") for text in via or []]
        paths = {"path": route_over(body, *ends, between, points=points)}
    for name, path in paths.items():
        print(f"{name}: length {path.length:.8g}, {len(path.points)} points")
        for wrap in path.wraps:
            first, last = (", ".join(f"{x:.6g}" for x in at) for at in (wrap.first, wrap.last))
            print(
                f"  on {wrap.body} from {wrap.start:.6g} [{first}] to {wrap.end:.6g} [{last}], "
                f"turns by {degrees(wrap.angle):.4g}°"
            )
        if not path.wraps:
            print("  touches nothing")
    if out is not None:
        draw_routes([*paths.values()], out)
        print(f"picture: {out}")


def _point(text: str | None, option: str) -> list[float]:
    """Return the point of a text ``X,Y,Z``; InputError, with the option, if it is none."""
    try:
        numbers = [float(x) for x in (text or "").split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 3:
        raise InputError("must be a point", where=option, found=text, allowed="X,Y,Z")
    return numbers

"""Triangles of trimmed bodies: how many a second, and how many over the fewest."""

from __future__ import annotations

from pathlib import Path
from time import process_time

import contiga as cg
from contiga_validation.rivals.rival_meshes import fewest_triangles

ROOT = Path(__file__).resolve().parents[1]
FILES = (
    ROOT / "examples" / "generated" / "headform.step",
    ROOT.parent / "shared" / "data" / "nist_ctc_02_asme1_ap242.stp",
)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
SHAPES = {
    "sphere": cg.shapes.sphere(),
    "torus": cg.shapes.torus(),
    "bumpy plate": cg.shapes.bumpy_plate(width=1.0, length=1.0, amplitude=0.04, waves=2),
}


def _line(name: str, body: cg.Body, tol: float, fewest: bool) -> str:
    start = process_time()
    mesh = body.tessellate(tol * body.size)
    seconds = process_time() - start
    count = len(mesh.triangles)
    text = f"{name} at {tol:.0e}: {count:,} triangles, {count / seconds:,.0f} a second"
    if fewest:
        text += f", {count / fewest_triangles(body, tol * body.size):.2f} of the fewest"
    return f"{text}, {len(mesh.open_edges())} open edges"


def run() -> list[str]:
    """The lines of the table; seconds of one core."""
    cg.Body([SHAPES["sphere"]]).tessellate(0.1)
    lines = [
        _line(name, cg.Body([shape]), tol, True)
        for name, shape in SHAPES.items()
        for tol in TOLERANCES[:-1]
    ]
    for file in FILES:
        if not file.is_file():
            lines.append(f"{file.name}: not there")
            continue
        body = cg.read_cad(file)
        lines += [_line(file.stem, body, tol, False) for tol in TOLERANCES]
    return lines

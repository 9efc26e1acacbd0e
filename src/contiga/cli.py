"""The command line: ``contiga run | check | info | report``.

Exit codes: 0 done, 1 the run failed, 2 the input is wrong. Wrong input gets one message on the
error stream, never a traceback; ``CONTIGA_DEBUG=1`` shows the traceback of any failure.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from contiga import __version__
from contiga.errors import ContigaError, FileError

if TYPE_CHECKING:
    from collections.abc import Iterable

_INTERRUPTED = 130
"""What a shell expects of a command stopped by Ctrl-C."""

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Contact between exact CAD surfaces and deformable meshes.",
)

CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]


def main() -> None:
    """Run the command line and leave with its exit code."""
    try:
        app()
    except ContigaError as error:
        _fail(str(error), error, error.exit_code)
    except KeyboardInterrupt:
        sys.exit(_INTERRUPTED)
    except Exception as error:
        what = f"{type(error).__name__}: {error}".rstrip(": ").splitlines()[0]
        _fail(f"unexpected {what} (set CONTIGA_DEBUG=1 for the traceback)", error, 1)


def _fail(message: str, error: Exception, code: int) -> None:
    if os.environ.get("CONTIGA_DEBUG", "0") not in ("", "0"):
        raise error
    print(f"contiga: error: {message}", file=sys.stderr)
    sys.exit(code)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"contiga {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Print the version and stop."
        ),
    ] = False,
) -> None:
    pass


@app.command()
def run(
    case: CaseFile,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Output folder; CASE_out beside the case if left out."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on from the checkpoint in the output folder.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Run a case: forces, fields and a report into the output folder."""
    from contiga import api
    from contiga.case.schema import load_case

    loaded = load_case(case)
    folder = out if out is not None else case.parent / f"{case.stem}_out"
    try:
        result = api.run(loaded, out=folder, resume=resume, quiet=quiet)
    except KeyboardInterrupt:
        print(
            f"\ncontiga: stopped; contiga run {case} -o {folder} --resume goes on from the last "
            "checkpoint",
            file=sys.stderr,
        )
        raise
    if not quiet:
        _print_result(result.summary, result.history, folder)


def _print_result(summary: dict[str, Any], history: dict[str, Any], folder: Path) -> None:
    import numpy as np

    from contiga.report.tables import number

    timings = summary.get("timings") or {}
    lost = float(timings.get("compile", 0.0))
    total = float(timings.get("total", 0.0))
    apart = f", {number(lost, 2)} s of it compiling kernels" if lost >= 0.05 else ""
    print(f"{summary.get('steps', len(history['time']))} steps in {number(total, 3)} s{apart}")
    for name, force in history.items():
        contact, _, column = name.rpartition(".")
        if column == "force" and len(force):
            at = int(np.nanargmax(force))
            label = f"{contact}: " if contact else ""
            print(f"{label}peak force {number(float(force[at]))} at t = {history['time'][at]:g}")
    for text in summary.get("warnings") or []:
        print(f"warning: {text}")
    page = folder / "report.html"
    print(f"report: {page}" if page.is_file() else f"output: {folder}")


@app.command()
def check(case: CaseFile) -> None:
    """Read a case and all its files, and say what a run would do."""
    from contiga.case.build import build
    from contiga.case.schema import load_case

    _table(_case_rows(build(load_case(case))))
    print(f"{case} is ready to run")


def _case_rows(simulation: Any) -> Iterable[tuple[str, str]]:
    times = simulation.times
    length, mass, time = simulation.units
    yield "title", simulation.title
    yield "units", f"{length}, {mass}, {time}"
    yield "time", f"{len(times) - 1} steps from {times[0]:g} to {times[-1]:g} {time}"
    for name, part in simulation.bodies.items():
        yield f"body {name}", f"{len(part.body.patches)} patches, moved {_motion(part.motion)}"
    for name, part in simulation.slaves.items():
        slave = part.slave
        facets = 0 if slave.facets is None else len(slave.facets)
        shape = f"{facets} triangles" if facets else "no facets"
        yield (
            f"slave {name}",
            f"{len(slave.points)} points, {int(slave.active.sum())} take part, {shape}, "
            f"moved {_motion(part.motion)}",
        )
    for contact in simulation.contacts:
        law = type(contact.contact.law).__name__
        yield f"contact {contact.name}", f"{contact.slave} on {contact.master}, {law}"
    output = simulation.output
    yield "output", f"every {output.every} steps: {', '.join(output.formats)}"


def _motion(motion: Any) -> str:
    return str(getattr(motion, "kind", "") or type(motion).__name__)


@app.command()
def info(file: Annotated[Path, typer.Argument(metavar="FILE", help="CAD file or mesh.")]) -> None:
    """Say what is in a CAD file (patches, degrees, trims, size) or in a mesh (counts)."""
    from contiga.io import cad, mesh

    if not file.is_file():
        raise FileError("no such file", where=str(file))
    if file.suffix.lower() in cad.SUFFIXES:
        _table(cad.summary(cad.read_cad(file)))
    else:
        _table(mesh.summary(mesh.read_mesh(file)))


def _table(rows: Iterable[tuple[str, str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="bold", no_wrap=True)
    grid.add_column(overflow="fold")
    for label, text in rows:
        grid.add_row(label, text)
    Console(highlight=False).print(grid)


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Output folder of a run.")],
) -> None:
    """Write report.html again from what a run left in its folder."""
    from contiga.report import write_report

    print(f"report: {write_report(folder)}")

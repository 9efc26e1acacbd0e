"""The commands: ``contiga run | check | preview | info | mesh | report | compare | …``."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from contiga.cli.compare import compare
from contiga.cli.compiling import watch_compiling
from contiga.cli.convert import convert
from contiga.cli.export import export
from contiga.cli.film import film
from contiga.cli.help_pages import Command, Group, epilog
from contiga.cli.options import HELPED, WITH_CASE, CaseFile, Quiet, Settings, load
from contiga.cli.pack import pack
from contiga.cli.plot import plot
from contiga.cli.preview_case import preview_path, write_preview
from contiga.cli.route import route
from contiga.cli.study import study
from contiga.cli.verify import verify
from contiga.cli.warmup import warmup
from contiga.errors import ContigaError, FileError, InputError, RunError
from contiga.running.progress import progress_bar
from contiga.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterable

_INTERRUPTED = 130
"""Exit code that a shell expects of a command stopped by Ctrl-C."""

app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Contact between exact CAD surfaces and deformable meshes.",
    epilog=epilog(""),
)


def main() -> None:
    """Run the command line and leave with its exit code.

    Errors are printed as one message on the error stream: of contiga with their own code, others
    with code 1. Ctrl-C gives 130. With CONTIGA_DEBUG errors are raised.
    """
    try:
        app()
    except ContigaError as error:
        _fail(str(error), error, error.exit_code)
    except KeyboardInterrupt:
        sys.exit(_INTERRUPTED)
    except MemoryError as error:
        _fail(f"not enough memory ({error})".replace(" ()", ""), error, 1)
    except Exception as error:
        message = f"{type(error).__name__}: {error}".rstrip(": ").splitlines()[0]
        _fail(f"unexpected {message} (set CONTIGA_DEBUG=1 for the traceback)", error, 1)


def _fail(message: str, error: Exception, code: int) -> None:
    """Print a message on the error stream and exit; with CONTIGA_DEBUG, raise the error instead."""
    if os.environ.get("CONTIGA_DEBUG", "0") not in ("", "0"):
        raise error
    print(f"contiga: error: {message}", file=sys.stderr)
    sys.exit(code)


def _show_version(is_requested: bool) -> None:
    """Print the version and the kernels in use, and stop, if that is requested."""
    if is_requested:
        from contiga.jit.prebuilt import choice

        print(f"contiga {__version__}\n{choice().text}")
        raise typer.Exit


@app.callback()
def _options(
    context: typer.Context,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Print the version and stop."
        ),
    ] = False,
) -> None:
    if context.invoked_subcommand not in (*WITH_CASE, *HELPED):
        watch_compiling(context)


@app.command(cls=Command, epilog=epilog("run"))
def run(
    context: typer.Context,
    case: CaseFile,
    settings: Settings = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Output folder; CASE_out beside the case if left out."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on from the checkpoint in the output folder.")
    ] = False,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict", help="Warnings of the model are errors; stop at a point not certified."
        ),
    ] = False,
    settle_only: Annotated[
        bool,
        typer.Option("--settle-only", help="Come to rest, write that state, and do not run."),
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Run a case: forces, fields and a report into the output folder."""
    from contiga.running import run_case

    loaded = load(case, settings, context)
    folder = out if out is not None else case.parent / f"{case.stem}_out"
    try:
        result = run_case.run(
            loaded,
            out=folder,
            resume=resume,
            strict=strict,
            settle_only=settle_only,
            quiet=quiet,
        )
    except KeyboardInterrupt:
        from contiga.simulation.output_folder import newest_checkpoint

        options = [f"--set={setting}" for setting in settings or ()]
        line = shlex.join(["contiga", "run", str(case), "-o", str(folder), *options, "--resume"])
        advice = f"; {line} goes on from the last checkpoint"
        has_checkpoint = newest_checkpoint(folder).is_file()
        print(f"\ncontiga: stopped{advice if has_checkpoint else ''}", file=sys.stderr)
        raise
    if quiet:
        return
    _print_result(result.summary, result.history, folder)
    if loaded.reference and (folder / "report.html").is_file():
        from contiga.report.references import rated, references_of
        from contiga.report.run_folder import read_run

        # ratings of signals over time beside the tests that the case names
        stored = read_run(folder)
        for reference in references_of(stored):
            if reference.x == "time":
                test = rated(stored, reference)
                text = f"not rated: {test.why}"
                if test.rating is not None:
                    overall, grade = f"{test.rating.overall:.3f}", test.rating.grade
                    text = f"rated {overall}, {grade}, by ISO/TS 18571"
                print(f"{reference.channel} beside test {reference.name}: {text}")


def _print_result(summary: dict[str, Any], history: dict[str, Any], folder: Path) -> None:
    """Print steps, peak forces, energy balance, criteria, notes and warnings of a run.

    The last line names the report in `folder`, or the folder if it has none.
    """
    import numpy as np

    from contiga.cli.step_reasons import steps_line
    from contiga.io.units import derived_units
    from contiga.report.style import number, span_of

    timings, units = summary.get("timings") or {}, summary.get("units") or {}
    columns = summary.get("columns") or {}
    if settled := summary.get("settled"):
        residual = f"unbalanced forces are {settled['residual']:.2g} of the loads"
        print(f"settled in {settled['steps']} steps: {residual}")
    n_steps, total = summary.get("steps", len(history["time"]) - 1), timings.get("total", 0.0)
    line = f"{n_steps} steps in {number(float(total), 3)} s"
    if (compiling := float(timings.get("compile", 0.0))) >= 0.05:
        line += f", {number(compiling, 2)} s of it compiling kernels"
    print(line)
    for name, force in history.items():
        contact, _, column = name.rpartition(".")
        if column == "force" and np.isfinite(force).any():
            k = int(np.nanargmax(np.abs(force)))
            label = f"{contact}: " if contact else ""
            peak = f"{number(float(force[k]))} {columns.get(name, '')}".rstrip()
            time = f"{history['time'][k]:g} {columns.get('time', '')}".rstrip()
            print(f"{label}peak force {peak} at t = {time}")
    if energy := summary.get("energy"):
        base = [units.get(key, "") for key in ("length", "mass", "time")]
        unit = derived_units(*base)["energy"] if all(base) else ""
        share = f"{100.0 * energy['relative']:.2g} %"
        print(f"energy balance: error at most {share} of {number(energy['most'])} {unit}".rstrip())
    for name, sensor in (summary.get("sensors") or {}).items():
        for criterion, result in sensor["criteria"].items():
            span = f"t = {span_of(result)} {units.get('time', '')}"
            value = number(result["value"]) + f" {result.get('unit', '')}".rstrip()
            value += f" ({result['band']})" if "band" in result else ""
            print(f"{name}: {criterion} {value}, {span}")
    if line := steps_line(summary.get("step_reasons") or {}):
        print(line)
    for text in summary.get("notes") or []:
        print(f"note: {text}")
    for text in summary.get("warnings") or []:
        print(f"warning: {text}")
    page = folder / "report.html"
    print(f"report: {page}" if page.is_file() else f"output: {folder}")


@app.command(cls=Command, epilog=epilog("check"))
def check(
    context: typer.Context,
    case: CaseFile,
    settings: Settings = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="x.png|x.html", help="Write a preview, too."),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Fail with exit code 2 where there is a warning.")
    ] = False,
) -> None:
    """Read a case and all its files, say what a run would do, and warn of what looks wrong."""
    from contiga.case.build import build
    from contiga.case.describe import describe, placed_parts
    from contiga.simulation.checks.finding import raise_findings
    from contiga.simulation.checks.joint_checks import joint_notes
    from contiga.simulation.checks.surface_checks import OPEN

    path = None if picture is None else preview_path(picture)
    loaded = load(case, settings, context, whole=True)
    simulation = build(loaded)
    _table(describe(loaded))
    print()
    _table(placed_parts(simulation))
    for name, part in simulation.bodies.items():
        print(f"\n{name}")
        _table(part.body.condition_rows())
    if path is not None:
        write_preview(simulation, path)
    findings = simulation.check()
    for note in joint_notes(simulation):
        print(f"note: {note}")
    for finding in findings:
        print(f"warning: {finding}")
    if strict and findings:
        raise_findings(findings)
    warnings = {0: "", 1: ", with a warning"}.get(len(findings), f", with {len(findings)} warnings")
    open_parts = ", ".join(finding.where for finding in findings if finding.rule == OPEN)
    if open_parts:
        print(f"{case} runs, but not as it is meant: {open_parts} counts as open{warnings}")
    else:
        print(f"{case} is ready to run{warnings}")


@app.command(cls=Command, epilog=epilog("preview"))
def preview(
    context: typer.Context,
    case: CaseFile,
    out: Annotated[
        Path,
        typer.Option("-o", "--out", metavar="x.png|x.html", help="Picture or page to write."),
    ],
    settings: Settings = None,
) -> None:
    """Draw what stands where at the start of a case: free sides, ways, gaps. Nothing is run."""
    from contiga.case.build import build

    path = preview_path(out)
    write_preview(build(load(case, settings, context)), path)


@app.command(cls=Command, epilog=epilog("info"))
def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="CAD file or mesh.")],
    faces: Annotated[
        bool, typer.Option("--faces", help="List the faces of CAD with their numbers, too.")
    ] = False,
) -> None:
    """Say what is in a CAD file (parts, patches, trims, size) or in a mesh (counts)."""
    from contiga.cli.info import rows_of

    if not file.exists():
        raise FileError("no such file", where=str(file))
    _table(rows_of(file, faces=faces))


def _table(rows: Iterable[tuple[str, str]]) -> None:
    """Print rows (label, text) in two columns as wide as the terminal."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="bold", no_wrap=True)
    grid.add_column(overflow="fold")
    for label, text in rows:
        grid.add_row(Text(label), Text(text))  # not markup: brackets are no styles
    Console(highlight=False).print(grid)


@app.command(cls=Command, epilog=epilog("mesh"))
def mesh(
    cad: Annotated[Path, typer.Argument(metavar="CAD", help="STEP, IGES, 3DM or G+Smo XML.")],
    tol: Annotated[
        float,
        typer.Option(
            "--tol", help="Largest distance to the surface; of the net method an area, by patch."
        ),
    ],
    out: Annotated[
        Path, typer.Option("-o", "--out", help="Mesh to write: .msh (Gmsh 4.1), .vtu or .stl.")
    ],
    size: Annotated[
        float | None,
        typer.Option(
            "--size",
            help="Longest side of triangles; a tenth of the part's size if left out, none if 0.",
        ),
    ] = None,
    method: Annotated[
        str,
        typer.Option("--method", help="chord (distance) or net (the thesis' control net rule)."),
    ] = "chord",
    unit: Annotated[
        str | None, typer.Option("--unit", help="Length unit to write; the file's own if left out.")
    ] = None,
    part: Annotated[
        list[str] | None,
        typer.Option("--part", help="Name or number of a part, once for each; all if left out."),
    ] = None,
) -> None:
    """Write triangles of a CAD file, without cracks where its faces share edges."""
    from contiga.cli.meshing import foretell
    from contiga.geometry.tessellate import check_request
    from contiga.io.cad.read_cad import read_cad
    from contiga.io.out.write_mesh import check_suffix, write_mesh
    from contiga.masters.sampling import BODY_SIZE_SHARE

    check_suffix(out)
    check_request(tol, method)
    if size is not None and not 0.0 <= size < float("inf"):
        raise InputError("must be a length", where="--size", found=size, allowed=">= 0")
    if not cad.exists():
        raise FileError("no such file", where=str(cad))
    parts = None if part is None else [int(key) if key.isdecimal() else key for key in part]
    body = read_cad(cad, unit=unit, parts=parts)
    if size is None and method == "chord":
        size = BODY_SIZE_SHARE * body.size
    if method == "chord":
        foretell(body, tol)
    triangles = body.tessellate(tol, method=method, size=size or None)
    write_mesh(out, triangles)
    open_edges = len(triangles.open_edges())
    closed = f"{open_edges} open edges" if open_edges else "closed"
    length = "" if triangles.unit is None else f" in {triangles.unit}"
    if unit is not None and triangles.unit is None:
        length = f" (the file has no unit: its numbers are taken as {unit})"
    print(
        f"{out}: {len(triangles.triangles)} triangles, {len(triangles.vertices)} vertices{length}, "
        f"area {triangles.area():.6g}, {closed}"
    )


@app.command(cls=Command, epilog=epilog("report"))
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Output folder of a run.")],
) -> None:
    """Write report.html again from what a run left in its folder."""
    from contiga.report import write_report

    print(f"report: {write_report(folder)}")


@app.command(cls=Command, epilog=epilog("reproduce"))
def reproduce(
    context: typer.Context,
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Output folder.")] = Path(
        "reproduction"
    ),
    only: Annotated[
        str | None,
        typer.Option(
            "--only",
            metavar="5.1,5.4,…",
            help="Chapters, sections or experiments, separated by commas; all if left out.",
        ),
    ] = None,
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="Compare with the finest meshes memory allows: tens of minutes."
        ),
    ] = False,
    cad: Annotated[
        Path | None,
        typer.Option("--cad", metavar="FILE", help="CAD file of the comparison's third body."),
    ] = None,
    data: Annotated[
        Path | None,
        typer.Option("--data", metavar="DIR", help="Folder of public CAD files to take it from."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Run the experiments of the thesis: a page, tables and pictures beside its own numbers."""
    from contiga_validation.reproduce import broken_claims
    from contiga_validation.reproduce import reproduce as run_all

    watch_compiling(context, helped=True)
    names = None if only is None else only.split(",")
    with progress_bar("reproduce", quiet=quiet) as show:
        page = run_all(out, only=names, full=full, cad=cad, data=data, progress=show)
    broken = broken_claims(out)
    if not quiet:
        print(f"report: {page}")
    if broken:
        raise RunError("not every statement held: " + "; ".join(broken))


for _command in (compare, convert, export, film, pack, plot, route, study, verify, warmup):
    app.command(cls=Command, epilog=epilog(_command.__name__))(_command)

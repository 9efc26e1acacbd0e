"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from contiga.cli.compiling import watch_compiling

if TYPE_CHECKING:
    from contiga.case.schema import Case

CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="A value in place of the case's: body.head.motion.velocity=[0,0,-5]. Repeatable.",
    ),
]
"""Settings that `load` applies to a case."""

Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]

HELPED = ("reproduce", "verify")
"""Commands that start helper processes for compiling themselves, once their options are read."""
WITH_CASE = ("run", "check", "preview")
"""Commands that begin with `load`."""


def load(
    case: Path,
    settings: list[str] | None,
    context: typer.Context | None = None,
    *,
    whole: bool = False,
) -> Case:
    """Return the case of a file, with the settings of the command line over it.

    If its tables are wrong, `whole` also checks the parts that other tables describe. From here on
    the reader of CAD loads if the case names CAD files and, with a `context`, other processes
    compile beside its command if it has to compile much.

    Raises
    ------
    InputError
        As `load_case`, or a setting is wrong.
    """
    from contiga.io.cad.formats import cad_files_in, expect_cad

    is_readable = True
    try:
        # the reader of CAD loads while the case is read
        expect_cad(*cad_files_in(case.read_text(encoding="utf-8"), case.parent))
    except (OSError, UnicodeDecodeError):
        is_readable = False  # `load_case` raises the error
    if context is not None:
        watch_compiling(context, helped=is_readable)
    from contiga.case.schema import load_case
    from contiga.case.settings import parse_settings
    from contiga.case.whole import load_case_to_build

    return (load_case_to_build if whole else load_case)(case, set=parse_settings(settings or ()))

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
"""What `load` takes."""

Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]

HELPED = ("reproduce", "verify")
"""Commands that have other processes compile as well once they know what is asked for."""
WITH_CASE = ("run", "check", "preview")
"""Commands that begin with `load`."""


def load(
    case: Path,
    settings: list[str] | None,
    context: typer.Context | None = None,
    *,
    whole: bool = False,
) -> Case:
    """The case of a file, with the settings of the command line over it.

    Where its tables are wrong, `whole` looks at the parts that other tables describe, too.

    From here on other processes compile beside the command of `context`, if it has to compile much.
    """
    readable = _expect_cad(case)
    if context is not None:
        watch_compiling(context, helped=readable)
    from contiga.case.schema import load_case
    from contiga.case.settings import parse_settings
    from contiga.case.whole import load_whole

    return (load_whole if whole else load_case)(case, set=parse_settings(settings or ()))


def _expect_cad(case: Path) -> bool:
    """Have what reads CAD loaded beside what reads cases, if the case may need it.

    Returns whether the file can be read; `load_case` says what is wrong.
    """
    from contiga.io.cad.formats import cad_files_in, expect_cad

    try:
        expect_cad(*cad_files_in(case.read_text(encoding="utf-8"), case.parent))
    except (OSError, UnicodeDecodeError):
        return False
    return True

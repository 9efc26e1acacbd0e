"""The command line: ``contiga run | check | preview | info | mesh | report | compare | …``.

Exit codes: 0 done, 1 the run failed, 2 the input is wrong. Wrong input gets one message on the
error stream, never a traceback; ``CONTIGA_DEBUG=1`` shows the traceback of any failure. Read
`commands` and `options`, then the file of a command.
"""

from __future__ import annotations

import sys

from contiga.cli.plain_signs import write_plain_signs
from contiga.errors import MissingPackageError
from contiga.extras import require
from contiga.warmup.garbage import rare_collections


def main() -> None:
    """Run the command line and leave with its exit code.

    It is 2, with a message, if a package that commands need is missing.
    """
    write_plain_signs()
    try:
        require("the command line", "typer", "rich", "pydantic")
    except MissingPackageError as error:
        print(f"contiga: error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    with rare_collections():
        from contiga.cli.commands import main as run

        run()

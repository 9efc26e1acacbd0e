"""``contiga convert DECK``: a case made of an LS-DYNA keyword deck."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from contiga.errors import OutputError


def convert(
    deck: Annotated[Path, typer.Argument(metavar="DECK.k", help="LS-DYNA keyword file.")],
    out: Annotated[Path, typer.Option("-o", "--out", help="Case file to write: .toml.")],
    units: Annotated[
        str,
        typer.Option(
            "--units", metavar="L,M,T", help="What the deck's numbers are in, such as mm,kg,ms."
        ),
    ],
) -> None:
    """Make a case of an LS-DYNA keyword deck, and list what of it is not understood."""
    from contiga.case.convert import convert as convert_deck
    from contiga.case.convert import parse_units
    from contiga.io.out.files import write_text

    if out.exists():
        raise OutputError(
            "there is such a file already", where=str(out), allowed="a new file: it may be yours"
        )
    conversion = convert_deck(deck, parse_units(units), out.parent)
    write_text(out, conversion.text)
    print(f"{out}: {conversion.bodies} bodies, {conversion.contacts} contacts")
    for name, lines in sorted(conversion.unknown.items()):
        more = ", …" if len(lines) > 5 else ""
        print(f"not understood: {len(lines)} {name}, line {', '.join(map(str, lines[:5]))}{more}")

"""Plain spelling of characters that an encoding lacks: ``12.5 N/mm²`` as ``12.5 N/mm^2``.

A stream that goes into a file or a pipe has the encoding of the system, which on Windows, and with
``PYTHONIOENCODING``, is often not UTF-8. A command must not fail over a thin space.
"""

from __future__ import annotations

import codecs
import sys
from io import TextIOWrapper
from unicodedata import name, normalize

ERRORS = "contiga.plain_signs"
"""Name of the handler of characters that cannot be encoded."""
PLAIN = {
    "⁄": "/",
    "²": "^2",
    "³": "^3",
    "⁴": "^4",
    "·": "*",
    "×": "x",
    "°": " deg",
    "±": "+/-",
    "−": "-",
    "–": "-",
    "—": "-",
    "→": "->",
    "≤": "<=",
    "≥": ">=",
    "µ": "u",
    "μ": "u",
    "λ": "lambda",
    "√": "sqrt ",
    "∫": "integral ",
    "“": '"',
    "”": '"',
    "‘": "'",
    "’": "'",
}
"""Plain spelling of each sign."""


def write_plain_signs() -> None:
    """Make the standard streams replace characters that they cannot encode by plain ones."""
    codecs.register_error(ERRORS, _encoded)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # pythonw.exe has none
            stream.reconfigure(errors=ERRORS)


def _encoded(error: UnicodeError) -> tuple[str, int]:
    """Return plain text for the characters that cannot be encoded, and the position after them."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(plain, error.object[error.start : error.end])), error.end


def plain(sign: str) -> str:
    """Return a character in ASCII: its plain spelling, the name of a Greek letter, or its number.

    >>> [plain(sign) for sign in ("²", "₁", "ω", "é")]
    ['^2', '1', 'omega', '\\\\xe9']
    """
    if sign in PLAIN:
        return PLAIN[sign]
    parts = normalize("NFKD", sign)
    if parts != sign and all(part.isascii() or part in PLAIN for part in parts):
        return "".join(PLAIN.get(part, part) for part in parts)
    if name(sign, "").startswith("GREEK "):
        return name(sign).split()[-1].lower()
    return sign.encode("ascii", "backslashreplace").decode("ascii")

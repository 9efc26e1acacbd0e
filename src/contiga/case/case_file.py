"""Files of a case as text and as tables of TOML."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from contiga.errors import CaseError, FileError

_MAX_BYTES = 32 * 1024**2  # the parser takes a second, and ten times the memory


def read_text(path: Path) -> str:
    """Return the text of a case file, without a byte order mark.

    Raises
    ------
    FileError
        It is missing, larger than 32 MiB, cannot be read or is not UTF-8.
    """
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise FileError(
                "too large for a case file",
                where=str(path),
                found=path.stat().st_size,
                allowed=f"up to {_MAX_BYTES} bytes",
                remedy="Points and long tables belong in files that the case names",
            )
        return path.read_text(encoding="utf-8-sig")  # editors of Windows put a mark in front
    except FileNotFoundError as error:
        raise FileError("no such file", where=str(path), allowed="a case file (TOML)") from error
    except UnicodeDecodeError as error:
        raise FileError("is not UTF-8 text", where=str(path), allowed="a case file") from error
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error


def tables_in(text: str, path: Path) -> dict[str, Any]:
    """Return the tables in the text of the file at `path`.

    Raises
    ------
    CaseError
        It is not TOML.
    """
    try:
        return tomllib.loads(text)
    except ValueError as error:  # TOMLDecodeError, or a number or date Python refuses
        raise CaseError(f"is not valid TOML: {error}", where=str(path)) from error
    except RecursionError as error:
        raise CaseError("is not valid TOML: nested too deeply", where=str(path)) from error

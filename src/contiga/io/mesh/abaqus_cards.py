"""Abaqus input files as keywords with their data lines.

Rules of syntax: Abaqus Analysis User's Guide, "Input syntax rules": ``*`` begins a keyword with
parameters separated by commas, which continues if its line ends with one; ``**`` a comment.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from contiga.errors import FileError, MeshError
from contiga.io.limits import watched_lines
from contiga.io.mesh.deck_text import find_included, parse_real

_WITH_INPUT = ("INCLUDE", "NODE", "ELEMENT", "NSET", "ELSET")
"""Keywords whose parameter INPUT names a file."""


class Line(NamedTuple):
    """A data line."""

    fields: list[str]
    """Texts between commas, stripped and without quotation marks."""
    where: str
    """File and line."""


class Keyword(NamedTuple):
    """A keyword with its parameters and data lines, comments and blank lines left out."""

    name: str
    """Upper case, one blank between words: "END PART"."""
    options: dict[str, str]
    """Values by upper-case parameter, "" for a parameter without one."""
    lines: list[Line]
    """Data lines; lines of an INPUT file come before those of the deck."""
    path: Path
    line: int
    """Line of the keyword."""

    @property
    def where(self) -> str:
        """File, line and keyword, for messages."""
        return f"{self.path}, line {self.line}: *{self.name}"

    def require(self, option: str) -> str:
        """Return the value of a required parameter.

        Raises
        ------
        MeshError
            The parameter is missing or has no value.
        """
        if not self.options.get(option):
            raise MeshError(f"the parameter {option} is missing", where=self.where)
        return self.options[option]

    def refuse_options_except(self, *allowed: str) -> None:
        """Refuse all parameters but `allowed`.

        Raises
        ------
        MeshError
            The keyword has another parameter; the first one is named.
        """
        for option in self.options:
            if option not in allowed:
                raise MeshError(
                    f"the parameter {option} is not carried out",
                    where=self.where,
                    allowed=", ".join(allowed),
                    remedy="Write the nodes and elements out in full",
                )


def read_keywords(path: Path, open_files: tuple[Path, ...] = ()) -> Iterator[Keyword]:
    """Yield the keywords of an input file and of the files it includes, in order.

    `open_files` are the files that include this one. Data before the first keyword are ignored;
    data from an INPUT file come before those of the keyword itself.
    Bytes that are not UTF-8 are replaced.

    Raises
    ------
    FileError
        The file is missing or includes itself, or the outermost one has no keyword.
    """
    open_files = (*open_files, path.resolve())
    is_empty = True
    for keyword in _split_into_keywords(path):
        is_empty = False
        if "INPUT" in keyword.options and keyword.name in _WITH_INPUT:
            file = find_included(keyword.options["INPUT"], [path.parent], open_files, keyword.where)
            if keyword.name == "INCLUDE":
                yield from read_keywords(file, open_files)
                continue
            lines = [_line(text, file, number) for number, text in _text_lines(file)]
            keyword = keyword._replace(lines=[*lines, *keyword.lines])
        yield keyword
    if is_empty and len(open_files) == 1:
        raise FileError(
            "not an Abaqus input file", where=str(path), allowed="keywords such as *NODE"
        )


def reals(line: Line, count: int) -> list[float]:
    """Return the first `count` numbers of a line; missing ones are 0."""
    texts = (line.fields + [""] * count)[:count]
    return [parse_real(text, line.where) for text in texts]


def _split_into_keywords(path: Path) -> Iterator[Keyword]:
    """Yield the keywords of a file with their data lines; a line that ends in a comma continues."""
    keyword: Keyword | None = None
    unfinished = ""
    for number, line in _text_lines(path):
        if not unfinished and not line.startswith("*"):
            if keyword is not None:
                keyword.lines.append(_line(line, path, number))
            continue
        if not unfinished:
            if keyword is not None:
                yield keyword
            start = number
        unfinished += line
        name, *words = _fields(unfinished[1:])
        options = {}
        for word in words:
            key, _, value = word.partition("=")
            if key.strip():
                options[" ".join(key.upper().split())] = value.strip().strip('"')
        keyword = Keyword(" ".join(name.upper().split()), options, [], path, start)
        if not line.endswith(","):
            unfinished = ""
    if keyword is not None:
        yield keyword


def _text_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number and text of the lines that are neither blank nor comments."""
    with path.open(encoding="utf-8", errors="replace") as stream:
        for number, text in watched_lines(stream, path):
            line = text.strip()
            if line and not line.startswith("**"):
                yield number, line


def _line(text: str, path: Path, number: int) -> Line:
    return Line([field.replace('"', "") for field in _fields(text)], f"{path}, line {number}")


def _fields(text: str) -> list[str]:
    """Return the texts between commas; commas within quotes do not separate."""
    if '"' not in text:
        return [field.strip() for field in text.split(",")]
    parts = text.split('"')
    parts[1::2] = [part.replace(",", "\0") for part in parts[1::2]]
    return [field.strip().replace("\0", ",") for field in '"'.join(parts).split(",")]

"""A data line of a keyword file, and what parameters read of a keyword's lines."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple, Protocol


class Card(NamedTuple):
    """One data line."""

    text: str
    line: int


class KeywordCards(Protocol):
    """What is read of a `Block`, which holds parameters and so stands above them."""

    @property
    def keyword(self) -> str: ...
    @property
    def cards(self) -> list[Card]: ...
    @property
    def long(self) -> bool: ...
    @property
    def path(self) -> Path: ...
    @property
    def line(self) -> int: ...
    def where(self, card: Card | None = None) -> str: ...

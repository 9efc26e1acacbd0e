"""Write the page of conventions from `contiga.conventions`: ``python docs/make_conventions.py``."""

from __future__ import annotations

from inspect import getdoc
from pathlib import Path

from contiga import conventions

PAGE = Path(__file__).with_name("conventions.md")


def page() -> str:
    """The page: the text of the module under a title of its own."""
    _, _, text = (getdoc(conventions) or "").partition("\n\n")
    source = "*Made from `contiga.conventions` by `docs/make_conventions.py`: change it there.*"
    return f"# Conventions\n\n{source}\n\n{text}\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")

"""How `make docs` builds the pages and the reference of the public names with Sphinx."""

from __future__ import annotations

import re
from typing import Any

from sphinx.util import logging

from contiga import __version__
from contiga.statuses import Advised

project = "contiga"
author = "The contiga developers"
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
exclude_patterns = ["README.md"]  # it is what the index shows
html_theme = "furo"
html_title = f"contiga {__version__}"

myst_heading_anchors = 3
default_role = "literal"
smartquotes = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings say what arguments are, with shapes and units
autodoc_default_options = {"members": True}
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_attr_annotations = False


PARAMETER = re.compile(r"([\w*, ]+) : (.+)")


def _prepare(
    _app: Any, _what: str, _name: str, value: Any, _options: Any, lines: list[str]
) -> None:
    """What stands in docstrings as Sphinx takes it.

    Each value of an enumeration is described by its advice. What stands behind the name of a
    parameter says what it is, and is no type. Examples that follow without a heading get one.
    """
    if isinstance(value, type) and issubclass(value, Advised):
        for member in value:
            lines += ["", f"``{member.name}`` = {int(member)}", f"    {member.advice}"]
        return
    section, output = "", []
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if line and set(below) == {"-"}:
            section = line
        if line.startswith(">>>") and section not in ("", "Examples"):
            section = "Examples"
            output += [section, "--------", ""]
        match = PARAMETER.fullmatch(line) if section == "Parameters" else None
        output += [line] if match is None else [match.group(1), f"    {match.group(2)}"]
    lines[:] = output


def _tell_of_overwritten(app: Any, name: str, _template: str, _context: Any, doctree: Any) -> None:
    """A warning, and so an error, where Sphinx writes a page of its own over one of ours."""
    if doctree is None and name in app.env.found_docs:
        logging.getLogger(__name__).warning("%s.html is written by Sphinx: rename the page", name)


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", _prepare, priority=400)  # before napoleon
    app.connect("html-page-context", _tell_of_overwritten)

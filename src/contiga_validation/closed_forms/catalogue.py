"""Every case of the suite, in the order of the page."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module

from contiga_validation.closed_forms.case import Case
from contiga_validation.engine import suite

MODULES = (
    "mass",
    "rotation",
    "flight",
    "springs",
    "devices",
    "winkler",
    "collisions",
    "friction",
    "patches",
    "matter",
    "vibrations",
    "at_rest",
    "foam",
    "catenary",
    "membranes",
    "hertz",
    "cook",
    "shells",
    "shell_motion",
    "belts",
    "gas",
    "injury",
)


def cases() -> tuple[Case, ...]:
    """All of them."""
    found = [import_module(f"contiga_validation.closed_forms.{name}").CASES for name in MODULES]
    return tuple(case for group in found for case in group)


def chosen(only: Sequence[str] | None) -> tuple[Case, ...]:
    """The cases named in `only`, all of them for None.

    An entry is the key of a case or the start of keys up to a dash: "mass" is "mass-box" and all
    that begin so.

    Raises
    ------
    InputError
        An entry that names no case, or no entries.
    """
    remedy = "The first word of names with a dash stands for all of them"
    return suite.chosen(cases(), only, "-", "case", remedy)

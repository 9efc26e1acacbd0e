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
    """Return all cases in the order of the page; their modules are imported."""
    modules = [import_module(f"contiga_validation.closed_forms.{name}").CASES for name in MODULES]
    return tuple(case for module in modules for case in module)


def selected(only: Sequence[str] | None) -> tuple[Case, ...]:
    """Return the cases named in `only`, all of them for None.

    A word is the key of a case or the start of keys up to a dash: "mass" is all cases whose
    keys start with "mass-".

    Raises
    ------
    InputError
        A word names no case, or there are no words.
    """
    remedy = "The first word of names with a dash stands for all of them"
    return suite.selected(cases(), only, "-", "case", remedy)

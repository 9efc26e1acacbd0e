"""Every experiment of the reproduction, in the order of the thesis."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module

from contiga_validation.engine import suite
from contiga_validation.engine.experiment import Experiment, Options

MODULES = (
    "chapter2",
    "chapter2_refine",
    "chapter5_splines",
    "chapter5_shapes",
    "chapter5_search",
    "chapter5_follow",
    "chapter5_detailed",
    "chapter5_split",
    "chapter5_area",
    "chapter5_force",
    "chapter6",
    "chapter7",
)
"""Modules of the thesis suite, each with its `EXPERIMENTS`."""
COMPARISON = "contiga_validation.rivals.comparison_page"
"""Module whose experiments take options."""

CHAPTERS = {
    2: "Chapter 2 · B-splines, NURBS and their refinement",
    3: "Chapter 3 · The contact of MADYMO",
    4: "Chapter 4 · The method",
    5: "Chapter 5 · Results",
    6: "Chapter 6 · Against finite elements",
    7: "Chapter 7 · Clusters",
    8: "Beyond the thesis",
}


DEFAULT = Options()


def experiments(options: Options = DEFAULT) -> tuple[Experiment, ...]:
    """Return all experiments, sorted by chapter; their modules are imported."""
    all_experiments = [
        experiment
        for name in MODULES
        for experiment in import_module(f"contiga_validation.thesis.{name}").EXPERIMENTS
    ]
    all_experiments += import_module(COMPARISON).experiments(options)
    return tuple(sorted(all_experiments, key=lambda experiment: experiment.chapter))


def chapter_title(chapter: int) -> str:
    """Return the heading of a chapter on the page; chapters beyond the thesis share one."""
    return CHAPTERS[min(chapter, max(CHAPTERS))]


def selected(only: Sequence[str] | None, options: Options = DEFAULT) -> tuple[Experiment, ...]:
    """Return the experiments named in `only`, all of them for None.

    A word is the key of an experiment or the start of keys: "5" is all of chapter 5, "5.1" all of
    section 5.1.

    Raises
    ------
    InputError
        A word names no experiment, or there are no words.
    """
    remedy = "A chapter or section such as 5 or 5.1 stands for all of it"
    return suite.selected(experiments(options), only, ".-", "experiment", remedy)

"""The formats of CAD files: suffixes, what reads them, and a reader loaded ahead of its file.

Nothing here takes time to import.
"""

from __future__ import annotations

from contiga.io.apart import prepare

SUFFIXES = (".step", ".stp", ".iges", ".igs", ".3dm", ".xml")
PACKAGES = dict.fromkeys(SUFFIXES[:4], ("OCP",)) | {".3dm": ("rhino3dm",), ".xml": ()}
"""What reads files of a suffix and has to be installed."""
READERS = dict.fromkeys(SUFFIXES[:4], "step_iges") | {".3dm": "rhino", ".xml": "gismo"}
"""Modules beside this one, with functions `read_<module>` and `list_<module>`."""


def reader(suffix: str, verb: str = "read") -> str:
    """What `read_apart` is to call for files of a suffix; "read" or "list".

    >>> reader(".igs")
    'contiga.io.cad.step_iges:read_step_iges'
    """
    return f"contiga.io.cad.{READERS[suffix]}:{verb}_{READERS[suffix]}"


def expect_cad(text: str) -> None:
    """Have OpenCASCADE loaded beside the rest where a path or a case file names a file for it.

    It takes as long to load as all else. Where the text names none that is there in the end, the
    process that has loaded it ends for want of work.
    """
    lowered = text.lower()
    for suffix, needed in PACKAGES.items():
        if "OCP" in needed and suffix in lowered:
            prepare(reader(suffix))
            return

"""Where entries of `contiga.arrays.disk_cache` are. Nothing here takes time to import."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

FOLDER = "CONTIGA_CACHE_DIR"
"""Environment variable: the folder, or "" or "0" for none."""


def cache_folder() -> Path | None:
    """The folder that the environment names, or the user's; None where nothing is kept."""
    named = os.environ.get(FOLDER)
    if named is not None:
        return None if named in ("", "0") else Path(named)
    with suppress(RuntimeError):  # there is no home
        home = Path.home()
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local")) / "contiga"
        if sys.platform == "darwin":
            return home / "Library" / "Caches" / "contiga"
        return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "contiga"
    return None

"""Record the cache files of a warm-up, so that the next one need not look at each kernel."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import numba

from contiga.jit.folder import RECORD, kernel_folder
from contiga.jit.prebuilt import kernel_target
from contiga.jit.stamps import PACKAGE
from contiga.jit.vectors import numbers_in_vector
from contiga.rigid.kernels.rigid_nb import to_body


def write(files: Iterable[str]) -> None:
    """Record the cache `files` of all kernels, if there is a folder for it."""
    if (path := _record_path()) is not None:
        with suppress(OSError):
            path.write_text(json.dumps(sorted(set(files))), encoding="utf-8")


def has_all() -> bool:
    """Return whether all kernels of these sources are cached for this kind of processor."""
    if (path := _record_path()) is None:
        return False
    try:
        files: Any = json.loads(path.read_text(encoding="utf-8"))
        return bool(files) and all(Path(file).is_file() for file in files)
    except (OSError, ValueError, TypeError):
        return False


def _record_path() -> Path | None:
    """Return the record of these sources, this Python, compiler and processor."""
    folder = kernel_folder()
    if folder is None:
        return None
    compiler = sys.implementation.cache_tag, numba.__version__, numbers_in_vector(kernel_target())
    digest = sha256(repr((*compiler, to_body.targetctx.codegen().magic_tuple())).encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        digest.update(file.relative_to(PACKAGE).as_posix().encode() + file.read_bytes())
    return folder / f"{RECORD}-{digest.hexdigest()[:16]}.json"

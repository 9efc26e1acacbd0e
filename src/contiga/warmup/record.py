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
    """Record the cache `files` of all kernels in the folder of kernels.

    Without a folder, or if it cannot be written, nothing is recorded.
    """
    if (path := _record_path()) is not None:
        with suppress(OSError):
            path.write_text(json.dumps(sorted(set(files))), encoding="utf-8")


def has_all() -> bool:
    """Return whether a warm-up of these sources is recorded and all its cache files are there.

    False if there is no record for this Python, compiler and processor, or it cannot be read.
    """
    if (path := _record_path()) is None:
        return False
    try:
        files: Any = json.loads(path.read_text(encoding="utf-8"))
        return bool(files) and all(Path(file).is_file() for file in files)
    except (OSError, ValueError, TypeError):
        return False


def _record_path() -> Path | None:
    """Return the path of the record of these sources, this Python, compiler and processor.

    Its name has a hash over all of them; None without a folder for kernels.
    """
    folder = kernel_folder()
    if folder is None:
        return None
    compiler = sys.implementation.cache_tag, numba.__version__, numbers_in_vector(kernel_target())
    digest = sha256(repr((*compiler, to_body.targetctx.codegen().magic_tuple())).encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        digest.update(file.relative_to(PACKAGE).as_posix().encode() + file.read_bytes())
    return folder / f"{RECORD}-{digest.hexdigest()[:16]}.json"

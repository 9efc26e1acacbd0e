"""Record what a warm-up has left, so that the next one need not go through the kernels."""

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
from contiga.jit.prebuilt import made_for
from contiga.jit.stamps import PACKAGE
from contiga.jit.vectors import numbers_in_vector
from contiga.rigid.kernels.rigid_nb import to_body


def write(files: Iterable[str]) -> None:
    """Write down the `files` of all kernels. Without a place for it: nothing."""
    if (place := _place()) is not None:
        with suppress(OSError):
            place.write_text(json.dumps(sorted(set(files))), encoding="utf-8")


def has_all() -> bool:
    """Whether a warm-up of these sources on this kind of processor has left all kernels.

    The kernels must still be there.
    """
    if (place := _place()) is None:
        return False
    try:
        files: Any = json.loads(place.read_text(encoding="utf-8"))
        return bool(files) and all(Path(file).is_file() for file in files)
    except (OSError, ValueError, TypeError):
        return False


def _place() -> Path | None:
    """The file of this version of the sources, of Python and the compiler, and this processor."""
    folder = kernel_folder()
    if folder is None:
        return None
    made_by = sys.implementation.cache_tag, numba.__version__, numbers_in_vector(made_for())
    whole = sha256(repr((*made_by, to_body.targetctx.codegen().magic_tuple())).encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        whole.update(file.relative_to(PACKAGE).as_posix().encode() + file.read_bytes())
    return folder / f"{RECORD}-{whole.hexdigest()[:16]}.json"

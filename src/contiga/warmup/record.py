"""What a warm-up leaves beside the kernels, so that the next one need not go through them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path
from typing import Any

import numba

from contiga.jit.stamps import PACKAGE
from contiga.rigid.kernels.rigid_nb import to_body

FILE = "warmup.json"
"""In the folder of one of the kernels, which every run needs."""


def written(folders: Iterable[str]) -> None:
    """Write down what is kept in the `folders` of all kernels. Without a place for it: nothing."""
    kept = sorted(str(file) for folder in folders for file in Path(folder).glob("*.nb[ci]"))
    try:
        _place().write_text(json.dumps({"of": _of(), "kept": kept}), encoding="utf-8")
    except OSError:
        return


def known() -> list[str] | None:
    """The files of all kernels, if a warm-up of these sources on such a processor has left them
    and they are still there; else None."""
    try:
        record: Any = json.loads(_place().read_text(encoding="utf-8"))
        if record["of"] == _of() and all(Path(file).is_file() for file in record["kept"]):
            return [str(file) for file in record["kept"]]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    return None


def _place() -> Path:
    return Path(to_body.stats.cache_path) / FILE


def _of() -> str:
    """Sources, compiler and processor: kernels of others are not these."""
    whole = sha256(repr((numba.__version__, to_body.targetctx.codegen().magic_tuple())).encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        whole.update(file.relative_to(PACKAGE).as_posix().encode() + file.read_bytes())
    return whole.hexdigest()

"""A wheel of three kernels: what all of them take minutes for, in seconds."""

from __future__ import annotations

import json
from pathlib import Path
from zipfile import ZipFile

import pytest

from contiga.warmup import pack
from contiga.warmup.compile_pool import CompilePool, Progress
from contiga.warmup.listing import FILE, Listing
from contiga.warmup.plan import Plan

CONTENT = json.loads(FILE.read_text(encoding="utf-8"))
LISTED = Listing(CONTENT | {"kernels": CONTENT["kernels"][:3]})
"""The list without all others: two kernels, and one that is built of them."""


LEVEL = pack.levels()[0]
"""The lowest one, which machines that run tests have."""


def compiled(folder: Path) -> dict[int, str]:
    """Their files, compiled under a folder by a process for the level."""
    done: dict[int, str] = {}

    def hear(_: int, progress: Progress) -> None:
        if progress.done:
            assert not progress.error
            done[progress.row] = progress.file

    plan = Plan([kernel.parts for kernel in LISTED.kernels])
    with CompilePool(1, hear, plan, pack.environment(LEVEL, folder)) as compile_pool:
        compile_pool.wait()
    return done


def written(kept: dict[int, str], folder: Path) -> Path:
    """The wheel of such kernels."""
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pack, "listing", lambda: LISTED)
        return pack.write_wheel({LEVEL: kept}, pack.sources(), folder)


def unpacked(folder: Path) -> Path:
    """The package of a new wheel, in a folder that modules can be found in."""
    with ZipFile(written(compiled(folder / "kept"), folder / "dist")) as wheel:
        wheel.extractall(folder / "site")
    return folder / "site" / "contiga_kernels"

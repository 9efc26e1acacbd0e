"""Prebuilt kernels of the package `contiga_kernels`, if it is installed.

`contiga.warmup.pack` writes it, for levels of processors (x86-64-v3), where kernels of this machine
are compiled for the processor at hand. A process uses all of the kernels of one level or none:
constants of kernels depend on the level (`vectors`), and have one value in a process. A kernel that
the package does not hold is compiled for this processor, as ever, with those constants. The two may
call each other, since they hand over numbers and addresses and no vectors, and have the same bits,
since these depend on no instruction set.

Of each level the package holds two files of data, and no code is imported:

- ``manifest.json``: what the kernels were compiled by, for and from (`Manifest`)
- ``kernels.bin``: of each kernel its versions, ``{(types of arguments, hashes of numba's): what
  numba would keep in a file}``, pickled and packed by zlib
"""

from __future__ import annotations

import json
import os
import pickle
import re
import sys
import zlib
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import sha256
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import numba
from numba import config
from numba.core.registry import cpu_target

from contiga.jit.stamps import PACKAGE, stamp_of_files
from contiga.jit.vectors import Target, numbers_in_vector

NAME = "contiga_kernels"
SWITCH = "CONTIGA_KERNELS"
"""Environment variable; "0" switches installed kernels off."""
MANIFEST, CODE = "manifest.json", "kernels.bin"
Version = tuple[Any, Any]
"""Types of a kernel's arguments, and numba's hashes of its bytecode."""
VERSION_OF_SYSTEM = re.compile(r"[\d.]+$")
"""Version in the name of a system; macOS has one, and its kernels run on other versions."""
OTHERS_MAY_WRITE, GROUP_MAY_WRITE = 0o002, 0o020
ROOT = 0


class Manifest(NamedTuple):
    """Versions, target and sources of prebuilt kernels."""

    python: str
    """Python's tag in the names of compiled files."""
    numba: str
    llvmlite: str
    target: Target
    features: Sequence[str]
    """Required features of the processor."""
    sources: Sequence[str]
    """Files of contiga that the kernels depend on."""
    stamp: str
    """Hash of the sources."""
    places: Mapping[str, Sequence[int]]
    """Offset and number of bytes of each kernel's versions in the file of all kernels.

    The keys are the names of its files.
    """
    digest: str = ""
    """Hash of all this and of the file of all kernels (`digest_of`)."""

    @property
    def level(self) -> str:
        """The level of processors."""
        return self.target[1]


class Prebuilt:
    """Installed kernels that this process uses."""

    def __init__(self, manifest: Manifest, code: bytes) -> None:
        self.manifest = manifest
        self._code = memoryview(code)

    def versions(self, name: str) -> dict[Version, bytes]:
        """Return the versions of a kernel by the name of its files; empty if not installed."""
        if name not in self.manifest.places:
            return {}
        start, size = self.manifest.places[name]
        versions: dict[Version, bytes] = pickle.loads(
            zlib.decompress(self._code[start : start + size])
        )
        return versions


class Choice(NamedTuple):
    """The choice of kernels of this process."""

    prebuilt: Prebuilt | None
    text: str
    """A line that describes the choice, and why installed kernels are not used."""
    refused: bool = False
    """Whether there are installed kernels that are not used."""


@cache
def choice() -> Choice:
    """Return the choice of this process, made once."""
    folder = _installed()
    here = "kernels are compiled on this machine"
    if folder is None:
        return Choice(None, f"{here}; {NAME} is not installed")
    try:
        prebuilt = _checked(folder)
    except _UnusableError as reason:
        return Choice(None, f"{here}; {NAME} in {folder} is not used: {reason}", refused=True)
    return Choice(prebuilt, f"kernels are those of {NAME} in {folder}: {prebuilt.manifest.level}")


def made_for() -> Target:
    """Return the target for the constants of kernels in this process.

    It is the level of prebuilt kernels, or else numba's target.
    """
    prebuilt = choice().prebuilt
    return compiled_for() if prebuilt is None else prebuilt.manifest.target


def compiled_for() -> Target:
    """Return numba's target in this process."""
    found: Target = cpu_target.target_context.codegen().magic_tuple()
    return found


class _UnusableError(Exception):
    """Reason why installed kernels are not used."""


def _installed() -> Path | None:
    """Return the folder of the package, without importing it."""
    spec = PathFinder.find_spec(NAME)
    return None if spec is None or spec.origin is None else Path(spec.origin).parent


def _checked(package: Path) -> Prebuilt:
    """Return the kernels of the highest level of this processor, if they fit and are whole.

    Raises `_UnusableError` otherwise.
    """
    if os.environ.get(SWITCH) == "0":
        raise _UnusableError(f"{SWITCH} is 0")
    if config.DISABLE_JIT:
        raise _UnusableError("NUMBA_DISABLE_JIT is set")
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:
        raise _UnusableError("NUMBA_CPU_NAME or NUMBA_CPU_FEATURES says what to compile for")
    if config.USING_SVML:
        raise _UnusableError("numba takes functions of Intel's SVML here, whose bits are others")
    try:
        folder, manifest = _of_highest_level(package)
        code = (folder / CODE).read_bytes()
    except OSError as error:
        raise _UnusableError(f"its files cannot be read ({error})") from None
    except (ValueError, TypeError, RecursionError):
        raise _UnusableError(f"its {MANIFEST} is damaged") from None
    if digest_of(manifest, code) != manifest.digest:
        raise _UnusableError("its files are damaged")
    _check_fits(manifest)
    return Prebuilt(manifest, code)


def _of_highest_level(package: Path) -> tuple[Path, Manifest]:
    """Return folder and manifest of the highest level of this processor, by name."""
    _check_ours(package.parent, package)
    reason = "it holds no kernels"
    for folder in sorted((path for path in package.iterdir() if path.is_dir()), reverse=True):
        _check_ours(folder, folder / MANIFEST, folder / CODE)
        manifest = Manifest(**json.loads((folder / MANIFEST).read_text(encoding="utf-8")))
        if not (lacking := _lacking(manifest)):
            return folder, manifest
        reason = f"it is for {manifest.level}, and this processor lacks {', '.join(lacking)}"
    raise _UnusableError(reason)


def _lacking(manifest: Manifest) -> list[str]:
    """Return the required features that this processor lacks or the compiler does not use."""
    here = compiled_for()
    lacking = [name for name in manifest.features if f"+{name}" not in here[2].split(",")]
    if not lacking and numbers_in_vector(manifest.target) > numbers_in_vector(here):
        lacking = ["vectors of 512 bits"]
    return lacking


def digest_of(manifest: Manifest, code: bytes) -> str:
    """Return the hash of a manifest, except that hash, and of the file of all kernels."""
    whole = sha256(json.dumps(manifest._replace(digest="")).encode())
    whole.update(code)
    return whole.hexdigest()


def _check_fits(manifest: Manifest) -> None:
    """Compare versions, target and sources of prebuilt kernels with those of this process."""
    system = compiled_for()[0]
    for what, theirs, ours in (
        ("Python", manifest.python, python_name()),
        ("numba", manifest.numba, numba.__version__),
        ("llvmlite", manifest.llvmlite, llvmlite.__version__),
        ("system", *(VERSION_OF_SYSTEM.sub("", name) for name in (manifest.target[0], system))),
    ):
        if theirs != ours:
            raise _UnusableError(f"it was compiled for {what} {theirs}, and this is {ours}")
    try:
        stamp = stamp_of_files(manifest.sources)
    except FileNotFoundError:
        stamp = ""
    if stamp != manifest.stamp:
        raise _UnusableError("it was compiled from other sources of contiga than these")


def python_name() -> str:
    """Return Python's tag in the names of files that only it can read."""
    return f"{sys.implementation.cache_tag}{getattr(sys, 'abiflags', '')}"


def _check_ours(*paths: Path) -> None:
    """Refuse files that others may write to."""
    for path in paths:
        if _others_may_write(path):
            raise _UnusableError(f"others may write to {path}")


def _others_may_write(path: Path) -> bool:
    """Return whether anybody may write to a file or folder who may not write to contiga itself.

    Such as may are root, this user, the owner of contiga, and a group that contiga has as well:
    where each user has a group of his own, he makes his files so.
    """
    if not hasattr(os, "geteuid"):
        return False
    status, own = os.stat(path), os.stat(PACKAGE)
    if status.st_uid not in (ROOT, os.geteuid(), own.st_uid) or status.st_mode & OTHERS_MAY_WRITE:
        return True
    is_shared = own.st_mode & GROUP_MAY_WRITE and own.st_gid == status.st_gid
    return bool(status.st_mode & GROUP_MAY_WRITE and not is_shared)

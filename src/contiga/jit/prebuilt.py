"""Prebuilt kernels of the package `contiga_kernels`, if it is installed.

`contiga.warmup.pack` writes it, for levels of processors (x86-64-v3); kernels of this machine are
compiled for its own processor. A process uses all of the kernels of one level or none: constants of
kernels depend on the level (`vectors`), and have one value in a process. A kernel that is not in
the package is compiled for this processor, as usual, with those constants. The two may call each
other, since they pass numbers and addresses and no vectors, and have the same bits, since these do
not depend on the instruction set.

For each level the package has two data files, and no code is imported:

- ``manifest.json``: compiler, target and sources of the kernels (`Manifest`)
- ``kernels.bin``: the versions of each kernel, ``{(types of arguments, hashes of numba's): the
  content of numba's cache file}``, pickled and compressed by zlib
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
SYSTEM_VERSION = re.compile(r"[\d.]+$")
"""Version in the name of a system; macOS has one, and its kernels run on other versions."""
OTHER_WRITE, GROUP_WRITE = 0o002, 0o020
ROOT = 0
"""User id of the administrator."""


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
        """Return the versions of the kernel with the file name `name`; empty if not installed."""
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
    """Return the choice of this process, made once: installed kernels if they are usable."""
    default = "kernels are compiled on this machine"
    spec = PathFinder.find_spec(NAME)  # without importing it
    if spec is None or spec.origin is None:
        return Choice(None, f"{default}; {NAME} is not installed")
    folder = Path(spec.origin).parent
    try:
        prebuilt = _load(folder)
    except _UnusableError as reason:
        return Choice(None, f"{default}; {NAME} in {folder} is not used: {reason}", refused=True)
    return Choice(prebuilt, f"kernels are those of {NAME} in {folder}: {prebuilt.manifest.level}")


def kernel_target() -> Target:
    """Return the target for the constants of kernels in this process.

    It is the level of prebuilt kernels, or else numba's target.
    """
    prebuilt = choice().prebuilt
    return compiled_for() if prebuilt is None else prebuilt.manifest.target


def compiled_for() -> Target:
    """Return numba's target in this process."""
    target: Target = cpu_target.target_context.codegen().magic_tuple()
    return target


class _UnusableError(Exception):
    """Reason why installed kernels are not used."""


def _load(package: Path) -> Prebuilt:
    """Return the kernels of the highest level of this processor, if they fit and are intact.

    They fit the same versions of Python, numba and llvmlite, the same system, and the same sources.
    `_UnusableError` is raised otherwise, or if the user's settings exclude them.
    """
    if os.environ.get(SWITCH) == "0":
        raise _UnusableError(f"{SWITCH} is 0")
    if config.DISABLE_JIT:
        raise _UnusableError("NUMBA_DISABLE_JIT is set")
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:
        raise _UnusableError("NUMBA_CPU_NAME or NUMBA_CPU_FEATURES says what to compile for")
    if config.USING_SVML:
        raise _UnusableError(
            "numba uses functions of Intel's SVML here, with results of other bits"
        )
    try:
        folder, manifest = _highest_level(package)
        code = (folder / CODE).read_bytes()
    except OSError as error:
        raise _UnusableError(f"its files cannot be read ({error})") from None
    except (ValueError, TypeError, RecursionError):
        raise _UnusableError(f"its {MANIFEST} is damaged") from None
    if digest_of(manifest, code) != manifest.digest:
        raise _UnusableError("its files are damaged")
    for label, packed, current in (
        ("Python", manifest.python, python_name()),
        ("numba", manifest.numba, numba.__version__),
        ("llvmlite", manifest.llvmlite, llvmlite.__version__),
        ("system", *(SYSTEM_VERSION.sub("", t[0]) for t in (manifest.target, compiled_for()))),
    ):
        if packed != current:
            raise _UnusableError(f"it was compiled for {label} {packed}, and this is {current}")
    try:
        stamp = stamp_of_files(manifest.sources)
    except FileNotFoundError:
        stamp = ""
    if stamp != manifest.stamp:
        raise _UnusableError("it was compiled from other sources of contiga than these")
    return Prebuilt(manifest, code)


def _highest_level(package: Path) -> tuple[Path, Manifest]:
    """Return folder and manifest of the highest level that this processor supports.

    Levels are ordered by the names of their folders. `_UnusableError` is raised if it supports
    none, or if another user may write to one of the files read (`_check_owner`).
    """
    _check_owner(package.parent, package)
    reason = "it holds no kernels"
    for folder in sorted((path for path in package.iterdir() if path.is_dir()), reverse=True):
        _check_owner(folder, folder / MANIFEST, folder / CODE)
        manifest = Manifest(**json.loads((folder / MANIFEST).read_text(encoding="utf-8")))
        target = compiled_for()
        missing = [name for name in manifest.features if f"+{name}" not in target[2].split(",")]
        if not missing and numbers_in_vector(manifest.target) > numbers_in_vector(target):
            missing = ["vectors of 512 bits"]
        if not missing:
            return folder, manifest
        reason = f"it is for {manifest.level}, and this processor lacks {', '.join(missing)}"
    raise _UnusableError(reason)


def digest_of(manifest: Manifest, code: bytes) -> str:
    """Return the hash of a manifest, without that hash, and of the file of all kernels."""
    hasher = sha256(json.dumps(manifest._replace(digest="")).encode())
    hasher.update(code)
    return hasher.hexdigest()


def python_name() -> str:
    """Return the tag of this Python in names of files that no other version reads."""
    return f"{sys.implementation.cache_tag}{getattr(sys, 'abiflags', '')}"


def _check_owner(*paths: Path) -> None:
    """Refuse files and folders that a user may write to who may not write to contiga itself.

    Root, this user, the owner of contiga, and a group that contiga has as well may write: where
    each user has a group of his own, he creates his files so. `_UnusableError` is raised otherwise;
    systems without user ids are not checked.
    """
    if not hasattr(os, "geteuid"):
        return
    package = os.stat(PACKAGE)
    for path in paths:
        status = os.stat(path)
        is_shared = package.st_mode & GROUP_WRITE and package.st_gid == status.st_gid
        if (
            status.st_uid not in (ROOT, os.geteuid(), package.st_uid)
            or status.st_mode & OTHER_WRITE
            or (status.st_mode & GROUP_WRITE and not is_shared)
        ):
            raise _UnusableError(f"others may write to {path}")

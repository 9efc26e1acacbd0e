"""All kernels of the list as a wheel, which processes load them from (`contiga.jit.prebuilt`).

They are compiled for levels of processors, which the compiling processes get by numba's setting
`NUMBA_CPU_NAME`: the wheel does not depend on the machine that makes it.
"""

from __future__ import annotations

import base64
import json
import os
import pickle
import platform
import sys
import sysconfig
import zlib
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import llvmlite
import numba
from numba.core.serialize import dumps

from contiga.errors import RunError
from contiga.jit.prebuilt import CODE, MANIFEST, NAME, Manifest, digest_of, python_name
from contiga.jit.stamps import PACKAGE, sources_of, stamp_of_files
from contiga.jit.vectors import WHOLE_VECTORS
from contiga.version import __version__
from contiga.warmup.listing import FILE, Row, listing

FILE_TIME = (1980, 1, 1, 0, 0, 0)
"""Time of all files in a wheel: wheels of the same content are the same file."""
MODE = 0o100644
"""Permissions of files in a wheel: everybody may read them."""
FIRST_ARM_MACOS = 11
SUMMARY = "Compiled kernels of contiga"
METADATA = f"""Metadata-Version: 2.1
Name: {NAME}
Version: {__version__}
Summary: {SUMMARY}, for numba {numba.__version__}
License: MIT
"""
WHEEL = f"""Wheel-Version: 1.0
Generator: contiga {__version__}
Root-Is-Purelib: false
Tag: {{tag}}
"""


class Level(NamedTuple):
    """Processors that kernels are compiled for."""

    name: str
    """Name in LLVM."""
    needs: tuple[str, ...]
    """Features that a processor must have, among the features that only some of a kind have."""
    compiled_with: str = ""
    """Setting of the compiler beside the name."""


V3 = (
    *("cx16", "popcnt", "sahf", "sse3", "ssse3", "sse4.1", "sse4.2"),
    *("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"),
)
V4 = (*V3, "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")
X86 = Level("x86-64-v3", V3), Level("x86-64-v4", V4, WHOLE_VECTORS)
"""On AMD's Zen 5 tracked points took 1.44 times as long with kernels of the lower level as with
kernels compiled there, and as long with kernels of the higher level."""
GENERIC = (Level("generic", ()),)


def levels() -> tuple[Level, ...]:
    """Return the two levels of x86, the lower first, or the generic level of another processor."""
    return X86 if platform.machine().lower() in ("x86_64", "amd64") else GENERIC


def environment(level: Level, folder: Path) -> dict[str, str]:
    """Return the environment of processes that compile for a level and keep kernels in `folder`.

    Other settings of numba are left out: some of them change the code.
    """
    without_numba = {k: value for k, value in os.environ.items() if not k.startswith("NUMBA_")}
    target = {"NUMBA_CPU_NAME": level.name, "NUMBA_CPU_FEATURES": level.compiled_with}
    return without_numba | target | {"NUMBA_CACHE_DIR": str(folder)}


class Sources(NamedTuple):
    """The sources that the kernels of the list are compiled from."""

    files: list[str]
    """Names of files of contiga."""
    stamp: str
    """Their hash."""


def sources() -> Sources:
    """Return the files of all kernels, of their imports and of the list, and their hash."""
    modules = {kernel.module.partition(".")[2] for kernel in listing().kernels}
    files = sources_of(PACKAGE / f"{module.replace('.', '/')}.py" for module in sorted(modules))
    files.append(FILE.relative_to(PACKAGE).as_posix())
    return Sources(files, stamp_of_files(files))


def write_wheel(
    index_files: Mapping[Level, Mapping[Row, str]], old_sources: Sources, folder: Path
) -> Path:
    """Write the wheel of all kernels of the list, whole or not at all, and return its path.

    Parameters
    ----------
    index_files : the cache index file of each kernel, by level
    old_sources : the sources when compiling began
    folder : folder of the wheel

    Raises
    ------
    RunError
        A kernel was not cached, or the sources have changed.
    OSError
        The wheel cannot be written.
    """
    if sources() != old_sources:
        raise RunError("the sources of kernels have changed while they were compiled")
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}{getattr(sys, 'abiflags', '')}-{_platform_tag()}"
    info = f"{NAME}-{__version__}.dist-info"
    files = {
        f"{NAME}/__init__.py": f'"""{SUMMARY}: data for contiga.jit.prebuilt."""\n'.encode(),
        f"{info}/METADATA": METADATA.encode(),
        f"{info}/WHEEL": WHEEL.format(tag=tag).encode(),
    }
    for level, level_files in index_files.items():
        manifest, code = _packed(level, level_files, old_sources)
        files[f"{NAME}/{level.name}/{MANIFEST}"] = json.dumps(manifest._asdict()).encode()
        files[f"{NAME}/{level.name}/{CODE}"] = code
    record = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(sha256(content).digest()).rstrip(b"=").decode()
        record.append(f"{name},sha256={digest},{len(content)}")
    files[f"{info}/RECORD"] = "\n".join((*record, f"{info}/RECORD,,\n")).encode()
    wheel = folder / f"{NAME}-{__version__}-{tag}.whl"
    unfinished = wheel.with_suffix(".new")
    try:
        with ZipFile(unfinished, "w", ZIP_DEFLATED) as archive:
            for name, content in files.items():
                entry = ZipInfo(name, FILE_TIME)
                entry.external_attr = MODE << 16
                archive.writestr(entry, content, ZIP_DEFLATED)
        unfinished.replace(wheel)
    finally:
        unfinished.unlink(missing_ok=True)
    return wheel


def _packed(
    level: Level, index_files: Mapping[Row, str], sources: Sources
) -> tuple[Manifest, bytes]:
    """Return the manifest of a level, and the content of its code file.

    The file has a compressed block for each cache index file, with its kernels by types and hashes.

    Raises
    ------
    RunError
        A kernel of the list is not in the cache.
    """
    versions: dict[str, dict[Any, bytes]] = {}
    for file in sorted(set(index_files.values()) - {""}):
        with Path(file).open("rb") as index:
            pickle.load(index)  # numba's version
            _, names = pickle.loads(index.read())
        versions[file] = {
            key: Path(file).with_name(name).read_bytes() for key, name in names.items()
        }
    for row, kernel in enumerate(listing().kernels):
        keys = versions.get(index_files.get(row, ""), {})
        if all(types != listing().arguments(row) for types, *_ in keys):
            raise RunError(f"{kernel.module}.{kernel.name} was compiled and could not be kept")
    (target,) = {target for keys in versions.values() for _, target, _ in keys}
    places: dict[str, tuple[int, int]] = {}
    code = b""
    for file, contents in versions.items():
        by_types = {(types, hashes): content for (types, _, hashes), content in contents.items()}
        packed = zlib.compress(dumps(by_types), 9)
        places[Path(file).stem] = len(code), len(packed)
        code += packed
    manifest = Manifest(
        python=python_name(),
        numba=numba.__version__,
        llvmlite=llvmlite.__version__,
        target=target,
        features=level.needs,
        sources=sources.files,
        stamp=sources.stamp,
        places=places,
    )
    return manifest._replace(digest=digest_of(manifest, code)), code


def _platform_tag() -> str:
    """Return the platform tag of the wheel.

    Python for macOS may be for two kinds of processor, and these kernels are for one. On arm64 the
    oldest version of macOS is 11.
    """
    system, version, *_ = *sysconfig.get_platform().split("-"), ""
    if system != "macosx":
        return sysconfig.get_platform().replace("-", "_").replace(".", "_")
    machine = platform.machine()
    oldest = FIRST_ARM_MACOS if machine == "arm64" else 0
    major, minor, *_ = (*map(int, version.split(".")), 0)
    major, minor = max((major, minor), (oldest, 0))
    return f"macosx_{major}_{minor}_{machine}"

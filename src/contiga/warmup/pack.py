"""All kernels of the list as a wheel, for processes that find them there (`contiga.jit.prebuilt`).

They are compiled for levels of processors, which numba's own settings name to the processes that
compile (`NUMBA_CPU_NAME`): the wheel does not depend on the machine that it is made on.
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

NEVER = (1980, 1, 1, 0, 0, 0)
"""The time of all files in a wheel: one of the same content is the same file."""
MODE = 0o100644
"""Of files in a wheel: everybody may read them."""
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
    """As LLVM calls it."""
    needs: tuple[str, ...]
    """Features that a processor must have, of those that not all of a kind have."""
    compiled_with: str = ""
    """What the compiler is told beside the name."""


V3 = (
    *("cx16", "popcnt", "sahf", "sse3", "ssse3", "sse4.1", "sse4.2"),
    *("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"),
)
V4 = (*V3, "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")
X86 = Level("x86-64-v3", V3), Level("x86-64-v4", V4, WHOLE_VECTORS)
"""On AMD's Zen 5 tracked points took 1.44 times as long with kernels of the lower level as with
those compiled there, and as long with kernels of the higher one."""
GENERIC = (Level("generic", ()),)


def levels() -> tuple[Level, ...]:
    """Those of x86, or what all processors of another kind have."""
    return X86 if platform.machine().lower() in ("x86_64", "amd64") else GENERIC


def environment(level: Level, folder: Path) -> dict[str, str]:
    """Environment of processes that compile for a level and keep kernels under `folder`.

    Other settings of numba's are left out: some of them change the code.
    """
    own = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    target = {"NUMBA_CPU_NAME": level.name, "NUMBA_CPU_FEATURES": level.compiled_with}
    return own | target | {"NUMBA_CACHE_DIR": str(folder)}


class Sources(NamedTuple):
    """The sources that the kernels of the list are compiled from."""

    files: list[str]
    """Names of files of contiga."""
    stamp: str
    """Their hash."""


def sources() -> Sources:
    """The files of all kernels and of all that these import, and the list, as they are now."""
    modules = {kernel.module.partition(".")[2] for kernel in listing().kernels}
    files = sources_of(PACKAGE / f"{module.replace('.', '/')}.py" for module in sorted(modules))
    files.append(FILE.relative_to(PACKAGE).as_posix())
    return Sources(files, stamp_of_files(files))


def write_wheel(kept: Mapping[Level, Mapping[Row, str]], of: Sources, folder: Path) -> Path:
    """Write the wheel of all kernels of the list into a folder.

    Parameters
    ----------
    kept : of each level and each kernel, the index file that its process has named
    of : the sources when compiling began
    folder : folder of the wheel

    Raises
    ------
    RunError
        where a kernel was not kept, or the sources are others by now
    OSError
        where the wheel cannot be written
    """
    if sources() != of:
        raise RunError("the sources of kernels have changed while they were compiled")
    tag = f"{_python_tag()}-{_platform_tag()}"
    about = f"{NAME}-{__version__}.dist-info"
    files = {
        f"{NAME}/__init__.py": f'"""{SUMMARY}: data for contiga.jit.prebuilt."""\n'.encode(),
        f"{about}/METADATA": METADATA.encode(),
        f"{about}/WHEEL": WHEEL.format(tag=tag).encode(),
    }
    for level, named in kept.items():
        manifest, code = _packed(level, named, of)
        files[f"{NAME}/{level.name}/{MANIFEST}"] = json.dumps(manifest._asdict()).encode()
        files[f"{NAME}/{level.name}/{CODE}"] = code
    record = [f"{name},sha256={_digest(content)},{len(content)}" for name, content in files.items()]
    files[f"{about}/RECORD"] = "\n".join((*record, f"{about}/RECORD,,\n")).encode()
    wheel = folder / f"{NAME}-{__version__}-{tag}.whl"
    unfinished = wheel.with_suffix(".new")
    try:
        with ZipFile(unfinished, "w", ZIP_DEFLATED) as archive:
            for name, content in files.items():
                entry = ZipInfo(name, NEVER)
                entry.external_attr = MODE << 16
                archive.writestr(entry, content, ZIP_DEFLATED)
        unfinished.replace(wheel)
    finally:
        unfinished.unlink(missing_ok=True)
    return wheel


def _packed(level: Level, kept: Mapping[Row, str], of: Sources) -> tuple[Manifest, bytes]:
    """The kernels in one file, and what is to be known of them."""
    versions = {file: _versions(Path(file)) for file in sorted(set(kept.values()) - {""})}
    for row, kernel in enumerate(listing().kernels):
        found = versions.get(kept.get(row, ""), {})
        if all(types != listing().arguments(row) for types, *_ in found):
            raise RunError(f"{kernel.module}.{kernel.name} was compiled and could not be kept")
    (target,) = {target for found in versions.values() for _, target, _ in found}
    places: dict[str, tuple[int, int]] = {}
    code = b""
    for file, found in versions.items():
        ours = {(types, hashes): content for (types, _, hashes), content in found.items()}
        packed = zlib.compress(dumps(ours), 9)
        places[Path(file).stem] = len(code), len(packed)
        code += packed
    manifest = Manifest(
        python=python_name(),
        numba=numba.__version__,
        llvmlite=llvmlite.__version__,
        target=target,
        features=level.needs,
        sources=of.files,
        stamp=of.stamp,
        places=places,
    )
    return manifest._replace(digest=digest_of(manifest, code)), code


def _versions(file: Path) -> dict[Any, bytes]:
    """Return what is kept of a kernel, by numba's keys, from its index file."""
    with file.open("rb") as index:
        pickle.load(index)  # numba's version
        _, names = pickle.loads(index.read())
    return {key: file.with_name(name).read_bytes() for key, name in names.items()}


def _python_tag() -> str:
    """Python and its binary interface, as wheels are named by."""
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{version}-{version}{getattr(sys, 'abiflags', '')}"


def _platform_tag() -> str:
    """The system, as wheels are named by.

    Python for macOS may be for two kinds of processor, and these kernels are for one.
    """
    system, version, *_ = *sysconfig.get_platform().split("-"), ""
    if system != "macosx":
        return sysconfig.get_platform().replace("-", "_").replace(".", "_")
    machine = platform.machine()
    oldest = FIRST_ARM_MACOS if machine == "arm64" else 0
    major, minor, *_ = (*map(int, version.split(".")), 0)
    major, minor = max((major, minor), (oldest, 0))
    return f"macosx_{major}_{minor}_{machine}"


def _digest(content: bytes) -> str:
    """Return a digest in the form of the list of a wheel's files."""
    return base64.urlsafe_b64encode(sha256(content).digest()).rstrip(b"=").decode()

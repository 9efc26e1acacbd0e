"""What kernels the demo and scenes need, recorded as they are compiled."""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

from numba.core import types as numba_types
from numba.core.sigutils import normalize_signature
from tests.kernels import exercises

import contiga as cg
from contiga.cache_folder import FOLDER
from contiga.io import worker
from contiga.jit.dispatcher import KernelDispatcher
from contiga.jit.reference import Reference
from contiga.jit.stamps import LOCAL
from contiga.warmup.listing import FILE

types: Any = numba_types
DEMO = Path(__file__).resolve().parents[2] / "examples" / "01_headform.toml"
Version = tuple[str, str, tuple[Any, ...]]
"""A kernel and the types of its arguments: module, name, types."""


class Recording:
    """Versions of kernels in the order in which they were there, and what they are built of."""

    def __init__(self) -> None:
        self.parts: dict[Version, set[Version]] = {}
        self._of = threading.local()

    @property
    def _at(self) -> list[set[Version]]:
        """What is at work on this thread: the parts so far of each, the innermost last."""
        if not hasattr(self._of, "at"):
            self._of.at = []
        at: list[set[Version]] = self._of.at
        return at

    @contextmanager
    def of(self, version: Version) -> Iterator[None]:
        """Within this, a version is compiled or called; others that are, are parts of it."""
        module, name, _ = version
        listed = module.startswith("contiga.") and LOCAL not in name
        if self._at and listed:
            self._at[-1].add(version)
        self._at.append(set())
        try:
            yield
        finally:
            own = self._at.pop()
        if listed:
            self.parts.setdefault(version, own)


@contextmanager
def recorded() -> Iterator[Recording]:
    """Record within this what is compiled: everything, where the cache is empty."""
    recording = Recording()
    compile_, overload = KernelDispatcher.compile, KernelDispatcher.get_overload

    def compiled(self: Any, signature: Any) -> Any:
        with recording.of(_version(self, signature)):
            return compile_(self, signature)

    def called(self: Any, signature: Any) -> Any:
        with recording.of(_version(self, normalize_signature(signature)[0])):
            return overload(self, signature)

    with (
        patch.object(KernelDispatcher, "compile", compiled),
        patch.object(KernelDispatcher, "get_overload", called),
        patch.object(worker._pool, "can_start", False),  # files are read in this process
        patch.dict(os.environ, {FOLDER: ""}),  # nothing is read that an earlier run worked out
    ):
        yield recording


def _version(kernel: Any, arguments: Any) -> Version:
    return kernel.py_func.__module__, kernel.py_func.__qualname__, tuple(arguments)


def write() -> int:
    """Write the list."""
    with recorded() as recording:
        _demo()
        for name in exercises.ALL:
            print(f"{len(recording.parts)} kernels, then {name}", file=sys.stderr)
            getattr(exercises, name)()
    FILE.write_text(text(recording), encoding="utf-8")
    print(f"{len(recording.parts)} kernels in {FILE}")
    return 0


def text(recording: Recording) -> str:
    """The list as it is kept: a type and a kernel a line."""
    rows = {version: row for row, version in enumerate(recording.parts)}
    coded = Types()
    kernels = []
    for (module, name, arguments), parts in recording.parts.items():
        own = [coded.row(of) for of in arguments]
        kernels.append([module, name, own, sorted(rows[part] for part in parts)])
    lines = []
    for what, listed in (("types", coded.codes), ("kernels", kernels)):
        lines.append(f' "{what}": [\n  ' + ",\n  ".join(map(json.dumps, listed)) + "\n ]")
    return "{\n" + ",\n".join(lines) + "\n}\n"


class Types:
    """Types as the list has them, each once, and behind those that it is made of."""

    def __init__(self) -> None:
        self.codes: list[Any] = []
        self._rows: dict[Any, int] = {}

    def row(self, of: Any) -> int:
        """Where a type stands."""
        if of not in self._rows:
            code = self._code(of)
            self._rows[of] = len(self.codes)
            self.codes.append(code)
        return self._rows[of]

    def _code(self, of: Any) -> Any:
        if isinstance(of, types.NestedArray):
            return ["nested", self.row(of.dtype), *of.shape]
        if isinstance(of, types.Array):
            return ["array", self.row(of.dtype), of.ndim, of.layout, of.mutable]
        if isinstance(of, Reference):
            return ["reference", self.row(of.members)]
        if isinstance(of, types.BaseTuple):
            parts = [self.row(part) for part in of.types]
            kind = getattr(of, "instance_class", None)
            named = ["named", f"{kind.__module__}:{kind.__qualname__}"] if kind else ["tuple"]
            return [*named, *parts]
        if isinstance(of, types.Record):
            fields = [
                [name, field.base.str, list(field.shape), offset]
                for name, (field, offset, *_) in of.dtype.fields.items()
            ]
            return ["record", fields, of.dtype.itemsize, of.dtype.isalignedstruct]
        return str(of)


def _demo() -> None:
    with TemporaryDirectory() as folder:
        cg.run(DEMO, Path(folder) / "out")

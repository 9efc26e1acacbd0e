"""What became of a damaged file."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from contiga.errors import ContigaError

READ, REFUSED = "read", "refused"


def read_case(path: Path) -> None:
    """As ``contiga check`` begins."""
    from contiga.case.describe import describe
    from contiga.case.schema import load_case

    list(describe(load_case(path)))


def read_body(path: Path) -> None:
    """As ``contiga info`` of a CAD file."""
    from contiga.io.cad.read_cad import read_cad
    from contiga.masters.body_summary import body_summary

    body = read_cad(path)
    for patch in body.patches:
        _check_finite(patch.homogeneous)
    body_summary(body)


def read_points(path: Path) -> None:
    """As ``contiga info`` of a mesh."""
    from contiga.io.mesh.read_master import master_of
    from contiga.io.mesh.read_mesh import read_mesh
    from contiga.slaves.mesh_summary import mesh_summary

    mesh = read_mesh(path)
    _check_finite(mesh.points)
    mesh_summary(mesh)
    if mesh.facets is not None and len(mesh.facets):
        master_of(mesh, where=str(path)).condition()


def _check_finite(array: Any) -> None:
    if not np.isfinite(array).all():
        raise AssertionError("numbers that are not finite got through")


def reader_of(path: Path) -> Callable[[Path], None]:
    """What reads a file of this suffix."""
    from contiga.io.cad.formats import SUFFIXES

    if path.suffix == ".toml":
        return read_case
    return read_body if path.suffix.lower() in SUFFIXES else read_points


def judged(path: Path) -> tuple[str, str]:
    """READ or REFUSED, or what is wrong; and what was said."""
    with _Heard() as heard:
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                reader_of(path)(path)
            result, said = READ, ""
        except ContigaError as error:
            result, said = REFUSED, str(error)
        except Exception as error:
            result, said = f"unexpected {type(error).__name__}", str(error)
    if heard.size:
        return "printed something", said
    if result == REFUSED and not said.strip():
        return "refused without a word", said
    return result, " ".join(said.split())[:400]


class _Heard:
    """Bytes that were printed meanwhile, by whatever means."""

    size = 0

    def __enter__(self) -> _Heard:
        self._file = tempfile.TemporaryFile()
        self._kept = [os.dup(stream) for stream in (1, 2)]
        for stream in (1, 2):
            os.dup2(self._file.fileno(), stream)
        return self

    def __exit__(self, *_: object) -> None:
        self.size = os.fstat(self._file.fileno()).st_size
        for stream, kept in zip((1, 2), self._kept, strict=True):
            os.dup2(kept, stream)
            os.close(kept)
        self._file.close()

"""Make the motion of a slave from its table."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.case.deform_spec import DeformSpec
from contiga.case.motion_spec import AttachedSpec, FreeSpec, SeriesSpec
from contiga.case.points_spec import FilePoints
from contiga.case.pulse_spec import AccelerationSpec, VelocitySpec
from contiga.case.rigid_spec import PrescribedMotionSpec
from contiga.case.schema import Case, SlaveSpec
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.deforming_parts import ELEMENT_OF_CELL, same_elements, split
from contiga.dynamics.free import Attached, Dependent
from contiga.dynamics.prescribed import BodyMotion, Fixed, Moved, SlaveMotion
from contiga.dynamics.pulses import check_covers
from contiga.errors import CaseError
from contiga.io.mesh.numbered import rows_of
from contiga.io.mesh.raw import cells_of, nodes_of
from contiga.io.mesh.read_mesh import read_raw
from contiga.io.mesh.series import MeshSeries, find_files
from contiga.io.units import length_factor
from contiga.records import IntArray
from contiga.slaves.slave import Slave


def slave_motion(
    spec: SlaveSpec, slave: Slave, case: Case, prescribed_motion: BodyMotion | None
) -> SlaveMotion | Dependent:
    """Return the motion of a slave's points.

    `prescribed_motion` is None if the slave has none, or a wrong one: its points then rest. Files
    of a series without times or a step are spread evenly over the run.

    Raises
    ------
    InputError
        The elements, or the files of a series, do not fit the slave.
    """
    motion = spec.motion
    if isinstance(motion, FreeSpec):
        return motion.moved(None)
    if isinstance(motion, AttachedSpec):
        return Attached(motion.body)
    if isinstance(motion, DeformSpec):
        return deforming_of(
            spec, motion, slave, partial(prescribed_motion_of, case=case), case.units.length
        )
    if not isinstance(motion, SeriesSpec):
        return Moved(slave.points, Fixed() if prescribed_motion is None else prescribed_motion)
    files = find_files(motion.files)
    start, end = case.time.start, case.time.end
    if motion.times is not None:
        times = np.array(motion.times)
    elif motion.step is not None:
        times = start + motion.step * np.arange(len(files))
    else:
        times = np.linspace(start, end, len(files))
    factor = 1.0 if motion.unit is None else length_factor(motion.unit, case.units.length)
    series = MeshSeries(files, times, factor=factor)
    count = len(series.points(case.time.start))
    if count != len(slave):
        raise CaseError(
            "the files of the series do not have the points of the slave",
            where="files",
            found=f"{count} points",
            allowed=f"{len(slave)}",
        )
    return series if motion.then is None else Moved(series, motion.then.instance)


def deforming_of(
    spec: SlaveSpec,
    motion: DeformSpec,
    slave: Slave,
    motion_of: Callable[[PrescribedMotionSpec], BodyMotion],
    unit: str,
) -> Deforming:
    """Return the deformation of a slave; its elements and places are checked.

    A mesh of reference is read here, with the slave's own choice of parts and layers. `motion_of`
    returns motions in the units of the case, whose unit of length is `unit`.
    """

    def mesh_of(file: str, file_unit: str | None) -> Slave:
        if isinstance(spec.points, FilePoints):
            changes = {"file": file, "unit": file_unit or spec.points.unit}
            return spec.points.model_copy(update=changes).raw(spec.name, unit)
        return FilePoints(file=file, unit=file_unit).raw(spec.name, unit)

    reference = motion.reference
    deforming = motion.moved(
        partial(nodes_named, spec),
        motion_of,
        partial(_elements_of_set, spec, slave),
        None if reference is None else reference.nodes(slave, mesh_of),
    )
    check_elements(spec.name, slave, deforming)
    return deforming


def check_elements(name: str, slave: Slave, motion: Deforming) -> None:
    """Refuse elements, materials and places that do not fit a slave called `name`.

    Raises
    ------
    InputError
        As `Deforming`.
    """
    bodies: dict[str, int] = {}
    motion.nodes(name, slave, lambda body: bodies.setdefault(body, len(bodies)))


def prescribed_motion_of(spec: PrescribedMotionSpec, case: Case) -> BodyMotion:
    """Return a prescribed motion in the units of the case.

    Raises
    ------
    InputError
        Velocities or accelerations do not cover the time of the run.
    """
    if isinstance(spec, VelocitySpec | AccelerationSpec):
        motion = spec.motion_in((case.units.length, case.units.mass, case.units.time))
        check_covers(motion.span, case.time.start, case.time.end, "table")
        return motion
    return spec.instance


def nodes_named(spec: SlaveSpec, key: str | int | list[int]) -> NDArray[Any]:
    """Return a mask (n,) of a set of the slave's file, or rows (k,) of nodes by number.

    Raises
    ------
    CaseError
        The points are not from a file.
    MeshError
        The file has no such set or node.
    """
    if not isinstance(spec.points, FilePoints):
        by_number = isinstance(key, list)
        raise CaseError(
            f"only a mesh from a file has {'numbers of nodes' if by_number else 'sets'}",
            where="nodes" if by_number else "set",
            found=key,
            allowed="box = [low, high], plane = [point, normal], side or layer",
        )
    path = Path(spec.points.file)
    mesh = read_raw(path)
    return (
        rows_of(mesh, key, str(path)) if isinstance(key, list) else nodes_of(mesh, key, str(path))
    )


def _elements_of_set(spec: SlaveSpec, slave: Slave, key: str | int) -> dict[str, IntArray]:
    """Return the slave's elements, by kind, that are cells of a part, set or group of its file.

    Cells are split into kinds that can deform. Lines of the set are bars, even if they are no cells
    of the slave.

    Raises
    ------
    InputError
        The points are not from a file, or no element of the slave is in the set.
    """
    if not isinstance(spec.points, FilePoints):
        raise CaseError("only a mesh from a file has parts", where="set", found=key, allowed="none")
    path = Path(spec.points.file)
    cells = cells_of(read_raw(path), key, str(path))
    elements: dict[str, list[IntArray]] = {}
    if len(lines := cells.pop("line", ())):
        # Lines along edges of other cells are bars only if their set is named.
        elements[ELEMENT_OF_CELL["line"]] = [np.asarray(lines, np.int32)]
    for kind, rows in slave.elements.items():
        if kind in cells and len(cells[kind]):
            rows_of_set = rows[same_elements(rows, cells[kind])]
            if len(rows_of_set):
                parts = elements.setdefault(ELEMENT_OF_CELL.get(kind, kind), [])
                parts.append(split(slave, kind, rows_of_set))
    if not elements:
        raise CaseError(
            "no element of the slave is in this part, set or group",
            where="set",
            found=key,
            allowed="one with cells among those that the slave is made of",
        )
    return {kind: np.concatenate(rows) for kind, rows in elements.items()}

"""Files that a case includes: read, checked, named, posed and put among the tables of the case.

The result is a case as if its tables had been written by hand in that posture, so that no other
module has to know of included files.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from contiga.case.case_file import read_text, tables_in
from contiga.case.include_spec import IncludeSpec
from contiga.case.included_tables import Included, names_of, tables_posed
from contiga.case.motion_spec import AttachedSpec
from contiga.case.posture import Tie, postures
from contiga.case.problems import Origin, case_error, errors_at
from contiga.case.spec import Spec
from contiga.dynamics.springs import GROUND
from contiga.errors import CaseError
from contiga.records import FloatArray

INCLUDE = "include"
OF_THE_CASE = ("title", "time", "world", "settle", "output")
"""Tables that an included file may not have."""


class CaseTables(NamedTuple):
    """The tables of a case, with the tables of the files that it includes."""

    data: dict[str, Any]
    origins: dict[tuple[str, int], Origin]
    """By the key and the place of tables that another file defines."""


def with_includes(data: Mapping[str, Any], path: Path, tables: type[Spec]) -> CaseTables:
    """Return the tables of the case at `path`, with the tables of the files that it includes.

    Tables of a file follow the case's own tables of the same key, in the order of `include`; their
    origins, the file and the row there, are returned with them.

    Parameters
    ----------
    data : tables of the case, as read from TOML
    path : case file, from whose folder the names of included files start
    tables : the tables that an included file may have

    Raises
    ------
    CaseError, FileError
        A table of `include`, or a file that it names, is wrong.
    """
    rows = data.get(INCLUDE, [])
    if not isinstance(rows, list):
        raise CaseError(
            "must be a list of tables",
            where=f"{path}: {INCLUDE}",
            remedy=f"Write [[{INCLUDE}]] in double brackets: there may be several",
        )
    case = CaseTables({key: value for key, value in data.items() if key != INCLUDE}, {})
    for i, row in enumerate(rows):
        try:
            spec = IncludeSpec.model_validate(row, context={"folder": path.parent})
        except ValidationError as error:
            raise case_error(error, row, str(path), key=f"{INCLUDE}[{i}]") from error
        included = _read(spec, path, data.get("units"), tables)
        with errors_at(f"{INCLUDE}[{i}]", str(path)):
            posed = _posed(spec, included)
        for key, new_tables in tables_posed(posed).items():
            case_tables = case.data.get(key, [])
            if not (new_tables and isinstance(case_tables, list)):
                continue  # the error in the case's own tables is reported
            case.data[key] = [*case_tables, *new_tables]
            for row_of_file in range(len(new_tables)):
                origin = Origin(spec.file, row_of_file)
                case.origins[key, len(case_tables) + row_of_file] = origin
    return case


def _read(spec: IncludeSpec, path: Path, units: Any, tables: type[Spec]) -> Any:
    """Return the tables of a file, checked like the tables of a case.

    Raises
    ------
    CaseError, FileError
        It includes files, or itself; it has tables of a whole case, or units other than the case's
        `units`; a table is wrong.
    """
    file = Path(spec.file)
    data = tables_in(read_text(file), file)
    is_case = file == path.resolve()
    if INCLUDE in data or is_case:
        raise CaseError(
            "a file that is included includes no other, nor itself",
            where=str(file),
            found=INCLUDE,
            remedy="Take the table out" if is_case else "Include both in the case",
        )
    for key in OF_THE_CASE:
        if key in data:
            raise CaseError(
                "is of the case, and this file is a part of one",
                where=f"{file}: {key}",
                remedy=f"Say it in {path}",
            )
    units_of_file = data.pop("units", units)
    if units is not None and units_of_file != units:  # a case without units is refused itself
        raise CaseError(
            "must be those of the case",
            where=f"{file}: units",
            found=units_of_file,
            allowed=str(units),
        )
    try:
        return tables.model_validate(data, context={"folder": file.parent, "units": units_of_file})
    except ValidationError as error:
        raise case_error(error, data, str(file)) from error


def _posed(spec: IncludeSpec, included: Any) -> Included:
    """Return the tables of a file with the poses of its bodies, from the joints of `spec`.

    Raises
    ------
    CaseError
        The root is no body of the file; joints are wrong, or would move a body of the case.
    """
    joints = {joint.instance.name: joint.instance for joint in included.joint}
    ties = [Tie(joint.between[0], joint.between[1], joint) for joint in joints.values()]
    for body in included.body:
        if isinstance(body.motion, AttachedSpec):
            ties.append(Tie(body.motion.body, body.name, None))
    names, poses = names_of(included), dict[str, FloatArray]()
    if spec.joints or spec.root is not None:
        # The body that joints do not move.
        ends = (end for tie in ties for end in (tie.first, tie.second))
        bodies = list(dict.fromkeys([*(body.name for body in included.body), *ends]))
        if spec.root is not None and spec.root not in bodies:
            raise CaseError(
                "the file has no body of this name",
                where="root",
                found=spec.root,
                allowed=", ".join(f'"{name}"' for name in bodies),
            )
        if not bodies:
            raise CaseError("the file has no body that joints could turn", where="joints")
        root = spec.root or (GROUND if GROUND in bodies else bodies[0])
        poses = postures(ties, root, spec.coordinates(joints))
    for name in poses.keys() - names:
        if not np.array_equal(poses.pop(name), np.eye(4)):
            raise CaseError(
                f"the joints given would move {name!r}, which is not of this file",
                where="root",
                remedy=f'Set root = "{name}", so that the others move',
            )
    return Included(spec, included, names, spec.matrix, poses)

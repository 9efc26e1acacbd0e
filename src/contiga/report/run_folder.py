"""The output of a run, read back without the code that wrote it."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.io.out.outlines import OutlineSeries
    from contiga.report.fields import RecordedFields

Columns = dict[str, FloatArray]
_UNNAMED_CONTACT = "contact"
_TIME_COLUMNS = ("time", "wall_time")
_ENERGY_OWNER = "energy"
_STEPS_OWNER = "step"
_BASE_UNITS = ("length", "mass", "time")
_BODY_COLUMNS = frozenset(
    (*"xyz", *(kind + axis for kind in "vaqw" for axis in "xyz"), "qw"),
)


_DERIVED_UNITS = ("area", "force", "moment", "stress", "velocity", "energy")


class Units(NamedTuple):
    """Names of units for labels; empty if the run names none."""

    length: str
    mass: str
    time: str
    area: str
    force: str
    moment: str
    stress: str
    velocity: str = ""
    acceleration: str = ""
    spin: str = ""
    energy: str = ""
    gravity: float = 0.0
    """One g in the units of the run; 0 if it names none."""

    def accelerations(self, values: FloatArray) -> tuple[FloatArray, str]:
        """Return accelerations and their unit for display: in g if g is known."""
        return (values / self.gravity, "g") if self.gravity else (values, self.acceleration)


class Run(NamedTuple):
    """One output folder."""

    folder: Path
    summary: dict[str, Any]
    """Content of summary.json."""
    times: FloatArray
    """(n,) times of the history."""
    contacts: dict[str, Columns]
    """Columns (n,) of the history by contact and name."""
    case_text: str
    """Content of case.toml; empty without one."""
    units: Units
    """Units in which its numbers are: its own, or those that it was converted to."""
    bodies: dict[str, Columns]
    """Columns of free bodies, by body and name."""
    sensors: dict[str, Columns]
    """Columns of sensors, by sensor and name."""
    energy: Columns
    """Energies of the whole system, by name; empty if forces move nothing."""
    springs: dict[str, Columns]
    """Columns of springs, by spring and name."""
    gas: dict[str, Columns]
    """Columns of chambers of gas, by chamber and name."""
    finished: bool = True
    """Whether the run has ended."""
    steps: Columns = {}  # noqa: RUF012 (read only)
    """Reasons for the lengths of steps, by name; empty for given steps."""
    slip_rings: dict[str, Columns] = {}  # noqa: RUF012 (read only)
    """Columns of slip rings, by ring and name."""
    joints: dict[str, Columns] = {}  # noqa: RUF012 (read only)
    """Columns of joints, by joint and name."""
    history: Columns = {}  # noqa: RUF012 (read only)
    """All columns by their names in the history."""
    own_units: tuple[str, str, str] = ("", "", "")
    """Length, mass and time unit of its files; empty if it names none."""

    @property
    def case(self) -> dict[str, Any]:
        """The tables of its case; empty for a run from Python, which may leave any text."""
        try:
            return tomllib.loads(self.case_text)
        except ValueError:
            return {}

    def summary_part(self, part: str) -> dict[str, Any]:
        """Return a table of the summary by its key; empty if there is none."""
        return self.summary.get(part) or {}

    def total(self, column: str) -> FloatArray:
        """Return the sum (n,) of one column over the contacts that have it; zeros if none has."""
        columns = [c[column] for c in self.contacts.values() if column in c]
        return np.sum(columns, axis=0) if columns else np.zeros(len(self.times))

    def greatest(self, column: str) -> tuple[float, float]:
        """Return the largest finite value of one column in any contact, and its time.

        Without a positive value it is 0, at the first time of the history.
        """
        greatest, time = 0.0, float(self.times[0]) if len(self.times) else 0.0
        for columns in self.contacts.values():
            values = columns.get(column)
            if values is not None and np.isfinite(values).any() and np.nanmax(values) > greatest:
                greatest = float(np.nanmax(values))
                time = float(self.times[int(np.nanargmax(values))])
        return greatest, time


def read_run(folder: Path, units: tuple[str, str, str] | None = None) -> Run:
    """Read history, summary and case of a run; of an unfinished one up to its last checkpoint.

    Conversion to other `units` includes the columns, the thicknesses of layers and the largest
    energy. The criteria of sensors and the text of the case stay as they were written.

    Parameters
    ----------
    folder : output folder of a run
    units : length, mass and time unit to convert to; those of the run if omitted, or if it names
        none

    Raises
    ------
    FileError
        The folder, its history or its summary is missing or cannot be read.
    """
    from contiga.io.column_units import column_factor, column_units
    from contiga.io.out.stored import read_stored

    stored = read_stored(folder)
    history, summary = stored.history, stored.summary
    length, mass, time = (str((summary.get("units") or {}).get(key) or "") for key in _BASE_UNITS)
    own = (length, mass, time)
    if units is not None and all(own) and units != own:
        history = {
            name: values * column_factor(name, own, units) for name, values in history.items()
        }
        changed: dict[str, Any] = {
            "units": dict(zip(_BASE_UNITS, units, strict=True)),
            "columns": column_units(history, units),
        }
        if layers := summary.get("layers"):
            length_factor = column_factor("x", own, units)
            changed["layers"] = {name: length_factor * layer for name, layer in layers.items()}
        if energy := summary.get("energy"):
            energy_factor = column_factor("energy.total", own, units)
            changed["energy"] = energy | {"most": energy["most"] * energy_factor}
        summary = summary | changed
    case = folder / "case.toml"
    owners = sort_columns(
        history,
        *(
            list(summary.get(key) or {})
            for key in ("statuses", "sensors", "springs", "gas", "slip_rings", "joints")
        ),
    )
    return Run(
        folder=folder,
        summary=summary,
        times=history.get("time", np.zeros(0)),
        case_text=case.read_text(encoding="utf-8") if case.is_file() else "",
        units=units_of(summary.get("units") or {}),
        finished=stored.finished,
        history=history,
        own_units=own,
        **owners._asdict(),
    )


class Owners(NamedTuple):
    """Columns of a history by their owners."""

    contacts: dict[str, Columns]
    bodies: dict[str, Columns]
    sensors: dict[str, Columns]
    energy: Columns
    springs: dict[str, Columns]
    gas: dict[str, Columns]
    slip_rings: dict[str, Columns]
    joints: dict[str, Columns]
    steps: Columns


def sort_columns(
    history: Columns,
    contacts: list[str],
    sensors: list[str],
    springs: list[str],
    gas: list[str],
    slip_rings: Sequence[str] = (),
    joints: Sequence[str] = (),
) -> Owners:
    """Return columns ``"<owner>.<name>"`` by owner; the lists name all owners but bodies.

    Bare names belong to the only contact, or to one called ``contact`` if there are none or
    several. An unlisted owner is a body if the name is a coordinate or a velocity of one, and else
    a contact; ``energy`` and ``step`` are contacts only if these are listed. The columns ``time``
    and ``wall_time`` are left out.
    """
    owners = Owners({}, {}, {}, {}, {}, {}, {}, {}, {})
    listed = (
        (sensors, owners.sensors),
        (springs, owners.springs),
        (gas, owners.gas),
        (slip_rings, owners.slip_rings),
        (joints, owners.joints),
    )
    for label, column in history.items():
        owner, dot, name = label.rpartition(".")
        if name in _TIME_COLUMNS:
            continue
        group = next((group for names, group in listed if owner in names), None)
        if not dot:
            owner = contacts[0] if len(contacts) == 1 else _UNNAMED_CONTACT
            columns = owners.contacts.setdefault(owner, {})
        elif group is not None:
            columns = group.setdefault(owner, {})
        elif owner == _ENERGY_OWNER and owner not in contacts:
            columns = owners.energy
        elif name in _BODY_COLUMNS:
            columns = owners.bodies.setdefault(owner, {})
        elif owner == _STEPS_OWNER and owner not in contacts:
            columns = owners.steps
        else:
            columns = owners.contacts.setdefault(owner, {})
        columns[name] = column
    return owners


def _existing_file(run: Run, name: str) -> Path | None:
    """Return a file of the folder, by its temporary name during the run; None if missing."""
    path = run.folder / (name if run.finished else f"{name}.part")
    return path if path.is_file() else None


def read_fields(run: Run) -> RecordedFields | None:
    """Return the fields over time; None if the run wrote no file of them, or no step."""
    path = _existing_file(run, "fields.vtkhdf")
    if path is None:
        return None
    from contiga.io.out.vtkhdf import read_fields as read
    from contiga.report.fields import ReadOnce

    series = read(path)
    return ReadOnce(series) if len(series.times) else None


def read_outlines(run: Run) -> OutlineSeries | None:
    """Return the outlines of the regions of contact over time, or None if the run wrote none."""
    path = _existing_file(run, "outlines.vtkhdf")
    if path is None:
        return None
    from contiga.io.out.outlines import read_outlines as read

    return read(path)


def units_of(names: dict[str, str]) -> Units:
    """Return the names of all units, from `names` by ``length``, ``mass`` and ``time``.

    Without all three, the derived ones are empty.
    """
    length, mass, time = (str(names.get(kind) or "") for kind in _BASE_UNITS)
    if not (length and mass and time):
        return Units(length, mass, time, "", "", "", "")
    from contiga.io.units import acceleration_factor, derived_units

    derived = derived_units(length, mass, time)
    return Units(
        length=length,
        mass=mass,
        time=time,
        **{kind: derived[kind] for kind in _DERIVED_UNITS},
        acceleration=f"{length}/{time}²",
        spin=f"rad/{time}",
        gravity=acceleration_factor("g", length, time),
    )

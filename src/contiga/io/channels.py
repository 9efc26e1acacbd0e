"""Channels of a run: the columns of its history, and quantities derived from them.

Columns of an only contact also have the name ``<contact>.<name>``. Derived channels are

- ``<owner>.travel`` of a body or sensor: distance from its place at the start, length;
- ``<contact>.strain`` of a contact whose law is a stress over strain in a layer of one thickness:
  deepest penetration over that thickness.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.io.column_units import column_kind, column_units
from contiga.io.naming import closest
from contiga.io.units import acceleration_factor
from contiga.records import FloatArray

_MAX_NAMES = 6
"""Largest number of names in a message."""


class Channel(NamedTuple):
    """A channel of a run in its displayed unit."""

    name: str
    values: FloatArray
    """(n,), one for each step; NaN at steps without a value. Accelerations are in g where the run
    names its units, and stresses in MPa where the run has GPa."""
    unit: str
    """Name of the unit; empty for counts and ratios, and where the run names no units."""


def channel_names(
    columns: Iterable[str], contacts: Iterable[str], layers: Iterable[str]
) -> set[str]:
    """Return the names of the channels of a run: its columns, and those derived from them.

    Columns without an owner are channels of an only contact, too. An owner of x, y, z has a travel.

    Parameters
    ----------
    columns : columns of its history
    contacts : names of its contacts
    layers : names of the contacts that have a strain
    """
    columns, contacts = set(columns), list(contacts)
    names = set(columns)
    if len(contacts) == 1:
        names |= {f"{contacts[0]}.{name}" for name in columns - {"time"} if "." not in name}
    owners = {name.rpartition(".")[0] for name in columns} - {""}
    places = (owner for owner in owners if {f"{owner}.{axis}" for axis in "xyz"} <= columns)
    names |= {f"{owner}.travel" for owner in places}
    return names | {f"{contact}.strain" for contact in layers}


def unknown_channel(what: str, where: str, name: str, names: Iterable[str]) -> dict[str, str]:
    """Return the arguments of an error about an unknown channel `name`, with up to 6 of `names`.

    They are the closest ones, or the first by alphabet if none is close.
    """
    names = sorted(names)
    close = get_close_matches(name, names, n=_MAX_NAMES, cutoff=0.3) or names[:_MAX_NAMES]
    return {
        "what": what,
        "where": where,
        "found": name,
        "allowed": f"one of {len(names)}, such as {', '.join(close)}",
        "remedy": closest(name, names) or "",
    }


def channel_of(
    history: Mapping[str, FloatArray], summary: Mapping[str, Any], name: str, where: str = "channel"
) -> Channel:
    """Return a channel of a run in the unit in which it is shown (`shown`).

    A travel is the distance from the first place of its owner, a strain the largest penetration
    over the thickness of the layer.

    Parameters
    ----------
    history : columns (n,) by name
    summary : content of summary.json
    name : name of the channel
    where : key or option that names it, for the message

    Raises
    ------
    InputError
        The run has no such channel.
    """
    contacts, layers = summary.get("statuses") or {}, summary.get("layers") or {}
    names = channel_names(history, contacts, layers)
    if name not in names:
        raise InputError(**unknown_channel("the run has no such channel", where, name, names))
    owner, _, column = name.rpartition(".")
    if name in history:
        values = history[name]
    elif column == "travel":
        places = (history[f"{owner}.{axis}"] for axis in "xyz")
        values = np.sqrt(sum((place - place[0]) ** 2 for place in places))
    elif column == "strain":
        depth = "max_penetration" if len(contacts) == 1 else f"{owner}.max_penetration"
        values = history[depth] / layers[owner]
    else:
        values = history[column]
    return shown(name, np.asarray(values, np.float64), summary.get("units") or {})


def shown(name: str, values: FloatArray, units: Mapping[str, str]) -> Channel:
    """Return a channel in the unit in which it is shown: accelerations in g, GPa as MPa.

    All others keep the unit of the run. If one of `units` is missing, values stay and the unit is
    "".

    Parameters
    ----------
    name : name of the channel
    values : (n,) in the units of the run
    units : names of the units of length, mass and time; empty where the run names none
    """
    length, mass, time = (str(units.get(key) or "") for key in ("length", "mass", "time"))
    if not (length and mass and time):
        return Channel(name, values, "")
    if column_kind(name) == "acceleration":
        return Channel(name, values / acceleration_factor("g", length, time), "g")
    unit = column_units([name], (length, mass, time))[name]
    return Channel(name, 1e3 * values, "MPa") if unit == "GPa" else Channel(name, values, unit)

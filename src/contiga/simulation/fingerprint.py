"""What tells a simulation from another: a digest of all that decides its results.

A checkpoint carries it, so that a run never goes on from the steps of another case. File names
are taken relative to the folder of the case: a folder that was moved is still the same case.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np

from contiga.contact.contact import Contact
from contiga.dynamics.free import Attached, Free
from contiga.dynamics.prescribed import Moved, SlaveMotion
from contiga.dynamics.stepping import ended
from contiga.num.digest import Digest
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.slaves.slave import Slave

# Instants a slave's motion is looked at where it is not a rigid one: a series of large files would
# have to be read again for more.
INSTANTS = 64
# Arguments a function is tried at, beside its code: strains, penetrations and rates.
_TRIED = np.array([0.0, 1e-6, 1e-3, 0.03, 0.3])
# Objects inside objects, inside objects…: beyond this a law says nothing more about itself.
_DEEPEST = 8
# The end of a run does not tell a case from another: the times do, as far as they go.
_END = re.compile(r"^(\[time\]\n(?:(?!\[).*\n)*?)end = .*\n", re.M)
# Nor does what is only told of it.
_TOLD = re.compile(r"^title = .*\n|^report = (true|false)\n", re.M)


def fingerprint_of(model: Model, end: float | None = None) -> str:
    """Of case, times, geometry, slaves, motions, contacts and what is written.

    `end` is taken for that of the run: a case that goes on for longer is the same until then.
    """
    digest = _Digest()
    times = (model.stepping if end is None else ended(model.stepping, end)).planned()
    digest.text(_TOLD.sub("", _END.sub(r"\1", _without_folder(model))))
    digest.arrays("times", times)
    digest.text(repr((model.output.every, tuple(model.output.formats))))
    digest.arrays("gravity", model.gravity)
    digest.text(repr((type(model.stepping).__name__, model.allow_unstable)))
    digest.thing([dict(model.springs), model.loads, model.sensors])
    for name, part in model.bodies.items():
        digest.text(f"motion of {name}")
        if isinstance(part.motion, Free | Attached):
            digest.thing(part.motion)
        else:
            digest.arrays("poses", *(part.motion.pose(float(t)) for t in times))
        part.body.digest(digest)
    for name, (slave, motion) in model.slaves.items():
        digest.text(name)
        digest.slave(slave)
        if isinstance(motion, Free | Attached):
            digest.thing(motion)
        else:
            digest.motion(motion, times)
    for pair in model.contacts:
        digest.text(repr((pair.name, pair.master, pair.slave)))
        digest.contact(pair.contact)
        if pair.contact.master is not model.bodies[pair.master].body:
            pair.contact.master.digest(digest)
        if pair.contact.slave is not model.slaves[pair.slave].slave:
            digest.slave(pair.contact.slave)
    return digest.hexdigest()


def _without_folder(model: Model) -> str:
    """The text of the case, its folder left out of the names of files."""
    folder = model.base_folder.resolve().as_posix()
    quoted = json.dumps(folder, ensure_ascii=False)[:-1]  # as the text has it: "/a/b
    return model.case_text.replace(f"{quoted.rstrip('/')}/", '"')


class _Digest(Digest):
    """Adds things one after the other, each with what tells it from its neighbours."""

    def slave(self, slave: Slave) -> None:
        """All that a contact uses of a slave."""
        nodal = slave.area, slave.thickness, slave.mass
        self.arrays("slave", slave.points, slave.facets, slave.active, *nodal)

    def motion(self, motion: SlaveMotion, times: FloatArray) -> None:
        """Where the points go."""
        if isinstance(motion, Moved):
            self.arrays("carried", *(motion.motion.pose(float(t)) for t in times))
            if isinstance(motion.base, np.ndarray):
                self.arrays("rest", motion.base)
            else:
                self.motion(motion.base, times)
            return
        some = np.unique(np.linspace(0, len(times) - 1, min(INSTANTS, len(times))).round())
        for k in some.astype(int):
            self.arrays("points", motion.points(float(times[k])))

    def contact(self, contact: Contact) -> None:
        """Options, law and area of a contact."""
        options = contact.search, contact.contact_type, contact.on_edge, contact.through
        self.text(
            repr((*options, contact.foot, contact.depth, contact.weights, contact.quadrature))
        )
        self.thing(contact.law)
        self.thing(contact.friction)
        self.thing(contact.area)

    def thing(self, value: Any, depth: int = 0) -> None:
        """A law, a method or what stands in one: numbers, arrays, functions, objects."""
        if value is None or isinstance(value, bool | int | float | complex | str | bytes):
            self.text(f"{type(value).__name__} {value!r}")
        elif isinstance(value, np.ndarray | np.generic):
            self.arrays("array", np.asarray(value))
        elif depth >= _DEEPEST:
            self.text(type(value).__qualname__)
        elif isinstance(value, Mapping):
            self._things(chain.from_iterable(value.items()), depth)
        elif isinstance(value, Sequence | set | frozenset):
            ordered = value if isinstance(value, Sequence) else sorted(value, key=repr)
            self._things(ordered, depth)
        else:
            self._object(value, depth)

    def _things(self, values: Iterable[Any], depth: int) -> None:
        own = list(values)
        self.text(f"{len(own)} things")
        for value in own:
            self.thing(value, depth + 1)

    def _object(self, value: Any, depth: int) -> None:
        named = value if callable(value) and hasattr(value, "__qualname__") else type(value)
        self.text(f"{named.__module__}.{named.__qualname__}")
        self._code(value, depth)
        if callable(value):
            self.text(_tried(value))
        if hasattr(value, "__dict__") and not isinstance(value, type):
            # What follows from the rest, and is there only once it was asked for, tells nothing.
            kept = [
                (name, own)
                for name, own in vars(value).items()
                if not isinstance(getattr(type(value), name, None), cached_property)
            ]
            self._things(chain.from_iterable(sorted(kept)), depth)

    def _code(self, value: Any, depth: int) -> None:
        """What a function of Python does: its code, constants, defaults and closure."""
        function = getattr(value, "__func__", value)
        code = getattr(function, "__code__", None)
        if code is None:
            return
        self.text(code.co_code.hex() + repr(code.co_names))
        plain = [c for c in code.co_consts if not hasattr(c, "co_code")]
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        self._things([plain, function.__defaults__, cells], depth)
        if function is not value:
            self.thing(value.__self__, depth + 1)


def _tried(function: Callable[..., Any]) -> str:
    """What a function answers; the name of the error where it takes other arguments."""
    try:
        with np.errstate(all="ignore"):
            return repr(np.asarray(function(_TRIED.copy()), dtype=np.float64).tobytes())
    except Exception as error:
        return type(error).__name__

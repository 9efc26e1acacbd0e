"""Every exception that contiga raises. Each names the fault, its place, and the allowed values.

`InputError`, its subclasses and `MissingPackageError` are errors of the user (exit code 2 on the
command line); `RunError` means that the run of a correct input has failed (exit code 1).

>>> import contiga as cg
>>> try:
...     cg.shapes.sphere(radius=-1.0)
... except cg.errors.InputError as error:
...     print(error.found, "|", error.allowed)
-1.0 | > 0
"""

from __future__ import annotations

from collections.abc import Sequence


class ContigaWarning(UserWarning):
    """An input was accepted and handled, but the user should know about it."""


class ContigaError(Exception):
    """Base of all errors raised by contiga."""

    exit_code = 1


class RunError(ContigaError):
    """The run of a valid input has failed."""


class ElementError(RunError):
    """A deforming element has turned inside out, or its corners are not finite.

    Parameters
    ----------
    kind : kind of the element, and its part
    element : its number in the part
    place : (3,) its centre
    count : number of such elements in the part
    time : time of the error; `at` adds it, since matter has no time
    """

    def __init__(
        self,
        kind: str,
        element: int,
        place: Sequence[float],
        count: int = 1,
        time: float | None = None,
    ) -> None:
        self.kind, self.element, self.count, self.time = kind, element, count, time
        self.place = tuple(float(x) for x in place)
        where = ", ".join(f"{x:.6g}" for x in self.place)
        when = "" if time is None else f" at the time {time:.6g}"
        more = f", and {count - 1} more" if count > 1 else ""
        super().__init__(
            f"element {element} ({kind}) at {where} has turned inside out{when}{more}. Take "
            "smaller steps, a finer mesh where it is pressed together, a material that stiffens, "
            "or a softer contact"
        )

    def at(self, time: float) -> ElementError:
        """Return the same error with its time."""
        return ElementError(self.kind, self.element, self.place, self.count, time)


class MissingPackageError(ContigaError, ImportError):
    """A feature needs a package that is not installed."""

    exit_code = 2


class InputError(ContigaError, ValueError):
    """An input is wrong.

    Parameters
    ----------
    what : the broken rule, as a full statement ("knots must not decrease")
    where : file, key, line or argument of the value
    found : the wrong value, shown with ``repr``
    allowed : values that would be accepted
    remedy : advice, if it does not follow from `allowed`
    """

    exit_code = 2
    _missing = object()

    def __init__(
        self,
        what: str,
        *,
        where: str | None = None,
        found: object = _missing,
        allowed: str | None = None,
        remedy: str | None = None,
    ) -> None:
        self.what = what
        self.where = where
        self.has_found = found is not InputError._missing
        self.found = found if self.has_found else None
        self.allowed = allowed
        self.remedy = remedy
        text = f"{where}: {what}" if where else what
        if found is not InputError._missing:
            text += f"; found {found!r}"
        if allowed:
            text += f"; allowed: {allowed}"
        if remedy:
            text += f". {remedy}"
        super().__init__(text)


class GeometryError(InputError):
    """A curve, surface or body cannot be built from its data."""


class FileError(InputError):
    """A file is missing, unreadable, empty or of another format."""


class MeshError(InputError):
    """A mesh or cloud cannot serve as a slave or a faceted master."""


class CaseError(InputError):
    """A case file has an unknown key, a wrong type or a value that does not fit."""


class UnitError(InputError):
    """A unit is unknown or has another dimension."""


class OutputError(InputError):
    """The output folder cannot be written, or holds files of another case."""


class CheckpointError(InputError):
    """A checkpoint is damaged or belongs to another case."""

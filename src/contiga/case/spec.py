"""Base of all tables of a case file: strict types, known keys, suggestions, file paths."""

from __future__ import annotations

import operator
import os
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, reduce
from pathlib import Path
from typing import Annotated, Any, ClassVar, Generic, Self, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    ModelWrapValidatorHandler,
    Tag,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import InitErrorDetails

from contiga.errors import CaseError, FileError, InputError
from contiga.io.naming import NAME, closest, closest_name

Made = TypeVar("Made")


class Spec(BaseModel):
    """A table of the case file. Text is no number, and unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @model_validator(mode="wrap")
    @classmethod
    def _keys_are_known(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Report every unknown key together with the errors under the known ones."""
        strange = unknown_keys(data, cls.known_keys(data)) if isinstance(data, dict) else {}
        if not strange:
            return handler(data)
        details = [as_detail(error, data) for error in strange.values()]
        try:
            handler({key: value for key, value in data.items() if key not in strange})
        except ValidationError as error:
            # A missing key may be a misspelt one, and the table as a whole is checked
            # when its keys are right.
            meant = {(closest_name(key, cls.known_keys(data)),) for key in strange}
            details += [
                InitErrorDetails(
                    type=one["type"], loc=one["loc"], input=one["input"], ctx=one.get("ctx", {})
                )
                for one in error.errors(include_url=False)
                if one["loc"] and not (one["type"] == "missing" and one["loc"] in meant)
            ]
        raise ValidationError.from_exception_data(cls.__name__, details)

    @classmethod
    def known_keys(cls, data: dict[str, Any]) -> list[str]:
        """Return the keys this table may have."""
        return [field.alias or name for name, field in cls.model_fields.items()]


class MadeSpec(Spec, Generic[Made]):
    """A table that describes one object; it is wrong if the object cannot be made."""

    makes: ClassVar[Callable[..., Any]]
    """Constructor of the object; it takes the values of the keys by their names."""

    @cached_property
    def made(self) -> Made:
        """The object, made once."""
        made: Made = type(self).makes(**self.arguments())
        return made

    def arguments(self) -> dict[str, Any]:
        """Return the values of the keys without `kind`; tables in it as objects."""
        names = (name for name in type(self).model_fields if name != "kind")
        return {name: _object_of(getattr(self, name)) for name in names}

    @model_validator(mode="after")
    def _can_be_made(self) -> Self:
        assert self.made is not None
        return self


def _object_of(value: Any) -> Any:
    if isinstance(value, MadeSpec):
        return value.made
    if isinstance(value, dict):
        return {name: _object_of(one) for name, one in value.items()}
    return value


def unknown_keys(data: dict[str, Any], known: Iterable[str]) -> dict[str, CaseError]:
    """Return an error for each unknown key, with the closest known one."""
    allowed = list(known)
    return {
        key: CaseError(
            "unknown key", where=key, allowed=", ".join(allowed), remedy=suggest(key, allowed)
        )
        for key in data
        if key not in allowed
    }


def as_detail(error: InputError, data: object) -> InitErrorDetails:
    """Return an error of ours as one of several that pydantic reports."""
    return InitErrorDetails(type="value_error", loc=(), input=data, ctx={"error": error})


def raise_together(data: object, checks: Iterable[Callable[[], object]]) -> None:
    """Carry out all checks and report their errors as one list, one per place and value.

    Raises
    ------
    InputError
        The only thing that is wrong.
    ValidationError
        Several are.
    """
    by_place: dict[tuple[str | None, str], InputError] = {}
    for check in checks:
        try:
            check()
        except InputError as error:
            by_place.setdefault((error.where, repr(error.found)), error)
    errors = [*by_place.values()]
    if len(errors) == 1:
        raise errors[0]
    if errors:
        details = [as_detail(error, data) for error in errors]
        raise ValidationError.from_exception_data(type(data).__name__, details)


def is_number(value: Any) -> bool:
    """Return whether a value of a file is a number; booleans are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def suggest(given: object, allowed: Iterable[str]) -> str | None:
    """Return a question that suggests the closest of `allowed`; None if none is close."""
    return closest(given, allowed)


def listed_choice(what: str, chosen: Sequence[str | int] | None) -> str:
    """Return the end of a description that names the selection from a file; "" for all of it."""
    return "" if chosen is None else f", {what} {', '.join(map(str, chosen))}"


def numbers_in(unit: str | None, otherwise: str) -> str:
    """Return the end of a description that names the unit of a file's numbers."""
    return f"numbers in {otherwise if unit is None else unit}"


class TellApart:
    """A rule in `Annotated` by which a union of tables is resolved.

    Parameters
    ----------
    keys : that only one of the tables has each, in the order of the union; their `kind` if none
    """

    def __init__(self, *keys: str) -> None:
        self._keys = keys

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        models = list(_tables_of(source))
        if self._keys:
            return handler.generate_schema(_by_key(dict(zip(self._keys, models, strict=True))))
        return handler.generate_schema(_by_kind(models))


BY_KIND = TellApart()


def _tables_of(union: Any) -> Iterator[type[Spec]]:
    """Yield the tables of a union, and of unions in it."""
    if isinstance(union, type):
        yield union
    for part in get_args(union):
        yield from () if isinstance(part, TellApart) else _tables_of(part)


def _by_kind(models: Sequence[type[Spec]]) -> Any:
    """Return a union of tables resolved by their `kind`."""
    kinds = {model.model_fields["kind"].default: model for model in models}

    def check(value: Any) -> Any:
        if isinstance(value, Spec):
            return value
        if not isinstance(value, dict):
            raise CaseError("must be a table with a kind", found=value, allowed=_quoted(kinds))
        if "kind" not in value:
            raise CaseError("is missing", where="kind", allowed=_quoted(kinds))
        kind = value["kind"]
        if kind not in list(kinds):
            raise CaseError(
                "unknown kind",
                where="kind",
                found=kind,
                allowed=_quoted(kinds),
                remedy=suggest(kind, kinds),
            )
        return value

    def tag(value: Any) -> str:
        return f"<{value['kind'] if isinstance(value, dict) else value.kind}>"

    return _union({f"<{kind}>": model for kind, model in kinds.items()}, tag, check)


def _by_key(models: Mapping[str, type[Spec]]) -> Any:
    """Return a union of tables resolved by the one key that each has alone."""

    def check(value: Any) -> Any:
        if isinstance(value, Spec):
            return value
        if not isinstance(value, dict):
            raise CaseError("must be a table", found=value, allowed=f"one with {_or(models)}")
        given = [key for key in models if key in value]
        if len(given) != 1:
            close = [hint for key in value if (hint := suggest(key, models))]
            raise CaseError(
                f"must have exactly one of the keys {_or(models)}",
                found=", ".join(value) or "none",
                remedy=close[0] if close and not given else None,
            )
        return value

    def tag(value: Any) -> str:
        if isinstance(value, dict):
            return next(f"<{key}>" for key in models if key in value)
        return next(f"<{key}>" for key, model in models.items() if type(value) is model)

    return _union({f"<{key}>": model for key, model in models.items()}, tag, check)


def _union(
    tagged: dict[str, type[Spec]], tag: Callable[[Any], str], check: Callable[[Any], Any]
) -> Any:
    # The brackets tell a tag from a key in the place an error reports.
    union = reduce(operator.or_, (Annotated[model, Tag(name)] for name, model in tagged.items()))
    return Annotated[union, Discriminator(tag), BeforeValidator(check)]


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _or(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} or {last}" if first else last


def _folder(info: ValidationInfo) -> Path:
    return Path((info.context or {}).get("folder", "."))


def _existing(path: str, info: ValidationInfo) -> str:
    mode = 0
    try:
        full = (_folder(info) / path).resolve()
        with suppress(FileNotFoundError, NotADirectoryError):
            mode = os.stat(full).st_mode
    except PermissionError as error:
        raise FileError("cannot be read (permission denied)", found=path) from error
    except (OSError, ValueError) as error:  # too long, or with a character no name can have
        raise FileError("is not a file name", found=path) from error
    if not stat.S_ISREG(mode):
        what = "this is a folder, not a file" if stat.S_ISDIR(mode) else "no such file"
        raise FileError(what, found=path, allowed=f"a file; looked for {full}")
    return full.as_posix()


def _pattern(pattern: str, info: ValidationInfo) -> str:
    from contiga.io.mesh.series import find_files

    find_files(pattern, _folder(info))
    return (_folder(info).resolve() / pattern).as_posix()


def _unit_of(dimension: str) -> Callable[[str], str]:
    def check(unit: str) -> str:
        from contiga.io.units import base_factor

        base_factor(unit, dimension)
        return unit

    return check


LengthUnit = Annotated[str, AfterValidator(_unit_of("length"))]
MassUnit = Annotated[str, AfterValidator(_unit_of("mass"))]
TimeUnit = Annotated[str, AfterValidator(_unit_of("time"))]

ExistingFile = Annotated[str, AfterValidator(_existing)]
"""A path, relative to the case file's folder; stored as absolute."""

FilePattern = Annotated[str, AfterValidator(_pattern)]
"""A pattern such as ``step_*.vtu`` that matches at least one file; stored as absolute."""

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Count = Annotated[int, Field(ge=1)]
Parts = Annotated[list[str | int], Field(min_length=1)]
"""Names or numbers of parts of a file."""
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Pair = Annotated[list[Vector], Field(min_length=2, max_length=2)]
"""Two points, or a point and a direction."""
Axis = str | Vector
Name = Annotated[str, Field(pattern=f"^{NAME.pattern}$")]


class MotionSpec(Spec):
    """A `motion` table of a body or slave."""

    by_forces: ClassVar[bool] = False
    """Whether forces move it, by masses of its own."""

    def named_bodies(self) -> Iterator[tuple[str, str]]:
        """Yield the keys that name a body it depends on, and the names."""
        yield from ()

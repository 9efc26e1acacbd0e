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

InstanceT = TypeVar("InstanceT")


class Spec(BaseModel):
    """A table of the case file. Text is no number, and unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @model_validator(mode="wrap")
    @classmethod
    def _keys_are_known(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Report every unknown key together with the errors under the known ones.

        A missing key that an unknown one may be a misspelling of, and rules about the table as a
        whole, are then not reported.
        """
        unknown = unknown_keys(data, cls.known_keys(data)) if isinstance(data, dict) else {}
        if not unknown:
            return handler(data)
        details = [as_detail(error, data) for error in unknown.values()]
        try:
            handler({key: value for key, value in data.items() if key not in unknown})
        except ValidationError as error:
            misspelt = {(closest_name(key, cls.known_keys(data)),) for key in unknown}
            details += [
                InitErrorDetails(
                    type=detail["type"],
                    loc=detail["loc"],
                    input=detail["input"],
                    ctx=detail.get("ctx", {}),
                )
                for detail in error.errors(include_url=False)
                if detail["loc"] and not (detail["type"] == "missing" and detail["loc"] in misspelt)
            ]
        raise ValidationError.from_exception_data(cls.__name__, details)

    @classmethod
    def known_keys(cls, data: dict[str, Any]) -> list[str]:
        """Return the keys this table may have."""
        return [field.alias or name for name, field in cls.model_fields.items()]


class InstanceSpec(Spec, Generic[InstanceT]):
    """A table that describes one object; it is wrong if the object cannot be made."""

    makes: ClassVar[Callable[..., Any]]
    """Constructor of the object; it takes the values of the keys by their names."""

    @cached_property
    def instance(self) -> InstanceT:
        """The object, made once."""
        instance: InstanceT = type(self).makes(**self.arguments())
        return instance

    def arguments(self) -> dict[str, Any]:
        """Return the values of the keys without `kind`; tables in it as objects."""
        names = (name for name in type(self).model_fields if name != "kind")
        return {name: _with_instances(getattr(self, name)) for name in names}

    @model_validator(mode="after")
    def _can_be_made(self) -> Self:
        assert self.instance is not None
        return self


def _with_instances(value: Any) -> Any:
    """Return a value with the objects of its tables in place of these; lists stay as they are."""
    if isinstance(value, InstanceSpec):
        return value.instance
    if isinstance(value, dict):
        return {name: _with_instances(entry) for name, entry in value.items()}
    return value


def unknown_keys(data: dict[str, Any], known_keys: Iterable[str]) -> dict[str, CaseError]:
    """Return an error for each unknown key, with the closest known one."""
    allowed = list(known_keys)
    return {
        key: CaseError(
            "unknown key", where=key, allowed=", ".join(allowed), remedy=suggest(key, allowed)
        )
        for key in data
        if key not in allowed
    }


def as_detail(error: InputError, data: object) -> InitErrorDetails:
    """Return an `InputError` as an entry of the list of errors that pydantic reports."""
    return InitErrorDetails(type="value_error", loc=(), input=data, ctx={"error": error})


def raise_together(data: object, checks: Iterable[Callable[[], object]]) -> None:
    """Carry out all checks and report their errors as one list, the first per place and value.

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


def must_be(
    accepts: Callable[[Any], bool],
    rule: str,
    allowed: str | None = None,
    *,
    words: Sequence[str] = (),
) -> BeforeValidator:
    """Return a validator with one message, where a union of types would give one for each type.

    Parameters
    ----------
    accepts : whether a value is allowed
    rule : text of the message
    allowed : the allowed values in the message; left out if None
    words : words among the allowed values, the closest of which the message suggests
    """

    def check(value: Any) -> Any:
        if not accepts(value):
            remedy = suggest(value, words)
            raise CaseError(rule, found=value, allowed=allowed, remedy=remedy)
        return value

    return BeforeValidator(check)


def is_number(value: Any) -> bool:
    """Return whether a value of a file is a number; booleans are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def is_number_or_rows(value: Any) -> bool:
    """Return whether a value of a file is a number, or a list of one row or more."""
    return is_number(value) or has_rows(value)


def has_rows(value: Any) -> bool:
    """Return whether a value of a file is a list of lists, and not empty."""
    return isinstance(value, list) and bool(value) and all(isinstance(row, list) for row in value)


def suggest(value: object, allowed: Iterable[str]) -> str | None:
    """Return a question that suggests the closest of `allowed`; None if none is close."""
    return closest(value, allowed)


def listed_choice(noun: str, names: Sequence[str | int] | None) -> str:
    """Return the end of a description that names the selection from a file; "" for all of it."""
    return "" if names is None else f", {noun} {', '.join(map(str, names))}"


def numbers_in(unit: str | None, default: str) -> str:
    """Return the end of a description that names the unit of a file's numbers."""
    return f"numbers in {default if unit is None else unit}"


class DiscriminatedBy:
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
            by_key = dict(zip(self._keys, models, strict=True))
            return handler.generate_schema(_union_by_key(by_key))
        by_kind = {model.model_fields["kind"].default: model for model in models}
        return handler.generate_schema(_union_by_kind(by_kind))


BY_KIND = DiscriminatedBy()


def _tables_of(union: Any) -> Iterator[type[Spec]]:
    """Yield the tables of a union, and of unions in it."""
    if isinstance(union, type):
        yield union
    for part in get_args(union):
        yield from () if isinstance(part, DiscriminatedBy) else _tables_of(part)


def _union_by_kind(models: Mapping[str, type[Spec]]) -> Any:
    """Return a union of tables resolved by their `kind`.

    A value with a missing or unknown kind gets one message.
    """
    allowed = ", ".join(f'"{kind}"' for kind in models)

    def check(value: Any) -> Any:
        if isinstance(value, Spec):
            return value
        if not isinstance(value, dict):
            raise CaseError("must be a table with a kind", found=value, allowed=allowed)
        if "kind" not in value:
            raise CaseError("is missing", where="kind", allowed=allowed)
        kind = value["kind"]
        if kind not in list(models):  # a list also answers for values without a hash
            raise CaseError(
                "unknown kind",
                where="kind",
                found=kind,
                allowed=allowed,
                remedy=suggest(kind, models),
            )
        return value

    def kind_of(value: Any) -> str:
        return str(value["kind"] if isinstance(value, dict) else value.kind)

    return _union(models, kind_of, check)


def _union_by_key(models: Mapping[str, type[Spec]]) -> Any:
    """Return a union of tables resolved by the one key that each has alone.

    A value with none or several of these keys gets one message.
    """
    *first, last = models
    keys = f"{', '.join(first)} or {last}" if first else last

    def check(value: Any) -> Any:
        if isinstance(value, Spec):
            return value
        if not isinstance(value, dict):
            raise CaseError("must be a table", found=value, allowed=f"one with {keys}")
        count = sum(key in value for key in models)
        if count != 1:
            hints = [hint for key in value if (hint := suggest(key, models))]
            raise CaseError(
                f"must have exactly one of the keys {keys}",
                found=", ".join(value) or "none",
                remedy=hints[0] if hints and not count else None,
            )
        return value

    def key_of(value: Any) -> str:
        if isinstance(value, dict):
            return next(key for key in models if key in value)
        return next(key for key, model in models.items() if type(value) is model)

    return _union(models, key_of, check)


def _union(
    models: Mapping[str, type[Spec]], name_of: Callable[[Any], str], check: Callable[[Any], Any]
) -> Any:
    """Return the union of tables by name, resolved by the name of a value, after a check of it."""
    # The brackets tell a tag from a key in the place an error reports.
    tagged = (Annotated[model, Tag(f"<{name}>")] for name, model in models.items())
    union = reduce(operator.or_, tagged)
    discriminator = Discriminator(lambda value: f"<{name_of(value)}>")
    return Annotated[union, discriminator, BeforeValidator(check)]


def _folder(info: ValidationInfo) -> Path:
    return Path((info.context or {}).get("folder", "."))


def _absolute_file(path: str, info: ValidationInfo) -> str:
    """Return the absolute path of a file, from the folder of the case; FileError if it is none."""
    mode = 0
    try:
        absolute = (_folder(info) / path).resolve()
        with suppress(FileNotFoundError, NotADirectoryError):
            mode = os.stat(absolute).st_mode
    except PermissionError as error:
        raise FileError("cannot be read (permission denied)", found=path) from error
    except (OSError, ValueError) as error:  # too long, or with a character no name can have
        raise FileError("is not a file name", found=path) from error
    if not stat.S_ISREG(mode):
        rule = "this is a folder, not a file" if stat.S_ISDIR(mode) else "no such file"
        raise FileError(rule, found=path, allowed=f"a file; looked for {absolute}")
    return absolute.as_posix()


def _absolute_pattern(pattern: str, info: ValidationInfo) -> str:
    """Return a pattern from the folder of the case as absolute; FileError if no file matches."""
    from contiga.io.mesh.series import find_files

    find_files(pattern, _folder(info))
    return (_folder(info).resolve() / pattern).as_posix()


def _unit_of(dimension: str) -> AfterValidator:
    def check(unit: str) -> str:
        from contiga.io.units import base_factor

        base_factor(unit, dimension)
        return unit

    return AfterValidator(check)


LengthUnit = Annotated[str, _unit_of("length")]
MassUnit = Annotated[str, _unit_of("mass")]
TimeUnit = Annotated[str, _unit_of("time")]

ExistingFile = Annotated[str, AfterValidator(_absolute_file)]
"""A path, relative to the case file's folder; stored as absolute."""

FilePattern = Annotated[str, AfterValidator(_absolute_pattern)]
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

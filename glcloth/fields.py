"""Fields of frozen values: each has its unit, help and limits once, and files, errors, options of the command line,
sliders and documents are made from that."""

from __future__ import annotations

import types
from dataclasses import dataclass
from pathlib import PurePath
from typing import Annotated, Any, Literal, Self, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic.fields import FieldInfo

from .errors import InputError, meant, short

SMALLEST, LARGEST = 1e-15, 1e15  # sizes of numbers that a shader may square


def about(
    unit: str,
    text: str,
    *,
    of: str = "",
    option: bool | str = False,
    file: bool = False,
    slider: tuple[float, float] | None = None,
    log: bool = False,
    repeat: bool = False,
    **limits: Any,
) -> Any:
    """A field of a `Value`.

    Parameters
    ----------
    of : the kind of scene, or the method, that alone reads it
    option : whether it is an option of the command line, or that option's name where it is not the field's
    file : whether it may name a file
    slider : ends of the window's slider, where these are not the limits; log : it is logarithmic
    repeat : whether its option may be given several times
    limits : as pydantic's Field takes them: default, ge, gt, le, lt, min_length
    """
    extra = {"unit": unit, "of": of, "option": option, "file": file, "slider": slider, "log": log}
    extra["repeat"] = repeat
    return Field(description=text, json_schema_extra=extra, **limits)


class Value(BaseModel):
    """A frozen value that is edited by making another one. Its title names it in errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _named(cls, data: Any) -> Any:
        """Paths are names: as text, also in lists and tables."""
        return {name: _as_names(value) for name, value in data.items()} if isinstance(data, dict) else data

    @model_validator(mode="after")
    def _in_single_precision(self) -> Self:
        """Shaders square numbers in single precision."""
        for name, value in zip(type(self).model_fields, self._fields(), strict=True):
            for number in value if isinstance(value, tuple) else (value,):
                if isinstance(number, float) and number and not SMALLEST <= abs(number) <= LARGEST:
                    raise ValueError(f"{name} = {number:g}: expected 0 or a size from {SMALLEST:g} to {LARGEST:g}")
        return self

    @classmethod
    def parse(cls, data: dict, where: str = "") -> Self:
        """The value of a plain dictionary; `where` names its origin in errors, if not by title. Raises InputError."""
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            where = where or cls.model_config.get("title") or cls.__name__.lower()
            raise InputError(f"{where}: {first_problem(error, cls)}") from None

    def changed(self, **changes: Any) -> Self:
        """The same value with some fields replaced. Raises InputError for unknown fields and values out of range."""
        data = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self).parse({**data, **changes})

    def model_copy(self, *, update: Any = None, deep: bool = False) -> Self:
        """As `changed`: pydantic's own copy would keep what was derived from the replaced fields."""
        return self.changed(**(update or {}))

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """As notebooks show it: what was said of it, on as many lines as that takes."""
        kind = type(self).__name__
        with printer.group(len(kind) + 1, f"{kind}(", ")"):
            for number, name in enumerate(name for name in type(self).model_fields if name in self.model_fields_set):
                if number:
                    printer.text(",")
                    printer.breakable()
                printer.text(f"{name}=")
                printer.pretty(getattr(self, name))

    def _fields(self) -> tuple:
        return tuple(getattr(self, name) for name in type(self).model_fields)

    def __eq__(self, other: object) -> bool:
        """Equal fields: pydantic also compares what was derived and kept, which fails for arrays."""
        return self is other or (
            isinstance(other, Value) and type(self) is type(other) and self._fields() == other._fields()
        )

    def __hash__(self) -> int:
        values = (frozenset(v.items()) if isinstance(v, dict) else v for v in self._fields())
        return hash((type(self), tuple(values)))


def _as_names(value: Any) -> Any:
    """A value whose paths are text."""
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, list | tuple) and any(isinstance(part, PurePath) for part in value):
        return [_as_names(part) for part in value]
    if isinstance(value, dict) and any(isinstance(part, PurePath) for part in value.values()):
        return {name: _as_names(part) for name, part in value.items()}
    return value


# -- the description of a field ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Entry:
    """The description of a field.

    Parameters
    ----------
    kind : "bool", "int", "float", "text", "choice", "color" (three shares), "triple", "pair", "list", "table" or "other"
    low, high : limits of the value; None where it has none
    option : the option of the command line with its dashes, or ""
    """

    name: str
    kind: str
    unit: str
    help: str
    default: Any
    low: float | None
    high: float | None
    choices: tuple[str, ...]
    of: str
    option: str
    file: bool
    slider: tuple[float, float] | None
    log: bool
    repeat: bool

    @property
    def label(self) -> str:
        """The name for people; a last single letter is a subscript, as in gamma_s."""
        name = self.name.removesuffix("_deg")
        return name if name[-2:-1] == "_" else name.replace("_", " ")

    @property
    def method(self) -> bool:
        """Whether one method alone reads it."""
        return self.of not in ("", "cloth", "curtain")

    @property
    def values(self) -> str:
        """Its possible values, with the unit: limits, choices, or an empty text."""
        low, high = (None if end is None else f"{end:g}" for end in (self.low, self.high))
        if self.choices and self.kind == "choice":
            said = one_of(self.choices)
        elif low is not None and high is not None:
            said = f"{low} to {high}"
        else:
            said = f"from {low}" if low is not None else f"up to {high}" if high is not None else ""
        return " ".join(part for part in (said, self.unit) if part)


def entries(model: type[BaseModel], names: tuple[str, ...] | None = None) -> list[Entry]:
    """The descriptions of the fields of a model (all, or those named), in their order."""
    return [_entry(name, model.model_fields[name]) for name in names or tuple(model.model_fields)]


def _entry(name: str, field: FieldInfo) -> Entry:
    kind, choices, metadata = _kind(field.annotation)
    extra = {"unit": "", "of": "", "option": False, "file": False, "slider": None, "log": False, "repeat": False}
    extra |= field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    option = extra.pop("option")
    extra["option"] = option if isinstance(option, str) else "--" + name.replace("_", "-") if option else ""
    default = None if field.is_required() else field.get_default(call_default_factory=True)
    low, high = _limits([*field.metadata, *metadata])
    return Entry(
        name, kind, help=field.description or "", default=default, low=low, high=high, choices=choices, **extra
    )


def _kind(annotation: Any) -> tuple[str, tuple[str, ...], list]:
    """The kind of a field, its choices, and the limits that its type itself carries."""
    if get_origin(annotation) in (Union, types.UnionType):
        parts = [a for a in get_args(annotation) if a is not types.NoneType]
        annotation = next((a for a in parts if a in (int, float)), parts[0])
    inner: list = []
    if get_origin(annotation) is Annotated:
        annotation, *inner = get_args(annotation)
    if get_origin(annotation) is Literal:
        return "choice", get_args(annotation), inner
    if get_origin(annotation) is tuple:
        return _kind_of_several(get_args(annotation))
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return "table", (), inner
    return {bool: "bool", int: "int", float: "float", str: "text"}.get(annotation, "other"), (), inner


def _kind_of_several(parts: tuple) -> tuple[str, tuple[str, ...], list]:
    """As `_kind`, of a tuple's parts."""
    if parts[-1] is Ellipsis:
        return ("list" if parts[0] is str else "other"), (), []
    inner = list(getattr(parts[0], "__metadata__", ()))
    if len(parts) == 2 and parts[0] == parts[1] and get_args(parts[0])[:1] == (float,):
        return "pair", (), inner
    kind = "other" if len(parts) != 3 else "color" if _limits(inner)[1] == 1.0 else "triple"
    return kind, (), inner if kind != "other" else []


def _limits(metadata: list) -> tuple[float | None, float | None]:
    low = high = None
    for item in metadata:
        if isinstance(item, FieldInfo):
            low, high = (a if b is None else b for a, b in zip((low, high), _limits(item.metadata), strict=True))
        low = getattr(item, "ge", None) if getattr(item, "ge", None) is not None else low
        # A limit that itself is not allowed: the slider ends a thousandth before it.
        low = item.gt + 1e-3 if getattr(item, "gt", None) is not None else low
        high = item.le if getattr(item, "le", None) is not None else high
    return low, high


def one_of(names: tuple[str, ...]) -> str:
    """Names as a sentence lists them: a, b or c."""
    return " or ".join([", ".join(names[:-1])] * (len(names) > 1) + [names[-1]])


# -- errors --------------------------------------------------------------------------------------------------------------


def first_problem(error: ValidationError, model: type[BaseModel]) -> str:
    """One line for the first problem that pydantic found; the number of other places with problems behind it."""
    # A misspelt key is also a missing one, and a wrong table is no name either: report the key, or the table's error.
    problems = sorted(error.errors(), key=lambda p: (p["type"] != "extra_forbidden", p["type"] == "string_type"))
    problem = problems[0]
    where, inner = _place(problem, model)
    kind, value = problem["type"], problem.get("input")
    if kind == "extra_forbidden":
        known = list(inner.model_fields)
        hint = meant(str(problem["loc"][-1]), known, "did you mean {}?") or f"known keys: {', '.join(known)}"
        text = f"{where}: unknown key; {hint}"
    elif kind == "missing":
        text = f"{where}: is missing; add it"
    elif kind == "value_error":
        text = f"{where}: {problem['ctx']['error']}" if where else str(problem["ctx"]["error"])
    elif kind == "literal_error":
        expected = problem["ctx"]["expected"].replace("'", "")
        text = f"{where} = {short(value)}: expected {expected}"
    else:
        text = f"{where} = {short(value)}: {problem['msg'][0].lower()}{problem['msg'][1:]}"
    more = sum(not where.startswith(place) for place in {_place(p, model)[0] for p in problems})
    return text + (f" (and {more} more)" if more else "")


def _place(problem: Any, model: type[BaseModel]) -> tuple[str, type[BaseModel]]:
    """Where a problem is, for people, and the model whose key that is."""
    place: list[str] = []
    table = False  # whether the part before names tables
    for number, part in enumerate(problem["loc"]):
        if isinstance(part, int):
            if table:
                place[-1] += f" {part + 1}"
            else:
                place.append(f"item {part + 1}")
            continue
        field = model.model_fields.get(part)
        unknown = problem["type"] == "extra_forbidden" and number == len(problem["loc"]) - 1
        if field is None and not unknown:
            continue  # which of several types it was compared with
        place.append(part)
        inner = _model_in(field.annotation) if field is not None else None
        table = inner is not None
        model = inner or model
    return ": ".join(place), model


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The model that a field holds, or holds several of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for found in map(_model_in, get_args(annotation)) if found), None)

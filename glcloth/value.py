"""Frozen values whose fields carry unit, help and limits; files, errors, documents and the window all read those."""

from __future__ import annotations

import difflib
import typing

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from .errors import InputError

MAX_LINE = 300  # characters of an error


def about(unit: str, text: str, **limits):
    """A field with its unit and help text."""
    return Field(description=text, json_schema_extra={"unit": unit}, **limits)


def one_line(text: str) -> str:
    """`text` as one printable line of at most 300 characters, for errors that quote what a file holds."""
    line = "".join(c if c.isprintable() else "?" for c in " ".join(str(text).split()))
    return line if len(line) <= MAX_LINE else f"{line[: MAX_LINE - 3]}..."


class Value(BaseModel):
    """A frozen value that is edited by making another one."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def _fields(self) -> tuple:
        return tuple(getattr(self, name) for name in type(self).model_fields)

    def __eq__(self, other) -> bool:
        """Equal fields: pydantic also compares what was derived and kept, which fails for arrays."""
        return self is other or (type(self) is type(other) and self._fields() == other._fields())

    def __hash__(self) -> int:
        return hash((type(self), self._fields()))

    def changed(self, **changes):
        """The same value with some fields replaced. Raises InputError for unknown fields and values out of range."""
        data = {name: getattr(self, name) for name in type(self).model_fields}
        try:
            return type(self).model_validate({**data, **changes})
        except ValidationError as error:
            raise InputError(f"{type(self).__name__.lower()}: {first_problem(error, type(self))}") from None

    def model_copy(self, *, update=None, deep=False):
        """As `changed`: pydantic's own copy would keep what was derived from the replaced fields."""
        return self.changed(**(update or {}))


def first_problem(error: ValidationError, model: type[BaseModel]) -> str:
    """One line for the first problem that pydantic found; the number of further ones behind it."""
    # A misspelt key is also a missing one; the misspelling is what to say.
    problems = sorted(error.errors(), key=lambda p: p["type"] != "extra_forbidden")
    problem = problems[0]
    place: list[str] = []
    for part in problem["loc"]:
        if not isinstance(part, int):
            place.append(str(part))
            model = _model_of(model, part) or model
        elif place and place[-1] == "yarn":
            place[-1] = f"yarn {part + 1}"
        else:
            place.append(f"item {part + 1}")
    where = ": ".join(place)
    kind, value = problem["type"], problem.get("input")
    if kind == "extra_forbidden":
        known = list(model.model_fields)
        close = difflib.get_close_matches(place[-1], known, 1, 0.5)
        hint = f"; did you mean {close[0]}?" if close else f"; known keys: {', '.join(known)}"
        text = f"{where}: unknown key{hint}"
    elif kind == "missing":
        text = f"{where}: is missing; add it"
    elif kind == "value_error":
        text = f"{where}: {problem['ctx']['error']}" if where else str(problem["ctx"]["error"])
    else:
        shown = value if len(value := repr(value)) <= 60 else f"{value[:57]}..."
        text = f"{where} = {shown}: {problem['msg'][0].lower()}{problem['msg'][1:]}"
    return text + (f" (and {len(problems) - 1} more)" if len(problems) > 1 else "")


def _model_of(model: type[BaseModel], field: str) -> type[BaseModel] | None:
    """The model that a field holds, be it optional or in a tuple; None for plain fields."""
    info = model.model_fields.get(field)
    queue = [info.annotation] if info else []
    while queue:
        kind = queue.pop()
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            return kind
        queue += typing.get_args(kind)
    return None

"""The methods by name."""

from __future__ import annotations

import moderngl

from ..errors import InputError
from .direct.method import Direct
from .method import Method
from .paper.method import Paper
from .reference import Reference

METHODS: dict[str, type[Method]] = {"direct": Direct, "paper": Paper, "reference": Reference}


def make_method(ctx: moderngl.Context, name: str) -> Method:
    """A method by its name. Raises InputError for one that does not exist."""
    if name not in METHODS:
        raise InputError(f"method {name!r}: expected one of {', '.join(METHODS)}")
    return METHODS[name](ctx)

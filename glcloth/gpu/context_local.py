"""One instance of a class for each context: shared by all rooms without handing it round."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import moderngl

T = TypeVar("T")


def of_context(kind: Callable[[moderngl.Context], T], ctx: moderngl.Context) -> T:
    """The instance of `kind` that belongs to a context; made by `kind(ctx)` at the first call."""
    if not isinstance(ctx.extra, dict):
        ctx.extra = {}
    if kind not in ctx.extra:
        ctx.extra[kind] = kind(ctx)
    return ctx.extra[kind]

"""Kinds of fields that several parts of a scene have."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from pydantic import Field

from ..fields import about

Vec3 = tuple[float, float, float]
Share = Annotated[float, Field(ge=0, le=1)]
option = partial(about, option=True)

"""Options that several commands share, and the printing of a result."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token

from ..errors import short
from ..progress import note

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object on stdout.")]
Device = Annotated[
    str | None,
    Parameter(help="Number of an EGL device or a part of its name, such as llvmpipe; `glcloth info` lists them."),
]


def whole(_: Any, tokens: Sequence[Token]) -> int:
    """The whole number of an option; cyclopts by itself rounds 1.5. Raises ValueError."""
    text = tokens[0].value
    try:
        number = float(text) if "." in text else int(text)
        if number == int(number):
            return int(number)
    except (ValueError, OverflowError):
        pass
    raise ValueError(f"expected a whole number, not {short(text)}")


def output_option(text: str) -> Parameter:
    """The option that names the file a command writes."""
    return Parameter(name=["--output", "-o"], help=text)


def tell(as_json: bool, result: dict, *lines: str) -> None:
    """Print a result: one JSON object on stdout, or lines for people on stderr."""
    if as_json:
        print(json.dumps(result), flush=True)
    else:
        for line in lines:
            note(line)

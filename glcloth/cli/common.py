"""Options that several commands share, and the printing of a result."""

from __future__ import annotations

import json
from typing import Annotated

from cyclopts import Parameter

from ..progress import say

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object on stdout.")]
Device = Annotated[
    str | None,
    Parameter(help="Number of an EGL device or a part of its name, such as llvmpipe; `glcloth info` lists them."),
]


def output_option(text: str) -> Parameter:
    """The option that names the file a command writes."""
    return Parameter(name=["--output", "-o"], help=text)


def tell(as_json: bool, result: dict, *lines: str) -> None:
    """Print a result: one JSON object on stdout, or lines for people on stderr."""
    if as_json:
        print(json.dumps(result), flush=True)
    else:
        for line in lines:
            say(line)

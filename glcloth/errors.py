"""The errors a user may meet; the doors turn them into one line and an exit code."""

import difflib
from collections.abc import Iterable


class DriverError(RuntimeError):
    """OpenGL refused something while a picture was made; the picture is not to be trusted. Exit code 1."""


MAX_LINE = 300  # characters of a message


def printable(text: object) -> str:
    """`text` as one line without control characters: what files hold must not steer a terminal."""
    return "".join(c if c.isprintable() else " " if c.isspace() else "?" for c in str(text))


def one_line(text: object) -> str:
    """`text` as one printable line of at most 300 characters; a longer one loses its middle: place and remedy stay."""
    return limited(printable(text).strip())


def limited(line: str) -> str:
    """A line without its middle where it is longer than 300 characters."""
    return line if len(line) <= MAX_LINE else f"{line[:190]} ... {line[195 - MAX_LINE :]}"


def short(value: object) -> str:
    """`value` as errors quote it: at most 60 characters."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # a whole number of thousands of digits, or a very deep list
        text = f"a very large {type(value).__name__}"
    return text if len(text) <= 60 else f"{text[:57]}..."


def meant(name: str, names: Iterable[str], said: str = "did you mean {}? ") -> str:
    """What an error says of a name that is none of `names`: the one that is most like it, whatever its case; or nothing."""
    known = {one.casefold(): one for one in names}
    close = difflib.get_close_matches(name.casefold(), known, 1, 0.5)
    return said.format(known[close[0]]) if close else ""


class InputError(ValueError):
    """Wrong input; one line with the fault, its place, the expected value and the remedy. Exit code 2."""

    def __init__(self, message: object = ""):
        super().__init__(one_line(" ".join(str(message).split())))


class NoOpenGLError(RuntimeError):
    """No usable OpenGL context: the devices tried, and packages to install. Exit code 3."""


class ShaderError(RuntimeError):
    """A GLSL file is missing, includes itself, or does not compile; the message names file and line."""

"""The errors a user may meet; the doors turn them into one line and an exit code."""


class InputError(ValueError):
    """Wrong input; one line with the fault, its place, the expected value and the remedy. Exit code 2."""


class NoOpenGLError(RuntimeError):
    """No usable OpenGL context: the devices tried, and packages to install. Exit code 3."""


class ShaderError(RuntimeError):
    """A GLSL file is missing, includes itself, or does not compile; the message names file and line."""


MAX_LINE = 300  # characters of an error


def one_line(text: str) -> str:
    """`text` as one printable line of at most 300 characters, for errors that quote what a file holds."""
    line = "".join(c if c.isprintable() else "?" for c in " ".join(str(text).split()))
    return line if len(line) <= MAX_LINE else f"{line[: MAX_LINE - 3]}..."

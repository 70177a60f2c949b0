"""The errors a user may meet; the doors turn them into one line and an exit code."""


class InputError(ValueError):
    """Wrong input; one line with the fault, its place, the expected value and the remedy. Exit code 2."""


class NoOpenGLError(RuntimeError):
    """No usable OpenGL context: the devices tried, and packages to install. Exit code 3."""


class ShaderError(RuntimeError):
    """A GLSL file is missing, includes itself, or does not compile; the message names file and line."""

"""The errors a user may meet; the doors turn them into one line and an exit code."""


class InputError(ValueError):
    """Wrong input: one line that says what, where, what was expected and what to do. Exit code 2."""


class NoOpenGLError(RuntimeError):
    """No usable OpenGL context: what was tried and what to install. Exit code 3."""


class ShaderError(RuntimeError):
    """A GLSL file is missing, includes itself, or does not compile; the message names file and line."""

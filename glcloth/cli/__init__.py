"""The command line: each command reads options, calls the package, and reports the result or the error in one line."""

from __future__ import annotations

import logging
import os
import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from cyclopts import App, CycloptsError, MissingArgumentError, UnusedCliTokensError

from .. import __version__
from ..errors import DriverError, InputError, NoOpenGLError, ShaderError
from ..progress import be_quiet, hear_ctrl_c, say, was_stopped
from .export import export
from .light import env, tables
from .measure import bench, check, diff, info
from .render import render, view
from .samples import samples
from .sequence import animate, drape
from .sweep import sweep
from .weave import fabrics, weave

ABOUT = """Woven cloth as it really looks, on OpenGL.

Exit codes: 0 done, 1 a fault of glcloth, 2 wrong input, 3 no usable OpenGL, 4 diff: beyond the --limit, 130 stopped by Ctrl-C.
--quiet (-q) with any command: only errors and results are printed, no progress, no warnings.
GLCLOTH_CACHE names the folder for fits and tables made on this machine (`glcloth info` shows it).
"""
app = App(name="glcloth", help=ABOUT, version=__version__, help_format="plaintext", suppress_keyboard_interrupt=False)

for _command in (
    render,
    animate,
    sweep,
    view,
    tables,
    env,
    weave,
    fabrics,
    export,
    samples,
    drape,
    diff,
    info,
    check,
    bench,
):
    app.command(_command)


def _with_heights(arguments: list[str]) -> list[str]:
    """The arguments with each --ground and its height in one, `auto` where none follows."""
    out: list[str] = []
    waiting = False
    for argument in arguments:
        given = waiting and re.fullmatch(r"auto|off|catcher|[-+]?(\.?\d.*|nan|inf)", argument)
        if waiting:
            out.append("--ground=" + (argument if given else "auto"))
        waiting = argument == "--ground"
        if not given and not waiting:
            out.append(argument)
    return [*out, "--ground=auto"] if waiting else out


@contextmanager
def _quiet_libraries() -> Iterator[None]:
    """Libraries' warnings and logs stay away from the terminal; GLCLOTH_DEBUG=1 shows them."""
    if os.environ.get("GLCLOTH_DEBUG"):
        yield
        return
    nobody, logging.lastResort = logging.lastResort, None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.lastResort = nobody


def _with_negative_values(arguments: list[str]) -> list[str]:
    """The arguments with each option and a value that begins with a minus in one, so that it is not read as an option."""
    out: list[str] = []
    for argument in arguments:
        if out and re.fullmatch(r"--[a-z][-a-z]*", out[-1]) and re.match(r"-\.?\d", argument):
            out[-1] += f"={argument}"
        else:
            out.append(argument)
    return out


def _open_streams() -> None:
    """Streams that the caller has closed (`2>&-`) lead nowhere: else the next file that is opened would take their place."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))


QUIET = {"-q", "--quiet"}


def main(arguments: list[str] | None = None) -> None:
    """Run one command. Exit 0 done, 1 a fault of ours, 2 wrong input, 3 no usable OpenGL, 4 pictures beyond the limit of
    `diff`, 130 stopped by Ctrl-C."""
    _open_streams()
    words = sys.argv[1:] if arguments is None else arguments
    be_quiet(not QUIET.isdisjoint(words))
    arguments = _with_negative_values(_with_heights([word for word in words if word not in QUIET]))
    hear_ctrl_c()
    try:
        with _quiet_libraries():
            app(arguments, exit_on_error=False, print_error=False)
        return
    except (Exception, KeyboardInterrupt) as error:
        code, line = _told(error)
        if code == 1 and os.environ.get("GLCLOTH_DEBUG"):
            raise
    # A module that was being imported may have swallowed Ctrl-C and failed of the consequences.
    if was_stopped() or code == 130:
        code, line = 130, "stopped; nothing was left half-written"
    if line:
        say(f"glcloth: {' '.join(line.split())}")
    sys.exit(code)


def _usage(error: Exception) -> str:
    """What is wrong with a command line, with the remedy."""
    command = " ".join(["glcloth", *(getattr(error, "command_chain", None) or ())])
    if isinstance(error, UnusedCliTokensError):
        rest = " ".join(error.unused_tokens or ())
        return f"{rest}: more than {command} takes; options begin with --, see {command} --help"
    if isinstance(error, MissingArgumentError) and error.argument is not None and "Did you mean" not in str(error):
        argument = error.argument
        given = error.keyword is not None or bool(argument.tokens)  # such as --fabric at the end
        if given and "-o" in argument.names:
            return f"{error.keyword or argument.name}: expected the name of a file after it; see {command} --help"
        if given:
            return f"{error.keyword or argument.name}: expected a value after it; see {command} --help"
        name = f"{argument.name} (-o)" if "-o" in argument.names else argument.name
        text = (argument.parameter.help or "").strip().splitlines()
        return f"{command}: {name} is missing{': ' + text[0].rstrip('.') if text else ''}; see {command} --help"
    return str(error)


def _told(error: BaseException) -> tuple[int, str]:
    """The exit code of an error, and the line that explains it."""
    if isinstance(error, CycloptsError | InputError):
        return 2, _usage(error)
    if isinstance(error, NoOpenGLError):
        return 3, str(error)
    if isinstance(error, ShaderError):
        lines = str(error).splitlines()
        first = next((line for line in lines if "error" in line.lower()), lines[0] if lines else "")
        more = f" (and {len(lines) - 1} lines more: GLCLOTH_DEBUG=1 shows them)" if len(lines) > 1 else ""
        return 1, f"a shader does not compile on this driver: {first}{more}"
    if isinstance(error, DriverError):
        return 1, f"{error}; please report it with what `glcloth info` says"
    if isinstance(error, MemoryError):
        return 2, "out of memory; choose a smaller --size, --grid or environment"
    if isinstance(error, BrokenPipeError):
        return 0, ""
    if isinstance(error, KeyboardInterrupt):
        return 130, ""
    if isinstance(error, OSError) and error.filename is not None:
        return 2, f"{error.filename}: {error.strerror}; check the name and its permissions"
    what = " ".join(f"{type(error).__name__}: {error}".split())
    return 1, f"a fault of glcloth, please report it: {what}; GLCLOTH_DEBUG=1 shows where"

"""Headless OpenGL contexts by EGL: device choice, Mesa's software rasteriser as fallback, a clear word when none works."""

from __future__ import annotations

import ctypes
import os
import re
import threading
import weakref
from dataclasses import dataclass
from typing import Any

# PyOpenGL serves the few calls that moderngl lacks (texture buffers); it must look for functions where moderngl does,
# and its per-call error query would stall the pipeline.
os.environ.setdefault("PYOPENGL_PLATFORM", "egl")

import moderngl
import OpenGL

from ..errors import DriverError, InputError, NoOpenGLError

OpenGL.ERROR_CHECKING = False
OpenGL.ERROR_LOGGING = False
OpenGL.CONTEXT_CHECKING = False

MOST_DEVICES = 16  # that are looked for
REQUIRED = 430  # compute shaders and storage buffers: GLSL 4.30


@dataclass(frozen=True)
class Device:
    """One EGL device as `glcloth info` lists it."""

    index: int
    renderer: str
    version: str


_used_by: set[int] = set()  # processes that made a context


def check_process() -> None:
    """Raise InputError in a process that was forked from one that had used OpenGL: there it would hang."""
    if _used_by and os.getpid() not in _used_by:
        raise InputError(
            "this process was forked from one that had used OpenGL, which cannot work in both; start processes by "
            'multiprocessing.get_context("spawn"), or fork before the first Renderer'
        )


class Owner:
    """The process and thread that made something on a context, which is current only there."""

    def __init__(self, what: str):
        self._what, self._process, self._thread = what, os.getpid(), threading.get_ident()

    def check(self) -> None:
        """Raise InputError anywhere else."""
        if os.getpid() != self._process:
            check_process()
        if threading.get_ident() != self._thread:
            raise InputError(
                f"this {self._what} belongs to another thread, as its OpenGL context does; make one in each thread that "
                "renders, and close it there"
            )


def _free(context: Any, process: int) -> None:
    """Free a context that nobody holds any more."""
    if os.getpid() == process:
        context.release()


def create_context(device: int | str | None = None) -> moderngl.Context:
    """Return a headless OpenGL >= 4.3 context.

    Parameters
    ----------
    device : number of an EGL device, or a part of its renderer's name, in any case (`glcloth info` lists them); the first
        of several such; None takes the first that works, the software one last

    Raises InputError for a device that does not exist, NoOpenGLError when nothing works: what was tried and what to
    install.
    """
    check_process()
    tried: list[str] = []
    if device is not None:
        index = _index(device)
        ctx = None if index is None else _try(index, tried)
        if ctx is None:
            raise _no_such_device(device, tried)
        return ctx
    best = None
    for index in range(MOST_DEVICES):
        ctx = _try(index, tried)
        if ctx is None:
            if tried and "no such device" in tried[-1]:
                break
            continue
        if not is_software(ctx):
            if best is not None:
                best.release()
            return ctx
        if best is None:
            best = ctx
        else:
            ctx.release()
    if best is not None:
        best.__enter__()
        return best
    # A broken hardware driver can hide Mesa's software rasteriser; ask for it by name.
    os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"
    ctx = _try(0, tried, "software rendering (LIBGL_ALWAYS_SOFTWARE=1)")
    if ctx is None:
        raise _failure(tried)
    return ctx


def check_errors(ctx: moderngl.Context, what: str) -> None:
    """Raise DriverError for what OpenGL reports since the last call, InputError where its memory is at an end.

    OpenGL leaves a call that it refuses undone and tells only who asks: a picture may be black without a word.
    """
    found: list[str] = []
    while (error := ctx.error) != "GL_NO_ERROR" and len(found) < 8:
        found.append(error)
    if "GL_OUT_OF_MEMORY" in found:
        raise InputError(f"{what}: the memory of the GPU is at an end; choose a smaller --size or fewer triangles")
    if found:
        raise DriverError(
            f"{what}: OpenGL reports {', '.join(dict.fromkeys(found))}, and the result is not to be trusted"
        )


def list_devices() -> list[Device]:
    """Return the EGL devices on which an OpenGL 4.3 context can be made."""
    found = []
    for index in range(MOST_DEVICES):
        ctx = _try(index, [])
        if ctx is not None:
            found.append(Device(index, ctx.info["GL_RENDERER"], ctx.info["GL_VERSION"]))
            ctx.release()
    return found


def _index(device: int | str) -> int | None:
    """The number of a device that is named by it or by a part of its renderer's name; None where there is none."""
    text = str(device).strip().lower()
    if re.fullmatch(r"-?\d+", text):
        return int(text) if 0 <= int(text) < MOST_DEVICES else None
    found = [known.index for known in list_devices() if text and text in known.renderer.lower()]
    return found[0] if found else None


def _no_such_device(device: int | str, tried: list[str]) -> Exception:
    """The error that lists the devices there are."""
    if known := list_devices():
        listed = ", ".join(f"{d.index} {d.renderer}" for d in known)
        return InputError(f"--device {device}: no such device; give the number or a part of the name of one: {listed}")
    return _failure(tried or [f"--device {device}: none works"])


def ask_display_for(device: int | str) -> str:
    """Have the windows that this process opens from now on drawn by a device, where its driver lets a program choose:
    Mesa's software, and NVIDIA's beside another GPU. Elsewhere the display chooses.

    device : as for `create_context`

    Returns the name of its renderer, which the window's must have. Raises as `create_context`.
    """
    check_process()
    index = _index(device)
    found = [known.renderer for known in list_devices() if known.index == index]
    if not found:
        raise _no_such_device(device, [])
    if _is_software_name(found[0]):
        os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"
    elif "nvidia" in found[0].lower():
        os.environ |= {"__NV_PRIME_RENDER_OFFLOAD": "1", "__GLX_VENDOR_LIBRARY_NAME": "nvidia"}
    # The last context that was looked at is still current; X refuses the window's beside it.
    ctypes.CDLL("libEGL.so.1").eglReleaseThread()
    return found[0]


def is_software(ctx: moderngl.Context) -> bool:
    """True on a software rasteriser (llvmpipe, softpipe, SwiftShader)."""
    return _is_software_name(ctx.info["GL_RENDERER"])


def _is_software_name(renderer: str) -> bool:
    return any(word in renderer.lower() for word in ("llvmpipe", "softpipe", "swiftshader", "swrast"))


def _try(index: int, tried: list[str], what: str | None = None) -> moderngl.Context | None:
    what = what or f"EGL device {index}"
    try:
        settings: dict[str, Any] = {"backend": "egl", "device_index": index}
        ctx = moderngl.create_context(require=REQUIRED, standalone=True, **settings)
        _used_by.add(os.getpid())
        vars(moderngl)["_store"].default_context = None  # where moderngl would keep it for ever
        # What lives on a context holds it and is held by it, so this happens when Python collects circles.
        weakref.finalize(ctx, _free, ctx.mglo, os.getpid()).atexit = False
        return ctx
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        if "device_index" in reason or "requested device" in reason.lower() or "out of range" in reason.lower():
            reason = f"no such device ({reason})"
        tried.append(f"{what}: {reason}")
        return None


def _failure(tried: list[str]) -> NoOpenGLError:
    return NoOpenGLError(
        "no usable OpenGL 4.3: tried "
        + "; ".join(dict.fromkeys(tried))
        + "; install a driver, or Mesa's software rasteriser: apt-get install libegl1 libgl1 libgl1-mesa-dri"
    )

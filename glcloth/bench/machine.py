"""What this machine is: versions, devices and limits of OpenGL, the cache folder."""

from __future__ import annotations

import importlib.metadata
import platform
import sys

from .. import __version__
from ..files import cache_dir
from ..gpu.context import create_context, is_software, list_devices
from ..picture.ways import known_ways

LIMITS = ("GL_MAX_TEXTURE_SIZE", "GL_MAX_3D_TEXTURE_SIZE", "GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS")
PACKAGES = ("moderngl", "PyOpenGL", "numpy", "scipy", "OpenEXR", "OpenImageIO", "pillow", "cyclopts")


def machine(device: int | str | None = None) -> dict:
    """Versions, GL renderer and limits, devices, cache folder and its size. Raises NoOpenGLError."""
    devices = [f"{d.index}: {d.renderer}, OpenGL {d.version}" for d in list_devices()]
    ctx = create_context(device)
    cache = cache_dir()
    files = [f for f in cache.rglob("*") if f.is_file()] if cache.is_dir() else []
    facts = {
        "glcloth": __version__,
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "packages": {name: importlib.metadata.version(name) for name in PACKAGES},
        "gl_renderer": ctx.info["GL_RENDERER"],
        "gl_version": ctx.info["GL_VERSION"],
        "software": is_software(ctx),
        "limits": {name: ctx.info[name] for name in LIMITS if name in ctx.info},
        "devices": devices,
        "shade": dict(known_ways(ctx)),
        "cache": f"{cache}: {len(files)} files, {sum(f.stat().st_size for f in files) / 1e6:.1f} MB",
    }
    ctx.release()
    return facts

"""Measurements on this machine: what it is, and how long a frame takes by each method."""

from __future__ import annotations

import importlib.metadata
import platform
import statistics
import sys
import time

from . import __version__
from .context import create_context, is_software, list_devices
from .errors import InputError
from .files import cache_dir
from .renderer import METHODS, Renderer
from .scene import Scene

LIMITS = ("GL_MAX_TEXTURE_SIZE", "GL_MAX_3D_TEXTURE_SIZE", "GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS")
PACKAGES = ("moderngl", "PyOpenGL", "numpy", "scipy", "trimesh", "OpenEXR", "OpenImageIO", "pillow", "cyclopts")


def machine(device: int | None = None) -> dict:
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
        "cache": f"{cache}: {len(files)} files, {sum(f.stat().st_size for f in files) / 1e6:.1f} MB",
    }
    ctx.release()
    return facts


def cloth(scene: Scene, methods: list[str], frames: int, device: int | None = None) -> dict:
    """Median frame times of methods on one scene, with ratios; `direct` at each quality and adaptive.

    Raises InputError for an unknown method or fewer than 1 frame.
    """
    if frames < 1:
        raise InputError(f"--frames {frames}: expected at least 1")
    for name in methods:
        if name not in METHODS:
            raise InputError(f"--methods: unknown method {name!r}, expected some of {', '.join(METHODS)}")
    variants = []
    for name in methods:
        if name == "direct":
            variants += [(f"direct_{quality}", {"quality": quality}) for quality in ("draft", "high")]
            variants += [("direct_adaptive", {"adaptive": True}), ("direct", {"adaptive": False})]
        else:
            variants.append((name, {}))
    results: dict[str, dict] = {}
    with Renderer(device) as renderer:
        for label, changes in variants:
            frame = renderer.prepare(scene.changed(method=label.split("_")[0], background=False, **changes))
            small = renderer.prepare(frame.scene.changed(size=(32, 24)), lights=frame.lights)
            renderer.draw(small)  # compiles, and makes tables
            renderer.ctx.finish()
            wall, cpu = [], []
            for _ in range(frames):
                begin, begin_cpu = time.perf_counter(), time.process_time()
                renderer.draw(frame)
                renderer.ctx.finish()
                wall.append(1000 * (time.perf_counter() - begin))
                cpu.append(1000 * (time.process_time() - begin_cpu))
            covered = renderer.covered_pixels()
            method = renderer.method(frame.scene.method)
            ms = statistics.median(wall)
            results[label] = {
                "frame_ms": round(ms, 3),
                "cpu_ms": round(statistics.median(cpu), 3),
                "frames_per_second": round(1000 / ms, 3),
                "covered_pixels": covered,
                "ns_per_pixel": round(1e6 * ms / max(covered, 1), 1),
                "evaluations_per_pixel": method.evaluations_per_pixel(),
            }
        for value in results.values():
            for other in ("paper", "reference"):
                if other in results:
                    value[f"{other}_ratio"] = round(results[other]["frame_ms"] / value["frame_ms"], 3)
        pixels = scene.size[0] * scene.size[1]
        return {
            "methods": results,
            "size": list(scene.size),
            "lobes": len(frame.lights.gaussians),
            "suns": len(frame.lights.suns),
            "fabric": frame.fabric.name,
            "mesh": frame.mesh.name,
            "env": frame.environment.name,
            "coverage": round(covered / pixels, 4),
            "frames": frames,
            "gl_renderer": renderer.ctx.info["GL_RENDERER"],
        }


def cloth_table(result: dict) -> str:
    """The result of `cloth` for a person."""
    head = f"{result['fabric']} on {result['mesh']} in {result['env']}, {result['size'][0]}x{result['size'][1]}, "
    head += f"{100 * result['coverage']:.0f} % covered, K = {result['lobes']}, median of {result['frames']}, "
    lines = [
        head + result["gl_renderer"],
        f"{'method':16}{'ms':>10}{'CPU ms':>10}{'ns/pixel':>10}{'evaluations':>13}{'reference/':>12}",
    ]
    for name, value in result["methods"].items():
        ratio = value.get("reference_ratio")
        lines.append(
            f"{name:16}{value['frame_ms']:10.1f}{value['cpu_ms']:10.1f}{value['ns_per_pixel']:10.0f}"
            f"{value['evaluations_per_pixel']:13.0f}{ratio if ratio is not None else '':>12}"
        )
    return "\n".join(lines)

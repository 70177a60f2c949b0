"""How long a frame of cloth takes on this machine, by each method."""

from __future__ import annotations

import statistics
import time
from dataclasses import replace

import numpy as np

from ..color import luminance
from ..errors import InputError
from ..geometry.mesh import Mesh
from ..methods.registry import METHODS
from ..picture.frame import Frame
from ..picture.renderer import Renderer
from ..progress import track
from ..scene import Scene

SWAY = 0.12  # mean edges
STEP = 0.3  # radians, from pose to pose
POSES = 4  # until all that is seen was seen in motion


def cloth(scene: Scene, methods: list[str], frames: int, device: int | str | None = None) -> dict:
    """Median frame times of methods on one scene, with ratios; `direct` at each quality and adaptive; `direct` and
    `paper` also with shadows (their rest on the cloth is traced before, and told apart).

    Raises InputError for an unknown method or fewer than 1 frame.
    """
    if frames < 1:
        raise InputError(f"--frames {frames}: expected at least 1")
    for name in methods:
        if name not in METHODS:
            raise InputError(f"--methods: unknown method {name!r}, expected some of {', '.join(METHODS)}")
    costs, moving = {}, {}
    with Renderer(device) as renderer:
        prepared: dict[str, Frame] = {}
        for label, changes in _variants(scene, methods):
            frame = renderer.prepare(scene.changed(method=label.split("_")[0], background=False, **changes))
            prepared[label] = frame
            small = renderer.prepare(frame.scene.changed(size=(32, 24)), lights=frame.lights)
            renderer.draw(small)  # compiles, and makes tables
            if frame.scene.shadows == "full" and not costs:
                renderer.draw(frame)
                costs = shadow_costs(renderer, frame, frames)
                moving = moving_cloth(renderer, frame, frames)
                renderer.draw(frame)
        results = _with_ratios(_measured(renderer, prepared, frames))
        covered = results[label]["covered_pixels"]
        return {
            "methods": results,
            "shadows": costs,
            "moving": moving,
            "size": list(scene.size),
            "lobes": len(frame.lights.gaussians),
            "suns": len(frame.lights.suns),
            "fabric": frame.fabric.name,
            "mesh": frame.mesh.name,
            "env": frame.environment.name,
            "coverage": round(covered / (scene.size[0] * scene.size[1]), 4),
            "frames": frames,
            "gl_renderer": renderer.ctx.info["GL_RENDERER"],
        }


def _variants(scene: Scene, methods: list[str]) -> list[tuple[str, dict]]:
    """The variants to measure: their names, which begin with the method's, and their changes of the scene."""
    variants: list[tuple[str, dict]] = []
    for name in methods:
        if name == "direct":
            variants += [(f"direct_{quality}", {"quality": quality}) for quality in ("draft", "high")]
            variants += [("direct_adaptive", {"adaptive": True}), ("direct", {"adaptive": False})]
        else:
            variants.append((name, {}))
    # The reference would trace a ray for each of its directions at every pixel: minutes.
    shadowed = [pair for pair in variants if pair[0] in ("direct", "direct_adaptive", "paper")]
    variants = [(label, {**changes, "shadows": "off"}) for label, changes in variants]
    if scene.shadows == "full":
        variants += [(f"{label}_shadows", {**changes, "shadows": "full"}) for label, changes in shadowed]
    return variants


def _measured(renderer: Renderer, prepared: dict[str, Frame], frames: int) -> dict[str, dict]:
    """Medians of the times of frames; the variants take turns, so that a machine whose speed drifts is alike to all."""
    times: dict[str, list] = {label: [] for label in prepared}
    ways_taken: dict[str, str] = {}
    for label in track([label for _ in range(frames) for label in prepared], "bench: frames"):
        frame = prepared[label]
        if frame.scene.method != "reference":
            renderer.draw(frame)  # a resting cloth keeps this: the pixels' frames and visibility
        renderer.ctx.finish()
        begin, begin_cpu = time.perf_counter(), time.process_time()
        renderer.draw(frame)
        renderer.ctx.finish()
        cpu = 1000 * (time.process_time() - begin_cpu)
        times[label].append((1000 * (time.perf_counter() - begin), cpu))
        covered, ways_taken[label] = renderer.covered_pixels(), renderer.stage.cloths[0].way
    results: dict[str, dict] = {}
    for label, rows in times.items():
        ms, cpu_ms = (statistics.median(column) for column in zip(*rows, strict=True))
        method = renderer.method(prepared[label].scene.method)
        method.prepare(prepared[label].fabric, prepared[label].lights, prepared[label].settings)
        results[label] = {
            "frame_ms": round(ms, 3),
            "cpu_ms": round(cpu_ms, 3),
            "frames_per_second": round(1000 / ms, 3),
            "covered_pixels": covered,
            "ns_per_pixel": round(1e6 * ms / max(covered, 1), 1),
            "evaluations_per_pixel": method.evaluations_per_pixel(),
            "shade": ways_taken[label],
        }
    return results


def _with_ratios(results: dict[str, dict]) -> dict[str, dict]:
    """The results, each with its ratio to the same without shadows, and the ratios of other methods to it."""
    for label, value in results.items():
        bare = results.get(label.removesuffix("_shadows"))
        if bare is not value:
            value["shadows_ratio"] = round(value["cpu_ms"] / bare["cpu_ms"], 3)
    for value in results.values():
        for other in ("paper", "reference"):
            if other in results:
                value[f"{other}_ratio"] = round(results[other]["frame_ms"] / value["frame_ms"], 3)
    return results


def shadow_costs(renderer: Renderer, frame: Frame, times: int) -> dict:
    """Costs of a frame's shadows beside its pixels: placing and tracing once a pose, the means whenever the lights
    turn (median of `times`), rays from the pixels once a view."""
    cloth = renderer.stage.cloths[0]
    vertices, mesh, structure = cloth.visibility.vertices, cloth.mesh, renderer.stage.occluders(frame)

    def measured(work) -> tuple[float, float]:
        renderer.ctx.finish()
        begin, begin_cpu = time.perf_counter(), time.process_time()
        work()
        renderer.ctx.finish()
        return 1000 * (time.perf_counter() - begin), 1000 * (time.process_time() - begin_cpu)

    place = measured(lambda: vertices.start(mesh, structure, frame.mesh))
    fixed = measured(lambda: list(vertices.steps()))
    own = measured(lambda: list(vertices.steps(frame.lights)))
    broad = renderer.method("direct").broad
    broad = broad if len(broad) == len(frame.lights.gaussians) else np.zeros(len(frame.lights.gaussians))
    means = np.median(
        [measured(lambda: vertices.integrate(frame.lights.rotated(np.eye(3)), broad)) for _ in range(times)], 0
    )
    renderer.draw(frame)
    view = renderer.target.part(cloth).view
    view.forget_edges()
    edges = measured(lambda: list(view.edges()))
    count = len(vertices.probes.points)
    return {
        "vertices": len(mesh.positions),
        "rays": count * vertices.share,
        "own_rays": count * (vertices.total(frame.lights) - vertices.share),
        **{
            f"{name}_{kind}": round(float(value), 1)
            for name, pair in (
                ("place", place),
                ("trace", fixed),
                ("trace_own", own),
                ("means", means),
                ("edges", edges),
            )
            for kind, value in zip(("ms", "cpu_ms"), pair, strict=True)
        },
    }


def moving_cloth(renderer: Renderer, frame: Frame, times: int) -> dict:
    """Frames of a cloth that sways by SWAY edges from pose to pose, with shadows that follow and without, in turns: medians
    of `times`; and how far the last picture is from one whose vertices look anew, in % of its mean luminance."""
    off = replace(frame, scene=frame.scene.changed(shadows="off"), settings=replace(frame.settings, shadows="off"))
    shows = {"": (Renderer(ctx=renderer.ctx), frame), "off_": (renderer, off)}
    shows[""][0].follow_poses()
    spent = {name: [] for name in shows}
    for number in range(POSES + times):
        pose = _swayed(frame.mesh, number)
        for name, (one, still) in shows.items():
            renderer.ctx.finish()
            begin, begin_cpu = time.perf_counter(), time.process_time()
            one.draw(still.with_cloth(mesh=pose))
            renderer.ctx.finish()
            spent[name].append((1000 * (time.perf_counter() - begin), 1000 * (time.process_time() - begin_cpu)))
    followed = shows[""][0].gbuffer.read()
    renderer.draw(frame.with_cloth(mesh=pose))
    anew = renderer.gbuffer.read()
    covered = anew[..., 3] > 0
    a, b = (luminance(picture[covered][:, :3]) for picture in (followed, anew))
    result = {"sway_edges": SWAY, "error_percent": round(float(100 * np.abs(a - b).mean() / b.mean()), 2)}
    for name, rows in spent.items():
        for kind, value in zip(("ms", "cpu_ms"), np.median(rows[POSES:], 0), strict=True):
            result[f"{name}{kind}"] = round(float(value), 1)
    return result


def _swayed(mesh: Mesh, number: int) -> Mesh:
    """A pose of a mesh: its points move by about SWAY mean edges from number to number, up to half a turn to and fro."""
    corners = mesh.positions[mesh.triangles[:, :2]].astype(float)
    edge = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).mean()
    phase = 6.0 / mesh.radius * mesh.positions[:, [2, 0, 1]].astype(float)
    # The mean of |d sin| over a step is the mean of |cos| times the step.
    way = SWAY * edge * np.sqrt(np.pi) / STEP * np.sin(phase + STEP * number)
    return replace(mesh, positions=mesh.positions + way / np.sqrt(3))


def cloth_table(result: dict) -> str:
    """The result of `cloth` for a person."""
    head = f"{result['fabric']} on {result['mesh']} in {result['env']}, {result['size'][0]}x{result['size'][1]}, "
    head += f"{100 * result['coverage']:.0f} % covered, K = {result['lobes']}, median of {result['frames']}, "
    lines = [
        head + result["gl_renderer"],
        f"{'method':24}{'ms':>10}{'CPU ms':>10}{'ns/pixel':>10}{'evaluations':>13}{'reference/':>12}{'shadows/':>10}",
    ]
    for name, value in result["methods"].items():
        ratio = value.get("reference_ratio")
        lines.append(
            f"{name:24}{value['frame_ms']:10.1f}{value['cpu_ms']:10.1f}{value['ns_per_pixel']:10.0f}"
            f"{value['evaluations_per_pixel']:13.0f}{ratio if ratio is not None else '':>12}"
            f"{value.get('shadows_ratio', ''):>10}"
        )
    if costs := result["shadows"]:
        lines.append(
            f"shadows of {costs['vertices']} vertices: once a pose {costs['place_ms']:.0f} ms to place probes, "
            f"{costs['trace_ms']:.0f} ms ({costs['trace_cpu_ms']:.0f} CPU) for {costs['rays']} rays; at rest "
            f"{costs['trace_own_ms']:.0f} ms ({costs['trace_own_cpu_ms']:.0f}) for {costs['own_rays']} of narrow Gaussians; "
            f"whenever the lights turn {costs['means_ms']:.1f} ms ({costs['means_cpu_ms']:.1f}); once a view "
            f"{costs['edges_ms']:.0f} ms ({costs['edges_cpu_ms']:.0f}) for rays from pixels"
        )
    if moving := result["moving"]:
        lines.append(
            f"cloth that moves by {moving['sway_edges']} edges a frame: {moving['ms']:.0f} ms ({moving['cpu_ms']:.0f} CPU), "
            f"without shadows {moving['off_ms']:.0f} ({moving['off_cpu_ms']:.0f}); "
            f"{moving['error_percent']:.1f} % from shadows traced anew"
        )
    return "\n".join(lines)

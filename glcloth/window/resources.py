"""Meshes, maps, fits and tables, made beside the window so that it never waits for one."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..fabric import Fabric
from ..geometry.mesh import Mesh
from ..geometry.parts import joined
from ..geometry.props import Objects, arrange, load_solids
from ..light.environment import Environment, load_environment, rotation_y
from ..light.fit_report import FitReport, fit_report, report_on
from ..light.lights import Lights
from ..light.lights_file import load_lights
from ..methods.paper.shapes import shapes_of
from ..methods.paper.tables import tables_for
from ..picture.cloths import load_meshes
from ..place import split_place
from ..scene import Scene
from ..tracing.energy import mean_albedo

KEPT = 4  # results of each kind


@dataclass(frozen=True, eq=False)
class Ready:
    """Everything a scene needs beside itself."""

    fabric: Fabric
    meshes: tuple[Mesh, ...]  # in metres
    environment: Environment
    report: FitReport
    lights: Lights  # turned as the scene says
    objects: Objects  # those around the cloth, or none


class Resources:
    """Loads and computes in one thread of its own; `ask` never waits."""

    def __init__(self):
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="resources")
        self._kinds: dict[str, OrderedDict[Any, Future]] = {}
        self.doing = ""  # the job that the last `ask` waits for, in words

    def close(self) -> None:
        """Drop the jobs that have not begun; a running one ends by itself."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def ask(self, scene: Scene, fabric: Fabric) -> Ready | None:
        """All that a scene needs, or None while something of it is still being made.

        Raises the error of a failed job (InputError for a bad file); asking again then begins anew.
        """
        self.doing = ""
        mesh_key = tuple((name, _stamp(name)) for name in scene.meshes), scene.units
        read = self._get("mesh", mesh_key, lambda: load_meshes(scene.meshes, scene.units), "reading the mesh")
        map_key = (scene.env, _stamp(scene.env), scene.layer, scene.env_layout)
        environment = self._get("env", map_key, lambda: _environment(scene), "reading the environment")
        stamps = tuple((name, _stamp(split_place(name)[0])) for name in scene.objects)
        if read is None or environment is None:
            return None
        meshes, unit = read
        load = lambda: load_solids(scene.objects, unit, scene.units == "auto")  # noqa: E731
        solids_key = stamps, unit, scene.units
        if (solids := self._get("solids", solids_key, load, "reading the objects")) is None:
            return None
        light_key = (scene.lights, _stamp(scene.lights)) if scene.lights else (map_key, scene.lobes)
        if scene.lights:
            given = self._get("given", light_key, lambda: load_lights(scene.lights), "reading the lights")
            make, words = lambda: report_on(environment, given), f"comparing the lights with {environment.name}"
        else:
            given = True
            make = lambda: fit_report(environment, scene.lobes)  # noqa: E731
            words = f"fitting {scene.lobes} lobes to {environment.name}"
        report = None if given is None else self._get("fit", (map_key, *light_key), make, words)
        if report is None:
            return None
        if scene.method == "paper":
            # They land in the cache on disk, where the method finds them.
            key = (shapes_of(fabric), scene.grid, scene.contribution)
            make = lambda: tables_for(fabric, scene.grid, scene.contribution).grid  # noqa: E731
            if self._get("tables", key, make, f"making the tables of {fabric.name}") is None:
                return None
        lights = self._get(
            "lights",
            (map_key, *light_key, scene.env_rotate),
            lambda: report.lights.rotated(rotation_y(scene.env_rotate)),
            "",
            beside=False,
        )
        objects = self._get(
            "objects",
            (mesh_key, solids_key, scene.ground, scene.ground_color),
            lambda: arrange(solids, scene.ground, scene.ground_color, joined(meshes)),
            "",
            beside=False,
        )
        return Ready(fabric, meshes, environment, report, lights, objects)

    def ask_curtain(self, scene: Scene, fabric: Fabric) -> Environment | None:
        """The environment, which the curtain needs beside itself. None while that, or the fabric's albedo (which the
        tracer then finds in its cache), is still being made. Raises as `ask` does."""
        self.doing = ""
        map_key = (scene.env, _stamp(scene.env), scene.layer, scene.env_layout)
        environment = self._get("env", map_key, lambda: _environment(scene), "reading the environment")
        key = fabric.model_dump_json(exclude={"name", "transmission"})
        albedo = self._get("albedo", key, lambda: mean_albedo(fabric), "the fabric's albedo")
        return None if albedo is None else environment

    def _get(self, kind: str, key: Any, make: Callable[[], Any], words: str, beside: bool = True) -> Any:
        found = self._kinds.setdefault(kind, OrderedDict())
        if key not in found:
            if beside:
                found[key] = self._pool.submit(make)
            else:
                found[key] = Future()
                found[key].set_result(make())
            while len(found) > KEPT:
                # A drag asks for many fits; those that nobody waits for any longer are not begun.
                found.popitem(last=False)[1].cancel()
        found.move_to_end(key)
        future = found[key]
        if not future.done():
            self.doing = words
            return None
        try:
            return future.result()
        except BaseException:
            del found[key]
            raise


def _environment(scene: Scene) -> Environment:
    return load_environment(scene.env, scene.layer, scene.env_layout)


def _stamp(name: str) -> float | None:
    """When a file was last changed; None for built-in names."""
    try:
        return Path(name).stat().st_mtime
    except OSError:
        return None

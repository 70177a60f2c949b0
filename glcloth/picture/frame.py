"""From a scene to a frame: files are read and lights are fitted, and the last of each are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..fabric import Fabric, load_fabric
from ..files import is_file
from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..geometry.mesh_files import BUILTIN_MESHES, load_mesh, load_view
from ..geometry.parts import joined
from ..geometry.props import Objects, arrange, load_solids
from ..geometry.smoothed import smoothed
from ..geometry.views import view_by_name
from ..gpu.memo import Last
from ..light.environment import Environment, load_environment, rotation_y
from ..light.fit import fit_lights
from ..light.lights import Lights, SphericalGaussians, as_lights
from ..light.lights_file import load_lights
from ..methods.settings import Settings
from ..place import split_place
from ..scene import MAPS, Scene, View, load_scene
from ..visibility.pixels import is_next_pose
from .cloths import Cloth, Dressing, in_metres, unit_of
from .masks import load_mask
from .openings import load_opacity
from .prints import load_print

MAP_LOADERS: dict[str, Callable[[Any], Any]] = {
    "print": load_print,
    "opacity": load_opacity,
    "fabric_mask": load_mask,
}


@dataclass(frozen=True, eq=False)
class Frame:
    """A scene whose files are read and whose lights are fitted: all that one draw needs.

    Parameters
    ----------
    cloths : at least one
    lights : in world space, the turn of the environment included
    objects : those around the cloths; None: none
    all_cloth : all cloth in one mesh; None: that of the first
    """

    scene: Scene
    cloths: tuple[Cloth, ...]
    environment: Environment
    lights: Lights
    camera: Camera
    settings: Settings
    objects: Objects | None = None
    all_cloth: Mesh | None = None

    @property
    def whole(self) -> Mesh:
        """All cloth in one mesh, to frame it and to stand it on a ground."""
        return self.all_cloth or self.mesh

    @property
    def mesh(self) -> Mesh:
        """The mesh of the first cloth."""
        return self.cloths[0].mesh

    @property
    def fabric(self) -> Fabric:
        """The fabric of the first cloth."""
        return self.cloths[0].fabric

    def moved(self, positions: np.ndarray, cloth: int = 0) -> Frame:
        """The same frame with the vertices of one of its cloths elsewhere, as `Mesh.moved`: camera, lights and objects stay.

        `Renderer.follow_poses` makes the shadows of such frames quicker. Raises InputError as `Mesh.moved`.
        """
        if not 0 <= cloth < len(self.cloths):
            raise InputError(f"cloth {cloth}: this frame has {len(self.cloths)}, counted from 0")
        cloths = list(self.cloths)
        cloths[cloth] = replace(cloths[cloth], mesh=cloths[cloth].mesh.moved(positions))
        return replace(self, cloths=tuple(cloths))

    def with_cloth(self, **changes: Any) -> Frame:
        """The same frame with another mesh or fabric for its first cloth."""
        return replace(self, cloths=(replace(self.cloths[0], **changes), *self.cloths[1:]))


class Frames:
    """Makes frames; each shares its unchanged parts with the last one, so that nothing is done twice."""

    def __init__(self) -> None:
        self.follow = False  # the next mesh with the same triangles is the next pose of a cloth that moves
        self._files: dict[Any, Last] = {}
        self._dressing = Dressing()
        self._metres: Last[tuple[str, tuple[Mesh, ...]]] = Last()  # the unit of the files, and the meshes in metres
        self._smooth: Last[tuple[Mesh, ...]] = Last()
        self._unit = "m"  # of the lengths in the cloths' files, of this frame
        self._whole: Last[Mesh] = Last()
        self._fit: Last[Lights] = Last()
        self._rotated: Last[Lights] = Last()
        self._solids: Last = Last()
        self._objects: Last[Objects] = Last()
        self._pose: Mesh | None = None
        self._first_pose: Mesh | None = None

    def make(
        self,
        scene: Scene | str | None = None,
        *,
        fabric: Fabric | str | Path | None = None,
        mesh: Mesh | str | Path | Sequence[Mesh | str | Path] | None = None,
        cloths: Sequence[Cloth] = (),
        environment: Environment | str | Path | None = None,
        lights: Lights | SphericalGaussians | None = None,
        camera: Camera | View | None = None,
        objects: Objects | None = None,
        **changes: Any,
    ) -> Frame:
        """Read the files of a scene and fit its lights. Parameters as for `Renderer.render`."""
        scene = Scene() if scene is None else load_scene(scene)
        if objects is not None and not isinstance(objects, Objects):
            changes, objects = {**changes, "objects": objects}, None
        if camera is not None and not isinstance(camera, Camera):
            changes, camera = {**changes, "camera": camera}, None
        if isinstance(mesh, str | Path):  # the scene's, whose file may bring cameras
            changes, mesh = {**changes, "mesh": mesh}, None
        scene = scene.changed(**changes) if changes else scene
        if scene.curtain is not None:
            raise InputError("the curtain is traced and has no frame of passes; render it, or take `Renderer.show`")
        self._unit = "m"
        meshes = tuple(one.mesh for one in cloths) or self._meshes(scene, mesh)
        if scene.subdivide and not cloths:
            read, times = meshes, scene.subdivide
            meshes = self._smooth.get(lambda: tuple(smoothed(one, times) for one in read), read, times)
        cloths = tuple(cloths) or self._dressed(scene, meshes, fabric)
        whole = self._whole.get(lambda: joined(meshes), meshes)
        environment = self.environment(environment or scene.env, scene)
        lights = self._lights(scene, environment) if lights is None else as_lights(lights)
        objects = self._arranged(scene, whole) if objects is None else objects
        objects = None if objects is None or objects.empty else objects
        camera = camera or default_camera(whole, scene)
        return Frame(scene, cloths, environment, lights, camera, _settings(scene, environment), objects, whole)

    def _meshes(self, scene: Scene, given: Mesh | str | Sequence[Mesh | str | Path] | None) -> tuple[Mesh, ...]:
        """The meshes of all cloth, in metres: those of a scene, or others."""
        names = scene.meshes if given is None else (given,) if isinstance(given, Mesh | str) else tuple(given)
        if len(meshes := tuple(name for name in names if isinstance(name, Mesh))) == len(names):
            return meshes
        read = [n if isinstance(n, Mesh) else self._loaded(load_mesh, n, i) for i, n in enumerate(names)]
        files = tuple((str(name), mesh) for name, mesh in zip(names, read, strict=True) if not isinstance(name, Mesh))
        self._unit, in_order = self._metres.get(lambda: self._in_metres(files, scene.units), files, scene.units)
        own = iter(in_order)
        return tuple(name if isinstance(name, Mesh) else next(own) for name in names)

    @staticmethod
    def _in_metres(files: Sequence[tuple[str, Mesh]], units: str) -> tuple[str, tuple[Mesh, ...]]:
        names, meshes = [name for name, _ in files], [mesh for _, mesh in files]
        unit = unit_of(names, meshes, units)
        return unit, in_metres(names, meshes, unit)

    def _dressed(self, scene: Scene, meshes: tuple[Mesh, ...], fabric: Fabric | str | Path | None) -> tuple[Cloth, ...]:
        """The cloths of a scene, or ones with another fabric where it names none for a part."""
        of_parts = {part: self.fabric(one) for part, one in scene.fabrics.items()}
        own = self.fabric(scene.fabric if fabric is None else fabric)
        maps = [self._maps(scene, field, load) for field, load in MAP_LOADERS.items()]
        return self._dressing.dress(meshes, own, of_parts, scene.uv_scale, *maps)

    def _maps(self, scene: Scene, field: str, load: Callable[[Any], Any]) -> dict[str, Any]:
        """The maps of a field by the parts that have them, "" for the others; the last one of each is kept until it or its
        file changes."""
        of_all = {} if getattr(scene, field) is None else {"": getattr(scene, field)}
        out = {}
        for part, entry in (of_all | getattr(scene, MAPS[field])).items():
            values = tuple(getattr(entry, name) for name in type(entry).model_fields)
            last = self._files.setdefault((load, part), Last())
            out[part] = last.get(partial(load, entry), values, _stamp(entry.file))
        return out

    def _lights(self, scene: Scene, environment: Environment) -> Lights:
        """The lights of a scene, turned with its environment."""
        if scene.lights:
            lights = self._loaded(load_lights, scene.lights)
        else:
            lights = self._fit.get(lambda: fit_lights(environment, scene.lobes), environment, scene.lobes)
        return self._rotated.get(lambda: lights.rotated(rotation_y(scene.env_rotate)), lights, float(scene.env_rotate))

    def _arranged(self, scene: Scene, mesh: Mesh) -> Objects | None:
        """The objects and the ground of a scene, the same ones as long as nothing about them changes."""
        if not scene.objects and scene.ground == "off":
            return None
        unit = self._unit if scene.units == "auto" else scene.units
        stamps = tuple(_stamp(split_place(name)[0]) for name in scene.objects)
        load = lambda: load_solids(scene.objects, unit, scene.units == "auto")  # noqa: E731
        solids = self._solids.get(load, scene.objects, stamps, unit, scene.units)
        # The ground stays where it is while the cloth moves over it.
        if not (self.follow and self._pose is not None and is_next_pose((self._pose,), (mesh,))):
            self._first_pose = mesh
        self._pose = mesh
        look = scene.ground, scene.ground_color
        return self._objects.get(lambda: arrange(solids, *look, mesh), self._first_pose, solids, look)

    def environment(self, name: str | Path | Environment, scene: Scene) -> Environment:
        """The environment of a name or file, read as a scene says; an Environment is itself."""
        if isinstance(name, Environment):
            return name
        how = scene.layer, scene.env_layout
        last = self._files.setdefault(load_environment, Last())
        return last.get(lambda: load_environment(name, *how), name, _stamp(name), how)

    def fabric(self, name: str | Path | Fabric) -> Fabric:
        """The fabric of a name or file; a Fabric is itself."""
        return name if isinstance(name, Fabric) else self._loaded(load_fabric, name, str(name))

    def _loaded(self, load: Callable[[str], Any], name: str | Path, number: int | str = 0) -> Any:
        """The result of `load` for a name or file; the last one of each kind and number is kept until its file changes."""
        return self._files.setdefault((load, number), Last()).get(lambda: load(str(name)), str(name), _stamp(name))


def _stamp(name: str | Path) -> int:
    """When a file changed; 0 where there is no file."""
    path = Path(name)
    return path.stat().st_mtime_ns if is_file(path) else 0


def _settings(scene: Scene, environment: Environment) -> Settings:
    of_scene = {
        field.name: getattr(scene, field.name) for field in fields(Settings) if field.name in Scene.model_fields
    }
    return Settings(**of_scene, environment=environment, rotation=rotation_y(scene.env_rotate))


def default_camera(mesh: Mesh, scene: Scene) -> Camera:
    """The camera of a scene; missing values are chosen so that the mesh fills the picture. Raises InputError for a view that
    neither we nor the mesh's file have."""
    view, aspect = _near(scene.camera, mesh), scene.size[0] / scene.size[1]
    if view.view is None:
        return view.over(mesh_camera(mesh, aspect))
    angle = view.fov_deg or 35.0
    far = any(mesh.origin)
    points = mesh.positions + np.array(mesh.origin) if far else mesh.positions
    named = view_by_name(view.view, points, aspect, angle, view.ortho, scene.meshes[0], mesh.scale)
    if far:
        eye, target = (tuple(np.subtract(point, mesh.origin)) for point in (named.eye, named.target))
        named = replace(named, eye=eye, target=target)
    return view.over(named)


def _near(view: View, mesh: Mesh) -> View:
    """The camera of a scene about a mesh that was moved to the origin."""
    if not any(mesh.origin):
        return view
    points = {name: getattr(view, name) for name in ("eye", "target")}
    moved = {name: tuple(np.subtract(p, mesh.origin).tolist()) for name, p in points.items() if p}
    return view.changed(**moved) if moved else view


def mesh_camera(mesh: Mesh, aspect: float) -> Camera:
    """The camera that shows a mesh well: a chosen one for the built-in meshes, else one that frames its bounds."""
    if mesh.name in BUILTIN_MESHES and (view := load_view(mesh.name)):
        return Camera(**view)
    return Camera.framing(mesh.center, mesh.radius, aspect=aspect)

"""From a scene to a frame: files are read and lights are fitted, and the last of each are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..fabric import Fabric, load_fabric
from ..files import is_file
from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..geometry.mesh_files import BUILTIN_MESHES, load_mesh, load_view
from ..geometry.props import Objects, arrange, load_solids
from ..geometry.views import view_by_name
from ..gpu.memo import Last
from ..light.environment import Environment, load_environment, rotation_y
from ..light.fit import fit_lights
from ..light.lights import Lights, SphericalGaussians, as_lights
from ..light.lights_file import load_lights
from ..methods.settings import Settings
from ..scene import Scene, View, load_scene
from ..visibility.pixels import is_next_pose


@dataclass(frozen=True, eq=False)
class Cloth:
    """One cloth of a frame: a mesh and its fabric."""

    mesh: Mesh
    fabric: Fabric


@dataclass(frozen=True, eq=False)
class Frame:
    """A scene whose files are read and whose lights are fitted: all that one draw needs.

    Parameters
    ----------
    cloths : at least one
    lights : in world space, the turn of the environment included
    objects : those around the cloths; None: none
    """

    scene: Scene
    cloths: tuple[Cloth, ...]
    environment: Environment
    lights: Lights
    camera: Camera
    settings: Settings
    objects: Objects | None = None

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
        self._files: dict[Callable, Last] = {}
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
        fabric: Fabric | str | None = None,
        mesh: Mesh | str | None = None,
        cloths: Sequence[Cloth] = (),
        environment: Environment | str | None = None,
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
        scene = scene.changed(**changes) if changes else scene
        if scene.curtain is not None:
            raise InputError("the curtain is traced and has no frame of passes; render it, or take `Renderer.show`")
        cloths = tuple(cloths) or (self._cloth(scene, mesh, fabric),)
        environment = self.environment(environment or scene.env, scene)
        lights = self._lights(scene, environment) if lights is None else as_lights(lights)
        first = cloths[0].mesh
        objects = self._arranged(scene, first) if objects is None else objects
        objects = None if objects is None or objects.empty else objects
        camera = camera or default_camera(first, scene)
        return Frame(scene, cloths, environment, lights, camera, _settings(scene, environment), objects)

    def _cloth(self, scene: Scene, mesh: Mesh | str | None, fabric: Fabric | str | None) -> Cloth:
        """The cloth of a scene, or one with another mesh or fabric."""
        mesh = mesh if isinstance(mesh, Mesh) else self._loaded(load_mesh, mesh or scene.mesh)
        return Cloth(mesh, self.fabric(scene.fabric if fabric is None else fabric))

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
        solids = self._solids.get(lambda: load_solids(scene.objects), scene.objects, tuple(map(_stamp, scene.objects)))
        # The ground stays where it is while the cloth moves over it.
        if not (self.follow and self._pose is not None and is_next_pose((self._pose,), (mesh,))):
            self._first_pose = mesh
        self._pose = mesh
        look = scene.ground, scene.ground_color
        return self._objects.get(lambda: arrange(solids, *look, mesh), self._first_pose, solids, look)

    def environment(self, name: str | Environment, scene: Scene) -> Environment:
        """The environment of a name or file, read as a scene says; an Environment is itself."""
        if isinstance(name, Environment):
            return name
        how = scene.layer, scene.env_layout
        last = self._files.setdefault(load_environment, Last())
        return last.get(lambda: load_environment(name, *how), name, _stamp(name), how)

    def fabric(self, name: str | Fabric) -> Fabric:
        """The fabric of a name or file; a Fabric is itself."""
        return name if isinstance(name, Fabric) else self._loaded(load_fabric, name)

    def _loaded(self, load: Callable[[str], Any], name: str) -> Any:
        """The result of `load` for a name or file; the last one of each kind is kept until its file changes."""
        return self._files.setdefault(load, Last()).get(lambda: load(name), name, _stamp(name))


def _stamp(name: str) -> int:
    """When a file changed; 0 where there is no file."""
    path = Path(name)
    return path.stat().st_mtime_ns if is_file(path) else 0


def _settings(scene: Scene, environment: Environment) -> Settings:
    return Settings(
        quality=scene.quality,
        segments=scene.segments,
        light=scene.light,
        cube=scene.cube,
        contribution=scene.contribution,
        grid=scene.grid,
        shadows=scene.shadows,
        bounce=scene.bounce,
        environment=environment,
        rotation=rotation_y(scene.env_rotate),
    )


def default_camera(mesh: Mesh, scene: Scene) -> Camera:
    """The camera of a scene; missing values are chosen so that the mesh fills the picture. Raises InputError for a view that
    neither we nor the mesh's file have."""
    view, aspect = _near(scene.camera, mesh), scene.size[0] / scene.size[1]
    if view.view is None:
        return view.over(mesh_camera(mesh, aspect))
    angle = view.fov_deg or 35.0
    far = any(mesh.origin)
    points = mesh.positions + np.array(mesh.origin) if far else mesh.positions
    named = view_by_name(view.view, points, aspect, angle, view.ortho, scene.mesh)
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

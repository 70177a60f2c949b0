"""From options to a scene."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from ..progress import warn
from .scene_options import SceneOptions

if TYPE_CHECKING:
    from ..scene import Scene


def scene_of(name: str | None, options: SceneOptions | None = None, **changes: Any) -> Scene:
    """The scene of a command: a name or file, and the options that were given. Raises InputError."""
    from ..picture.options import with_options
    from ..scene import Scene, load_scene

    given = {} if options is None else {field.name: getattr(options, field.name) for field in fields(options)}
    changes = {key: value for key, value in {**given, **changes}.items() if value is not None}
    scene = with_options(Scene() if name is None else load_scene(name), changes)
    if scene.camera.aperture > 0.0 and scene.spp == 1:
        warn(
            f"aperture {scene.camera.aperture:g}: with one sample per pixel everything is sharp; give --spp 16 or more"
        )
    return scene

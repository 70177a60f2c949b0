"""From options to a scene."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .scene_options import SceneOptions

if TYPE_CHECKING:
    from ..scene import Scene


def scene_of(name: str | None, options: SceneOptions | None = None, **changes: Any) -> Scene:
    """The scene of a command: a name or file, and the options that were given. Raises InputError."""
    from ..scene import CurtainParameters, Scene, load_scene

    given = {} if options is None else {field.name: getattr(options, field.name) for field in fields(options)}
    changes = {key: value for key, value in {**given, **changes}.items() if value is not None}
    scene = load_scene(name) if name else Scene()
    table = {key: changes.pop(key) for key in CurtainParameters.model_fields if key in changes}
    if table and scene.curtain is None:
        raise InputError(f"--{next(iter(table))}: belongs to the curtain; give its scene: glcloth render curtain")
    if table:
        changes["curtain"] = scene.curtain.changed(**table)
    return scene.changed(**changes) if changes else scene

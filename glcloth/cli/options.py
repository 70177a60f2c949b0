"""From options to a scene."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..progress import warn
from .scene_options import SceneOptions

if TYPE_CHECKING:
    from ..scene import Scene, View


def _of_parts(option: str, given: list[str], example: str) -> tuple[str | None, dict[str, str]]:
    """The values of an option that takes VALUE and PART=VALUE; a file with an = in its name is itself."""
    parts = [text.partition("=") for text in given if "=" in text and not Path(text).is_file()]
    plain = [text for text in given if "=" not in text or Path(text).is_file()]
    if len(set(plain)) > 1:
        raise InputError(
            f"--{option} {plain[0]} --{option} {plain[1]}: expected one for all cloth; for a part say PART={plain[1]}"
        )
    for part, _, value in parts:
        if not part or not value:
            raise InputError(f"--{option} {part}={value}: expected PART={option.upper()}, such as {example}")
    return plain[0] if plain else None, {part: value for part, _, value in parts}


def _fabrics(given: list[str], scene: Scene) -> dict[str, Any]:
    """The fields that FABRIC and PART=FABRIC change."""
    of_all, of_parts = _of_parts("fabric", given, "Lining=voile")
    changes: dict[str, Any] = {} if of_all is None else {"fabric": of_all}
    return changes | ({"fabrics": {**scene.fabrics, **of_parts}} if of_parts else {})


def _maps(field: str, changes: dict[str, Any], scene: Scene) -> dict[str, Any]:
    """The fields that FILE and PART=FILE of a map of the cloth change; the other options of that map, which are taken out of
    `changes`, are those of all these files, or of the scene's own."""
    from ..scene import MAPS

    given = changes.pop(field, [])
    look = {
        name: changes.pop(f"{field}_{name}") for name in ("repeat", "unit", "space") if f"{field}_{name}" in changes
    }
    of_all, of_parts = _of_parts(field.replace("_", "-"), given, "Skirt=roses.png")
    own = getattr(scene, field)
    out: dict[str, Any] = {} if of_all is None else {field: {"file": of_all, **look}}
    if of_parts:
        named = {part: {"file": file, **look} for part, file in of_parts.items()}
        out[MAPS[field]] = {**getattr(scene, MAPS[field]), **named}
    if look and not out:
        if own is None:
            option = field.replace("_", "-")
            raise InputError(f"--{option}-{next(iter(look))}: there is no {option}; give --{option} FILE too")
        out[field] = own.changed(**look)
    return out


def scene_of(name: str | None, options: SceneOptions | None = None, **changes: Any) -> Scene:
    """The scene of a command: a name or file, and the options that were given. Raises InputError."""
    from ..scene import MAPS, CurtainParameters, Scene, View, load_scene

    given = {} if options is None else {field.name: getattr(options, field.name) for field in fields(options)}
    changes = {key: value for key, value in {**given, **changes}.items() if value is not None}
    scene = load_scene(name) if name else Scene()
    changes |= _fabrics(changes.pop("fabric", []), scene)
    for field in MAPS:
        changes |= _maps(field, changes, scene)
    table = {key: changes.pop(key) for key in CurtainParameters.model_fields if key in changes}
    if table and scene.curtain is None:
        raise InputError(f"--{next(iter(table))}: belongs to the curtain; give its scene: glcloth render curtain")
    if table:
        changes["curtain"] = scene.curtain.changed(**table)
    look = {key: changes.pop(key) for key in View.model_fields if key in changes}
    if look:
        changes["camera"] = _looked(scene, look)
    scene = scene.changed(**changes) if changes else scene
    if scene.camera.aperture > 0.0 and scene.spp == 1:
        warn(
            f"aperture {scene.camera.aperture:g}: with one sample per pixel everything is sharp; give --spp 16 or more"
        )
    return scene


def _looked(scene: Scene, look: dict[str, Any]) -> View:
    """A camera with the options that were given: a view by name takes the place of the scene's own place, and a bookmark is a
    whole camera."""
    camera = scene.camera
    if (marked := scene.bookmark(look.get("view", ""))) is not None:
        camera = marked
        look = {name: value for name, value in look.items() if name != "view"}
    if "fov_deg" in look and "ortho" in look:
        raise InputError("--fov, --ortho: an angle of view or parallel rays; give one of them")
    gone = (
        {"eye", "target", "up", "focus"} if "view" in look else {"view"} if {"eye", "target"} <= look.keys() else set()
    )
    gone |= {"ortho"} if "fov_deg" in look else {"fov_deg"} if "ortho" in look else set()
    kept = {name: getattr(camera, name) for name in camera.model_fields_set - gone}
    return type(camera).parse({**kept, **look})

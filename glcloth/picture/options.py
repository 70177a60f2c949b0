"""A scene with other values, as options say them: those of the command line, and of a sweep."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import InputError
from ..fields import entries
from ..scene import MAPS, CurtainParameters, FabricMaskMap, OpacityMap, PrintMap, Scene, View

LOOK = ("repeat", "unit", "space")  # how a map lies, each an option of its own behind the map's
OPTIONS = frozenset(e.name for model in (Scene, View, CurtainParameters) for e in entries(model) if e.option) | {
    f"{field}_{name}"
    for field, model in (("print", PrintMap), ("opacity", OpacityMap), ("fabric_mask", FabricMaskMap))
    for name in LOOK
    if name in model.model_fields
}
OWN = (None, "", "auto")  # of options that say how a file is read: as the file itself says
SEVERAL = frozenset(e.name for e in entries(Scene) if e.option and e.repeat)  # in lists


def with_options(scene: Scene, changes: dict[str, Any]) -> Scene:
    """A scene with the values of some of OPTIONS, and of other fields of a scene; those of SEVERAL are lists of words. Raises
    InputError."""
    changes = dict(changes)
    changes |= _fabrics(changes.pop("fabric", []), scene)
    for field in MAPS:
        changes |= _maps(field, changes, scene)
    table = {key: changes.pop(key) for key in CurtainParameters.model_fields if key in changes}
    if table and scene.curtain is None:
        raise InputError(
            f"--{next(iter(table)).replace('_', '-')}: belongs to the curtain; give its scene: glcloth render curtain"
        )
    if table:
        assert scene.curtain is not None
        changes["curtain"] = scene.curtain.changed(**table)
    look = {key: changes.pop(key) for key in View.model_fields if key in changes}
    if look:
        changes["camera"] = _looked(scene, look)
    whole = scene.changed(**changes) if changes else scene
    _check_unread(whole, changes | table)
    return whole


def _check_unread(scene: Scene, changes: dict[str, Any]) -> None:
    """Raise InputError for options that were given, and that nothing reads as the scene is."""
    if scene.method != "path" and (unread := [name for name in ("noise", "denoise") if changes.get(name)]):
        raise InputError(f"--{unread[0]}: of method path; give --method path too, or leave it out")
    unread = [name for name in ("photons", "photon_neighbours") if name in changes]
    if unread and (scene.curtain is None or scene.gi != "photons"):
        raise InputError(f"--{unread[0].replace('_', '-')}: of gi photons; give --gi photons too, or leave it out")
    if changes.get("light") == "map" and scene.method not in ("reference", "path"):
        raise InputError("--light map: of methods reference and path; give --method reference too, or leave it out")
    if (asked := next((name for name in ("layer", "env_layout") if changes.get(name) not in OWN), None)) is not None:
        from ..light.environment import BUILT_IN  # the command line starts without it

        if scene.env in BUILT_IN:
            raise InputError(
                f"--{asked.replace('_', '-')}: of an environment's file, and {scene.env} is built in; give --env FILE too, or "
                "leave it out"
            )
    if changes.get("behind_open") and scene.curtain is not None and not scene.curtain.behind:
        raise InputError("--behind-open: of a second curtain; give --behind FABRIC too, or leave it out")


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
    given = changes.pop(field, [])
    look = {name: changes.pop(f"{field}_{name}") for name in LOOK if f"{field}_{name}" in changes}
    option = field.replace("_", "-")
    of_all, of_parts = _of_parts(option, given, "Skirt=roses.png")
    own = getattr(scene, field)
    out: dict[str, Any] = {} if of_all is None else {field: {"file": of_all, **look}}
    if of_parts:
        named = {part: {"file": file, **look} for part, file in of_parts.items()}
        out[MAPS[field]] = {**getattr(scene, MAPS[field]), **named}
    if look and not out:
        if own is None:
            raise InputError(f"--{option}-{next(iter(look))}: there is no {option}; give --{option} FILE too")
        out[field] = own.changed(**look)
    return out

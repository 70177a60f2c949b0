"""A session as others can use it: files, a command line, a Python script; and the kind of a dropped file."""

from __future__ import annotations

import pprint
import shlex
from pathlib import Path
from typing import Any, Literal

import tomli_w

from ..errors import InputError
from ..fabric import Fabric
from ..fields import entries
from ..files import path_of, read_toml
from ..geometry.mesh_files import MESH_SUFFIXES
from ..image import read_settings
from ..light.lights_file import FORMAT
from ..scene import CurtainParameters, Scene, View
from ..weave.others import SUFFIXES

KINDS = {".hdr": "env", ".png": "scene", ".json": "lights", **dict.fromkeys(MESH_SUFFIXES, "mesh")}
KINDS |= dict.fromkeys(SUFFIXES, "fabric")


def kind_of(path: str | Path) -> Literal["scene", "fabric", "lights", "mesh", "env"]:
    """The kind of a file. Raises InputError when the window cannot open it."""
    path = path_of(path)
    suffix = path.suffix.lower()
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if suffix in KINDS:
        return KINDS[suffix]
    if suffix == ".exr":
        settings = read_settings(path) or {}
        return "scene" if "scene" in settings or "curtain" in settings else "env"
    if suffix == ".toml":
        data = read_toml(path, "a fabric, a scene or lights")
        if data.get("format") == FORMAT:
            return "lights"
        return "fabric" if "yarn" in data or "normalization" in data else "scene"
    raise InputError(
        f"{path}: cannot open {suffix or 'a file without suffix'}, expected .toml (fabric, scene or lights), "
        f".json (lights), {' '.join(SUFFIXES)} (draft), {' '.join(MESH_SUFFIXES)} (mesh), .hdr .exr "
        "(environment), or a picture of ours (.exr .png)"
    )


def at_frame(scene: Scene, frame: int) -> Scene:
    """A scene as it is shown: of the curtain, the frame."""
    return scene if scene.curtain is None else scene.model_copy(update={"frame": frame})


def as_command(scene: Scene, output: str = "picture.png", frame: int = 0) -> str:
    """A shell command that renders the scene; values without an option travel as a scene file in it."""
    data = at_frame(scene, frame).differences()
    table, camera = data.pop("curtain", None), data.pop("camera", {})
    options = {e.name: e.option for model in (Scene, View, CurtainParameters) for e in entries(model)}
    options |= {"frame": "--frame", "fabrics": options["fabric"]}
    edited = any(isinstance(fabric, Fabric) for fabric in (scene.fabric, *scene.fabrics.values()))
    if edited or not all(options[name] for name in (*data, *(table or ()))):
        data |= ({} if table is None else {"curtain": table}) | ({"camera": camera} if camera else {})
        return f"cat > scene.toml <<'END'\n{tomli_w.dumps(data)}END\nglcloth render scene.toml -o {output}\n"
    words = ["glcloth", "render", *(["curtain"] if table is not None else []), "-o", output]
    for name, value in (data | camera | (table or {})).items():
        words += _words(name, options[name], value)
    return shlex.join(words) + "\n"


def _words(name: str, option: str, value: Any) -> list[str]:
    """The words of a command line that give an option a value."""
    if isinstance(value, bool):
        return [option if value else f"--no-{option[2:]}"]
    if name in ("objects", "mesh") and isinstance(value, list):
        return [f"{option}={path}" for path in value]
    if name == "fabrics":
        return [f"--fabric={part}={fabric}" for part, fabric in value.items()]
    if isinstance(value, dict):  # a map of the cloth: its file, and how it lies
        look = (f"{option}-{of}={said}" for of, said in value.items() if of != "file")
        return [f"{option}={value['file']}", *look]
    if name == "size":
        return [option, f"{value[0]}x{value[1]}"]
    return [f"{option}={','.join(f'{v:g}' for v in value) if isinstance(value, list) else value}"]


def as_python(scene: Scene, output: str = "picture.png", frame: int = 0) -> str:
    """A Python script that renders the scene."""
    literal = pprint.pformat(at_frame(scene, frame).differences(), width=100, sort_dicts=False)
    look = "".join(
        f", {name}={getattr(scene, name)!r}"
        for name in ("exposure", "view_transform")
        if getattr(scene, name) != Scene.model_fields[name].default
    )
    if not isinstance(scene.transform, str):
        look = f", exposure={scene.exposure!r}, view_transform=scene.transform"
    return (
        "import glcloth\n\n"
        f"scene = glcloth.Scene.model_validate({literal})\n"
        "with glcloth.Renderer() as renderer:\n"
        "    picture = renderer.render(scene)  # float32 [H, W, 3 or 4], linear Rec. 709\n"
        f"glcloth.write_image({output!r}, picture{look})\n"
    )

"""A session as others can use it: files, a command line, a Python script; and what a dropped file is."""

from __future__ import annotations

import pprint
import shlex
import tomllib
from pathlib import Path
from typing import Literal

import tomli_w

from ..errors import InputError
from ..fabric import Fabric
from ..image import read_settings
from ..scene import Scene, View

MESHES = (".obj", ".ply", ".glb", ".gltf")
# Fields of Scene that are options of `glcloth render`.
_OPTIONS = tuple(name for name in Scene.model_fields if name not in ("camera", "fabric"))


def kind_of(path: str | Path) -> Literal["scene", "fabric", "mesh", "env"]:
    """What a file is to the window. Raises InputError when it is nothing that the window can open."""
    path = Path(path)
    suffix = path.suffix.lower()
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if suffix in MESHES:
        return "mesh"
    if suffix == ".hdr":
        return "env"
    if suffix == ".exr":
        settings = read_settings(path)
        return "scene" if settings and "scene" in settings else "env"
    if suffix == ".png":
        return "scene"
    if suffix == ".toml":
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise InputError(f"{path}: not TOML: {error}") from None
        return "fabric" if "yarn" in data or "normalization" in data else "scene"
    raise InputError(
        f"{path}: cannot open {suffix or 'a file without suffix'}, expected .toml (fabric or scene), "
        f"{' '.join(MESHES)} (mesh), .hdr .exr (environment), or a picture of ours (.exr .png)"
    )


def scene_dict(scene: Scene) -> dict:
    """What differs from the default scene, as plain values; paths made absolute, so that it holds in every folder."""
    plain, base = scene.model_dump(mode="json", exclude_none=True), Scene().model_dump(mode="json", exclude_none=True)
    out = {name: value for name, value in plain.items() if value != base[name]}
    for name in ("fabric", "mesh", "env"):
        value = out.get(name)
        if isinstance(value, str) and Path(value).is_file():
            out[name] = str(Path(value).resolve())
    return out


def as_command(scene: Scene, output: str = "picture.png") -> str:
    """A shell command that renders the scene; an edited fabric or a camera of its own travels as a scene file in it."""
    data = scene_dict(scene)
    if isinstance(scene.fabric, Fabric) or scene.camera != View():
        text = tomli_w.dumps(data)
        return f"cat > scene.toml <<'END'\n{text}END\nglcloth render scene.toml -o {output}\n"
    words = ["glcloth", "render", "-o", output]
    for name, value in data.items():
        option = "--" + name.replace("_", "-")
        if isinstance(value, bool):
            words.append(option if value else f"--no-{name.replace('_', '-')}")
        elif name == "size":
            words += [option, f"{value[0]}x{value[1]}"]
        else:
            words.append(f"{option}={value}")
    return shlex.join(words) + "\n"


def as_python(scene: Scene, output: str = "picture.png") -> str:
    """A Python script that renders the scene."""
    data = scene_dict(scene)
    literal = pprint.pformat(data, width=100, sort_dicts=False)
    look = "".join(
        f", {name}={getattr(scene, name)!r}"
        for name in ("exposure", "view_transform")
        if getattr(scene, name) != Scene.model_fields[name].default
    )
    return (
        "import glcloth\n\n"
        f"scene = glcloth.Scene.model_validate({literal})\n"
        "with glcloth.Renderer() as renderer:\n"
        "    picture = renderer.render(scene)  # float32 [H, W, 3 or 4], linear Rec. 709\n"
        f"glcloth.write_image({output!r}, picture{look})\n"
    )

"""A session as others can use it: files, a command line, a Python script; and what a dropped file is."""

from __future__ import annotations

import pprint
import shlex
import tomllib
from pathlib import Path
from typing import Literal

import tomli_w

from ..curtain.show import CurtainScene
from ..errors import InputError
from ..fabric import Fabric
from ..image import read_settings
from ..light.lights_file import FORMAT
from ..scene import Scene, View

MESHES = (".obj", ".ply", ".glb", ".gltf")
# Fields of CurtainScene that are options of `glcloth render`, and parameters of the curtain itself.
_CURTAIN_OPTIONS = (
    "fabric",
    "env",
    "env_rotate",
    "size",
    "depth",
    "spp",
    "accelerator",
    "room",
    "exposure",
    "view_transform",
)
_CURTAIN_PARAMETERS = ("wind", "fullness")


def kind_of(path: str | Path) -> Literal["scene", "fabric", "lights", "mesh", "env"]:
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
        settings = read_settings(path) or {}
        return "scene" if "scene" in settings or "curtain" in settings else "env"
    if suffix == ".png":
        return "scene"
    if suffix == ".json":
        return "lights"
    if suffix == ".toml":
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise InputError(f"{path}: not TOML: {error}") from None
        if data.get("format") == FORMAT:
            return "lights"
        return "fabric" if "yarn" in data or "normalization" in data else "scene"
    raise InputError(
        f"{path}: cannot open {suffix or 'a file without suffix'}, expected .toml (fabric, scene or lights), "
        f".json (lights), {' '.join(MESHES)} (mesh), .hdr .exr (environment), or a picture of ours (.exr .png)"
    )


def stored(scene: Scene | CurtainScene, frame: int = 0) -> dict:
    """What a picture keeps of the scene that it shows, as `render` writes it; files by their whole path."""
    data = _whole_paths(scene.model_dump(mode="json"))
    return {"scene": data} if isinstance(scene, Scene) else {"curtain": data, "frame": frame}


def _whole_paths(data: dict) -> dict:
    for name in ("fabric", "mesh", "env", "lights", "room"):
        value = data.get(name)
        if isinstance(value, str) and value and Path(value).is_file():
            data[name] = str(Path(value).resolve())
    if data.get("objects"):
        data["objects"] = [str(Path(name).resolve()) if Path(name).is_file() else name for name in data["objects"]]
    return data


def scene_dict(scene: Scene | CurtainScene) -> dict:
    """What differs from the default scene, as plain values; paths made absolute, so that it holds in every folder."""
    plain = scene.model_dump(mode="json", exclude_none=True)
    base = type(scene)().model_dump(mode="json", exclude_none=True)
    out = {name: value for name, value in plain.items() if value != base[name]}
    if isinstance(scene, CurtainScene):
        # The table is what a file is known by.
        changed = {name: value for name, value in plain["curtain"].items() if value != base["curtain"][name]}
        out["curtain"] = changed
    return _whole_paths(out)


def as_command(scene: Scene | CurtainScene, output: str = "picture.png", frame: int = 0) -> str:
    """A shell command that renders the scene; what has no option travels as a scene file in it."""
    data = scene_dict(scene)
    words = ["glcloth", "render", "-o", output]
    if isinstance(scene, CurtainScene):
        words[2:2] = ["curtain"]
        words += ["--frame", str(frame)]
        curtain = data.pop("curtain")
        plain = set(data) <= set(_CURTAIN_OPTIONS) and set(curtain) <= set(_CURTAIN_PARAMETERS)
        plain, data = (
            plain and not isinstance(scene.fabric, Fabric),
            data | (curtain if plain else {"curtain": curtain}),
        )
    else:
        plain = not isinstance(scene.fabric, Fabric) and scene.camera == View()
    if not plain:
        end = f" --frame {frame}" if isinstance(scene, CurtainScene) else ""
        return f"cat > scene.toml <<'END'\n{tomli_w.dumps(data)}END\nglcloth render scene.toml -o {output}{end}\n"
    for name, value in data.items():
        option = "--" + name.replace("_", "-")
        if isinstance(value, bool):
            words.append(option if value else f"--no-{name.replace('_', '-')}")
        elif name == "objects":
            words += [f"--object={path}" for path in value]
        elif name == "ground_color":
            words.append(f"{option}={','.join(f'{v:g}' for v in value)}")
        elif name == "size":
            words += [option, f"{value[0]}x{value[1]}"]
        else:
            words.append(f"{option}={value}")
    return shlex.join(words) + "\n"


def as_python(scene: Scene | CurtainScene, output: str = "picture.png", frame: int = 0) -> str:
    """A Python script that renders the scene."""
    literal = pprint.pformat(scene_dict(scene), width=100, sort_dicts=False)
    look = "".join(
        f", {name}={getattr(scene, name)!r}"
        for name in ("exposure", "view_transform")
        if getattr(scene, name) != type(scene).model_fields[name].default
    )
    if isinstance(scene, CurtainScene):
        return (
            "import glcloth\n"
            "from glcloth.gpu.context import create_context\n"
            "from glcloth.curtain.show import CurtainScene, CurtainShow\n\n"
            f"scene = CurtainScene.model_validate({literal})\n"
            "with CurtainShow(create_context(), scene) as show:\n"
            f"    show.advance({frame})\n"
            "    picture = show.picture()  # float32 [H, W, 3], linear Rec. 709\n"
            f"glcloth.write_image({output!r}, picture{look})\n"
        )
    return (
        "import glcloth\n\n"
        f"scene = glcloth.Scene.model_validate({literal})\n"
        "with glcloth.Renderer() as renderer:\n"
        "    picture = renderer.render(scene)  # float32 [H, W, 3 or 4], linear Rec. 709\n"
        f"glcloth.write_image({output!r}, picture{look})\n"
    )

"""Scenes in files and in the headers of pictures."""

from __future__ import annotations

import os
import shlex
from functools import partial
from pathlib import Path

from .. import __version__
from ..errors import InputError, meant
from ..files import PACKAGE, atomic_write, path_of, read_toml
from .scene import Scene, with_paths

SCENES = PACKAGE / "scenes"


def _is_path(name: str) -> bool:
    """Whether a name is none of the built-in ones, which have neither folder nor suffix, or are a URI (ocio://default)."""
    return "://" not in name and (Path(name).suffix != "" or len(Path(name).parts) > 1)


def _beside(folder: Path, name: str) -> str:
    """A path that a file in `folder` holds."""
    return str(folder / name) if _is_path(name) else name


def _from(folder: Path, name: str) -> str:
    """A path as a file in `folder` holds it: relative to it where it lies below, else whole."""
    if not _is_path(name):
        return name
    path = Path(os.path.realpath(name))
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else str(path)


def builtin_scenes() -> list[str]:
    """Names of the scenes that come with glcloth."""
    return sorted(path.stem for path in SCENES.glob("*.toml"))


def load_scene(name_or_path: str | Path | Scene) -> Scene:
    """Return a built-in scene, one read from a TOML file (its paths are relative to it), or the one that a picture of ours was
    rendered from.

    Raises InputError for an unknown name (with a suggestion), a malformed file, or a picture without a scene in it.
    """
    if isinstance(name_or_path, Scene):
        return name_or_path
    text, path = str(name_or_path), path_of(name_or_path)
    folder = path.parent
    if path.suffix.lower() in (".exr", ".png"):
        return Scene.parse(_of_picture(path), text)
    if path.suffix != ".toml":
        names = builtin_scenes()
        if text not in names and path.is_file():
            raise InputError(
                f"{path}: not a scene, expected .toml, .exr or .png; for a mesh use --mesh, a fabric --fabric, a map --env"
            )
        if text not in names:
            hint = meant(text, names, '; did you mean "{}"?')
            raise InputError(
                f'scene "{text}": not a built-in scene ({", ".join(names)}) and not a .toml, .exr or .png file{hint}'
            )
        path, folder = SCENES / f"{text}.toml", Path()
    data = read_toml(path, "a scene file (.toml)")
    if "yarn" in data:
        raise InputError(f"{path}: a fabric and not a scene; use --fabric {shlex.quote(text)}")
    return Scene.parse(with_paths(data, partial(_beside, folder)), text)


def _of_picture(path: Path) -> dict:
    """The plain values of the scene that a picture keeps."""
    from ..image import read_settings

    settings = read_settings(path) or {}
    if isinstance(settings.get("scene"), dict):
        return settings["scene"]
    if isinstance(settings.get("curtain"), dict):  # as glcloth wrote it before there was one kind of scene
        return {**settings["curtain"], **({"frame": settings["frame"]} if "frame" in settings else {})}
    raise InputError(
        f"{path}: holds no glcloth scene; give a picture that glcloth rendered, or a scene file (.toml); for a map use --env"
    )


def header(scene: Scene) -> dict:
    """The scene as its picture keeps it, for `write_image`; `load_scene` reads it back."""
    return {"glcloth": __version__, "scene": scene.stored()}


def save_scene(path: str | Path, scene: Scene, comment: str = "") -> None:
    """Write a scene file that `load_scene` reads back to an equal Scene, but for how paths are written: they are relative
    to the file, or whole. A comment, a whole line, stands first. Raises InputError if it cannot be written."""
    import tomli_w

    # A curtain that does not say its frame begins in the window where its wind does.
    unsaid = scene.unsaid | ({"frame"} - scene.model_fields_set)
    data = scene.model_dump(mode="json", exclude_none=True, exclude=unsaid)
    data = with_paths(data, partial(_from, Path(os.path.realpath(path_of(path))).parent))
    with atomic_write(path) as temporary:
        temporary.write_text(comment + tomli_w.dumps(data), encoding="utf-8")

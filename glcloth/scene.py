"""A scene: everything that determines a picture, as one frozen value that files, pictures and doors share."""

from __future__ import annotations

import difflib
import math
import shlex
import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, field_validator

from .color import known_transform
from .errors import InputError
from .fabric import Fabric
from .files import PACKAGE, atomic_write
from .image import read_settings

SCENES = PACKAGE / "scenes"
Vec3 = tuple[float, float, float]
Share = Annotated[float, Field(ge=0, le=1)]
ViewTransform = Annotated[str, AfterValidator(known_transform)]


class View(BaseModel):
    """The camera of a scene; what is not given follows from the mesh."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    eye: Vec3 | None = None
    target: Vec3 | None = None
    up: Vec3 = (0.0, 1.0, 0.0)
    fov_deg: Annotated[float, Field(ge=1, le=170)] | None = None


class Scene(BaseModel):
    """What `glcloth render` renders; the fields are the options of that command."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    fabric: str | Fabric = "silk_crepe_de_chine"
    mesh: str = "drape"
    objects: tuple[str, ...] = ()  # meshes that stand about the cloth, matt
    ground: float | Literal["off", "auto"] = "off"  # its height, m; auto: just under the lowest point
    ground_color: tuple[Share, Share, Share] = (0.3, 0.3, 0.3)  # diffuse reflectance, linear
    env: str = "studio"
    env_rotate: float = 0.0
    lobes: int | Literal["auto"] = 10
    lights: str = ""  # a file of lights instead of a fit; the environment is still what stands behind the cloth
    method: Literal["direct", "paper", "reference", "trace"] = "direct"
    quality: Literal["draft", "normal", "high"] = "normal"
    adaptive: bool = False
    light: Literal["sg", "map"] = "sg"
    shadows: Literal["off", "sun", "full"] = "full"
    bounce: bool = True
    segments: Annotated[int, Field(ge=2, le=64)] = 6
    cube: Annotated[int, Field(ge=4, le=128)] = 32
    contribution: Annotated[float, Field(ge=0.5, le=0.9999)] = 0.9
    grid: Annotated[int, Field(ge=8, le=96)] = 48
    spp: Annotated[int, Field(ge=1, le=256)] = 1
    size: tuple[int, int] = (640, 480)
    exposure: Annotated[float, Field(ge=-20, le=20)] = 0.0
    view_transform: ViewTransform = "standard"
    background: bool = True
    camera: View = View()

    @field_validator("size", mode="before")
    @classmethod
    def _size(cls, value):
        if isinstance(value, str):
            parts = value.lower().split("x")
            if len(parts) != 2 or not all(p.isdigit() for p in parts):
                raise ValueError(f"expected WIDTHxHEIGHT such as 640x480, not {value!r}")
            value = tuple(int(p) for p in parts)
        if any(not 1 <= v <= 16384 for v in value):
            raise ValueError(f"expected 1 to 16384 pixels a side, not {value[0]}x{value[1]}")
        if value[0] * value[1] > 2**26:
            raise ValueError(f"expected at most 67 million pixels, not {value[0]}x{value[1]}")
        return value

    @field_validator("objects", mode="before")
    @classmethod
    def _objects(cls, value):
        return (value,) if isinstance(value, str) else value

    @field_validator("ground", mode="before")
    @classmethod
    def _ground(cls, value):
        if isinstance(value, bool):
            return "auto" if value else "off"
        try:
            height = value if value in ("off", "auto") else float(value)
        except (TypeError, ValueError):
            height = math.nan
        if height not in ("off", "auto") and not math.isfinite(height):
            raise ValueError(f"expected a height in metres, auto or off, not {value!r}")
        return height

    @field_validator("ground_color", mode="before")
    @classmethod
    def _ground_color(cls, value):
        if isinstance(value, str):
            value = value.split(",")
        try:
            color = tuple(float(v) for v in value)
        except (TypeError, ValueError):
            color = ()
        if len(color) != 3 or not all(0.0 <= v <= 1.0 for v in color):
            raise ValueError(f"expected R,G,B from 0 to 1 such as 0.3,0.3,0.3, not {_said(value)}")
        return color

    @field_validator("lobes", mode="before")
    @classmethod
    def _lobes(cls, value):
        if isinstance(value, str) and value != "auto":
            if not value.isdigit():
                raise ValueError(f'expected 1 to 64 or "auto", not {value!r}')
            value = int(value)
        if value != "auto" and not 1 <= value <= 64:
            raise ValueError(f'expected 1 to 64 or "auto", not {value}')
        return value

    def changed(self, **changes) -> Scene:
        """The same scene with some fields replaced. Raises InputError for unknown fields and values out of range."""
        return parse_scene({**self.model_dump(exclude_unset=True), **changes}, "scene")


def _said(value) -> str:
    """A value of several as a person wrote it."""
    return ",".join(map(str, value)) if isinstance(value, list | tuple) else str(value)


def parse_scene(data: dict, where: str) -> Scene:
    """Return the Scene of a plain dictionary; `where` names its origin in errors. Raises InputError."""
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        problem = error.errors()[0]
        place = [
            str(part) for part in problem["loc"] if not str(part).startswith(("literal", "function", "constrained"))
        ]
        name = place[0] if place else "scene"
        if problem["type"] == "extra_forbidden":
            close = difflib.get_close_matches(name, list(Scene.model_fields), 1, 0.5)
            hint = f"; did you mean {close[0]}?" if close else f"; known keys: {', '.join(Scene.model_fields)}"
            raise InputError(f"{where}: {name}: unknown key{hint}") from None
        if problem["type"] == "value_error":
            raise InputError(f"{where}: {name}: {problem['ctx']['error']}") from None
        if problem["type"] == "literal_error":
            expected = problem["ctx"]["expected"].replace("'", "")
            raise InputError(f"{where}: {name} = {problem['input']!r}: expected {expected}") from None
        message = problem["msg"][0].lower() + problem["msg"][1:]
        raise InputError(f"{where}: {name} = {problem['input']!r}: {message}") from None


def builtin_scenes() -> list[str]:
    """Names of the scenes that come with glcloth."""
    return sorted(path.stem for path in SCENES.glob("*.toml"))


# Ray traced, with fields of its own: glcloth/curtain/show.py reads it.
CURTAIN = "curtain"


def load_scene(name_or_path: str | Path) -> Scene:
    """Return a built-in scene, one read from a TOML file, or the one that a picture of ours was rendered from.

    Raises InputError for an unknown name (with a suggestion), a malformed file, or a picture without a scene in it.
    """
    text, path = str(name_or_path), Path(name_or_path)
    if path.suffix.lower() in (".exr", ".png"):
        data = read_settings(path)
        if not data or "scene" not in data:
            raise InputError(
                f"{path}: holds no glcloth scene; give a picture that glcloth rendered, or a scene file (.toml); "
                "for a map use --env"
            )
        return parse_scene(data["scene"], text)
    if path.suffix != ".toml":
        names = builtin_scenes()
        if text not in names and path.is_file():
            raise InputError(
                f"{path}: not a scene, expected .toml, .exr or .png; for a mesh use --mesh, a fabric --fabric, a map --env"
            )
        if text not in names:
            names = [*names, CURTAIN]
            close = difflib.get_close_matches(text.lower(), names, 1, 0.4)
            hint = f'; did you mean "{close[0]}"?' if close else ""
            raise InputError(
                f'scene "{text}": not a built-in scene ({", ".join(names)}) and not a .toml, .exr or .png file{hint}'
            )
        path = SCENES / f"{text}.toml"
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; expected a scene file (.toml)") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a text file ({error}); expected a scene file (.toml)") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not TOML: {error}") from None
    if "yarn" in data:
        raise InputError(f"{path}: a fabric and not a scene; use --fabric {shlex.quote(text)}")
    return parse_scene(data, text)


def save_scene(path: str | Path, scene: Scene) -> None:
    """Write a scene file that `load_scene` reads back to an equal Scene. Raises InputError if it cannot be written."""
    import tomli_w

    with atomic_write(path) as temporary:
        temporary.write_text(tomli_w.dumps(scene.model_dump(mode="json", exclude_none=True)), encoding="utf-8")

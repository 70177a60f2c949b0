"""A scene: everything that determines a picture, as one frozen value that files, pictures and doors share.

The description of a field (`about`) serves errors, the window's controls, options of the command line and
docs/scene.md; after a change `python -m glcloth.cli.generate` writes the last two.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Literal

from pydantic import ConfigDict, field_validator, model_serializer, model_validator

from ..color import Transform, is_hex, whole_hex
from ..errors import short
from ..fabric import Fabric
from ..fields import Value, about, entries
from ..files import is_file
from ..ocio import ocio_view
from ..place import FARTHEST, Place, split_place
from .curtain_parameters import CurtainParameters
from .kinds import Share, Vec3, option
from .maps import MAPS, FabricMaskMap, OpacityMap, PrintMap
from .view import Bookmark, View

Kind = Literal["cloth", "curtain"]
MethodName = Literal["direct", "paper", "reference"]  # of cloth under an environment
Quality = Literal["draft", "normal", "high"]
ShadowMode = Literal["off", "sun", "full"]
# Defaults of a curtain's scene: it is traced in a room, before a sky.
CURTAIN = {
    "fabric": "sheer_voile", "env": "sky", "env_rotate": 90.0, "size": (640, 640), "method": "trace", "exposure": 1.5
}  # fmt: skip
cloth, curtain = partial(option, of="cloth"), partial(option, of="curtain")
direct, paper, reference, path = (partial(option, of=method) for method in ("direct", "paper", "reference", "path"))
KINDS = {"cloth": "cloth under an environment", "curtain": "the curtain"}


class Scene(Value):
    """The content of a picture: cloth under an environment, or, with a table `curtain`, a curtain in a room.

    Lengths in metres, +Y up. The curtain's window is in the plane z = 0, the room before it (z > 0), the lamp behind.
    """

    model_config = ConfigDict(title="scene")

    # fmt: off
    fabric: str | Fabric = option(
        "", "built-in fabric, a .toml file or a draft (.wif); PART=FABRIC for a material, group or object alone (* and ? match "
        "any); repeatable", default="silk_crepe_de_chine", file=True, repeat=True)
    fabrics: dict[str, str | Fabric] = cloth(
        "", "a table: PART = FABRIC; a whole name before a pattern, the longer pattern first; \"#rrggbb\" = FABRIC for a "
        "colour of the fabric mask", default_factory=dict,
        option=False, file=True)
    threads: bool = cloth(
        "", "threads where one comes near, of a fabric with a weave", default=True)
    uv_scale: float = cloth(
        "m", "length of a UV unit of the mesh, for the size of threads; 0: measured", default=0.0, ge=0, le=1000)
    mesh: str | tuple[str, ...] = cloth(
        "", "built-in mesh or a file (.obj .ply .glb .gltf .stl .off); repeatable", default="drape", file=True, repeat=True)
    subdivide: int = cloth(
        "", "times that each triangle of the cloth is cut into four on a smooth surface (Loop), for coarse meshes", default=0,
        ge=0, le=4)
    print: PrintMap | None = cloth(
        "", "a picture that the yarns' colours are multiplied by, over the UVs: a table in files; PART=FILE for a part alone; "
        "repeatable", default=None, file=True, repeat=True)
    prints: dict[str, PrintMap] = cloth(
        "", "a table: PART = a table as print", default_factory=dict, option=False, file=True)
    opacity: OpacityMap | None = cloth(
        "", "a picture that says where cloth is, over the UVs: black is open; a table in files; PART=FILE for a part alone; "
        "repeatable", default=None, file=True, repeat=True)
    opacities: dict[str, OpacityMap] = cloth(
        "", "a table: PART = a table as opacity", default_factory=dict, option=False, file=True)
    fabric_mask: FabricMaskMap | None = cloth(
        "", "a picture whose colours say which fabric a place has, over the UVs, with --fabric '#rrggbb=FABRIC' for each colour; "
        "a table in files; PART=FILE for a part alone; repeatable", default=None, file=True, repeat=True)
    fabric_masks: dict[str, FabricMaskMap] = cloth(
        "", "a table: PART = a table as fabric_mask", default_factory=dict, option=False, file=True)
    objects: tuple[str, ...] = cloth(
        "", "mesh that stands by the cloth, in its own colours; behind it @x,y,z,scale,turn (metres, factor, degrees about "
        "+Y), as many as are needed; repeatable", default=(), option="--object", file=True, repeat=True)
    units: Literal["auto", "m", "dm", "cm", "mm", "in"] = cloth(
        "", "of the lengths in mesh files; auto: metres, but for cloth that would be 20 m or more", default="auto")
    ground: float | Literal["off", "auto", "catcher"] = cloth(
        "m", "height of a ground; alone or auto: just under the lowest point; catcher: there, but only its shadow is seen; or "
        "off", default="off")
    ground_color: tuple[Share, Share, Share] = cloth(
        "linear Rec. 709", "what the ground reflects, R,G,B", default=(0.3, 0.3, 0.3))
    env: str = option("", "built-in environment or a .hdr or .exr file", default="studio", file=True)
    layer: str = option("", "layer of an OpenEXR environment with several; none: the picture proper", default="")
    env_layout: Literal["auto", "equirect", "cross", "strip", "angular", "mirror"] = option(
        "", "how the environment's picture covers the sphere: cube maps are crosses or strips, balls angular or mirrors",
        default="auto")
    env_rotate: float = option(
        "degrees", "turn the environment about +Y; in the window, drag with the right button", default=0.0,
        slider=(-180.0, 180.0))
    lobes: int | Literal["auto"] = cloth(
        "", "spherical Gaussians fitted to the environment, 1 to 64, or auto", default=10, slider=(1, 64))
    lights: str = cloth(
        "", "file of lights (.json, .toml) instead of a fit; `glcloth env` writes one", default="", file=True)
    method: Literal[MethodName, "path", "trace"] = option(
        "", "how light on the cloth is summed; path: by samples of all its ways, for finished pictures and as the judge; the "
        "curtain is traced (trace, path)", default="direct")
    quality: Quality = direct(
        "", "nodes per light: draft is fastest, high is closest to the reference", default="normal")
    adaptive: bool = direct(
        "", "shade one pixel in four where neighbours are alike; small pictures in the window always do", default=False)
    shade: Literal["auto", "fragment", "compute"] = cloth(
        "", "by which programs pixels are shaded, with the same picture: fragments, as in the papers, compute, or auto: what was "
        "measured as faster on this device", default="auto")
    light: Literal["sg", "map"] = reference("", "the fitted lights, or the map itself (reference, path)", default="sg")
    shadows: ShadowMode = cloth(
        "", "what the cloth hides from itself: nothing, the suns, or all the light", default="full")
    bounce: bool = cloth("", "light from fold to fold; reference: once (with shadows full)", default=True)
    segments: int = paper("", "theta segments per Gaussian; the paper has 6", default=6, ge=2, le=64)
    cube: int = reference("texels", "edge of the cube map whose directions are summed", default=32, ge=4, le=128)
    grid: int = paper("", "directions per axis of the tables; a change makes new ones", default=48, ge=8, le=96)
    contribution: float = paper(
        "", "share of the singular values that tables keep; a change makes new ones", default=0.9, ge=0.5, le=0.9999)
    spp: int = option(
        "", "samples per pixel of a whole picture; path: 1 stands for 64, or with noise for as many as it takes", default=1, ge=1,
        le=1 << 20, slider=(1, 64))
    noise: float = path(
        "%", "stop where the mean standard error of the pixels that show surfaces is so small a share of their mean light, spp "
        "at the latest; 0: never before", default=0.0, ge=0, le=100, slider=(0.0, 5.0))
    denoise: bool = path(
        "", "take what noise is left away, by Open Image Denoise (pip install 'glcloth[denoise]')", default=False)
    size: tuple[int, int] = option("pixels", "WIDTHxHEIGHT", default=(640, 480))
    exposure: float = option(
        "stops", "brightness on screen and in PNG files; EXR files keep the light itself", default=0.0, ge=-20, le=20,
        slider=(-8.0, 8.0))
    view_transform: Literal["standard", "filmic", "neutral", "agx"] = option(
        "", "from light to the screen and PNG files", default="standard")
    ocio: str = option(
        "", "OpenColorIO config (.ocio .ocioz, or built in: ocio://default) whose views take the place of the view transform; "
        "none: $OCIO where that is set and no view transform is said; or off", default="", file=True)
    display: str = option("", "display of the config; none: its default", default="")
    ocio_view: str = option("", "view of that display; none: its default", default="")
    background: bool = cloth("", "show the environment behind the cloth", default=True)
    accelerator: Literal["kdtree", "kdtree_median", "lbvh", "brute"] = curtain(
        "", "what rays are traced through; all give the same picture; median: large nodes cut as in paper B", default="kdtree")
    depth: int = curtain("", "generations of rays: through the cloth and mirrored by it", default=4, ge=1, le=8)
    room: str = curtain("", "OBJ file of the room; none: built in", default="", file=True)
    gi: Literal["off", "radiosity", "photons"] = curtain(
        "", "light around the room: radiosity, of the sky, the curtain and all bounces; photons: the same by photon mapping, for "
        "stills; off: even light", default="radiosity")
    photons: int = curtain(
        "", "photons that begin for each sample of the pixels (gi photons)", default=400_000, ge=1000, le=2_000_000)
    photon_neighbours: int = curtain(
        "", "nearest photons of an estimate in the first sample; later ones take fewer (gi photons)", default=800, ge=8, le=2000)
    spread: bool = curtain(
        "", "blur what is seen through the yarns; needs many samples per pixel", default=False)
    cutoff: float = curtain("", "share of the light below which a ray ends", default=1e-3, ge=0, lt=1, option=False)
    sun: Literal["lamp", "map"] = curtain(
        "", "what shines in: the lamp, or the brightest sun of the environment, a disc far away; where no sun of the map does, "
        "the sky alone", default="lamp")
    lamp_position: Vec3 = curtain(
        "m", "the lamp outside the window, x y z; +y up, the window at z = 0", default=(1.6, 3.6, -5.0), slider=(-12.0, 12.0),
        option=False)
    lamp_intensity: Vec3 = curtain(
        "W/sr", "of the lamp, red green blue", default=(190.0, 176.0, 150.0), slider=(0.0, 1000.0), option=False)
    ambient: Vec3 = curtain(
        "", "even light in the room, red green blue; a scene that says it and no gi has gi off", default=(0.3, 0.3, 0.31),
        slider=(0.0, 2.0), option=False)
    rate: int = curtain("1/s", "frames per second", default=24, ge=1, le=240, option=False)
    frame: int = curtain("", "frame of the moving curtain", default=48, ge=0, le=100_000, option=False)
    camera: View = about("", "the camera, a table", default_factory=View)
    bookmarks: tuple[Bookmark, ...] = about("", "other cameras, tables with name and camera; --view NAME takes one", default=())
    curtain: CurtainParameters | None = about("", "the curtain, a table; with it the scene is the curtain", default=None)
    # fmt: on

    @model_validator(mode="before")
    @classmethod
    def _of_one_kind(cls, data: Any) -> Any:
        """Fill in the defaults of a curtain; refuse fields of the other kind."""
        if not isinstance(data, dict):
            return data
        curtain = data.get("curtain") is not None
        for name in data:
            if not curtain and kind_of(name) == "curtain" and name != "curtain":
                raise ValueError(f"{name}: belongs to the curtain; give its scene: glcloth render curtain")
            if curtain and kind_of(name) == "cloth":
                raise ValueError(f"{name}: belongs to {KINDS['cloth']}, and this is the curtain; leave it out")
        if not curtain:
            return data
        even = {"gi": "off"} if "ambient" in data else {}  # who says how bright even light is, wants it
        return {**CURTAIN, **even, **data}

    @model_validator(mode="after")
    def _in_its_way(self):
        if self.method != "path" and (self.method == "trace") != (self.curtain is not None):
            raise ValueError(
                f"method {self.method}: the curtain is ray traced, expected trace or path" if self.curtain is not None else
                "method trace: renders the curtain; give its scene: glcloth render curtain"
            )  # fmt: skip
        most = 4096 if self.curtain is not None else 256
        if self.spp > most and self.method != "path":
            raise ValueError(f"spp = {self.spp}: expected at most 256 (the curtain: 4096, method path: 1048576)")
        return self

    @model_serializer(mode="wrap")
    def _own_fields(self, dump) -> dict:
        return {name: value for name, value in dump(self).items() if kind_of(name) in ("", self.kind)}

    @field_validator("size", mode="before")
    @classmethod
    def _size(cls, value):
        if isinstance(value, str):
            parts = value.lower().split("x")
            if len(parts) != 2 or not all(p.isdigit() for p in parts):
                raise ValueError(f"expected WIDTHxHEIGHT such as 640x480, not {short(value)}")
            value = tuple(int(p) for p in parts)
        whole = isinstance(value, list | tuple) and all(isinstance(v, int) and not isinstance(v, bool) for v in value)
        if not whole or len(value) != 2:
            raise ValueError(f"expected two whole numbers such as [640, 480], not {short(value)}")
        if any(not 1 <= v <= 16384 for v in value):
            raise ValueError(f"expected 1 to 16384 pixels a side, not {short(value[0])}x{short(value[1])}")
        if value[0] * value[1] > 2**26:
            raise ValueError(f"expected at most 67 million pixels, not {value[0]}x{value[1]}")
        return value

    @field_validator("objects", mode="before")
    @classmethod
    def _objects(cls, value):
        value = (value,) if isinstance(value, str) else value
        for text in value if isinstance(value, list | tuple) else ():
            if isinstance(text, str):
                Place.of(split_place(text)[1])
        return value

    @field_validator("fabrics", mode="after")
    @classmethod
    def _colors(cls, value):
        # Colours of a mask in one spelling; the last one given counts.
        return {whole_hex(name) if is_hex(name) else name: one for name, one in value.items()}

    @field_validator("print", "opacity", "fabric_mask", mode="before")
    @classmethod
    def _map(cls, value):
        return {"file": value} if isinstance(value, str) else value

    @field_validator("prints", "opacities", "fabric_masks", mode="before")
    @classmethod
    def _maps(cls, value):
        return {part: cls._map(one) for part, one in value.items()} if isinstance(value, dict) else value

    @field_validator("mesh", mode="before")
    @classmethod
    def _meshes(cls, value):
        if isinstance(value, list | tuple) and len(value) < 2:
            if not value:
                raise ValueError("names no mesh; give one, such as drape")
            return value[0]
        return value

    @field_validator("ground", mode="before")
    @classmethod
    def _ground(cls, value):
        if isinstance(value, bool):
            return "auto" if value else "off"
        try:
            height = value if value in ("off", "auto", "catcher") else float(value)
        except (TypeError, ValueError, OverflowError):
            height = math.nan
        if height not in ("off", "auto", "catcher") and not abs(height) <= FARTHEST:
            raise ValueError(f"expected a height in metres, auto, catcher or off, not {short(value)}")
        return height

    @field_validator("ground_color", mode="before")
    @classmethod
    def _ground_color(cls, value):
        if isinstance(value, str):
            value = value.split(",")
        try:
            color = tuple(float(v) for v in value)
        except (TypeError, ValueError, OverflowError):
            color = ()
        if len(color) != 3 or not all(0.0 <= v <= 1.0 for v in color):
            said = ",".join(map(short, value)).replace("'", "") if isinstance(value, list | tuple) else short(value)
            raise ValueError(f"expected R,G,B from 0 to 1 such as 0.3,0.3,0.3, not {said}")
        return color

    @field_validator("lobes", mode="before")
    @classmethod
    def _lobes(cls, value):
        if isinstance(value, str) and value != "auto":
            if not value.isdigit():
                raise ValueError(f'expected 1 to 64 or "auto", not {short(value)}')
            value = int(value)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if value != "auto" and not (number and 1 <= value <= 64):
            raise ValueError(f'expected 1 to 64 or "auto", not {short(value)}')
        return value

    @property
    def transform(self) -> Transform:
        """From light to code values, for `write_image`: the view transform, or a view of an OpenColorIO config. Raises
        InputError for a config, display or view that cannot be."""
        asked = self.ocio or self.display or self.ocio_view
        if self.ocio == "off" or (not asked and "view_transform" in self.model_fields_set):
            return self.view_transform
        return ocio_view(self.ocio, self.display, self.ocio_view) or self.view_transform

    def bookmark(self, name: str) -> View | None:
        """The camera that is kept under a name; None: there is none."""
        return next((one.camera for one in self.bookmarks if one.name == name), None)

    def with_bookmark(self, name: str, camera: View | None) -> tuple[Bookmark, ...]:
        """Its bookmarks with one more, another or (None) one less."""
        if camera is None:
            return tuple(one for one in self.bookmarks if one.name != name)
        new = Bookmark(name=name, camera=camera)
        if self.bookmark(name) is None:
            return (*self.bookmarks, new)
        return tuple(new if one.name == name else one for one in self.bookmarks)

    @property
    def meshes(self) -> tuple[str, ...]:
        """The names and files of all meshes."""
        return (self.mesh,) if isinstance(self.mesh, str) else self.mesh

    @property
    def kind(self) -> Kind:
        """Whether it is cloth under an environment or the curtain."""
        return "cloth" if self.curtain is None else "curtain"

    def files(self) -> set[str]:
        """The names and files that it is made of."""
        found: list[Any] = []
        for entry in entries(type(self)):
            if entry.file:
                value = getattr(self, entry.name)
                found += value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else [value]
        if self.curtain is not None:
            found.append(self.curtain.behind)
        names = (getattr(one, "file", one) for one in found)
        return {split_place(name)[0] for name in names if isinstance(name, str) and name}

    def stored(self) -> dict:
        """Its plain values as a picture keeps them: files by their whole path, so that it renders from any folder."""
        return with_paths(self.model_dump(mode="json", exclude_none=True, exclude=self.unsaid), _whole)

    @property
    def unsaid(self) -> set[str]:
        """Fields that a file must not say where nobody has: how a room is lit, for one that is too large has even light then."""
        light = {"gi", "ambient"}
        return set() if light & self.model_fields_set else light

    def differences(self) -> dict:
        """The plain values that differ from those of a new scene of its kind, as a file or a script holds them."""
        base = Scene() if self.curtain is None else Scene(curtain=CurtainParameters())
        before = base.model_dump(mode="json", exclude_none=True)
        out = {name: value for name, value in self.stored().items() if value != before.get(name)}
        if self.curtain is not None:  # by this table a file is known
            table = self.curtain.model_dump(mode="json")
            out["curtain"] = {name: v for name, v in table.items() if v != before["curtain"].get(name)}
            if "ambient" in out:
                out["gi"] = self.gi
        return out


def kind_of(name: str) -> Kind | Literal[""]:
    """The kind of scene that a field belongs to; "" for a field of both."""
    field = Scene.model_fields.get(name)
    if name == "curtain":
        return "curtain"
    of = field.json_schema_extra["of"] if field is not None and isinstance(field.json_schema_extra, dict) else ""
    return "" if of == "path" else of if of in ("", "curtain") else "cloth"


def with_paths(data: dict, change: Callable[[str], str]) -> dict:
    """Plain values of a scene whose names and files have gone through `change`."""

    def changed(value: Any) -> Any:
        if isinstance(value, list):
            return [changed(part) for part in value]
        if isinstance(value, dict) and isinstance(value.get("file"), str):  # of a ClothMap
            return {**value, "file": change(value["file"])}
        if not isinstance(value, str) or not value:
            return value
        name, place = split_place(value)
        return change(name) + (f"@{place}" if place else "")

    out = dict(data)
    for entry in entries(Scene):
        if entry.file and entry.name in data:
            value = data[entry.name]
            table = entry.name in ("fabrics", *MAPS.values()) and isinstance(value, dict)
            out[entry.name] = {part: changed(v) for part, v in value.items()} if table else changed(value)
    curtain = out.get("curtain")
    if isinstance(curtain, dict) and "behind" in curtain:
        out["curtain"] = {**curtain, "behind": changed(curtain["behind"])}
    return out


def _whole(name: str) -> str:
    return str(Path(name).resolve()) if is_file(name) else name

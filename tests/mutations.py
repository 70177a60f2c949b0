"""Small files of every format that glcloth reads, made here, and ways to damage them: for tests/doors/test_fuzz.py and
tests/measure/fuzz.py."""

import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from glcloth import load_fabric
from glcloth.curtain.room import load_room
from glcloth.errors import InputError
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh, load_solid, save_mesh
from glcloth.image import read_image, write_image
from glcloth.light.environment import load_environment
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.light.lights_file import load_lights, save_lights
from glcloth.methods.paper import tables
from glcloth.picture.frame import Frames
from glcloth.scene import Scene, header, load_scene
from glcloth.weave.wif import load_draft

HUGE = [5000 * "9", "0x" + 5000 * "f"]
NUMBERS = [*"nan inf -inf 1e400 1e39 -1e39 1e-320 0 -1 -0.0 65536 4294967296 1e308".split(), *HUGE]
WORDS = [
    "",
    "\x1b[31mx",
    "\x1b]0;x\x07",
    "\u202ex",
    "a\nb\rc",
    3000 * "x",
    "../../x",
    "\ud800",
    "\0",
    "-",
    "%s{0}",
    "nan",
]
VALUES = [
    "5",
    "-1",
    "true",
    "[]",
    "[1]",
    '["a"]',
    "[[1]]",
    "{}",
    "{a = 1}",
    '""',
    "1979-05-27",
    "'x'",
    2000 * "[",
    "inf",
]
BYTES = [0, 0x7F, 0x80, 0xFF, 0x1B, 0x0A]
LONGS = [0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x10000, 0x7FC00000, 0x7F800000]
KINDS = ("flip", "byte", "long", "cut", "drop", "double", "insert", "number", "word", "value", "line")
NUMBER, WORD, VALUE = rb"-?\d+(?:\.\d+)?(?:e-?\d+)?", rb'"[^"\n]*"', rb"(?<=[=:]) *[^\n]+"


def edit(data: bytes, kind: str, at: float, choice: int) -> bytes:
    """`data` with one fault; `at` from 0 to 1 says where, `choice` which."""
    place = min(int(at * len(data)), len(data) - 1)
    if kind in ("number", "word", "value"):
        pattern, texts = {"number": (NUMBER, NUMBERS), "word": (WORD, WORDS), "value": (VALUE, VALUES)}[kind]
        found = list(re.finditer(pattern, data))
        if not found:
            return data
        match = found[min(int(at * len(found)), len(found) - 1)]
        text = texts[choice % len(texts)].encode("utf-8", "surrogatepass")
        return data[: match.start()] + (b'"' + text + b'"' if kind == "word" else text) + data[match.end() :]
    if kind == "line":
        lines = data.split(b"\n")
        line = lines.pop(min(int(at * len(lines)), len(lines) - 1))
        lines[choice % (len(lines) + 1) : 0] = [line] * (choice % 3)
        return b"\n".join(lines)
    length = 1 + choice % 64
    return {
        "flip": lambda: data[:place] + bytes([data[place] ^ (1 << choice % 8)]) + data[place + 1 :],
        "byte": lambda: data[:place] + bytes([BYTES[choice % len(BYTES)]]) + data[place + 1 :],
        "long": lambda: (
            data[:place] + struct.pack("<>"[choice % 2] + "I", LONGS[choice % len(LONGS)]) + data[place + 4 :]
        ),
        "cut": lambda: data[:place],
        "drop": lambda: data[:place] + data[place + length :],
        "double": lambda: data[: place + length] + data[place:],
        "insert": lambda: data[:place] + NUMBERS[choice % len(NUMBERS)].encode() + data[place:],
    }[kind]()


def damaged(data: bytes, edits: list[tuple[str, float, int]], mend: Callable[[bytes], bytes] | None = None) -> bytes:
    """`data` with several faults; `mend` puts check sums right again, so that the faults reach what is behind them."""
    for one in edits:
        data = edit(data, *one) if data else data
    return data if mend is None else mend(data)


def random_edits(rng) -> list[tuple[str, float, int]]:
    """Edits of a random.Random."""
    return [(rng.choice(KINDS), rng.random(), rng.randrange(1 << 16)) for _ in range(rng.choice((1, 1, 1, 2, 3, 6)))]


def mended_png(data: bytes) -> bytes:
    """A PNG file with right sums of its chunks, as far as they can be told apart."""
    out, place = [data[:8]], 8
    while place + 12 <= len(data):
        (length,) = struct.unpack(">I", data[place : place + 4])
        body = data[place + 4 : place + 8 + length]
        out.append(data[place : place + 4] + body + struct.pack(">I", zlib.crc32(body)))
        place += 12 + length
    return b"".join(out) + data[place:]


class Format(NamedTuple):
    """A format: `make(folder)` returns sound files; `read(path)` reads one as the doors do; `mend` as in `damaged`."""

    make: Callable[[Path], list[Path]]
    read: Callable[[Path], object]
    mend: Callable[[bytes], bytes] | None = None


def _grid(suffix: str) -> Callable[[Path], list[Path]]:
    def make(folder: Path) -> list[Path]:
        x, z = (a.ravel() for a in np.meshgrid(np.linspace(-1, 1, 4), np.linspace(-1, 1, 4)))
        cells = np.array([4 * i + j for i in range(3) for j in range(3)])
        triangles = np.concatenate(
            [np.stack([cells, cells + 4, cells + 1], 1), np.stack([cells + 1, cells + 4, cells + 5], 1)]
        )
        positions = np.stack([x, 0.1 * x * z, z], 1)
        uv = np.stack([x, z], 1)
        return [save_mesh(folder / f"a{suffix}", build_mesh("a", positions, triangles, uv)) or folder / f"a{suffix}"]

    return make


def _obj(folder: Path) -> list[Path]:
    (made,) = _grid(".obj")(folder)
    made.write_text("mtllib a.mtl\nusemtl red\n" + made.read_text())
    (folder / "a.mtl").write_text("newmtl red\nKd 0.5 0.25 0.125\n")
    return [made]


def _mtl(folder: Path) -> list[Path]:
    _obj(folder)
    return [folder / "a.mtl"]


def _stl(folder: Path) -> list[Path]:
    facet = "facet normal 0 1 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
    (folder / "a.stl").write_text(f"solid a\n{facet}endsolid a\n")
    (folder / "b.stl").write_bytes(bytes(80) + struct.pack("<I12fH", 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0))
    return [folder / "a.stl", folder / "b.stl"]


def _scene(folder: Path) -> list[Path]:
    cloth = 'fabric = "linen"\nmesh = "sphere"\nenv = "studio"\nenv_rotate = 30.0\nlobes = 2\nmethod = "direct"\n'
    cloth += 'quality = "draft"\nshadows = "sun"\nsize = [32, 24]\nground = -0.5\nground_color = [0.3, 0.2, 0.1]\n'
    cloth += 'objects = ["plane"]\nspp = 1\nexposure = 0.5\n[camera]\neye = [0.0, 1.0, 3.0]\nfov_deg = 30.0\n'
    curtain = "size = [32, 24]\ndepth = 2\nlamp_position = [1.0, 2.0, -3.0]\nlamp_intensity = [90.0, 90.0, 80.0]\n"
    curtain += (
        '[camera]\ntarget = [0.0, 1.0, 0.0]\n[curtain]\nwidth = 2.0\nquads = [24, 12]\npleats = 2\nheading = "tape"\n'
    )
    (folder / "a.toml").write_text(cloth)
    (folder / "b.toml").write_text(curtain)
    return [folder / "a.toml", folder / "b.toml"]


def _read_scene(path: Path) -> object:
    scene = load_scene(path)
    # The light's fit and the cloth's camera need nothing from the file but names and numbers that are checked by now.
    return scene if scene.curtain is not None or scene.lobes == "auto" or scene.lobes > 4 else FRAMES.make(scene)


FRAMES = Frames()


def _picture(suffix: str) -> Callable[[Path], list[Path]]:
    def make(folder: Path) -> list[Path]:
        array = np.linspace(0, 2, 8 * 4 * 3, dtype=np.float32).reshape(4, 8, 3)
        return [write_image(folder / f"a{suffix}", array, header(Scene(mesh="sphere", lobes=2)))]

    return make


def _read_picture(path: Path) -> object:
    """As an environment and as a scene: both must be heard, whatever the first one says."""
    first = None
    scene = (load_scene,) if path.suffix in (".png", ".exr") else ()
    for read in (load_environment, read_image, *scene):
        try:
            read(path)
        except InputError as error:
            first = first or error
    if first is not None:
        raise first
    return None


def _hdr(folder: Path) -> list[Path]:
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y 4 +X 8\n"
    rows = b"".join(bytes([2, 2, 0, 8]) + 4 * bytes([136, 100 + row]) for row in range(4))
    (folder / "a.hdr").write_bytes(head + bytes([128, 128, 128, 129]) * 32)
    (folder / "b.hdr").write_bytes(head + rows)
    return [folder / "a.hdr", folder / "b.hdr"]


def _jpg(folder: Path) -> list[Path]:
    Image.fromarray(np.arange(4 * 8 * 3, dtype=np.uint8).reshape(4, 8, 3)).save(folder / "a.jpg")
    return [folder / "a.jpg"]


def _fabric(folder: Path) -> list[Path]:
    source = Path(load_fabric.__code__.co_filename).parent / "fabrics"
    out = []
    for name in ("linen", "sheer_voile", "velvet", "silk_shot"):
        out.append(folder / f"{name}.toml")
        out[-1].write_bytes((source / f"{name}.toml").read_bytes())
    return out


def _read_fabric(path: Path) -> object:
    fabric = load_fabric(path)
    assert np.isfinite(fabric.weights).all() and all(np.isfinite(t.tilt) for t in fabric.tangents)
    return fabric


def _wif(folder: Path) -> list[Path]:
    text = "[WIF]\nVersion=1.1\n[CONTENTS]\nWEAVING=true\nWARP=true\nWEFT=true\nTIEUP=true\nTHREADING=true\nTREADLING=true\n"
    text += "COLOR TABLE=true\n[WEAVING]\nShafts=2\nTreadles=2\n[WARP]\nThreads=4\nColor=1\nSpacing=0.05\nUnits=centimeters\n"
    text += "[WEFT]\nThreads=4\nColor=2\nSpacing=0.05\n[COLOR PALETTE]\nEntries=2\nRange=0,255\n[COLOR TABLE]\n1=9,0,0\n2=0,0,9\n"
    text += "[THREADING]\n1=1\n2=2\n3=1\n4=2\n[TIEUP]\n1=1\n2=2\n[TREADLING]\n1=1\n2=2\n3=1\n4=2\n[TEXT]\nTitle=a\n"
    (folder / "a.wif").write_text(text)
    return [folder / "a.wif"]


def _lights(suffix: str) -> Callable[[Path], list[Path]]:
    def make(folder: Path) -> list[Path]:
        gaussians = SphericalGaussians([[0, 1, 0], [1, 0, 0]], [3.0, 40.0], [[1, 1, 1], [2, 1, 0.5]])
        return [save_lights(folder / f"a{suffix}", Lights(gaussians, Suns([[0, 1, 1]], [[3.0, 3, 2]])))]

    return make


def _tables(folder: Path) -> list[Path]:
    tables.save_tables(folder / "a.npz", tables.compute_tables(load_fabric("linen"), 8, 0.3))
    return [folder / "a.npz"]


def _read_tables(path: Path) -> object:
    """Tables that are not those that were written must not be taken."""
    shapes, _ = tables.shapes_of(load_fabric("linen"))
    found, sound = tables._load(path, len(shapes)), tables._load(path.parent / "sound" / path.name, len(shapes))
    assert sound is not None
    assert found is None or all(
        np.array_equal(a, b) for side in range(3) for x, y in zip(found[side], sound[side], strict=True)
        for a, b in zip(x, y, strict=True)
    )  # fmt: skip
    return found


FORMATS = {
    "scene": Format(_scene, _read_scene),
    "fabric": Format(_fabric, _read_fabric),
    "wif": Format(_wif, load_draft),
    "lights.json": Format(_lights(".json"), load_lights),
    "lights.toml": Format(_lights(".toml"), load_lights),
    "png": Format(_picture(".png"), _read_picture, mended_png),
    "exr": Format(_picture(".exr"), _read_picture),
    "hdr": Format(_hdr, _read_picture),
    "jpg": Format(_jpg, _read_picture),
    "obj": Format(_obj, load_mesh),
    "obj object": Format(_obj, load_solid),
    "mtl": Format(_mtl, lambda path: load_room(path.with_suffix(".obj"))),
    "ply": Format(_grid(".ply"), load_solid),
    "glb": Format(_grid(".glb"), load_solid),
    "stl": Format(_stl, load_mesh),
    "tables": Format(_tables, _read_tables),
}


def corpus(name: str, folder: Path) -> list[Path]:
    """Sound files of a format, in folder/sound; those that are read from lie in the folder beside it."""
    sound = folder / "sound"
    sound.mkdir(parents=True, exist_ok=True)
    made = FORMATS[name].make(sound)
    for path in sound.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    return made

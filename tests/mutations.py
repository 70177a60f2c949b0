"""Small files of every format that glcloth reads, made here, and ways to damage them: for tests/doors/test_fuzz.py and
tests/measure/fuzz.py."""

import base64
import datetime
import json
import math
import re
import struct
import tomllib
import zipfile
import zlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tomli_w
from PIL import Image

from glcloth.curtain.room import load_room
from glcloth.errors import InputError
from glcloth.fabric import FABRICS, load_fabric
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh, load_solid, save_mesh
from glcloth.image import read_image, write_image
from glcloth.kept import keep, read_kept
from glcloth.light.environment import load_environment
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.light.lights_file import load_lights, save_lights
from glcloth.methods.paper import tables
from glcloth.picture.frame import Frames
from glcloth.picture.masks import load_mask
from glcloth.picture.openings import load_opacity
from glcloth.picture.prints import load_print
from glcloth.scene import FabricMaskMap, OpacityMap, PrintMap, Scene, header, load_scene
from glcloth.weave.named import named_draft
from glcloth.weave.wif import draft_text, load_draft

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
# What a value of a table may become; the text stays TOML or JSON, so that the fault reaches what is behind the parser.
LEAVES: list = [
    *(
        math.nan,
        math.inf,
        -math.inf,
        0,
        -1,
        1,
        2,
        7,
        0.5,
        1e39,
        -1e39,
        1e308,
        1e-320,
        -0.0,
        2**31,
        2**63,
        10**400,
        1e9,
        65536,
    ),
    *(
        True,
        False,
        "",
        "x",
        "nan",
        "1e400",
        "auto",
        "off",
        "linen",
        "m.png",
        "a.toml",
        "#ff0000",
        "#gggggg",
        "1,2,3",
        "nan,0,0",
    ),
    *(
        "/dev/zero",
        "/dev/full",
        "/",
        ".",
        "..",
        "../../x.png",
        "sky@1,2",
        "m.png@nan,0,0",
        "*",
        "?",
        "[",
        "1x1",
        "plane@0,0,0,1,1,1",
    ),
    *(word for word in WORDS if "\ud800" not in word),
    *(
        [],
        [1],
        ["a"],
        [[1]],
        {},
        {"a": 1},
        [0, 0, 0],
        [-1, -1, -1],
        [math.nan] * 3,
        [1e39] * 3,
        [math.inf, 0, 0],
        999 * [1],
    ),
    *(
        [1, 2],
        [1, 2, 3, 4],
        [[0, 1], [1, 0]],
        [True, False],
        {"file": "m.png"},
        {"file": 5},
        {"": 1},
        datetime.date(1979, 5, 27),
    ),
]
KINDS = ("leaf", "flip", "byte", "long", "cut", "drop", "double", "insert", "number", "word", "value", "line")
NUMBER, WORD, VALUE = rb"-?\d+(?:\.\d+)?(?:e-?\d+)?", rb'"[^"\n]*"', rb"(?<=[=:]) *[^\n]+"


def edit(data: bytes, kind: str, at: float, choice: int) -> bytes:
    """`data` with one fault; `at` from 0 to 1 says where, `choice` which."""
    place = min(int(at * len(data)), len(data) - 1)
    if kind == "leaf":
        return _other_leaf(data, at, choice)
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


def _other_leaf(data: bytes, at: float, choice: int) -> bytes:
    """A TOML or JSON text with another value in one place, or one key less, or under another name; other data as they are."""
    try:
        tree, back = tomllib.loads(data.decode()), tomli_w.dumps
    except (ValueError, RecursionError):
        try:
            tree, back = json.loads(data), partial(json.dumps, default=str)
        except (ValueError, RecursionError):
            return data
    places = list(_places(tree))
    if not places:
        return data
    parent, key = places[min(int(at * len(places)), len(places) - 1)]
    way, choice = choice % 8, choice // 8
    value = parent[key]
    names = [name for _, name in places if isinstance(name, str)] or ["a"]
    if way == 0:
        del parent[key]
    elif way == 1 and isinstance(parent, dict):
        parent[names[choice % len(names)]] = value
    elif way == 2 and type(value) in (int, float):
        parent[key] = value * (-1, 2, 10, 0.1, 1000, 1e6)[choice % 6]
    else:
        parent[key] = LEAVES[choice % len(LEAVES)]
    try:
        return back(tree).encode("utf-8", "surrogatepass")
    except (TypeError, ValueError, RecursionError):
        return data


def _places(tree: object) -> Iterator[tuple]:
    """(table or list, key or number) of every value within a tree."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ():
        yield tree, key
        yield from _places(value)


def damaged(data: bytes, edits: list[tuple[str, float, int]], mend: Callable[[bytes], bytes] | None = None) -> bytes:
    """`data` with several faults; `mend` puts check sums right again, so that the faults reach what is behind them."""
    for one in edits:
        data = edit(data, *one) if data else data
    return data if mend is None else mend(data)


def random_edits(rng, kinds: tuple[str, ...] = KINDS) -> list[tuple[str, float, int]]:
    """Edits of a random.Random."""
    return [(rng.choice(kinds), rng.random(), rng.randrange(1 << 16)) for _ in range(rng.choice((1, 1, 1, 2, 3, 6)))]


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
    """A format: `make(folder)` returns sound files; `read(path)` reads one as the doors do; `mend` as in `damaged`; `tree`: it is
    TOML or JSON."""

    make: Callable[[Path], list[Path]]
    read: Callable[[Path], object]
    mend: Callable[[bytes], bytes] | None = None
    tree: bool = False


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


def _read_new_scene(path: Path) -> object:
    """Also what its names mean: fabrics, maps and cameras."""
    scene = load_scene(path)
    if scene.curtain is not None:
        return [load_fabric(one) for one in (scene.fabric, scene.curtain.behind) if one]
    small = scene.subdivide <= 1 and (scene.lobes == 1 or scene.lights)
    return FRAMES.make(scene) if small else scene


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
    out = []
    for name in ("linen", "sheer_voile", "velvet", "silk_shot"):
        out.append(folder / f"{name}.toml")
        out[-1].write_bytes((FABRICS / f"{name}.toml").read_bytes())
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


def _new_scene(folder: Path) -> list[Path]:
    """Of cloth with prints, openings, masks, parts and bookmarks; of a pair of curtains before a third."""
    Image.fromarray(np.uint8([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [9, 9, 9]]])).save(folder / "m.png")
    save_mesh(
        folder / "m.obj", build_mesh("m", [[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[0, 1, 2]], [[0, 0], [1, 0], [0, 1]])
    )
    cloth = 'mesh = "m.obj"\nlobes = 1\nenv = "studio"\nsubdivide = 1\nuv_scale = 0.5\nthreads = true\n'
    cloth += 'shade = "auto"\nnoise = 0.0\n'
    cloth += (
        'units = "m"\nground = "catcher"\nobjects = ["plane@0,0,0.5,1.5,30"]\nenv_layout = "auto"\nsize = [32, 24]\n'
    )
    cloth += '[fabrics]\n"#ff0000" = "linen"\nm = "velvet"\n[print]\nfile = "m.png"\nrepeat = 0.5\nunit = "uv"\n'
    cloth += '[opacities.m]\nfile = "m.png"\nrepeat = 2.0\nunit = "m"\n[fabric_mask]\nfile = "m.png"\n[camera]\nview = "side"\n'
    cloth += '[[bookmarks]]\nname = "near"\n[bookmarks.camera]\neye = [0.0, 1.0, 3.0]\northo = 0.5\naperture = 0.01\n'
    curtain = (
        'fabric = "sheer_voile"\ngi = "photons"\nphotons = 4000\nphoton_neighbours = 100\nsun = "map"\nspread = true\n'
    )
    curtain += (
        'accelerator = "kdtree_median"\nmethod = "trace"\nframe = 3\nambient = [0.1, 0.1, 0.1]\n[curtain]\nopen = 0.5\n'
    )
    curtain += 'behind = "blackout"\nbehind_open = 0.3\nbehind_color = "crimson"\ncolor = [0.1, 0.2, 0.3]\nheading = "pencil"\n'
    curtain += (
        "width = 1.5\ndrop = 1.2\nfullness = 2.0\nbending = 0.0001\nwind = -1.5\nbehind_mass = 0.1\nsettle = 1.0\n"
    )
    (folder / "a.toml").write_text(cloth)
    (folder / "b.toml").write_text(curtain)
    return [folder / "a.toml", folder / "b.toml"]


def _weave(folder: Path) -> list[Path]:
    """Fabrics whose geometry follows from a [weave]: hairs, holes, figures, colours, a curve's tangents."""
    out = []
    for name in ("flannel", "lace", "damask", "tartan", "denim_raw"):
        out.append(folder / f"{name}.toml")
        out[-1].write_bytes((FABRICS / f"{name}.toml").read_bytes())
    return out


def _map(suffix: str) -> Callable[[Path], list[Path]]:
    def make(folder: Path) -> list[Path]:
        codes = np.arange(4 * 8 * 4, dtype=np.uint8).reshape(4, 8, 4)
        path = folder / f"a{suffix}"
        if suffix == ".exr":
            return [write_image(path, codes / 255.0)]
        Image.fromarray(codes if suffix == ".png" else codes[..., :3]).save(path)
        if suffix == ".jpg":
            return [path]
        Image.fromarray(codes[..., 0]).convert("P").save(folder / "b.png")
        Image.fromarray(codes[..., 0].astype(np.uint16) * 257).save(folder / "c.png")
        return [path, folder / "b.png", folder / "c.png"]

    return make


def _read_map(path: Path) -> object:
    """As a mask, an opacity and a print: all three must be heard."""
    first = None
    for load, entry in ((load_mask, FabricMaskMap), (load_opacity, OpacityMap), (load_print, PrintMap)):
        try:
            got = load(entry(file=str(path), repeat=0.5, unit="m"))
            values = [v for v in vars(got).values() if isinstance(v, np.ndarray)]
            assert all(np.isfinite(v).all() for v in values)
            if load is load_mask:
                got.numbers(["#ff0000", "#010203"]), got.common()
        except InputError as error:
            first = first or error
    if first is not None:
        raise first
    return None


def _off(folder: Path) -> list[Path]:
    (folder / "a.off").write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n1 0 1\n0 0 1\n3 0 1 2 255 0 0\n3 0 2 3\n")
    return [folder / "a.off"]


def _gltf(folder: Path) -> list[Path]:
    """A GLB's text by itself, with its bytes in it."""
    (glb,) = _grid(".glb")(folder)
    data = glb.read_bytes()
    glb.unlink()
    (length,) = struct.unpack_from("<I", data, 12)
    tree = json.loads(data[20 : 20 + length])
    binary = base64.b64encode(data[28 + length :]).decode()
    tree["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{binary}"
    (folder / "a.gltf").write_text(json.dumps(tree, indent=1))
    return [folder / "a.gltf"]


DTX = "@@StartDTX\n@@Description\nA\n@@Info\n%%ends 4\n%%picks 4\n%%shafts 2\n%%treadles 2\n@@Threading\n1 2 1 2\n@@Tieup\n01\n"
DTX += "10\n@@Treadling\n1 2 1 2\n@@Color Palet\n200,10,10\n20,20,20\n@@Warp Colors\n0 0 0 0\n@@Weft Colors\n1 1 1 1\n@@EndDTX\n"


def _drafts(folder: Path) -> list[Path]:
    """TempoWeave's, and where the extra `drafts` is installed Fiberworks' and WeavePoint's."""
    with zipfile.ZipFile(folder / "a.twa", "w") as archive:
        archive.writestr("twamain.waf", draft_text(named_draft("twill_2_2")))
    out = [folder / "a.twa"]
    try:
        import dtx_to_wif  # noqa: F401
    except ImportError:
        return out
    numbers = lambda *values: struct.pack(">H", len(values)) + bytes(values)  # noqa: E731
    wpo = bytes([123, 7, 101, 10, 4, 4, 0, 0, 0, 40, 20, 0, 0]) + struct.pack(">HH", 4, 4) + bytes(7)
    wpo += numbers(1, 2, 3, 4) + numbers(0, 0, 0, 0) + numbers(1, 1, 1, 1) + bytes([3, 6, 12, 9])
    wpo += numbers(1, 2, 3, 4) + bytes(66) + bytes([2, 255, 0, 0, 0, 0, 255])
    (folder / "b.dtx").write_text(DTX)
    (folder / "c.wpo").write_bytes(wpo)
    return [*out, folder / "b.dtx", folder / "c.wpo"]


def _kept(folder: Path) -> list[Path]:
    keep(folder / "a.npz", np.linspace(0, 1, 60, dtype=np.float32).reshape(4, 5, 3))
    return [folder / "a.npz"]


def _read_kept(path: Path) -> object:
    """What is kept is as it was written, or none."""
    found, sound = (read_kept(one, (4, 5, 3), 10.0) for one in (path, path.parent / "sound" / path.name))
    assert sound is not None and (found is None or np.array_equal(found, sound))
    return found


FORMATS = {
    "scene": Format(_scene, _read_scene, tree=True),
    "fabric": Format(_fabric, _read_fabric, tree=True),
    "wif": Format(_wif, load_draft),
    "lights.json": Format(_lights(".json"), load_lights, tree=True),
    "lights.toml": Format(_lights(".toml"), load_lights, tree=True),
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
    "new scene": Format(_new_scene, _read_new_scene, tree=True),
    "weave": Format(_weave, _read_fabric, tree=True),
    "map png": Format(_map(".png"), _read_map, mended_png),
    "map jpg": Format(_map(".jpg"), _read_map),
    "map exr": Format(_map(".exr"), _read_map),
    "off": Format(_off, load_solid),
    "gltf": Format(_gltf, load_solid, tree=True),
    "drafts": Format(_drafts, load_draft),
    "kept": Format(_kept, _read_kept),
}


def corpus(name: str, folder: Path) -> list[Path]:
    """Sound files of a format, in folder/sound; those that are read from lie in the folder beside it."""
    sound = folder / "sound"
    sound.mkdir(parents=True, exist_ok=True)
    made = FORMATS[name].make(sound)
    for path in sound.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    return made

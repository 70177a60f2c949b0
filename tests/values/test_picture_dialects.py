"""Radiance and OpenEXR pictures as programs write them, and maps of the sphere in other layouts."""

import struct
import tracemalloc

import numpy as np
import OpenEXR
import pytest

from glcloth import progress
from glcloth.errors import InputError
from glcloth.formats.primaries import REC_709, rec709_from
from glcloth.image import read_image
from glcloth.light import equirect
from glcloth.light.environment import load_environment
from glcloth.light.layouts import FACES, STRIP, TALL, WIDE, as_equirect, guessed

RNG = np.random.default_rng(4)
H, W = 6, 16
RGBE = np.concatenate([RNG.integers(2, 256, (H, W, 3)), RNG.integers(120, 136, (H, W, 1))], -1).astype(np.uint8)
RGBE[2, 3:12], RGBE[4] = RGBE[2, 3], RGBE[4, 0]  # something to repeat
RADIANCE = RGBE[..., :3] * 2.0 ** (RGBE[..., 3:].astype(float) - 136)


def new_runs(lines):
    """Each channel by itself: a count above 128 repeats the next byte, another precedes as many."""
    out = b""
    for line in lines:
        out += bytes([2, 2, len(line) >> 8, len(line) & 255])
        for channel in line.T.tolist():
            i = 0
            while i < len(channel):
                n = 1
                while i + n < len(channel) and channel[i + n] == channel[i] and n < 127:
                    n += 1
                if n > 2:
                    out += bytes([128 + n, channel[i]])
                else:
                    n = min(2, len(channel) - i)
                    out += bytes([n, *channel[i : i + n]])
                i += n
    return out


def old_runs(lines):
    """1 1 1 n after a pixel repeats it n times."""
    out, last, times = b"", None, 0
    for pixel in [*lines.reshape(-1, 4).tolist(), None]:
        if pixel == last:
            times += 1
            continue
        while times:
            out += bytes([1, 1, 1, times & 255])
            times >>= 8
        last = pixel
        out += bytes(pixel or [])
    return out


def flat(lines):
    return lines.tobytes()


def hdr(lines=RGBE, body=new_runs, size=None, head="FORMAT=32-bit_rle_rgbe\n", end="\n"):
    size = size or f"-Y {len(lines)} +X {lines.shape[1]}"
    return f"#?RADIANCE\n{head}{end}{size}\n".encode() + body(lines)


def read(tmp_path, blob, name="a.hdr"):
    (tmp_path / name).write_bytes(blob)
    return read_image(tmp_path / name)


SIDE = RGBE.swapaxes(0, 1)
ORIENTATIONS = {
    "-Y 6 +X 16": RGBE, "+Y 6 +X 16": RGBE[::-1], "-Y 6 -X 16": RGBE[:, ::-1], "+Y 6 -X 16": RGBE[::-1, ::-1],
    "+X 16 -Y 6": SIDE, "-X 16 -Y 6": SIDE[::-1], "+X 16 +Y 6": SIDE[:, ::-1], "-X 16 +Y 6": SIDE[::-1, ::-1],
}  # fmt: skip


@pytest.mark.parametrize("body", [new_runs, old_runs, flat])
@pytest.mark.parametrize("size", ORIENTATIONS)
def test_radiance_orientations_and_codes(tmp_path, size, body):
    lines = np.ascontiguousarray(ORIENTATIONS[size])
    body = flat if body is new_runs and lines.shape[1] < 8 else body  # shorter lines have no newer code
    assert np.array_equal(read(tmp_path, hdr(lines, body, size)), RADIANCE.astype("f4"))


@pytest.mark.parametrize(
    "head, scale",
    [
        ("", 1),
        ("# made by a camera\nSOFTWARE=x\n", 1),
        ("FORMAT=32-bit_rle_rgbe\nEXPOSURE=4\nEXPOSURE=0.5\nCOLORCORR=1 2 4\n", (2, 4, 8)),
        ("FORMAT = 32-bit_rle_rgbe\nEXPOSURE= 2.0e+00 \n", 2),
        ("FORMAT=32-bit_rle_rgbe\nPRIMARIES=.64 .33 .30 .60 .15 .06 .3127 .3290\n", 1),
        ("FORMAT=32-bit_rle_rgbe\r\n", 1),
    ],
)
def test_radiance_headers(tmp_path, head, scale):
    got = read(tmp_path, hdr(head=head))
    assert np.allclose(got * np.array(scale), RADIANCE, rtol=1e-6)


def test_radiance_without_an_empty_line_and_of_another_kind(tmp_path):
    assert np.allclose(read(tmp_path, hdr(end="")), RADIANCE, rtol=1e-6)
    grey = np.full((H, W, 4), (128, 128, 128, 129), np.uint8)
    assert np.allclose(read(tmp_path, hdr(grey, head="FORMAT=32-bit_rle_xyze\n")), 1, atol=2e-4), "white stays white"
    assert (
        read(tmp_path, hdr(np.full((H, W, 4), (128, 0, 0, 129), np.uint8), head="FORMAT=32-bit_rle_xyze\n"))[0, 0, 0]
        > 2
    )
    for blob, word in (
        (hdr(head="FORMAT=32-bit_rle_unheard\n"), "its format is"),
        (hdr(size="-Y 6 +Y 16"), "gives no size"),
        (hdr()[:-40], "damaged"),
        (hdr(body=old_runs)[:-9], "damaged"),
        (hdr(body=lambda _: bytes([1, 1, 1, 200]) * 99), "damaged"),
        (b"#?RADIANCE\n" + b"x=y\n" * 99_999, "no end"),
        (hdr(size="-Y 60000 +X 60000"), "at most 134,217,728"),
        (hdr(size="-Y 6000 +X 6000"), "in a file of"),
        (hdr(size="-Y 0 +X 16"), "no pixels"),
    ):
        with pytest.raises(InputError, match=word):
            read(tmp_path, blob)


# -- OpenEXR -------------------------------------------------------------------------------------------------------

HEADER = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
A, B = (RNG.random((4, 8, 3), np.float32) for _ in range(2))


def layered(prefix, pixels):
    return {f"{prefix}.{role}": np.ascontiguousarray(pixels[..., k]) for k, role in enumerate("RGB")}


def write(path, *parts):
    parts = [OpenEXR.Part(HEADER | header, channels) for header, channels in parts]
    with OpenEXR.File(parts) if len(parts) > 1 else OpenEXR.File(parts[0].header, parts[0].channels) as file:
        file.write(str(path))
    return path


LAYERS = {
    "only layers": ([({}, layered("specular", A) | layered("diffuse", B))], B, "layer diffuse is taken", "specular", A),
    "plain and layers": ([({}, {"RGB": B} | layered("diffuse", A))], B, "", "diffuse", A),
    "the beauty second": ([({"name": "albedo"}, {"RGB": A}), ({"name": "beauty"}, {"RGB": B})], B, "layer beauty", "albedo", A),
    "plain in the second part": ([({"name": "a"}, layered("diffuse", A)), ({"name": "b"}, {"RGB": B})], B, "", "diffuse", A),
    "depth, then light": ([({"name": "depth"}, {"Z": A[..., 0]}), ({"name": "x"}, {"RGB": B})], B, "", "x", B),
    "Blender's": ([({}, layered("ViewLayer.Combined", B) | layered("ViewLayer.AO", A))], B, "layer ViewLayer.Combined",
                  "ViewLayer.AO", A),
    "by its last word": ([({}, layered("RenderLayer.Diffuse", A) | layered("RenderLayer.Combined", B))], B, "Combined",
                         "diffuse", A),
}  # fmt: skip


@pytest.mark.parametrize("name", LAYERS)
def test_exr_layers(tmp_path, name, capsys):
    parts, first, said, layer, other = LAYERS[name]
    path = write(tmp_path / "a.exr", *parts)
    progress._warned.clear()
    assert np.array_equal(read_image(path), first)
    errors = capsys.readouterr().err
    assert said in errors and bool(said) == bool(errors)
    assert np.array_equal(read_image(path, layer), other)
    with pytest.raises(InputError, match="has no layer nothing, expected"):
        read_image(path, "nothing")


def test_layers_of_files_that_have_none(tmp_path):
    (tmp_path / "a.hdr").write_bytes(hdr())
    with pytest.raises(InputError, match="only OpenEXR files have layers"):
        read_image(tmp_path / "a.hdr", "diffuse")


# ACES 2065-1 (S-2008-001), ACEScg (S-2014-004), Rec. 2020 (BT.2020-2), Adobe RGB (1998), P3-D65.
AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
ACESCG = (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)
REC_2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)


@pytest.mark.parametrize(
    "primaries, rgb, expected",
    [
        (ACESCG, (0.2, 0.4, 0.9), (0.0174, 0.4208, 0.9813)),
        # ITU-R BT.2087-0 gives this matrix' inverse; red of Rec. 2020 is far outside of Rec. 709.
        (REC_2020, (1, 0, 0), (1.6605, -0.1246, -0.0182)),
        (AP0, (1, 1, 1), (1, 1, 1)),
    ],
)
def test_exr_chromaticities(tmp_path, primaries, rgb, expected, capsys):
    path = write(tmp_path / "a.exr", ({"chromaticities": primaries}, {"RGB": np.tile(np.float32(rgb), (2, 4, 1))}))
    progress._warned.clear()
    assert np.allclose(read_image(path), expected, atol=1e-4)
    assert "Bradford" in capsys.readouterr().err


def test_chromaticities_that_change_nothing(tmp_path, capsys):
    path = write(tmp_path / "a.exr", ({"chromaticities": REC_709}, {"RGB": A}))
    assert np.array_equal(read_image(path), A) and not capsys.readouterr().err
    assert rec709_from((0,) * 8) is None and rec709_from((np.nan,) * 8) is None


def _header_exr(display, data, body=b""):
    """The head of an uncompressed OpenEXR file."""

    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(n + b"\0" + struct.pack("<iIii", 2, 0, 1, 1) for n in (b"B", b"G", b"R")) + b"\0"
    return (
        b"\x76\x2f\x31\x01\x02\0\0\0" + attribute(b"channels", b"chlist", channels)
        + attribute(b"compression", b"compression", b"\0") + attribute(b"lineOrder", b"lineOrder", b"\0")
        + attribute(b"dataWindow", b"box2i", struct.pack("<4i", *data))
        + attribute(b"displayWindow", b"box2i", struct.pack("<4i", *display))
        + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
        + attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
        + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0" + body
    )  # fmt: skip


@pytest.mark.parametrize("display, data", [((0, 0, 29999, 29999), (0, 0, 15, 7)), ((0, 0, 15, 7), (0, 0, 29999, 29999)),
                                           ((0, 0, 8999, 8999), (0, 0, 15, 7))])  # fmt: skip
def test_exr_windows_are_checked_before_they_are_made(tmp_path, display, data):
    rows = b"".join(struct.pack("<ii", y, 16 * 12) + bytes(16 * 12) for y in range(8))
    head = _header_exr(display, data)
    offsets = b"".join(struct.pack("<Q", len(head) + 64 + y * (8 + 192)) for y in range(8))
    (tmp_path / "a.exr").write_bytes(head + offsets + rows)
    tracemalloc.start()
    with pytest.raises(InputError, match="pixels"):
        read_image(tmp_path / "a.exr")
    assert tracemalloc.get_traced_memory()[1] < 2e6
    tracemalloc.stop()


@pytest.mark.parametrize("bits", [1, 16])
def test_a_png_of_gigabytes_is_refused(tmp_path, bits):
    def chunk(kind, data):
        import zlib

        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    kind = 0 if bits == 1 else 2
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", 16, 4_194_312, bits, kind, 0, 0, 0))
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", b"x\x9c") + chunk(b"IEND", b""))
    tracemalloc.start()
    with pytest.raises(InputError, match="16 x 4194312 pixels in a file of"):
        read_image(tmp_path / "a.png")
    assert tracemalloc.get_traced_memory()[1] < 2e6
    tracemalloc.stop()


# -- layouts -------------------------------------------------------------------------------------------------------


def light(omega):
    """A radiance that differs in every direction."""
    x, y, z = np.moveaxis(omega / np.linalg.norm(omega, axis=-1, keepdims=True), -1, 0)
    return np.stack([1 + 0.5 * x + 0.3 * y * z, 1 + 0.8 * y, 1 + 0.9 * z - 0.2 * x], -1).astype("f4")


N = 32
_c = (np.arange(N) + 0.5) / N * 2 - 1
_t, _s = np.meshgrid(_c, _c, indexing="ij")


def face(name):
    return light(np.stack([np.ones_like(_s), _s, _t], -1) @ np.array(FACES[name], float).T)


def cross(cells):
    rows, columns = np.array(list(cells.values())).max(0) + 1
    picture = np.zeros((rows * N, columns * N, 3), "f4")
    for name, (row, column) in cells.items():
        picture[row * N : (row + 1) * N, column * N : (column + 1) * N] = face(name)
    return picture


def ball(angle_of_radius):
    c = (np.arange(2 * N) + 0.5) / N - 1
    x, y = np.meshgrid(c, -c)
    r = np.hypot(x, y)
    angle = angle_of_radius(np.minimum(r, 1))
    omega = np.stack([-x * np.sin(angle) / r, y * np.sin(angle) / r, np.cos(angle)], -1)
    return np.where(r[..., None] <= 1, light(omega), 0).astype("f4")


MAPS = {
    "strip across": (np.concatenate([face(name) for name in STRIP], 1), "strip"),
    "strip down": (np.concatenate([face(name) for name in STRIP], 0), "strip"),
    "wide cross": (cross(WIDE), "cross"),
    "tall cross": (cross(TALL), "cross"),
    "angular": (ball(lambda r: np.pi * r), "angular"),
    "mirror": (ball(lambda r: 2 * np.arcsin(r)), "mirror"),
}


@pytest.mark.parametrize("name", MAPS)
def test_other_layouts_show_the_same_light(name):
    picture, layout = MAPS[name]
    if layout != "mirror":  # a mirror ball looks like an angular map
        assert guessed(picture) == layout
    got = as_equirect(picture, layout, "a")
    height = len(got)
    expected = light(equirect.texel_directions(height, 2 * height))
    error = np.abs(got - expected)
    # All that lies behind a mirror ball is in its rim.
    front = equirect.texel_directions(height, 2 * height)[..., 2] > (-0.8 if layout == "mirror" else -1)
    assert error[front].max() < (0.005 if layout in ("strip", "cross") else 0.05) and error[front].mean() < 0.004
    if layout != "mirror":
        assert np.allclose(equirect.total(got), equirect.total(expected), rtol=2e-3)


@pytest.mark.parametrize("cells", [WIDE, TALL], ids=["wide", "tall"])
def test_faces_of_crosses_meet_at_their_edges(cells):
    """A natural picture: across an edge between two squares the light goes on as within them."""
    picture, used = cross(cells), np.zeros((4, 4), bool)
    for row, column in cells.values():
        used[row, column] = True
    step = np.abs(np.diff(picture[N // 2 : N + N // 2, N + N // 2], axis=0)).max()
    for row, column in cells.values():
        y, x = row * N, column * N
        if row and used[row - 1, column]:
            assert np.abs(picture[y, x : x + N] - picture[y - 1, x : x + N]).max() < 2 * step
        if column and used[row, column - 1]:
            assert np.abs(picture[y : y + N, x] - picture[y : y + N, x - 1]).max() < 2 * step


def test_openexr_says_which_face_is_which(tmp_path, capsys):
    """The six faces of ImfEnvmap.h, +x -x +y -y +z -z, one below the other."""
    colors = np.arange(1, 19, dtype="f4").reshape(6, 1, 1, 3)
    strip = np.broadcast_to(colors, (6, 8, 8, 3)).reshape(48, 8, 3)
    environment = load_environment(write(tmp_path / "cube.exr", ({}, {"RGB": np.ascontiguousarray(strip)})))
    for axis, color in zip([*np.eye(3)[:1], -np.eye(3)[0], *np.eye(3)[1:2], -np.eye(3)[1], np.eye(3)[2], -np.eye(3)[2]],
                           colors[:, 0, 0], strict=True):  # fmt: skip
        assert np.allclose(equirect.lookup(environment.radiance, axis), color)
    assert "layout strip" in capsys.readouterr().err
    assert load_environment(tmp_path / "cube.exr", layout="equirect").radiance.shape == (48, 8, 3)


def test_ordinary_pictures_are_not_taken_for_crosses(tmp_path):
    photograph = RNG.random((48, 64, 3), np.float32)
    assert guessed(photograph) == "equirect" and guessed(photograph[:, :48]) == "equirect"
    assert guessed(RNG.random((32, 64, 3), np.float32)) == "equirect"
    path = write(tmp_path / "a.exr", ({}, {"RGB": photograph}))
    for layout, word in (("strip", "six squares"), ("angular", "is a square"), ("cubes", "unknown, expected equirect")):
        with pytest.raises(InputError, match=word):
            load_environment(path, layout=layout)
    assert load_environment(path, layout="cross").radiance.shape == (32, 64, 3)

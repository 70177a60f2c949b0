"""Pictures: what is written comes back, in linear light; wrong files are refused in one line; no library speaks."""

import json
import shutil
import struct
import subprocess
import sys

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from glcloth.color import VIEW_TRANSFORMS, srgb_decode, srgb_encode, view
from glcloth.errors import InputError
from glcloth.image import read_image, read_settings, write_image

SETTINGS = {"fabric": "linen", "size": [640, 480], "exposure": -1.5, "name": "größe 織物", "nested": {"a": None}}


@pytest.fixture
def picture():
    rng = np.random.default_rng(1)
    return (rng.random((11, 17, 4), np.float32) * [9, 5, 1, 1]).astype(np.float32)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("half", [False, True])
def test_exr_round_trip(tmp_path, picture, channels, half):
    path = tmp_path / "a.exr"
    write_image(path, picture[..., :channels], SETTINGS, half=half, exposure=3, view_transform="agx")
    back = read_image(path)
    assert back.dtype == np.float32 and back.shape == (11, 17, channels)
    expected = picture[..., :channels].astype(np.float16 if half else np.float32).astype(np.float32)
    assert np.array_equal(back, expected)
    assert read_settings(path) == SETTINGS


def test_half_limits_large_values_and_keeps_infinity(tmp_path):
    row = np.array([1e9, -1e9, np.inf, 1.0], np.float32)
    path = write_image(tmp_path / "a.exr", np.stack([row] * 3, -1)[None], half=True)
    assert read_image(path)[0, :, 0].tolist() == [65504.0, -65504.0, np.inf, 1.0]


def test_png_standard_is_the_exact_srgb_curve(tmp_path):
    x = np.concatenate([[-1.0, 0.0, 0.0031308, 0.0031309, 0.18, 1.0, 7.0], np.linspace(0, 1, 57)])
    path = write_image(tmp_path / "a.png", np.stack([x] * 3, -1)[None])
    got = np.asarray(Image.open(path))[0, :, 0]
    c = np.clip(x, 0, 1)
    expected = np.array([12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055 for v in c])
    assert np.array_equal(got, np.round(expected * 255).astype(int))


def test_png_exposure_is_in_stops(tmp_path):
    grey = np.full((2, 2, 3), 0.1)
    a = write_image(tmp_path / "a.png", grey, exposure=1.5)
    b = write_image(tmp_path / "b.png", grey * 2**1.5)
    assert np.array_equal(np.asarray(Image.open(a)), np.asarray(Image.open(b)))


def test_png_round_trip_with_alpha_and_settings(tmp_path, picture):
    premultiplied = picture / np.array([9, 5, 1, 1], np.float32)
    premultiplied[..., :3] *= premultiplied[..., 3:]
    path = write_image(tmp_path / "a.png", premultiplied, SETTINGS)
    back = read_image(path)
    assert back.shape[-1] == 4 and read_settings(path) == SETTINGS
    # Half a code value of 255, where the sRGB curve is steepest to invert (slope 2.3 at white), and of alpha.
    assert np.abs(back - premultiplied).max() < 2.3 * 0.5 / 255 + 0.5 / 255 + 1e-6
    straight = np.asarray(Image.open(path))
    solid = premultiplied[..., 3] > 0.5
    expected = srgb_encode(premultiplied[..., :3] / np.maximum(premultiplied[..., 3:], 1e-9)) * 255
    assert np.abs(straight[..., :3] - expected)[solid].max() <= 0.5 + 1e-4


def test_settings_are_absent_or_refused(tmp_path):
    path = write_image(tmp_path / "a.exr", np.ones((2, 2, 3)))
    assert read_settings(path) is None
    assert read_settings(write_image(tmp_path / "a.png", np.ones((2, 2, 3)))) is None
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, "glcloth": "[1, 2"}
    with OpenEXR.File(header, {"RGB": np.ones((2, 2, 3), np.float32)}) as file:
        file.write(str(tmp_path / "b.exr"))
    with pytest.raises(InputError, match=r"b\.exr.*not valid JSON"):
        read_settings(tmp_path / "b.exr")


def test_settings_take_numpy_values(tmp_path):
    path = write_image(tmp_path / "a.png", np.ones((2, 2, 3)), {"x": np.float32(1.5), "y": np.arange(3), "p": tmp_path})
    assert read_settings(path) == {"x": 1.5, "y": [0, 1, 2], "p": str(tmp_path)}


def _exr(path, channels, **header):
    base = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(base | header, channels) as file:
        file.write(str(path))
    return path


def test_exr_of_other_programs(tmp_path):
    rng = np.random.default_rng(2)
    R, G, B, Z = (rng.random((4, 6), np.float32) for _ in range(4))
    rgb = np.stack([R, G, B], -1)
    layers = {"View.Combined.R": R, "View.Combined.G": G, "View.Combined.B": B, "View.Normal.X": Z, "Z": Z}
    assert np.array_equal(read_image(_exr(tmp_path / "layers.exr", layers)), rgb)
    assert np.array_equal(read_image(_exr(tmp_path / "grey.exr", {"Y": R})), np.stack([R] * 3, -1))
    mixed = {"B": B.astype(np.float16), "R": R, "G": (G * 9).astype(np.uint32)}
    expected = np.stack([R, (G * 9).astype(np.uint32), B.astype(np.float16)], -1).astype(np.float32)
    assert np.array_equal(read_image(_exr(tmp_path / "mixed.exr", mixed)), expected)
    with pytest.raises(InputError, match=r"depth\.exr: no part has R, G, B"):
        read_image(_exr(tmp_path / "depth.exr", {"Z": Z}))
    assert np.array_equal(read_image(tmp_path / "layers.exr", "depth")[..., 0], Z)  # no picture, found by its name


def test_exr_parts_and_windows(tmp_path):
    rng = np.random.default_rng(3)
    rgb, Z = rng.random((4, 6, 3), np.float32), rng.random((4, 6), np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    parts = [
        OpenEXR.Part(header | {"name": "depth"}, {"Z": Z}),
        OpenEXR.Part(header | {"name": "beauty"}, {"RGB": rgb}),
    ]
    with OpenEXR.File(parts) as file:
        file.write(str(tmp_path / "parts.exr"))
    assert np.array_equal(read_image(tmp_path / "parts.exr"), rgb)
    window = (np.array([0, 0], np.int32), np.array([9, 7], np.int32))
    data = (np.array([2, 3], np.int32), np.array([7, 6], np.int32))
    path = _exr(tmp_path / "crop.exr", {"RGB": rgb}, displayWindow=window, dataWindow=data)
    got = read_image(path)
    assert got.shape == (8, 10, 3)
    assert np.array_equal(got[3:7, 2:8], rgb) and got.sum() == pytest.approx(rgb.sum(), rel=1e-6)


def _uncompressed_exr(path, planes):
    """An OpenEXR file byte by byte; planes: {name: (float32 plane, sampling)}, because the library writes no chroma."""

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    names = sorted(planes)
    height, width = max(plane.shape for plane, _ in planes.values())
    channels = b"".join(n.encode() + b"\0" + struct.pack("<iIii", 2, 0, planes[n][1], planes[n][1]) for n in names)
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    head = b"\x76\x2f\x31\x01" + struct.pack("<I", 2) + attribute("channels", "chlist", channels + b"\0")
    head += attribute("compression", "compression", b"\0") + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    table, body = b"", b""
    for y in range(height):
        rows = [planes[n][0][y // planes[n][1]] for n in names if y % planes[n][1] == 0]
        data = b"".join(row.astype("<f4").tobytes() for row in rows)
        table += struct.pack("<Q", len(head) + 8 * height + len(body))
        body += struct.pack("<ii", y, len(data)) + data
    path.write_bytes(head + table + body)
    return path


def test_exr_luminance_and_chroma(tmp_path):
    """Y with RY and BY at half size: blocks of 2 x 2 of one hue come back."""
    rng = np.random.default_rng(6)
    hue = np.repeat(np.repeat(rng.random((2, 3, 3)) + 0.2, 2, 0), 2, 1)
    rgb = hue * (rng.random((4, 6, 1)) + 0.5)
    Y = rgb @ [0.2126, 0.7152, 0.0722]
    RY, BY = (((rgb[..., c] - Y) / Y)[::2, ::2] for c in (0, 2))
    path = _uncompressed_exr(tmp_path / "yc.exr", {"Y": (Y, 1), "RY": (RY, 2), "BY": (BY, 2)})
    assert np.allclose(read_image(path), rgb, rtol=1e-5)


def _rle_free_hdr(path, rgbe):
    height, width = rgbe.shape[:2]
    path.write_bytes(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + rgbe.tobytes())
    return path


def test_hdr_values(tmp_path):
    """Flat RGBE pixels of Ward 1991: value = mantissa / 256 * 2^(exponent - 128)."""
    rgbe = np.array([[[128, 64, 32, 129], [255, 0, 1, 140]], [[0, 0, 0, 0], [200, 100, 50, 120]]], np.uint8)
    got = read_image(_rle_free_hdr(tmp_path / "a.hdr", rgbe))
    mantissa, exponent = rgbe[..., :3].astype(float), rgbe[..., 3:].astype(float)
    low = np.where(exponent > 0, mantissa / 256 * 2.0 ** (exponent - 128), 0)
    high = np.where(exponent > 0, (mantissa + 0.5) / 256 * 2.0 ** (exponent - 128), 0)  # some readers add half a step
    assert np.all(got >= low * (1 - 1e-6)) and np.all(got <= high * (1 + 1e-6))


def test_png_of_16_bits_and_grey_and_palette(tmp_path):
    """A hand-made 16-bit PNG keeps its 16 bits; other modes become RGB or RGBA."""
    import zlib

    values = np.array([[0, 257, 32768, 65535]], ">u2")
    rows = b"\x00" + np.repeat(values[0], 3).astype(">u2").tobytes()

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 1, 16, 2, 0, 0, 0))
    (tmp_path / "a.png").write_bytes(png + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
    assert np.allclose(read_image(tmp_path / "a.png")[0, :, 1], srgb_decode(values[0] / 65535), rtol=1e-5, atol=1e-7)
    grey = b"\x00" + np.stack([values[0], [65535, 32768, 65535, 0]], -1).astype(">u2").tobytes()  # with alpha
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 1, 16, 4, 0, 0, 0))
    (tmp_path / "g.png").write_bytes(png + chunk(b"IDAT", zlib.compress(grey)) + chunk(b"IEND", b""))
    g, light = read_image(tmp_path / "g.png")[0], srgb_decode(values[0] / 65535)
    assert g.shape == (4, 4) and np.allclose(g[:, 3], [1, 32768 / 65535, 1, 0]) and np.ptp(g[:, :3], axis=1).max() == 0
    assert np.allclose(g[:, 1], light * g[:, 3], rtol=1e-4, atol=1e-7)
    for mode, channels in (("L", 3), ("LA", 4), ("P", 3), ("1", 3), ("RGBA", 4)):
        Image.new(mode, (3, 2)).save(tmp_path / "m.png")
        assert read_image(tmp_path / "m.png").shape == (2, 3, channels), mode
    Image.new("RGB", (5, 4), (255, 128, 0)).save(tmp_path / "a.jpg", quality=95)
    assert np.allclose(read_image(tmp_path / "a.jpg")[0, 0], srgb_decode(np.array([1, 128 / 255, 0])), atol=0.03)


@pytest.mark.parametrize("suffix", [".exr", ".hdr", ".png", ".jpg"])
def test_broken_files_are_refused_in_one_line(tmp_path, suffix):
    rng = np.random.default_rng(4)
    array = rng.random((64, 128, 3), np.float32)
    good = tmp_path / f"good{suffix}"
    if suffix in (".exr", ".png"):
        write_image(good, array)
    elif suffix == ".jpg":
        Image.fromarray((array * 255).astype(np.uint8)).save(good)
    else:
        _rle_free_hdr(good, np.dstack([array * 255, np.full((64, 128), 129)]).astype(np.uint8))
    read_image(good)
    data = good.read_bytes()
    path = tmp_path / f"bad{suffix}"

    def refused(match):
        with pytest.raises(InputError, match=match) as caught:
            read_image(path)
        message = str(caught.value)
        assert message.startswith(str(path)) and "\n" not in message and len(message) < 250 + len(str(path))

    refused("no such file.*check the name")
    path.write_bytes(b"")
    refused("empty")
    path.write_text("hello, I am text\n" * 40)
    refused("is not")
    for share in (0.02, 0.3, 0.7, 0.99):
        path.write_bytes(data[: int(len(data) * share)])
        refused("cannot be decoded|is not")
    other = ".png" if suffix != ".png" else ".exr"
    shutil.copy(write_image(tmp_path / f"other{other}", array), path)
    refused("rename it")


def test_wrong_names_and_shapes(tmp_path):
    with pytest.raises(InputError, match=r"ends in \.exr or \.png"):
        write_image(tmp_path / "a.tiff", np.ones((2, 2, 3)))
    with pytest.raises(InputError, match=r"\(2, 2, 5\), expected"):
        write_image(tmp_path / "a.exr", np.ones((2, 2, 5)))
    with pytest.raises(InputError, match="mkdir"):
        write_image(tmp_path / "no" / "a.exr", np.ones((2, 2, 3)))
    with pytest.raises(InputError, match="did you mean filmic"):
        write_image(tmp_path / "a.png", np.ones((2, 2, 3)), view_transform="filmc")
    with pytest.raises(InputError, match="folder"):
        read_image(tmp_path)
    (tmp_path / "a.tga").write_bytes(b"x")
    with pytest.raises(InputError, match=r"cannot read \.tga"):
        read_image(tmp_path / "a.tga")
    assert [p.name for p in tmp_path.iterdir()] == ["a.tga"], "a refused picture leaves nothing behind"


def test_libraries_say_nothing(tmp_path):
    """A process that reads a truncated EXR and HDR prints nothing of its own on either stream."""
    path = write_image(tmp_path / "a.exr", np.random.default_rng(5).random((64, 64, 3)))
    path.write_bytes(path.read_bytes()[:-500])
    (tmp_path / "a.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\nxx")
    code = (
        "import sys; from glcloth.image import read_image; from glcloth.errors import InputError\n"
        "for name in sys.argv[1:]:\n"
        "    try: read_image(name); raise SystemExit('it was read')\n"
        "    except InputError: pass\n"
        "print('still here')"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, str(path), str(tmp_path / "a.hdr")], capture_output=True, text=True
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "still here\n", "")


@pytest.mark.parametrize("name", VIEW_TRANSFORMS)
def test_view_transforms(name):
    """Black is black, more light is never darker, values stay in 0..1, greys stay grey, odd values are handled."""
    x = np.concatenate([[0.0], np.geomspace(1e-5, 1e6, 400)])
    code = view(np.stack([x] * 3, -1), name)
    assert np.all((code >= 0) & (code <= 1)) and code[0].max() < 0.02
    # AgX's published polynomial dips by less than a code value near black.
    assert np.diff(code[:, 1]).min() >= -1 / 255
    assert np.ptp(code, axis=-1).max() < 1e-3
    odd = view(np.array([[np.nan, np.inf, -np.inf]]), name)
    assert np.all(np.isfinite(odd))
    assert json.dumps(odd.tolist())


def test_view_transforms_agree_with_their_publications():
    grey = np.full(3, 0.18)
    f = lambda x: (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3  # noqa: E731
    assert view(grey, "filmic")[0] == pytest.approx(float(srgb_encode(f(0.36) / f(11.2))), abs=1e-12)
    # Khronos: a base colour between 0.08 and 0.8 loses exactly F_90 = 0.04.
    assert np.allclose(view(np.array([0.5, 0.3, 0.2]), "neutral"), srgb_encode(np.array([0.46, 0.26, 0.16])))
    # Of its text, brighter: (4, 2, 1) less 0.04 has the peak 3.96, which becomes 1 - 0.24^2 / (3.96 + 0.24 - 0.76), and runs to
    # white by 1 - 1 / (0.15 * (3.96 - that) + 1).
    peak = 1 - 0.24**2 / 3.44
    g = 1 - 1 / (0.15 * (3.96 - peak) + 1)
    shown = np.array([3.96, 1.96, 0.96]) * peak / 3.96 * (1 - g) + peak * g
    assert np.allclose(view(np.array([4.0, 2.0, 1.0]), "neutral"), srgb_encode(shown))
    # AgX keeps middle grey near the middle of the display range.
    assert 0.40 < view(grey, "agx")[0] < 0.55

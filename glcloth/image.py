"""Pictures as linear Rec. 709 float32 arrays: reading .exr .hdr .png .jpg, writing .exr .png with the scene's settings.

Arrays are [H, W, 3] or [H, W, 4], the first row on top. Alpha is coverage and colours are multiplied by it (as
OpenEXR has it); PNG files keep unmultiplied colours, as their standard asks.
"""

from __future__ import annotations

import io
import json
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from .color import Transform, srgb_decode, view
from .errors import InputError
from .files import MOST_TEXT, atomic_write, check_writable, path_of, read_bytes, read_json
from .formats.common import broken, check_pixels, decoded, silence
from .formats.exr import open_exr, read_exr
from .formats.radiance import read_radiance

READABLE = (".exr", ".hdr", ".png", ".jpg", ".jpeg")
WRITABLE = (".exr", ".png")
SETTINGS_KEY = "glcloth"
HALF_MAX = 65504.0
MOST_BYTES = 1 << 30  # of a Radiance file


class Picture(np.ndarray):
    """An array of a picture that a notebook shows; all else is as of any array.

    scene : the scene that says how it is shown; None: as `write_image` does
    """

    scene: Any

    def __array_finalize__(self, other: Any) -> None:
        self.scene = getattr(other, "scene", None)

    def _repr_png_(self) -> bytes | None:
        """The picture as a notebook shows it; None where the array is no picture any more: a row, a channel."""
        if self.ndim != 3 or self.shape[-1] not in (3, 4) or 0 in self.shape or self.dtype.kind != "f":
            return None
        look = (0.0, "standard") if self.scene is None else (self.scene.exposure, self.scene.transform)
        return _png(np.asarray(self), None, *look)


def as_picture(array: np.ndarray, scene: Any) -> Picture:
    """An array as a Picture that is shown as a scene says."""
    picture = array.view(Picture)
    picture.scene = scene
    return picture


def read_image(path: str | Path, layer: str = "") -> np.ndarray:
    """Read a picture as float32 [H, W, 3] or [H, W, 4] (when it has alpha), linear Rec. 709.

    OpenEXR (half, float or integer channels in any order, layers, several parts, luminance with or without chroma,
    tiles, other chromaticities), Radiance .hdr (all orientations and codes, exposure divided out), PNG and JPEG (8 or 16
    bits, decoded with the sRGB curve). Samples are returned as they are, infinities included.

    layer : of an OpenEXR file with several, the one to read; "": the picture proper. Those that are no pictures, by our
        names or the file's: normal and position [H, W, 3], uv [H, W, 2], depth and mask [H, W, 1]

    Raises InputError when the file is missing, empty, cut short, too large, of another kind, of an unknown suffix, or
    without such a layer.
    """
    path = _existing(path, READABLE)
    suffix = path.suffix.lower()
    _check_magic(path, suffix)
    if layer and suffix != ".exr":
        raise InputError(f"{path}: layer {layer}: only OpenEXR files have layers; leave it out")
    if suffix == ".exr":
        image = read_exr(path, layer)
    elif suffix == ".hdr":
        image = read_radiance(path, read_bytes(path, MOST_BYTES))
    else:
        image = _read_display(path)
    image = np.ascontiguousarray(image, np.float32)
    if image.ndim != 3 or 0 in image.shape:
        raise InputError(f"{path}: holds no pixels, expected a picture; save it again")
    return image


def write_image(
    path: str | Path,
    array: np.ndarray,
    settings: dict | None = None,
    half: bool = False,
    exposure: float = 0.0,
    view_transform: Transform = "standard",
    layers: Any = None,
) -> Path:
    """Write `array` ([H, W], [H, W, 3] or [H, W, 4], linear Rec. 709) to .exr or .png, whole or not at all.

    Parameters
    ----------
    settings : of the picture; stored as JSON (EXR attribute or PNG text chunk "glcloth"), see read_settings
    half : EXR with 16-bit floats (values beyond 65504 are limited); else 32-bit
    exposure : stops, PNG only
    view_transform : a name in color.VIEW_TRANSFORMS, or a function such as ocio.OcioView, PNG only
    layers : picture.layers.Layers of the picture, EXR with 32-bit floats only

    An EXR is the scene-linear picture itself: exposure and view transform do not touch it. Returns the path.
    Raises InputError on a wrong shape or suffix and when the file cannot be written.
    """
    path = check_output(path)
    suffix = path.suffix.lower()
    array = np.asarray(array)
    if array.ndim == 2:
        array = np.repeat(array[..., None], 3, -1)
    if array.ndim != 3 or array.shape[-1] not in (3, 4) or 0 in array.shape:
        raise InputError(f"{path}: array of shape {array.shape}, expected [H, W, 3] or [H, W, 4]")
    text = None if settings is None else json.dumps(settings, sort_keys=True, default=_plain)
    if layers is not None and (suffix != ".exr" or half):
        raise InputError(f"{path}: layers need an .exr of 32-bit floats")
    if suffix == ".png":
        data = _png(array, text, exposure, view_transform)
        with atomic_write(path) as temporary:
            temporary.write_bytes(data)
    else:
        with atomic_write(path) as temporary:
            _write_exr(temporary, array, text, half, layers)
    return path


def check_output(path: str | Path) -> Path:
    """Return `path` if a picture can be written there; a long render asks before it starts. Raises InputError."""
    path = Path(path)
    if path.suffix.lower() not in WRITABLE and not path.is_dir():
        what = path.suffix or "a file without suffix"
        raise InputError(f"{path}: cannot write {what}, expected a name that ends in {' or '.join(WRITABLE)}")
    return check_writable(path)


def read_settings(path: str | Path) -> dict | None:
    """The settings stored in a picture by write_image, or None when it has none.

    Raises InputError when the file is missing or unreadable, or the stored text is not a JSON object.
    """
    path = _existing(path, READABLE)
    suffix = path.suffix.lower()
    _check_magic(path, suffix)
    if suffix == ".exr":
        header = open_exr(path, header_only=True)[0].header
        text = header.get(SETTINGS_KEY)
    elif suffix == ".png":
        text = _with_pillow(path, lambda picture: getattr(picture, "text", {}).get(SETTINGS_KEY))
    else:
        return None
    if text is None:
        return None
    expected = "settings as glcloth writes them; render the picture again"
    if not isinstance(text, str) or len(text) > MOST_TEXT:
        raise InputError(f"{path}: its '{SETTINGS_KEY}' entry is no text, or too long; expected {expected}")
    settings = read_json(text, f"{path}: its '{SETTINGS_KEY}' entry", expected)
    if not isinstance(settings, dict):
        raise InputError(f"{path}: its '{SETTINGS_KEY}' entry is not a JSON object; render the picture again")
    return settings


def _plain(value):
    """Paths, NumPy numbers and arrays as JSON values."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return str(value)


def _existing(path: str | Path, suffixes: tuple[str, ...]) -> Path:
    path = _there(path, suffixes)
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"{path}: cannot read {path.suffix or 'a file without suffix'}, expected {', '.join(suffixes)}"
        )
    return path


def _there(path: str | Path, suffixes: tuple[str, ...]) -> Path:
    path = path_of(path)
    if path.is_dir():
        raise InputError(f"{path}: is a folder, expected a picture ({', '.join(suffixes)})")
    if not path.is_file():
        what = "is a pipe or a device" if path.exists() else "no such file"
        raise InputError(f"{path}: {what}, expected a picture ({', '.join(suffixes)}); check the name")
    return path


_MAGIC = {
    ".exr": ((b"\x76\x2f\x31\x01",), "an OpenEXR file"),
    ".hdr": ((b"#?",), "a Radiance .hdr file"),
    ".png": ((b"\x89PNG\r\n\x1a\n",), "a PNG file"),
    ".jpg": ((b"\xff\xd8\xff",), "a JPEG file"),
    ".jpeg": ((b"\xff\xd8\xff",), "a JPEG file"),
}


def _check_magic(path: Path, suffix: str) -> None:
    """The first bytes tell a wrong file before a decoder sees it, and tell what it really is."""
    try:
        with open(path, "rb") as file:
            head = file.read(16)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check its permissions") from None
    starts, kind = _MAGIC[suffix]
    if not head:
        raise InputError(f"{path}: the file is empty, expected {kind}; copy or save it again")
    if not head.startswith(starts):
        other = next((name for magic, name in _MAGIC.values() if head.startswith(magic)), None)
        remedy = f"it is {other}: rename it" if other else "save it again, or give another file"
        raise InputError(f"{path}: is not {kind} although its name ends in {suffix}; {remedy}")


# OpenEXR ----------------------------------------------------------------------------------------------------------


def _write_exr(path: Path, array: np.ndarray, text: str | None, half: bool, layers: Any = None) -> None:
    import OpenEXR

    if half:
        array = np.where(np.isfinite(array), np.clip(array, -HALF_MAX, HALF_MAX), array)
    pixels = np.ascontiguousarray(array, np.float16 if half else np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if text is not None:
        header[SETTINGS_KEY] = text
    channels = {"RGB" if array.shape[-1] == 3 else "RGBA": pixels}
    if layers is not None:
        header |= layers.attributes()
        channels |= {name: np.ascontiguousarray(plane, np.float32) for name, plane in layers.channels().items()}
    try:
        with silence():
            with OpenEXR.File(header, channels) as file:
                file.write(str(path))
    except (RuntimeError, ValueError) as error:
        raise InputError(f"{path.parent}: the picture cannot be written there ({error}); is the disk full?") from None


# PNG and JPEG -----------------------------------------------------------------------------------------------------


def _with_pillow(source: Path | bytes, use):
    from PIL import Image

    # A material's picture may be of any kind that Pillow knows.
    path = _there(source, READABLE) if isinstance(source, Path) else "a picture in the file"

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            size = len(source) if isinstance(source, bytes) else source.stat().st_size
            with Image.open(io.BytesIO(source) if isinstance(source, bytes) else source) as picture:
                check_pixels(path, *picture.size, size)
                picture.load()
                return use(picture)
    except InputError:
        raise
    except Image.DecompressionBombError:
        raise InputError(f"{path}: has too many pixels (over 178 million); give a smaller picture") from None
    except (OSError, ValueError, SyntaxError, struct.error, IndexError, EOFError):
        raise broken(path) from None


def _read_display(path: Path) -> np.ndarray:
    if path.suffix.lower() == ".png" and _png_bit_depth(path) == 16:
        # Pillow would cut 16-bit colours to 8 bits.
        check_pixels(path, *_png_size(path), path.stat().st_size)
        code = decoded(path, path, unassociated=True)
        if code.shape[-1] <= 2:
            code = np.concatenate([np.repeat(code[..., :1], 3, -1), code[..., 1:]], -1)
    else:
        code = _with_pillow(path, _codes)
    rgb = srgb_decode(code[..., :3].astype(np.float32))
    if code.shape[-1] < 4:
        return rgb
    return np.concatenate([rgb * code[..., 3:4], code[..., 3:4]], -1)


def _codes(picture) -> np.ndarray:
    if picture.mode.startswith("I"):  # 16 bits of grey, which `convert` would cut at 255
        return np.repeat(np.asarray(picture, np.float32)[..., None], 3, -1) / 65535.0
    alpha = picture.mode in ("RGBA", "LA", "PA", "RGBa", "La") or "transparency" in picture.info
    return np.asarray(picture.convert("RGBA" if alpha else "RGB"), np.float32) / 255.0


def decode_codes(source: Path | bytes) -> np.ndarray:
    """The code values [H, W, 3 or 4] in 0 to 1 of a PNG or JPEG file, or of its bytes. Raises InputError."""
    return _with_pillow(source, _codes)


def decode_bytes(path: Path) -> np.ndarray:
    """The code values [H, W, 3] uint8 of a PNG or JPEG file, without its alpha. Raises InputError."""

    def codes(picture) -> np.ndarray:
        if picture.mode.startswith("I"):
            return np.repeat(np.rint(np.asarray(picture, np.float32) / 257.0).astype(np.uint8)[..., None], 3, -1)
        return np.asarray(picture.convert("RGB"))

    return _with_pillow(path, codes)


def _png_size(path: Path) -> tuple[int, int]:
    with open(path, "rb") as file:
        return struct.unpack(">II", (file.read(24) + bytes(24))[16:24])


def _png_bit_depth(path: Path) -> int:
    with open(path, "rb") as file:
        return (file.read(25) + bytes(25))[24]


def _png(array: np.ndarray, text: str | None, exposure: float, view_transform: Transform) -> bytes:
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    rgb = array[..., :3]
    if array.shape[-1] == 4:
        alpha = np.clip(np.nan_to_num(array[..., 3:4]), 0.0, 1.0)
        rgb = np.where(alpha > 0, rgb / np.where(alpha > 0, alpha, 1), rgb)
        code = np.concatenate([view(rgb, view_transform, exposure), alpha], -1)
    else:
        code = view(rgb, view_transform, exposure)
    info = PngInfo()
    if text is not None:
        info.add_itxt(SETTINGS_KEY, text)
    if getattr(view_transform, "srgb", True):
        # 0 = perceptual; it declares that the codes are sRGB.
        info.add(b"sRGB", b"\x00")
    buffer = io.BytesIO()
    Image.fromarray(np.round(code * 255.0).astype(np.uint8)).save(buffer, "PNG", pnginfo=info)
    return buffer.getvalue()
